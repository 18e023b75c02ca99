"""Which law goes into which recording, and which recordings stay as they are but for what the base circuit takes up."""

import random

from ..recordings import MEASURED
from ..out_of_model.cases import seed_of

ZERO = "zero"
ZEROS_A_ROUND = 2
# The cell is none of lead and acid: no lead-acid mechanism is promised of it.
NO_EFFECTS = ("leaf_cell",)
# Effects of the catalogue that are put in at a promised strength, by equations of their own (concealment.py).
PROMISED = ("acid_transport", "ocv_soc", "high_rate_depletion", "contact_resistance", "voltage_drift", "current_offset", "time_skew")
INSTANT_SHARE = 0.35   # of all charge has passed when a contact changes
LONGEST_S = 3600.0     # of a stretch that is shown, from its beginning
SLOW_S = 86400.0       # the same where samples are seconds apart
SLOW_INTERVAL_S = 2.0
INSTRUMENT, LONGEST_INSTRUMENT_S = "instrument", 10800.0  # as draw_out_of_model --beside takes them


def rounds(seed, forms, only=()):
    """Cases without end, in rounds: every recording with every mechanism once and ZEROS_A_ROUND times with none, in an order of the seed.

    A case's name reports its place in the plan; the form of a mechanism is another every round.
    """
    recordings = [one for one in MEASURED if not only or one in only]
    number = 0
    while True:
        cases = []
        for recording in recordings:
            kinds = [ZERO] * ZEROS_A_ROUND + ([] if recording in NO_EFFECTS else sorted(forms))
            for place, kind in enumerate(kinds):
                name = f"{number}/{recording}/{kind}" + (f"/{place}" if kind == ZERO else "")
                cases.append({"name": name, "recording": recording, "kind": kind, "seed": seed_of(seed, name), "turn": number})
        random.Random(seed_of(seed, number)).shuffle(cases)
        yield from cases
        number += 1


def promised(seed, catalogue, only=(), recordings=MEASURED):
    """Cases of one round: every recording with each of PROMISED, at the strength that its own answer calls the least to be reported, and ZEROS_A_ROUND times with none."""
    for recording in recordings:
        if only and recording not in only:
            continue
        kinds = [(ZERO, None)] * ZEROS_A_ROUND + ([] if recording in NO_EFFECTS else [(catalogue.mechanism(effect), effect) for effect in PROMISED])
        for place, (kind, effect) in enumerate(kinds):
            name = f"promised/{recording}/{effect or kind}" + ("" if effect else f"/{place}")
            case = {"name": name, "recording": recording, "kind": kind, "seed": seed_of(seed, name), "turn": 0}
            yield dict(case, effect=effect, tau_s=catalogue.times.get(effect)) if effect else case


def forms_in_turn(case, forms):
    """The forms of a case's mechanism, beginning with the one whose turn it is on this recording."""
    mine = forms[case["kind"]]
    first = (case["turn"] + list(MEASURED).index(case["recording"])) % len(mine)
    return mine[first:] + mine[:first]


def stretch(t):
    """How many of the first samples are shown."""
    slow = len(t) > 1 and (t[-1] - t[0]) / (len(t) - 1) > SLOW_INTERVAL_S
    return int((t - t[0] <= (SLOW_S if slow else LONGEST_S)).sum())

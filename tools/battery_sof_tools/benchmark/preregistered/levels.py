"""What the benchmark consists of: levels of concealment, their cases, and how strong each case's addition is made."""

import collections
import random

from ..generator import seed_of

PHYSICS_1_TO_7 = ("gassing", "charge_acceptance", "sulphate_history", "acid_transport", "ocv_soc", "ocv_hysteresis",
                  "high_rate_depletion")
SHOWN = PHYSICS_1_TO_7 + ("cpe2", "current_dependent_resistance", "second_electrode")
INSTRUMENT_FAULTS = ("current_offset", "current_gain", "time_skew", "sensor_lag", "quantisation", "contact_resistance", "clipping", "dropouts",
          "voltage_drift", "aliasing")
UNLISTED = ("memory_resistance", "step_force", "gated_tone", "capacitance_fall", "dead_zone", "hysteretic_r")
MASKED = ("charge_acceptance+gassing", "charge_acceptance+current_gain", "ocv_soc+voltage_drift",
          "current_dependent_resistance+time_skew")
ABSENT = ("charge_acceptance", "gassing", "high_rate_depletion", "acid_transport")
# What comes with an effect and is not scaled: both ids are true.
WITH_COMPANION = ("gassing", "sulphate_history")

Stratum = collections.namedtuple("Stratum", "level mechanism ids each rule")
STRATA = (
    Stratum("N1", "null", ("-",), 62, "as drawn"),
    Stratum("N2", "structural_null", ("-",), 32, "as drawn"),
    Stratum("N2", "porous_null", ("-",), 8, "as drawn"),
    Stratum("C1", "effect", SHOWN, 4, "z"),
    Stratum("C2", "effect", SHOWN, 2, "z"),
    Stratum("C3", "effect", PHYSICS_1_TO_7 + ("cpe2",), 3, "absorbed"),
    Stratum("C4", "masked", MASKED, 4, "masked"),
    Stratum("C5", "absent", ABSENT, 4, "as drawn"),
    Stratum("D1", "decoy", INSTRUMENT_FAULTS, 3, "as drawn"),
    Stratum("U1", "unknown", UNLISTED, 4, "as drawn"),
    Stratum("X1", "structural_effect", PHYSICS_1_TO_7, 4, "as drawn"),
    Stratum("X1", "porous_effect", ("charge_acceptance", "acid_transport", "gassing"), 2, "as drawn"),
    Stratum("C6", "effect", PHYSICS_1_TO_7 + ("cpe2", "second_electrode"), 3, "concealed"))
Z_WANTED = {"C1": (12.0, 40.0), "C2": (4.0, 8.0)}
SHORT_S = 300.0  # what C3 and C6 show first
ON_REQUEST = ("C6",)  # levels that committed seals do not have


def plan(secret, share, max_porous=None, duration_s=None, only=None):
    """Cases without their strengths, under opaque names in an order of the seed. Every stratum keeps at least one case."""
    dice, cases, porous = random.Random(seed_of(secret, "order")), [], 0
    for stratum in (one for one in STRATA if (one.level in only if only else one.level not in ON_REQUEST)):
        ids = list(stratum.ids)
        dice.shuffle(ids)
        rows = [name for _ in range(stratum.each) for name in ids]
        count = max(1, round(share * len(rows)))
        if stratum.mechanism.startswith("porous"):
            count = count if max_porous is None else min(count, max_porous - porous)
            porous += count
        for k, name in enumerate(rows[:count]):
            cases.append({"level": stratum.level, "family": stratum.mechanism, "id": name, "rule": stratum.rule,
                          "seed": seed_of(secret, stratum.mechanism, stratum.level, name, k), "scale": [1.0]})
            if duration_s and stratum.mechanism != "absent":
                cases[-1]["duration_s"] = duration_s
    dice.shuffle(cases)
    return [dict(case, name=f"case_{k:04d}") for k, case in enumerate(cases, 1)]

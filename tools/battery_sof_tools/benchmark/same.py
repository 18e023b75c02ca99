"""Is it the same answer twice? The first mechanism of every measured recording: as it is, after changes that add no physics, and of its two halves.

A neutral change adds what the base circuit has already: a level of the voltage, a resistance. Halves are asked for where the recording is
20 minutes and longer; recordings of one vehicle are compared with one another.
"""

import itertools
import os

from .. import recordings, sof
from ..files import finished, write_json
from ..tables import table
from . import measured
from .runner import diagnose_samples

CHANGES = {"+ 0.1 V": (0.1, 0.0), "+ 2 mOhm": (0.0, 0.002)}  # [V], [Ohm]
HALVES = ("first half", "second half")
AS_IT_IS = "as it is"
SHORTEST_S = 1200.0  # of a recording whose halves are compared
VEHICLES = (("startstop_car/drive_1", "startstop_car/drive_2"),)
PATIENCE_S = 600.0


def shown(data, one):
    """{what was done: time, current, voltage} of a recording."""
    t, i, u = recordings.read(os.path.join(data, one.path), one.columns, one.discharge_positive)
    cases = {AS_IT_IS: (t, i, u)}
    cases.update({change: (t, i, u + level + resistance * i) for change, (level, resistance) in CHANGES.items()})
    if t[-1] - t[0] >= SHORTEST_S:
        first = t - t[0] < (t[-1] - t[0]) / 2
        cases.update(zip(HALVES, ((t[half], i[half], u[half]) for half in (first, ~first))))
    return cases


def asked(program, data, name, one, case):
    """(recording, case, {mechanism: probability} of the set of 0.9, verdict); no mechanism where nothing is missing or there is no answer."""
    try:
        answer = diagnose_samples(program, shown(data, one)[case], PATIENCE_S)
    except sof.Failure as failure:
        return name, case, {}, str(failure)
    said = {one["id"]: one["probability"] for one in answer["mechanisms"]} if answer["mechanism"] else {}
    return name, case, said, answer["verdict"]


def first(said):
    return next(iter(said), None)


def agreement(pairs):
    """Counts over pairs of {mechanism: probability}, of which both have a mechanism."""
    both = [(one, other) for one, other in pairs if one and other]
    same = sum(first(one) == first(other) for one, other in both)
    return {"cases": len(both), "same": same, "changed": len(both) - same, "overlap": sum(bool(set(one) & set(other)) for one, other in both),
            "without": len(pairs) - len(both)}


def figures(found):
    """Agreement of what should be alike. found: {recording: {case: ({mechanism: probability}, verdict)}}."""
    changed = [(of[AS_IT_IS][0], of[change][0]) for of in found.values() for change in CHANGES]
    halves = [tuple(of[half][0] for half in HALVES) for of in found.values() if HALVES[0] in of]
    trips = [tuple(found[one][AS_IT_IS][0] for one in pair) for vehicle in VEHICLES for pair in itertools.combinations(vehicle, 2) if set(pair) <= set(found)]
    return {"neutral": agreement(changed), "halves": agreement(halves), "trips": agreement(trips)}


def cell(answer):
    said, verdict = answer
    return f"{verdict}; " + ", ".join(f"{one} {said[one]:.2f}" for one in list(said)[:2]) if said else verdict


def report(found):
    """Lines: every answer, then who agrees."""
    cases = (AS_IT_IS, *CHANGES, *HALVES)
    lines = table(("recording", *cases), [(name, *(cell(of[case]) if case in of else "" for case in cases)) for name, of in found.items()])
    return lines + [""] + [f"{what}: the same first mechanism in {one['same']} of {one['cases']}; sets of 0.9 overlap in {one['overlap']}; {one['without']} more have none on a side."
                           for what, one in figures(found).items()]


def main():
    parser = measured.parser(__doc__)
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    program, wanted = measured.chosen(arguments)
    todo = [(program, arguments.data, name, one, case) for name, one in wanted.items() for case in shown(arguments.data, one)]
    found = {name: {} for name in wanted}
    for name, case, said, verdict in finished(arguments.jobs, asked, todo, "diagnosis"):
        found[name][case] = (said, verdict)
    print("\n".join(report(found)))
    write_json(arguments.json, figures(found))

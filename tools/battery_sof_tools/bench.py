"""Times identifications against Ceres. Usage: bench[_composed] BUILD

bench: one window with the base circuit. bench_composed: base + three effects. All contenders minimise
the same cost from the same start on one thread; whoever ends in another optimum ends the run with a
message and status 1. Times are of the processor. The contenders take turns, so that a busy machine
slows all of them; what counts are the ratios.
"""

import os
import statistics
import subprocess
import sys
import tempfile

from .files import read_json
from .progress import followed

BATCHES, ROUNDS, COMPOSED_ROUNDS = 3, 6, 5
IDENTIFY, SEARCH = "ours, identify()", "ours, search alone"  # names that side_by_side.cpp gives
OURS = "ours: compressed, then full rate"                    # and composed_fit.cpp
WINDOW = "{:<44} {:>9} {:>8} {:>16} {:>8} {:>16} {:>7}"
FIT = "{:<40} {:>9} {:>8} {:>16} {:>10} {:>8}  {}"


def written(build, name, rounds):
    """What a program writes into a file of JSON."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.json")
        subprocess.check_output([os.path.join(build, "bench", name), str(rounds), out])
        return read_json(out)


def figures(values, form="{:.2f}"):
    """Median, and smallest to largest, as text."""
    ends = (form + " .. " + form).format(min(values), max(values))
    return form.format(statistics.median(values)), ends


def ratios(theirs, ours):
    return figures([a / b for a, b in zip(theirs, ours)])


def side_by_side(build):
    """{contender: ([ms], passes)} over all batches."""
    table = {}
    for _ in followed(range(BATCHES), "batch"):
        for entry in written(build, "side_by_side", ROUNDS)["times"]:
            times, _ = table.setdefault(entry["name"], ([], entry["evaluations"]))
            times.extend(entry["milliseconds"])
    return table


def window(build):
    table = side_by_side(build)
    print(WINDOW.format("one window, 240 s at 100 Hz", "median ms", "/ ident.", "min .. max",
                        "/ search", "min .. max", "passes"))
    for name, (times, passes) in table.items():
        print(WINDOW.format(name, figures(times)[0], *ratios(times, table[IDENTIFY][0]),
                            *ratios(times, table[SEARCH][0]), passes))


def composed(build):
    contenders = written(build, "composed_fit", COMPOSED_ROUNDS)["contenders"]
    ours = next(entry["milliseconds"] for entry in contenders if entry["name"] == OURS)
    print(FIT.format("base + 3 effects, 30 min at 100 Hz", "median ms", "/ first", "min .. max",
                     "cost - 1", "std.err.", "passes"))
    for entry in contenders:
        times = entry["milliseconds"]
        print(FIT.format(entry["name"], figures(times, "{:.0f}")[0], *ratios(times, ours),
                         f"{entry['cost_share']:.1e}", f"{entry['standard_errors']:.2f}",
                         entry["passes"]))


def main():
    *which, build = sys.argv[1:] or [None]
    if build is None or which not in ([], ["composed"]):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        (composed if which else window)(os.path.abspath(build))
    except (OSError, subprocess.CalledProcessError) as failure:
        print(f"bench: {failure}", file=sys.stderr)
        return 1
    return 0

"""Times identifications against Ceres, and what compositions cost. Usage: bench[_composed] BUILD

bench: one window with the base circuit, and one sample of a pass. bench_composed: base + three
effects, cost against length, live tracker, threads, fits behind a source. All contenders minimise
the same cost from the same start on one thread; whoever ends in another optimum ends the run with a
message and status 1. Times are of the processor but where the table says wall. The contenders take
turns, so that a busy machine slows all of them; what counts are the ratios.
"""

import json
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
LENGTHS = (240, 900, 3600, 14400, 36000)  # [s]
WINDOW = "{:<44} {:>9} {:>8} {:>16} {:>8} {:>16} {:>7}"
FIT = "{:<40} {:>9} {:>8} {:>16} {:>10} {:>8}  {}"
LENGTH = "{:>8} {:>9} {:>10} {:>12} {:>10} {:>10} {:>7} {:>12} {:>10} {:>10} {:>10}"
MICRO = ("--benchmark_format=json", "--benchmark_repetitions=9", "--benchmark_min_time=0.1",
         "--benchmark_enable_random_interleaving=true")


def program(build, name, *arguments):
    return subprocess.check_output([os.path.join(build, "bench", name), *map(str, arguments)], text=True)


def written(build, name, rounds):
    """What a program writes into a file of JSON."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.json")
        program(build, name, rounds, out)
        return read_json(out)


def figures(values, form="{:.2f}"):
    """Median, and smallest to largest, as text."""
    ends = (form + " .. " + form).format(min(values), max(values))
    return form.format(statistics.median(values)), ends


def ratios(theirs, ours):
    return figures([a / b for a, b in zip(theirs, ours)])


# ----------------------------------------------------------------------- one window, one sample

def side_by_side(build):
    """{contender: ([ms], passes)} over all batches."""
    table = {}
    for _ in followed(range(BATCHES), "batch"):
        for entry in written(build, "side_by_side", ROUNDS)["times"]:
            times, _ = table.setdefault(entry["name"], ([], entry["evaluations"]))
            times.extend(entry["milliseconds"])
    return table


def microbenchmarks(build):
    """{name: [ns per sample]} in the order they are written in: the bare loop of exp first."""
    entries = json.loads(program(build, "micro_benchmark", *MICRO))["benchmarks"]
    times = {}
    for entry in sorted(entries, key=lambda entry: entry["family_index"]):
        is_run = entry["run_type"] == "iteration"
        if is_run and not entry.get("error_occurred"):  # instructions the processor lacks
            times.setdefault(entry["run_name"], []).append(1e9 / entry["items_per_second"])
    return times


def window(build):
    table, micro = side_by_side(build), microbenchmarks(build)
    print(WINDOW.format("one window, 240 s at 100 Hz", "median ms", "/ ident.", "min .. max",
                        "/ search", "min .. max", "passes"))
    for name, (times, passes) in table.items():
        print(WINDOW.format(name, figures(times)[0], *ratios(times, table[IDENTIFY][0]),
                            *ratios(times, table[SEARCH][0]), passes))
    print(WINDOW.format("one sample of a pass over the window", "median ns", "/ exp", "min .. max",
                        "", "", "").rstrip())
    exponentials = next(iter(micro.values()))
    for name, values in micro.items():
        print(WINDOW.format(name, figures(values, "{:.1f}")[0], *ratios(values, exponentials),
                            "", "", "").rstrip())


# -------------------------------------------------------------------------------- compositions

def print_fits(contenders):
    ours = next(entry["milliseconds"] for entry in contenders if entry["name"] == OURS)
    print(FIT.format("base + 3 effects, 30 min at 100 Hz", "median ms", "/ first", "min .. max",
                     "cost - 1", "std.err.", "passes"))
    for entry in contenders:
        times = entry["milliseconds"]
        print(FIT.format(entry["name"], figures(times, "{:.0f}")[0], *ratios(times, ours),
                         f"{entry['cost_share']:.1e}", f"{entry['standard_errors']:.2f}",
                         entry["passes"]))


def print_lengths(build):
    print(LENGTH.format("length s", "samples", "pass ms", "ns / sample", "fit ms", "compressed",
                        "passes", "ns / (s. p.)", "record MB", "+ fit", "+ pass"))
    for seconds in LENGTHS:
        m = json.loads(program(build, "composed_length", seconds))
        print(LENGTH.format(
            seconds, m["samples"], f"{m['pass_ms']:.1f}",
            f"{1e6 * m['pass_ms'] / m['samples']:.0f}", f"{m['fit_ms']:.1f}", m["compressed"],
            m["fit_passes"],
            f"{1e6 * m['fit_ms'] / (m['samples'] * m['fit_passes']):.0f}", f"{m['record_mb']:.1f}",
            f"{m['fit_mb']:.1f}", f"{m['pass_mb']:.1f}"))


def print_live(build):
    result = json.loads(program(build, "composed_live", COMPOSED_ROUNDS))
    tracker, threads = result["tracker"], result["threads"]
    if not tracker["same"] or not threads["same"]:
        raise RuntimeError("a result depends on what runs beside it")
    one, two = (threads[key] for key in ("one_ms", "two_ms"))
    print(f"live tracker, base + 4 effects, {tracker['lanes']} directions of uncertainty: "
          "samples / s")
    print(f"  alone {tracker['alone_processor']:,.0f}; beside identifications in another thread "
          f"{tracker['beside_processor']:,.0f} ({tracker['beside_wall']:,.0f} on the wall); "
          "the same voltage")
    print("six starts of a search, one thread and two: the same result")
    print("  wall: one {} ms, two {} ms; one / two {} ({})".format(
        *(figures(times, "{:.0f}")[0] for times in (one, two)), *ratios(one, two)))
    print("  two loops that share nothing gain {} ({}) in the same rounds".format(
        *figures(threads["possible"])))
    print("  with a core for each thread the processor times of the six starts allow "
          f"{threads['starts']:.2f}")


def composed(build):
    print_fits(written(build, "composed_fit", COMPOSED_ROUNDS)["contenders"])
    print_lengths(build)
    print_live(build)
    print(program(build, "mixed_fit", COMPOSED_ROUNDS), end="")


def main():
    *which, build = sys.argv[1:] or [None]
    if build is None or which not in ([], ["composed"]):
        print(__doc__, file=sys.stderr)
        return 2
    try:
        (composed if which else window)(os.path.abspath(build))
    except (OSError, RuntimeError, subprocess.CalledProcessError) as failure:
        print(f"bench: {failure}", file=sys.stderr)
        return 1
    return 0

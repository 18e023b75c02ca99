"""Times one identification against Ceres and SciPy on the same window, in one run. Usage: bench BUILD_FOLDER

All contenders minimise the same cost from the same start on one thread; whoever ends in another optimum ends the run
with a message and status 1. Times are of the processor, not of the wall. The contenders take turns, so that a busy
machine slows all of them; what counts are the ratios.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

for library in ("OPENBLAS", "OMP", "MKL"):  # read when numpy is loaded
    os.environ[library + "_NUM_THREADS"] = "1"

import numpy as np  # noqa: E402

from . import scipy_fit  # noqa: E402
from .progress import followed  # noqa: E402

BATCHES, ROUNDS = 3, 6  # SciPy runs once a batch, the programs in C++ once a round
IDENTIFY, SEARCH = "ours, identify()", "ours, search alone"  # names that side_by_side.cpp gives
LINE = "{:<44} {:>9} {:>8} {:>16} {:>8} {:>16} {:>7}"


class Times:
    """[ms] of one contender, and its ratios to ours of the same round (SciPy: to the median of the same batch)."""

    def __init__(self, evaluations):
        self.evaluations = evaluations
        self.milliseconds, self.to_identify, self.to_search = [], [], []

    def add(self, milliseconds, identify, search):
        self.milliseconds.extend(milliseconds)
        self.to_identify.extend(theirs / ours for theirs, ours in zip(milliseconds, identify))
        self.to_search.extend(theirs / ours for theirs, ours in zip(milliseconds, search))


def run_programs(build, folder):
    """One batch of the C++ contenders; the parsed result."""
    out = os.path.join(folder, "batch.json")
    subprocess.run([os.path.join(build, "bench", "side_by_side"), str(ROUNDS), out], check=True)
    with open(out) as file:
        return json.load(file)


def require_same_optimum(name, unknowns, cost, batch):
    allowed = batch["tolerance"]
    ours = np.array(batch["optimum"])
    off = np.max(np.abs(unknowns[:4] / ours[:4] - 1.0))
    cost_off = abs(cost / batch["cost"] - 1.0)
    if off > allowed["optimum"] or cost_off > allowed["cost"]:
        raise RuntimeError("{} ended elsewhere: {} with cost {:.10g}, ours {} with {:.10g}".format(
            name, unknowns, cost, ours, batch["cost"]))


def add_batch(table, batch):
    times = {entry["name"]: entry["milliseconds"] for entry in batch["times"]}
    ours = times[IDENTIFY], times[SEARCH]
    for entry in batch["times"]:
        table.setdefault(entry["name"], Times(entry["evaluations"])).add(entry["milliseconds"], *ours)
    for name, settings in scipy_fit.CONTENDERS.items():
        begun = time.process_time()
        unknowns, cost, evaluations = scipy_fit.fit(batch["window"], batch["i0"], **settings)
        milliseconds = 1e3 * (time.process_time() - begun)
        require_same_optimum(name, unknowns, cost, batch)
        table.setdefault(name, Times(evaluations)).add([milliseconds], *([statistics.median(own)] for own in ours))


def microbenchmarks(build):
    """{name: [ns per sample]} of nine repetitions each, in the order they are written in: the bare loop of exp first."""
    program = os.path.join(build, "bench", "micro_benchmark")
    options = ["--benchmark_format=json", "--benchmark_repetitions=9", "--benchmark_min_time=0.1",
               "--benchmark_enable_random_interleaving=true"]
    output = subprocess.run([program] + options, check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
    times = {}
    for entry in sorted(json.loads(output)["benchmarks"], key=lambda entry: entry["family_index"]):
        if entry["run_type"] == "iteration" and not entry.get("error_occurred"):  # an instruction set it does not have
            times.setdefault(entry["run_name"], []).append(1e9 / entry["items_per_second"])
    return times


def figures(values, form):
    """Median, and smallest to largest, as text."""
    return form.format(statistics.median(values)), (form + " .. " + form).format(min(values), max(values))


def print_table(table, micro):
    print(LINE.format("one window, 240 s at 100 Hz", "median ms", "/ ident.", "min .. max", "/ search", "min .. max",
                      "passes"))
    for name, times in table.items():
        print(LINE.format(name, *figures(times.milliseconds, "{:.2f}")[:1], *figures(times.to_identify, "{:.2f}"),
                          *figures(times.to_search, "{:.2f}"), times.evaluations))
    print(LINE.format("one sample of a pass over the window", "median ns", "/ exp", "min .. max", "", "", "").rstrip())
    exponentials = next(iter(micro.values()))
    for name, values in micro.items():
        ratios = [own / bare for own, bare in zip(values, exponentials)]
        print(LINE.format(name, figures(values, "{:.1f}")[0], *figures(ratios, "{:.2f}"), "", "", "").rstrip())


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    build, table = os.path.abspath(sys.argv[1]), {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            for _ in followed(range(BATCHES), "batch"):
                add_batch(table, run_programs(build, folder))
        print_table(table, microbenchmarks(build))
    except (OSError, RuntimeError, subprocess.CalledProcessError) as failure:
        print("bench: {}".format(failure), file=sys.stderr)
        return 1
    return 0

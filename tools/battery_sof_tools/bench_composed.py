"""Times compositions: base + three effects against Ceres and SciPy, cost against length, live tracker, threads, fits behind a source.
Usage: bench_composed BUILD_FOLDER

Whoever ends in another optimum ends the run with a message and status 1. Times are of the processor but where the table
says wall. The contenders take turns; what counts are the ratios.
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

from . import scipy_composed_fit  # noqa: E402

ROUNDS, THREAD_ROUNDS = 5, 5
LENGTHS = (240, 900, 3600, 14400, 36000)  # [s]
SAME_COST = 1e-4
OURS, OURS_COMPRESSED = "ours: compressed, then full rate", "ours: of that on the compressed drive"
FIT = "{:<40} {:>9} {:>8} {:>16} {:>10} {:>8}  {}"
LENGTH = "{:>8} {:>9} {:>10} {:>12} {:>10} {:>10} {:>7} {:>12} {:>10} {:>10} {:>10}"


def program(build, name, *arguments):
    return subprocess.run([os.path.join(build, "bench", name), *map(str, arguments)], check=True,
                          stdout=subprocess.PIPE).stdout


def fits(build):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "fits.json")
        program(build, "composed_fit", ROUNDS, out)
        with open(out) as file:
            return json.load(file)


def with_scipy(result):
    """SciPy on the compressed drive, beside ours there."""
    begun = time.process_time()
    _, cost, simulations = scipy_composed_fit.fit(result["compressed"])
    milliseconds = 1e3 * (time.process_time() - begun)
    share = cost / result["compressed"]["cost"] - 1.0
    if abs(share) > SAME_COST:
        raise RuntimeError("SciPy ended elsewhere: cost away by a share of {:.2g}".format(share))
    return {"milliseconds": milliseconds, "share": share, "simulations": simulations}


def ratios(theirs, ours):
    each = [a / b for a, b in zip(theirs, ours)]
    return "{:.2f}".format(statistics.median(each)), "{:.2f} .. {:.2f}".format(min(each), max(each))


def print_fits(result, scipy):
    ours = {entry["name"]: entry["milliseconds"] for entry in result["contenders"]}
    print(FIT.format("base + 3 effects, 30 min at 100 Hz", "median ms", "/ first", "min .. max", "cost - 1", "std.err.",
                     "passes"))
    for entry in result["contenders"]:
        print(FIT.format(entry["name"], "{:.0f}".format(statistics.median(entry["milliseconds"])),
                         *ratios(entry["milliseconds"], ours[OURS]), "{:.1e}".format(entry["cost_share"]),
                         "{:.2f}".format(entry["standard_errors"]), entry["passes"]))
    print(FIT.format("the compressed drive alone", "median ms", "/ ours", "", "cost - 1", "", "passes"))
    beside = scipy["milliseconds"] / statistics.median(ours[OURS_COMPRESSED])
    print(FIT.format("SciPy trf, bounds, 2-point Jacobian", "{:.0f}".format(scipy["milliseconds"]),
                     "{:.0f}".format(beside), "once", "{:.1e}".format(scipy["share"]), "",
                     "{} short".format(scipy["simulations"])))


def print_optima(result):
    first, ceres = result["contenders"][0], result["contenders"][3]
    print("{:<40} {:>14} {:>14}".format("optimum", "ours", "Ceres, QR"))
    rows = zip(result["names"], first["parameters"] + first["state"], ceres["parameters"] + ceres["state"])
    for name, ours, theirs in rows:
        print("{:<40} {:>14.6g} {:>14.6g}".format(name, ours, theirs))


def print_lengths(build):
    print(LENGTH.format("length s", "samples", "pass ms", "ns / sample", "fit ms", "compressed", "passes",
                        "ns / (s. p.)", "record MB", "+ fit", "+ pass"))
    for seconds in LENGTHS:
        m = json.loads(program(build, "composed_length", seconds))
        print(LENGTH.format(
            seconds, m["samples"], "{:.1f}".format(m["pass_ms"]), "{:.0f}".format(1e6 * m["pass_ms"] / m["samples"]),
            "{:.1f}".format(m["fit_ms"]), m["compressed"], m["fit_passes"],
            "{:.0f}".format(1e6 * m["fit_ms"] / (m["samples"] * m["fit_passes"])), "{:.1f}".format(m["record_mb"]),
            "{:.1f}".format(m["fit_mb"]), "{:.1f}".format(m["pass_mb"])))


def print_live(build):
    result = json.loads(program(build, "composed_live", THREAD_ROUNDS))
    tracker, threads = result["tracker"], result["threads"]
    if not tracker["same"] or not threads["same"]:
        raise RuntimeError("a result depends on what runs beside it")
    print("live tracker, base + 4 effects, {} directions of uncertainty: samples / s".format(tracker["lanes"]))
    print("  alone {:,.0f}; beside identifications in another thread {:,.0f} ({:,.0f} on the wall); the same voltage".format(
        tracker["alone_processor"], tracker["beside_processor"], tracker["beside_wall"]))
    print("six starts of a search, one thread and two: the same result")
    print("  wall: one {:.0f} ms, two {:.0f} ms; one / two {} ({})".format(
        statistics.median(threads["one_ms"]), statistics.median(threads["two_ms"]),
        *ratios(threads["one_ms"], threads["two_ms"])))
    possible = threads["possible"]
    print("  two loops that share nothing gain {:.2f} ({:.2f} .. {:.2f}) in the same rounds".format(
        statistics.median(possible), min(possible), max(possible)))
    print("  with a core for each thread the processor times of the six starts allow {:.2f}".format(threads["starts"]))


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    build = os.path.abspath(sys.argv[1])
    try:
        result = fits(build)
        print_fits(result, with_scipy(result))
        print_optima(result)
        print_lengths(build)
        print_live(build)
        print(program(build, "mixed_fit", ROUNDS).decode(), end="")
    except (OSError, RuntimeError, subprocess.CalledProcessError) as failure:
        print("bench_composed: {}".format(failure), file=sys.stderr)
        return 1
    return 0

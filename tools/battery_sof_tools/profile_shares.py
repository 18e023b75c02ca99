"""Where the processor's time goes, by what the code is about: groups the symbols of a `perf record`.
Usage: profile_shares PERF_DATA

    perf record -F 299 -o PERF_DATA build/devel/lib/battery_sof/sof diagnose drive.csv
"""

import re
import subprocess
import sys

LINE = re.compile(r"\s+([\d.]+)%\s+\S+\s+(\S+)\s+\[.\]\s+(.*)")
WIDE = re.compile(r"Matrix<double, (8|16|24|48), 1, 0")
ONE = "Matrix<double, 1, 1, 0, 1, 1> >"
ALGEBRA = re.compile("gebp|gemm|general_matrix|triangular|ldlt|rank|sumsOf|evaluateDeviance|gemv")
LAYER = re.compile("balance|solve|::activity|euler|sideCurrent|DoubleLayer|matchedFlow|closedForm|currentAt|Ladder")
ENGINE = re.compile("EngineOf|SourceSearch|Layer")


def group(library, symbol):
    if library.startswith("libm"):
        return "exp, log and the like"
    if ALGEBRA.search(symbol) and "DoubleLayer" not in symbol:
        return "linear algebra"
    wide = WIDE.search(symbol)
    if LAYER.search(symbol):
        trial = not wide or (ONE in symbol and "::balance" in symbol)
        return "double layer: trials and values" if trial else "double layer: derivatives"
    if ENGINE.search(symbol):
        return "simulation around it: states, other effects, terminal voltage"
    return "sums and products of numbers with derivatives" if wide else "everything else"


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    report = subprocess.run(["perf", "report", "-i", sys.argv[1], "--stdio", "--no-children"], check=True,
                            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout.decode()
    shares = {}
    for found in filter(None, map(LINE.match, report.splitlines())):
        name = group(found[2], found[3])
        shares[name] = shares.get(name, 0.0) + float(found[1])
    for name, share in sorted(shares.items(), key=lambda item: -item[1]):
        print("{:5.1f} %  {}".format(share, name))
    return 0

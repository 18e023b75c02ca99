"""Draws what the pages show.

    page_drawings                          the diagrams: states of the node, a query, the energy manager
    page_drawings --build B                also a crank over the length of the stop, of the example drive
    page_drawings --build B --data D       also a crank and a charge of a real car, measured and predicted
"""

import argparse
import os
import tempfile

from ..files import ROOT, write_text
from ..sof import program
from . import diagrams, plots


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", help="build folder: draws what needs the command sof")
    parser.add_argument("--data", help="folder of the measured recordings: draws what needs them")
    parser.add_argument("--out", default=os.path.join(ROOT, "docs", "pictures"), help="folder of the drawings")
    args = parser.parse_args()
    if args.data and not args.build:
        parser.error("--data needs --build")
    for name, draw in diagrams.DIAGRAMS.items():
        write_text(os.path.join(args.out, name), draw())
    if args.build:
        sof = program(args.build, "sof")
        with tempfile.TemporaryDirectory(prefix="drawings_") as folder:
            plots.crank_over_stop(sof, folder, os.path.join(args.out, "crank_over_stop.svg"))
            if args.data:
                plots.measured_and_predicted(sof, args.data, folder, os.path.join(args.out, "measured_and_predicted.svg"))
    print(f"drawings are in {args.out}")
    return 0

"""Puts laws that no catalogue has into recordings that were measured, asks `sof diagnose`, and counts (docs/validation.md).

    proof_real BUILD --data FOLDER --out DIR [--count 200] [--minutes 30] [--seed 1] [--only RECORDING,...]
    proof_real BUILD --data FOLDER --out DIR --promised [--plain] [--only RECORDING,...]
    proof_real --only-score --out DIR [--markdown FILE]

The laws are those of `draw_out_of_model`, beside the recording's own current, so strong that what other parameters of the base circuit leave of them
is at least twice what the diagnosis of the unchanged recording calls too small to tell. Named is what is named with the law and not without.
With --promised the catalogue's own effects are put in, at the least strength that the answer to the unchanged recording lists (`detectable`).
At zero strength only what the base circuit takes up whole is changed. One row a case in DIR/rows.jsonl: a run that was cut off goes on.
"""

import argparse
import math
import os
import sys

from ..files import lines_of
from ..sof import catalogue, program
from ..out_of_model.cases import forms_of
from . import run, score


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default="build")
    parser.add_argument("--data", help="folder of the recordings")
    parser.add_argument("--out", default="build/proof_real", help="folder of the rows")
    parser.add_argument("--count", type=int, default=200, help="cases that are asked about")
    parser.add_argument("--minutes", type=float, default=math.inf, help="end after the case that passes these")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="recordings, comma-separated")
    parser.add_argument("--promised", action="store_true", help="effects of the catalogue, each at the least strength that a diagnosis of the unchanged recording promises to tell")
    parser.add_argument("--plain", action="store_true", help="with --promised: the recordings are all FOLDER/*.csv (time_s, current_a, voltage_v), such as simulated ones that lack nothing")
    parser.add_argument("--only-score", action="store_true", help="ask nothing")
    parser.add_argument("--markdown", help="file to write the tables to; printed too")
    return parser.parse_args(given)


def main(given=None):
    a = arguments(given)
    if not a.only_score:
        if not a.data:
            raise SystemExit("--data is missing: the folder of the recordings")
        if a.plain and not a.promised:
            raise SystemExit("--plain goes with --promised alone: laws are put into the recordings that were measured")
        draw = program(a.build, "draw_out_of_model")
        bench = run.Bench(program(a.build, "sof"), draw, a.data, a.out, a.plain)
        run.run(bench, a.seed, forms_of(draw), a.count, a.minutes, [one for one in a.only.split(",") if one],
                catalogue=catalogue(program(a.build, "sof")) if a.promised else None, say=lambda *said: print("proof_real:", *said, file=sys.stderr, flush=True))
    unchanged = {row["recording"]: row["answer"] for row in lines_of(os.path.join(a.out, run.UNCHANGED))}
    text = score.as_markdown(lines_of(os.path.join(a.out, run.ROWS)), unchanged)
    sys.stdout.write(text)
    if a.markdown:
        with open(a.markdown, "w") as file:
            file.write(text)
    return 0

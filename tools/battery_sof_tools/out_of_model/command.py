"""Judges `sof diagnose` on out-of-model cases: recordings of physics in forms that no catalogue has, and nulls (docs/validation.md).

    out-of-model cases --build B --out DIR [--kinds null=50,imperfect_null=200,other_form=140] [--seed 1] [--jobs 2]
    out-of-model cases --build B --out DIR --only-draw [--kinds ...] [--seed 1]
    out-of-model cases --out DIR --only-score [--markdown FILE] [--json FILE]

Draws the cases, shows every recording to `sof diagnose` under a name that reports nothing, keeps the answers (a second call goes on
where the first was cut off), and only then opens the labels. Beside every hold-out a ridge regression on currents and their memories
is set that the script fits itself.
"""

import argparse
import os
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one process a case

import numpy as np

from ..files import finished, require_same, write_json
from ..sof import Failure, catalogue, diagnose, product_digest, program, required
from .cases import ANSWERS, KINDS, LABELS, RECORDINGS, RIDGES, drawn, forms_of, path, plan
from .ridge import ridge_rmse
from .score import as_json, as_markdown, opened

USUAL = "null=50,imperfect_null=200,other_form=140"
PATIENCE_S = 1200.0  # of one diagnosis


def wanted_of(text):
    """Numbers by kind of "null=5,other_form=10"."""
    wanted = {}
    for part in text.split(","):
        kind, _, count = part.partition("=")
        if kind not in KINDS or not count.isdigit():
            raise SystemExit(f"--kinds: \"{part}\": expected one of {', '.join(KINDS)}, =, and how many")
        wanted[kind] = int(count)
    return wanted


def sof_of(a):
    return required(os.path.abspath(a.sof)) if a.sof else program(a.build, "sof")


def asked(sof, out, name):
    """Shows one recording to `sof diagnose` unless its answer is kept: {"seconds", "answer"} or {"seconds", "failed"}."""
    kept = path(out, ANSWERS, name, "json")
    if os.path.exists(kept):
        return
    began = time.monotonic()
    try:
        result = {"answer": diagnose(sof, path(out, RECORDINGS, name, "csv"), patience_s=PATIENCE_S)}
    except Failure as failure:
        result = {"failed": str(failure)}
    write_json(kept, dict(result, seconds=time.monotonic() - began))


def ridged(out, name):
    """The ridge's hold-out RMSE of one recording, kept."""
    kept = path(out, RIDGES, name, "json")
    if not os.path.exists(kept):
        data = np.loadtxt(path(out, RECORDINGS, name, "csv"), delimiter=",", skiprows=1)
        write_json(kept, {"rmse_v": ridge_rmse(*data.T[:3])})


def run(jobs, work, todo, what):
    return list(finished(jobs, work, todo, what))


def draw_cases(a):
    """Draws what is not drawn yet. Returns the names of the recordings."""
    draw = required(os.path.abspath(a.draw)) if a.draw else program(a.build, "draw_out_of_model")
    for folder in (RECORDINGS, LABELS):
        os.makedirs(os.path.join(a.out, folder), exist_ok=True)
    given = {key: value for key, value in (("rate", a.rate), ("duration", a.duration)) if value is not None}
    cases = plan(wanted_of(a.kinds), a.seed, forms_of(draw), **given)
    require_same(os.path.join(a.out, "plan.json"), {"cases": cases}, "other cases")
    for one in run(a.jobs, drawn, [(draw, a.out, case) for case in cases], "drawn"):
        if one:
            print("not drawn:", one, file=sys.stderr)
    return [case["name"] for case in cases if os.path.exists(path(a.out, RECORDINGS, case["name"], "csv"))]


def gather(a):
    """Draws, asks, fits the ridge; each goes on where it was cut off."""
    sof, names = sof_of(a), draw_cases(a)
    for folder in (ANSWERS, RIDGES):
        os.makedirs(os.path.join(a.out, folder), exist_ok=True)
    require_same(os.path.join(a.out, ANSWERS, "product.sha256"), product_digest(sof), "answers of another build of sof")
    run(a.jobs, asked, [(sof, a.out, name) for name in names], "asked")
    run(a.jobs, ridged, [(a.out, name) for name in names], "ridge")


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default="build", help="folder of the build")
    parser.add_argument("--sof", help="another sof than the build's")
    parser.add_argument("--draw", help="another draw_out_of_model than the build's")
    parser.add_argument("--out", required=True, help="folder of cases and answers")
    parser.add_argument("--kinds", default=USUAL, help=f"how many of each ({USUAL})")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rate", type=float, help="of all recordings [Hz]; the seeds choose 1, 10 or 100")
    parser.add_argument("--duration", type=float, help="of all recordings [s]; the seeds choose 600 to 3600")
    parser.add_argument("--jobs", type=int, default=2)
    only = parser.add_mutually_exclusive_group()
    only.add_argument("--only-draw", action="store_true", help="ask nothing: recordings and labels")
    only.add_argument("--only-score", action="store_true", help="draw and ask nothing")
    parser.add_argument("--markdown", help="write the tables there too")
    parser.add_argument("--json", help="write every case with its outcome")
    return parser.parse_args(given)


def main(given=None):
    a = arguments(given)
    if a.only_draw:
        print(f"{len(draw_cases(a))} recordings in {os.path.join(a.out, RECORDINGS)}")
        return 0
    if not a.only_score:
        gather(a)
    cases, failed = opened(a.out, catalogue(sof_of(a)))
    text = as_markdown(cases, failed)
    sys.stdout.write(text)
    for file, content in ((a.markdown, text), (a.json, as_json(cases, failed))):
        if file:
            with open(file, "w") as f:
                f.write(content)
    return 0

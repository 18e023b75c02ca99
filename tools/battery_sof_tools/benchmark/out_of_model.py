"""Judges `sof diagnose` on out-of-model cases: recordings of physics in forms that no catalogue has, and nulls (docs/validation.md).

    out_of_model --build B --out DIR [--kinds null=50,imperfect_null=200,other_form=140] [--seed 1] [--jobs 2] [--json FILE]
    out_of_model --build B --out DIR --only-draw [--kinds ...] [--seed 1]

Draws the cases, shows every recording to `sof diagnose` under a name that tells nothing, keeps the answers (a second call goes on
where the first was cut off), and only then opens the labels. Beside every hold-out a ridge regression on currents and their memories
is set that the script fits itself.
"""

import argparse
import functools
import json
import os
import random
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one process a case

from ..files import finished, lines_of, read_json, require_same, write_text
from ..recordings import read_plain
from ..sof import Failure, catalogue, program
from ..tables import table
from . import scorers
from .answers import Case, asked
from .generator import Generator, as_planned, seed_of
from .ridge import ridge_rmse
from .runner import ANSWERS, complete, kept_for

USUAL = "null=50,imperfect_null=200,other_form=140"
KINDS = {"null": "Plain nulls", "imperfect_null": "Imperfect nulls", "other_form": "Other forms"}
OTHER = "other_form"
PATIENCE_S = 1200.0  # of one diagnosis
RECORDINGS, LABELS, RIDGES = "recordings", "labels", "ridges.jsonl"


def path(out, folder, name, ending):
    return os.path.join(out, folder, f"{name}.{ending}")


def plan(wanted, seed, forms, **given):
    """Cases under opaque names, in an order of the seed. Mechanisms take turns, and within a mechanism its forms.

    wanted: number by kind.  forms: {mechanism: [form, ...]}.  given: rate [Hz] or duration [s] of all, in place of the seeds' choice.
    """
    cases = []
    for kind in KINDS:
        for number in range(wanted.get(kind, 0)):
            case = {"kind": kind, "seed": seed_of(seed, kind, number), **given}
            if kind == OTHER:
                mechanism = sorted(forms)[number % len(forms)]
                case.update(mechanism=mechanism, form=forms[mechanism][number // len(forms) % len(forms[mechanism])])
            cases.append(case)
    random.Random(seed).shuffle(cases)
    return [dict(case, name=f"case_{k:04d}") for k, case in enumerate(cases, 1)]


def wanted_of(text):
    """Numbers by kind of "null=5,other_form=10"."""
    wanted = {}
    for part in text.split(","):
        kind, _, count = part.partition("=")
        if kind not in KINDS or not count.isdigit():
            raise SystemExit(f"--kinds: \"{part}\": expected one of {', '.join(KINDS)}, =, and how many")
        wanted[kind] = int(count)
    return wanted


def drawn(generator, out, case):
    """Draws a case; what went wrong, or None."""
    try:
        generator.draw_labelled(case, path(out, RECORDINGS, case["name"], "csv"), path(out, LABELS, case["name"], "json"))
    except Failure as failure:
        return f"{case['name']}: {failure}"
    return None


def draw_missing(generator, out, jobs, cases):
    """Draws the cases of a folder that are not drawn yet; other cases than the folder's are refused. Returns those that have a recording."""
    for folder in (RECORDINGS, LABELS):
        os.makedirs(os.path.join(out, folder), exist_ok=True)
    require_same(os.path.join(out, "plan.json"), {"cases": cases}, "other cases")

    def is_there(case):
        return os.path.exists(path(out, RECORDINGS, case["name"], "csv")) and os.path.exists(path(out, LABELS, case["name"], "json"))
    for one in finished(jobs, drawn, [(generator, out, case) for case in cases if not is_there(case)], "drawn"):
        if one:
            print("not drawn:", one, file=sys.stderr)
    return [case for case in cases if is_there(case)]


def draw_cases(a):
    """Draws what is not drawn yet. Returns the cases that have a recording."""
    generator = Generator(a.build)
    asked_for = {"rate": a.rate, "duration": a.duration, "independent_drive": a.independent_drive or None}
    given = {key: value for key, value in asked_for.items() if value is not None}
    cases = plan(wanted_of(a.kinds), a.seed, generator.laws(), **given)
    return draw_missing(generator, a.out, a.jobs, cases)


def answer_of(sof, out, case):
    return {"answer": asked(sof, path(out, RECORDINGS, case["name"], "csv"), patience_s=PATIENCE_S)}


def ridge_of(out, case):
    return {"rmse_v": ridge_rmse(*read_plain(path(out, RECORDINGS, case["name"], "csv")))}


def gather(a):
    """Draws, asks, fits the ridge; each goes on where it was cut off."""
    sof, cases = program(a.build, "sof"), draw_cases(a)
    kept_for(a.out, sof)
    complete(os.path.join(a.out, ANSWERS), functools.partial(answer_of, sof, a.out), cases, a.jobs, "asked")
    complete(os.path.join(a.out, RIDGES), functools.partial(ridge_of, a.out), cases, a.jobs, "ridge")


def opened(out, catalogue_of=None):
    """Judged cases and what could not be judged."""
    rows, ridges = ({row["name"]: row for row in lines_of(os.path.join(out, name))} for name in (ANSWERS, RIDGES))
    cases, failed = [], []
    for name in (case["name"] for case in read_json(os.path.join(out, "plan.json"))["cases"]):
        label = path(out, LABELS, name, "json")
        row = rows.get(name, {"failed": "not asked"}) if os.path.exists(label) else {"failed": "not drawn"}
        if "failed" in row:
            failed.append(f"{name}: {row['failed']}")
        else:
            cases.append(Case(dict(as_planned(read_json(label)), name=name), row["answer"], catalogue_of, row["seconds"], ridges.get(name, {}).get("rmse_v")))
    return cases, failed


def as_markdown(cases, failed):
    lines = []

    def add(title, rows):
        lines.extend(["", f"**{title}**", ""] + table(["", ""], rows))

    for kind, title in KINDS.items():
        some = [one for one in cases if one.label["kind"] == kind]
        if some:
            add(f"{title} ({len(some)})", scorers.outcome_rows(some) + scorers.set_rows(some) + scorers.error_rows(some) if kind == OTHER else scorers.control_rows(some))
    if any(one.claims for one in cases):
        add("Probability of mechanisms, and how many were right", scorers.reliability_rows(cases))
    else:
        lines.extend(["", "No answer names a mechanism with a probability."])
    return "\n".join(lines[1:] + ([""] + [f"Not judged: {one}" for one in failed] if failed else [])) + "\n"


def as_json(cases, failed):
    """Every case with what was found of it, for looking closer."""
    keys = ("kind", "mechanism", "form", "drive", "seed", "duration_s", "sample_rate_hz", "visible_rms_v")
    rows = [{"name": one.label["name"], **{key: one.label.get(key) for key in keys}, "verdict": one.verdict, "mechanisms": sorted(one.said),
             "ratio": one.over_base(), "ridge_v": one.ridge_v, "base_v": one.held("base"), "extended_v": one.held("extended"), "withheld_v": one.answer.get("withheld_v"),
             "seconds": one.seconds, "effects": [effect["id"] for effect in one.answer["effects"]],
             "outcome": one.outcome if one.label["kind"] == OTHER else "alarm" if one.alarmed else one.verdict} for one in cases]
    return json.dumps({"cases": rows, "failed": failed}, indent=1)


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default="build", help="folder of the build")
    parser.add_argument("--out", required=True, help="folder of cases and answers")
    parser.add_argument("--kinds", default=USUAL, help=f"how many of each ({USUAL})")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rate", type=float, help="of all recordings [Hz]; the seeds choose 1, 10 or 100")
    parser.add_argument("--duration", type=float, help="of all recordings [s]; the seeds choose 600 to 3600")
    parser.add_argument("--independent-drive", action="store_true", help="drives drawn independently of the law, 60 to 3600 s")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only-draw", action="store_true", help="ask nothing: recordings and labels")
    parser.add_argument("--json", help="write every case with its outcome")
    return parser.parse_args(given)


def main(given=None):
    a = arguments(given)
    if a.only_draw:
        print(f"{len(draw_cases(a))} recordings in {os.path.join(a.out, RECORDINGS)}")
        return
    gather(a)
    cases, failed = opened(a.out, catalogue(program(a.build, "sof")))
    sys.stdout.write(as_markdown(cases, failed))
    write_text(a.json, as_json(cases, failed))

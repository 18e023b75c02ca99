"""Runs `sof diagnose` on cases of the reference simulator, as they are drawn, and counts.

    calibrate_diagnosis BUILD [--out FOLDER] [--set null=200 structural_null=60 effect=10 ...]
                        [--first-seed N] [--jobs N]

Judged as preregistered cases are; of these nothing is sealed: thresholds are chosen with them.
Answers are kept in FOLDER/answers.jsonl: a run that was cut off goes on where it stopped.
"""

import argparse
import functools
import os

from ..files import lines_of
from ..sof import catalogue, program
from ..tables import grouped, table
from .answers import asked
from .generator import Generator
from .preregistered import judged, score
from .runner import ANSWERS, complete, kept_for
from .scorers import share

# What is counted of a kind of case, and of those that no kind here names.
OF_KIND = {"null": {"any verdict but no_mismatch": lambda case: case.verdict != "no_mismatch"},
           "structural_null": {
               "a wrong name of tier P": judged.wrong_physics,
               "a wrong name of tier P or I": judged.wrong_names,
               "of these with no piece of structure in the class": judged.names_without_structure}}
OF_KIND["porous_null"] = OF_KIND["structural_null"]
OF_OTHERS = {"truth in the first class, at most three names": judged.class_true,
             "added effect named itself": judged.named_itself,
             "nothing said": lambda case: judged.is_silent(case.answer)}


def cases_of(listed, wanted, first_seed):
    for kind, count in wanted.items():
        if kind not in listed:
            raise SystemExit(f"no kind {kind}; known: {', '.join(sorted(listed))}")
        for name in listed[kind]:
            for seed in range(first_seed, first_seed + count):
                yield {"name": f"{kind}_{name}_{seed}", "family": kind, "id": name, "seed": seed}


def answer_of(generator, sof, case):
    with generator.drawn(case) as (label, recording):
        return dict(case, level=case["family"], expected=label["expected"], answer=asked(sof, recording))


def report(rows, known):
    """Lines: rates with their intervals, who was taken for whom, and what failed."""
    cases = [judged.Case(row, {"whole": row["answer"]}, None, known)
             for row in rows if "failed" not in row]
    figures = [(kind, what, share(right, some))
               for kind, some in grouped(cases, lambda case: case.level).items()
               for what, right in OF_KIND.get(kind, OF_OTHERS).items()]
    yield from table(("kind", "counted", "rate (95 %, Clopper and Pearson)"), figures)
    yield from ("", "who was taken for whom (truth: first name, or verdict in brackets)")
    yield from score.confusion_lines(score.confusion(cases))
    yield from (f"failed: {row['name']} {row['failed'][:200]}" for row in rows if "failed" in row)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--out", help="folder of answers.jsonl; default BUILD/calibration")
    parser.add_argument("--set", nargs="+", metavar="KIND=N",
                        default=["null=200", "structural_null=60", "effect=10"])
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    a = parser.parse_args()
    generator, sof = Generator(a.build), program(a.build, "sof")
    out = a.out or os.path.join(a.build, "calibration")
    path = os.path.join(out, ANSWERS)
    kept_for(out, sof)
    wanted = {kind: int(count) for kind, count in (part.split("=") for part in a.set)}
    cases = cases_of(generator.catalogue(), wanted, a.first_seed)
    complete(path, functools.partial(answer_of, generator, sof), cases, a.jobs, "case")
    print("\n".join(report(lines_of(path), catalogue(sof))))

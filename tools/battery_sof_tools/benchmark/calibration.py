"""Runs `sof diagnose` on cases drawn from the reference simulator and counts what it says.

    calibrate_diagnosis BUILD [--out FOLDER] [--set null=200 structural_null=60 effect=10 ...] [--ids ID,ID] [--first-seed N] [--jobs N]

The tool is a process of its own that is given the recording alone; the label is read once it has answered. Answers are kept
in FOLDER/answers.jsonl: a run that was cut off goes on where it stopped. Printed are the rates with their 95 % intervals
(Clopper and Pearson 1934) and the confusion matrix.
"""

import argparse
import collections
import functools
import os
import tempfile

from ..sof import catalogue, program
from ..files import lines_of
from .answers import LARGEST_CLASS, alike, asked, class_of, first_class
from .generator import Generator
from .runner import ANSWERS, complete, kept_for
from .scorers import share


def cases_of(listed, wanted, first_seed, only):
    for mechanism, count in wanted.items():
        if mechanism not in listed:
            raise SystemExit(f"no mechanism {mechanism}; known: {', '.join(sorted(listed))}")
        for name in listed[mechanism]:
            if only and name not in only | {"-"}:
                continue
            for seed in range(first_seed, first_seed + count):
                yield {"name": f"{mechanism}_{name}_{seed}", "mechanism": mechanism, "id": name, "seed": seed}


def answer_of(generator, sof, keep, case):
    with tempfile.TemporaryDirectory() as folder:
        recording = os.path.join(keep or folder, case["name"] + ".csv")
        label = generator.draw(case, recording)
        return dict(case, answer=asked(sof, recording), expected=label.get("expected"), strength=label.get("strength"))


def effects(row):
    return row["answer"]["effects"]


def is_wrong_physics(known, row):
    return any(one["id"] in known.physics and not any(alike(one["id"], other) and other not in known.physics for other in one["indistinguishable_from"])
               for one in effects(row))


def is_without_structure(known, row):
    return any(not known.structure & set(class_of(one)) for one in effects(row))


def report(rows, known):
    for row in [row for row in rows if "failed" in row][:5]:
        print("failed:", row["name"], row["failed"][:200])
    by = collections.defaultdict(list)
    for row in rows:
        if "failed" not in row:
            by[row["mechanism"]].append(row)
    for mechanism, group in by.items():
        print(f"\n{mechanism}: {len(group)} cases, verdicts", dict(collections.Counter(row["answer"]["verdict"] for row in group)))
        names = dict(collections.Counter(one["id"] for row in group for one in effects(row)))
        if mechanism == "null":
            print("  false alarms", share(lambda row: row["answer"]["verdict"] != "no_mismatch", group))
            print("  names", names)
        elif mechanism in ("structural_null", "porous_null"):
            print("  named physics that is not there", share(functools.partial(is_wrong_physics, known), group))
            print("  named physics or instruments that are not there", share(functools.partial(is_without_structure, known), group))
            print("  names", names)
        else:
            confusion(group)


def is_first(row):
    heard = first_class(row["answer"])
    true = (row["expected"] or {}).get("effects") or [row["id"]]  # some effects need another to be seen at all
    return bool(heard) and (any(alike(heard[0], one) for one in true) or (row["id"] in heard and len(heard) <= LARGEST_CLASS))


def is_named(row):
    return any(alike(one["id"], row["id"]) for one in effects(row))


def is_among_few(row):
    return is_named(row) and len(effects(row)) <= LARGEST_CLASS


def confusion(group):
    for name in sorted({row["id"] for row in group}):
        rows = [row for row in group if row["id"] == name]
        top = collections.Counter((first_class(row["answer"]) or [f"({row['answer']['verdict']})"])[0] for row in rows)
        first, named, few = (sum(map(right, rows)) for right in (is_first, is_named, is_among_few))
        print(f"  {name:30s} first or in its class {first:2d}, named {named:2d}, in at most three names {few:2d} of {len(rows):2d} | first: "
              + ", ".join(f"{k} {v}" for k, v in top.most_common()))
    print("  first or in a class of at most three", share(is_first, group))
    print("  named", share(is_named, group), "| in at most three names", share(is_among_few, group))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--out", default=None, help="folder of answers.jsonl; default BUILD/calibration")
    parser.add_argument("--set", nargs="+", default=["null=200", "structural_null=60", "effect=10"], metavar="FAMILY=N")
    parser.add_argument("--ids", default="", help="comma-separated; the only ones drawn of mechanisms that have ids")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", help="folder to leave the recordings in")
    parser.add_argument("--report-only", action="store_true")
    a = parser.parse_args()
    generator, sof = Generator(a.build), program(a.build, "sof")
    out = a.out or os.path.join(a.build, "calibration")
    path = os.path.join(out, ANSWERS)
    if not a.report_only:
        kept_for(out, sof)
        wanted = {mechanism: int(count) for mechanism, count in (part.split("=") for part in a.set)}
        cases = cases_of(generator.catalogue(), wanted, a.first_seed, {name for name in a.ids.split(",") if name})
        complete(path, functools.partial(answer_of, generator, sof, a.keep), cases, a.jobs, "case")
    report(sorted(lines_of(path), key=lambda row: row["name"]), catalogue(sof))

"""Runs `sof diagnose` on cases drawn from the reference simulator and counts what it says.

    calibrate_diagnosis BUILD [--out FOLDER] [--set null=200 structural_null=60 effect=10 ...] [--ids ID,ID] [--first-seed N] [--jobs N]

The tool is a process of its own that is given the recording alone; the label is read once it has answered. Answers are kept
in FOLDER/results.jsonl: a run that was cut off goes on where it stopped. Printed are the rates with their 95 % intervals
(Clopper and Pearson 1934), the confusion matrix, and the evidence of wrong names, from which thresholds follow.
"""

import argparse
import collections
import concurrent.futures
import json
import os
import subprocess
import sys
import tempfile

from .files import append, lines_of
from .progress import followed
from .proof.names import alike
from .rates import rate
from .sof import Failure, catalogue, diagnose, program


def cases_of(draw, wanted, first_seed, only):
    listed = [line.split() for line in subprocess.run([draw, "--list"], check=True, capture_output=True, text=True).stdout.splitlines()]
    for mechanism, count in wanted.items():
        ids = [words[1] if len(words) > 1 else "" for words in listed if words[0] == mechanism]
        if not ids:
            sys.exit(f"no mechanism {mechanism}; known: {', '.join(sorted({words[0] for words in listed}))}")
        for name in ids:
            if only and name not in only | {"", "-"}:
                continue
            for seed in range(first_seed, first_seed + count):
                yield mechanism, name, seed


def run_case(draw, sof, case, keep):
    mechanism, name, seed = case
    with tempfile.TemporaryDirectory() as folder:
        recording, label = os.path.join(keep or folder, f"{mechanism}_{name}_{seed}.csv"), os.path.join(folder, "label.json")
        command = [draw, "--family", mechanism, "--seed", str(seed), "--out", recording, "--label", label]
        if name:
            command += ["--id", name]
        drawn = subprocess.run(command, capture_output=True, text=True)
        if drawn.returncode:
            return {"case": case, "failed": drawn.stderr.strip()}
        try:
            diagnosis = diagnose(sof, recording)
        except Failure as failure:
            return {"case": case, "failed": str(failure)}
        with open(label) as f:
            truth = json.load(f)
    fit = diagnosis["fit"]
    return {"case": case, "verdict": diagnosis["verdict"],
            "effects": [[e["id"], e["confidence"], e.get("evidence"), e.get("indistinguishable_from", [])] for e in diagnosis["effects"]],
            "candidates": [[c["id"], c["evidence"], c["holdout_gain_percent"], c["rejected_because"]] for c in diagnosis["candidates"]],
            "base_rmse": fit["base"]["holdout"]["rmse_v"], "extended_rmse": fit["extended"]["holdout"]["rmse_v"],
            "mechanism": diagnosis.get("mechanism"), "expected": truth.get("expected"), "strength": truth.get("strength")}


def first_class(result):
    """Names of the strongest finding and what it is tied with."""
    if not result["effects"]:
        return []
    name, _, _, tied = result["effects"][0]
    return [name] + list(tied)


def report(results, known):
    failed = [r for r in results if "failed" in r]
    done = [r for r in results if "failed" not in r]
    for r in failed[:5]:
        print("failed:", r["case"], r["failed"][:200])
    by = collections.defaultdict(list)
    for r in done:
        by[r["case"][0]].append(r)
    for mechanism, group in by.items():
        print(f"\n{mechanism}: {len(group)} cases, verdicts", dict(collections.Counter(r["verdict"] for r in group)))
        names = collections.Counter(e[0] for r in group for e in r["effects"])
        if mechanism == "null":
            print("  false alarms", rate(sum(r["verdict"] != "no_mismatch" for r in group), len(group)))
            print("  names", dict(names))
        elif mechanism in ("structural_null", "porous_null"):
            wrong = [r for r in group if any(e[0] in known.physics and not any(alike(e[0], t) and t not in known.physics for t in e[3])
                                             for e in r["effects"])]
            either = [r for r in group if any(e[0] not in known.structure and not known.structure & set(e[3]) for e in r["effects"])]
            print("  named physics that is not there", rate(len(wrong), len(group)))
            print("  named physics or instruments that are not there", rate(len(either), len(group)))
            print("  names", dict(names))
        else:
            confusion(group, names)


def confusion(group, names):
    ids = sorted({r["case"][1] for r in group})
    first = named = classes = 0
    for name in ids:
        rows = [r for r in group if r["case"][1] == name]
        top = collections.Counter()
        hit_first = hit = hit_class = 0
        for r in rows:
            heard = first_class(r)
            top[heard[0] if heard else f"({r['verdict']})"] += 1
            true = (r["expected"] or {}).get("effects") or [name]  # some effects need another to be seen at all
            hit_first += bool(heard) and (any(alike(heard[0], t) for t in true) or (name in heard and len(heard) <= 3))
            everything = [e[0] for e in r["effects"]]
            hit += any(alike(one, name) for one in everything)
            hit_class += any(alike(one, name) for one in everything) and len(everything) <= 3
        first, named, classes = first + hit_first, named + hit, classes + hit_class
        print(f"  {name:30s} first or in its class {hit_first:2d}, named {hit:2d}, in at most three names {hit_class:2d} of {len(rows):2d} | first: "
              + ", ".join(f"{k} {v}" for k, v in top.most_common()))
    print("  first or in a class of at most three", rate(first, len(group)))
    print("  named", rate(named, len(group)), "| in at most three names", rate(classes, len(group)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--out", default=None, help="folder of results.jsonl; default BUILD/calibration")
    parser.add_argument("--set", nargs="+", default=["null=200", "structural_null=60", "effect=10"], metavar="FAMILY=N")
    parser.add_argument("--ids", default="", help="comma-separated; the only ones drawn of mechanisms that have ids")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--keep", help="folder to leave the recordings in")
    parser.add_argument("--report-only", action="store_true")
    arguments = parser.parse_args()
    draw, sof = program(arguments.build, "draw_case"), program(arguments.build, "sof")
    out = arguments.out or os.path.join(arguments.build, "calibration")
    os.makedirs(out, exist_ok=True)
    path = os.path.join(out, "results.jsonl")
    results = lines_of(path)
    known = {tuple(r["case"]) for r in results}
    wanted = dict((part.split("=")[0], int(part.split("=")[1])) for part in arguments.set)
    ids = {name for name in arguments.ids.split(",") if name}
    todo = [] if arguments.report_only else [c for c in cases_of(draw, wanted, arguments.first_seed, ids) if c not in known]
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        pending = [pool.submit(run_case, draw, sof, case, arguments.keep) for case in todo]
        for finished in followed(concurrent.futures.as_completed(pending), "case", len(todo)):
            results.append(finished.result())
            append(path, results[-1])
    results.sort(key=lambda r: [str(part) for part in r["case"]])
    report(results, catalogue(sof))

"""The sealed benchmark of `sof diagnose` (docs/validation.md).

    proof seal  --build B --seed-from HASH --out DIR [--share 1.0]     draws cases and strengths, publishes the labels' digest
    proof run   --build B --seal DIR --out RESULTS                     shows every recording to `sof diagnose`
    proof score --build B --seal DIR --out RESULTS [--json FILE]
    proof quick --build B --seal DIR --out RESULTS [--json FILE]       run again and score, with bounds: exit code 1 beyond them
    proof sealed --build B --docs docs/proof --out OUT   all of it for the committed seal
"""

import argparse
import os
import shutil
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one process a case; the same sums on every machine

from ...files import digest, read_text, write_text
from ...sof import catalogue, program
from . import score, seal


def do_seal(a):
    only = a.levels.split(",") if a.levels else None
    seal.seal(a.build, a.seed_from, a.share, a.out, a.max_porous, a.duration, only, a.jobs)


def do_score(a):
    report = score.score(*seal.cases_of(a.seal, a.out, catalogue(program(a.build, "sof"))))
    text = score.as_text(report)
    sys.stdout.write(text)
    write_text(a.text, text)
    write_text(a.json, score.as_json(report) + "\n")
    return report


def do_quick(a):
    """Every time again: answers that were kept would hide what has changed."""
    shutil.rmtree(a.out, ignore_errors=True)
    seal.run(a.build, a.seal, a.out, a.jobs, with_truth=False)
    said = score.broken(do_score(a))
    for one in said:
        print("beyond its bound:", one)
    sys.exit(1 if said else 0)


def do_sealed(a):
    """The committed digest must come out again from the frozen commit's hash."""
    committed = os.path.join(a.docs, seal.SEAL)
    if not os.path.exists(committed):
        sys.exit(f"{committed} is missing: nothing is sealed yet (docs/validation.md says how)")
    secret = read_text(os.path.join(a.docs, "frozen")).strip()
    sealed, results = os.path.join(a.out, "seal"), os.path.join(a.out, "results")
    if not os.path.exists(os.path.join(sealed, seal.SEAL)):
        seal.seal(a.build, secret, 1.0, sealed, jobs=a.jobs)
    if digest(committed) != digest(os.path.join(sealed, seal.SEAL)):
        sys.exit(f"{sealed}/seal.json is not {committed}: other labels were sealed")
    seal.run(a.build, sealed, results, a.jobs)
    a.text, a.json = (os.path.join(a.out, name) for name in ("score.txt", "score.json"))
    a.seal, a.out = sealed, results
    do_score(a)


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)

    def command(name, does, *options):
        one = commands.add_parser(name)
        one.set_defaults(does=does, text=None)
        for option, settings in options:
            one.add_argument(option, **settings)

    build = ("--build", {"default": "build"})
    out = ("--out", {"required": True})
    jobs = ("--jobs", {"type": int, "default": os.cpu_count()})
    sealed = ("--seal", {"required": True})
    command("seal", do_seal, build, out, jobs, ("--seed-from", {"required": True}), ("--share", {"type": float, "default": 1.0}),
            ("--max-porous", {"type": int, "default": None}), ("--duration", {"type": float, "default": None}),
            ("--levels", {"help": "comma-separated; only these"}))
    command("run", lambda a: seal.run(a.build, a.seal, a.out, a.jobs), build, sealed, out, jobs)
    command("score", do_score, build, sealed, out, ("--json", {}))
    command("quick", do_quick, build, sealed, out, jobs, ("--json", {}))
    command("sealed", do_sealed, build, out, jobs, ("--docs", {"required": True}))
    return parser.parse_args(given)


def main(given=None):
    chosen = arguments(given)
    chosen.does(chosen)

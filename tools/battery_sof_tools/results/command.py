"""Measures what the pages say and keeps it in docs/results.json (CONTRIBUTING.md, Figures).

    results collect [--only ID ...] [--quick] [--build B] [--data D]    runs the commands, keeps their figures, renders the pages
    results list                                                        what there is, how long it takes, at which commit it was measured
    results pages                                                       renders the pages
    results gate [--only ID ...] [--quick] [--against COMMIT] [--json FILE] [--build B] [--data D]

The gate runs the same commands, sets their figures beside those of docs/results.json (of COMMIT, where it is given) and ends with 1 where one is
worse by more than its scatter. --quick: what takes at most five minutes each.
"""

import argparse
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile

from ..files import ROOT, digest, read_json, write_text
from ..tables import table
from . import gate, pages
from .measurements import MEASUREMENTS

DOCS = os.path.join(ROOT, "docs")
QUICK_MINUTES = 5
DIGITS = 6


def rounded(value):
    """Numbers with DIGITS digits, in any nesting."""
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def printed(command, places):
    """What a command prints. SystemExit where it fails; code 1 is an honest negative outcome, or beyond a bound."""
    words = shlex.split(command)
    for place, path in places.items():
        words = [word.replace(place, path) for word in words]
    done = subprocess.run(words, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"exit code {done.returncode}: {shlex.join(words)}")
    return done.stdout


def measured(name, places, docs=None):
    """Figures of one measurement, and digests of the files it made, which go to docs where that is given."""
    one = MEASUREMENTS[name]
    with tempfile.TemporaryDirectory(prefix="results_") as folder:
        os.makedirs(os.path.join(folder, "docs", "pictures"))
        text = "\n".join(printed(command, dict(places, OUT=folder)) for command in one.commands)
        try:
            figures = rounded(one.kept(folder, text))
        except FileNotFoundError as missing:
            raise SystemExit(f"{name}: no {os.path.basename(missing.filename)} was made; its commands say why above") from missing
        for file in one.files if docs else ():
            shutil.copyfile(os.path.join(folder, "docs", file), os.path.join(docs, file))
        return figures, {file: digest(os.path.join(folder, "docs", file)) for file in one.files if file.endswith(".png")}


def head():
    return subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=True).stdout.strip()


def collect(args):
    for name in args.chosen:
        print(f"{name}: about {MEASUREMENTS[name].minutes:g} min", file=sys.stderr, flush=True)
        figures, files = measured(name, args.places, DOCS)
        results = read_json(pages.RESULTS)
        results[name] = {"commands": list(MEASUREMENTS[name].commands), "commit": head(), "figures": figures, "files": files}
        write_text(pages.RESULTS, json.dumps(results, indent=1, sort_keys=True) + "\n")
    pages.write()


def hold(args):
    if args.against:
        told = subprocess.run(["git", "show", f"{args.against}:docs/results.json"], cwd=ROOT, capture_output=True, text=True)
        if told.returncode:
            raise SystemExit(f"--against {args.against}: {told.stderr.strip()}")
        before = json.loads(told.stdout)
    else:
        before = read_json(pages.RESULTS)
    now = {}
    for name in [one for one in args.chosen if one in {figure.id.split(".")[0] for figure in gate.FIGURES}]:
        print(f"{name}: about {MEASUREMENTS[name].minutes:g} min", file=sys.stderr, flush=True)
        now[name] = {"figures": measured(name, args.places)[0]}
        write_text(args.json, json.dumps(now, indent=1))
    rows, worse = gate.held(before, now)
    print("\n".join(table(gate.HEAD, rows)))
    return 1 if worse else 0


def listed(_):
    results = read_json(pages.RESULTS)
    for name, entry in results.items():
        one = MEASUREMENTS.get(name)
        print(f"{name}: at {entry['commit']}" + (f", {one.minutes:g} min" + (", needs --data" if one.data else "") if one else ", recorded"))
        for command in entry["commands"]:
            print("    " + command)


def chosen(args):
    """Ids that the options name, those that need data only with it. SystemExit for an unknown one."""
    for name in args.only:
        if name not in MEASUREMENTS:
            raise SystemExit(f"--only {name}: expected one of {', '.join(MEASUREMENTS)}")
        if MEASUREMENTS[name].data and not args.data:
            raise SystemExit(f"{name} needs the folder of the measured recordings: --data FOLDER")
    return args.only or [name for name, one in MEASUREMENTS.items() if (args.data or not one.data) and not (args.quick and one.minutes > QUICK_MINUTES)]


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("list").set_defaults(does=listed)
    commands.add_parser("pages").set_defaults(does=lambda _: pages.write())
    for name, does in (("collect", collect), ("gate", hold)):
        one = commands.add_parser(name)
        one.set_defaults(does=does)
        one.add_argument("--only", nargs="+", default=[], metavar="ID")
        one.add_argument("--quick", action="store_true")
        one.add_argument("--build", default=os.path.join(ROOT, "build"))
        one.add_argument("--data", help="folder of the measured recordings; without it what needs them is left out")
        if name == "gate":
            one.add_argument("--against", metavar="COMMIT", help="docs/results.json of that commit in place of the one that is there")
            one.add_argument("--json", metavar="FILE", help="keeps the new figures there")
    args = parser.parse_args(given)
    if args.command in ("collect", "gate"):
        args.chosen = chosen(args)
        args.places = {"BUILD": os.path.abspath(args.build), "DATA": os.path.abspath(args.data or ".")}
    return args


def main(given=None):
    args = arguments(given)
    return args.does(args) or 0

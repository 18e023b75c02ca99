"""sof-fleet: runs `sof` on many recordings, collects the results in one database, and shows them on one page (docs/fleet.md).

    sof-fleet run RECORDINGS... --out FOLDER     check, convert, identify, predict, diagnose and score each; call again to continue
    sof-fleet report FOLDER                      write FOLDER/report.html
    sof-fleet load FOLDER                        build FOLDER/fleet.sqlite again from the results in the folder
    sof-fleet export FOLDER --csv DIR            write each table as a CSV file
    sof-fleet rebuild FLEET.sqlite --out FOLDER  build the folder again from its database
    sof-fleet judge FOLDER                       count false positives and false discoveries on recordings that out_of_model --only-draw drew
    sof-fleet digest FOLDER                      print the SHA-256 of all rows except measured times

Exit codes: 0 done; 1 jobs were lost, call again; 2 refused, and a sentence names what is wrong and what to do.
"""

import argparse
import os
import sqlite3
import sys
import time

from ..files import printable, write_json, write_text
from ..sof import product_digest, program
from . import database, engine, plan

MOST = 3e7  # [s], and of jobs
DESCRIPTION = "RECORDINGS: folders, .csv or .bag files, or lists of them (.csv or .yaml) with the columns path, battery, vehicle_type, age_years, time_column, current_column, " \
              "voltage_column, temperature_column, topic, discharge_positive, from_s, to_s, effects; only path is needed."


def parser():
    every = argparse.ArgumentParser(description=__doc__, epilog=DESCRIPTION, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = every.add_subparsers(dest="command", required=True)

    def command(name, does, words, folder="folder", about=None):
        one = commands.add_parser(name, help=words)
        one.set_defaults(does=does)
        one.add_argument(folder, help=about)
        return one

    either = "folder or database"
    add_run(commands.add_parser("run", help="run all steps that are still missing in the folder", epilog=DESCRIPTION))
    one = command("report", report, "write the page of the fleet")
    one.add_argument("--out", help="page to write; FOLDER/report.html by default. Links to recordings' pages work from there alone")
    one.add_argument("--nulls", metavar="FOLDER", help="folder of a fleet of fault-free controls, processed with the same sof; p-values are computed from it")
    command("load", lambda args: print(f"{database.load(args.folder)} recordings"), "build the database again from the results")
    one = command("export", lambda args: database.export(args.folder, args.csv), "write the tables as CSV", about=either)
    one.add_argument("--csv", required=True, help="folder to write")
    one = command("rebuild", rebuild, "build the folder again from its database", "database")
    one.add_argument("--out", required=True)
    one = command("judge", judge, "count false positives and false discoveries on drawn recordings, whose labels have the truth", about=either)
    one.add_argument("--nulls", metavar="FOLDER", help="as for report")
    command("digest", lambda args: print(database.digest(args.folder)), "print a checksum of all rows except measured times", about=either)
    return every


def positive(kind):
    """A type of argparse: a number above 0, finite and below a year of seconds."""
    def number(text):
        value = kind(text)
        if not 0 < value < MOST:
            raise argparse.ArgumentTypeError(f"{text} is not above 0 and below {MOST:g}")
        return value
    return number


def add_run(one):
    one.set_defaults(does=run)
    one.add_argument("recordings", nargs="+")
    one.add_argument("--out", required=True, help="folder of results")
    one.add_argument("--steps", default=",".join(plan.STEPS), help="comma-separated; all by default")
    one.add_argument("--jobs", type=positive(int), default=os.cpu_count(), help="at a time; all cores by default")
    one.add_argument("--slurm", action="store_true", help="as jobs of Slurm")
    one.add_argument("--window", type=positive(float), default=900.0, help="[s] fitted, and predicted, by the step score")
    one.add_argument("--patience", type=positive(float), default=1800.0, help="[s] for one step of one recording")
    one.add_argument("--without-pages", action="store_true", help="no page of each recording")
    one.add_argument("--build", default="build", help="folder of the build")
    one.add_argument("--sof", help="the command, in place of the build's")


def steps_of(text):
    """In their order. SystemExit for names that are none."""
    wanted = text.split(",")
    unknown = sorted(set(wanted) - set(plan.STEPS))
    if unknown:
        raise SystemExit(f"no step {', '.join(unknown)}; there are {', '.join(plan.STEPS)}")
    return [step for step in plan.STEPS if step in wanted]


def run(args):
    steps = steps_of(args.steps)
    sof = program(args.build, "sof", args.sof)
    options = {"window_s": args.window, "without_pages": args.without_pages}
    begin = time.monotonic()
    os.makedirs(args.out, exist_ok=True)
    lock = engine.alone(args.out)
    recordings = plan.make(args.out, args.recordings, steps, product_digest(sof), options)
    write_json(os.path.join(args.out, "setting.json"), {"sof": sof, "patience_s": args.patience})
    left = engine.run(args.out, recordings, steps, args.jobs, args.slurm)
    worked = time.monotonic()
    database.load(args.out)
    lock.close()
    print(f"{printable(args.out)}/{database.NAME}: {len(recordings)} recordings; {worked - begin:.1f} s, database {time.monotonic() - worked:.1f} s", file=sys.stderr)
    for entry in left[:10]:
        print(f"{printable(entry['path'])}: not finished; {printable(args.out)}/engine.log says why, call again to go on", file=sys.stderr)
    return 1 if left else 0


def report(args):
    from . import page  # statsmodels takes its time
    out = args.out or os.path.join(args.folder, "report.html")
    write_text(out, page.make(args.folder, args.nulls))
    print(printable(out))


def rebuild(args):
    database.rebuild(args.database, args.out)
    database.load(args.out)


def judge(args):
    from . import judge as truth, page  # statsmodels takes its time
    print("\n".join(truth.judged(database.open_read(args.folder), page.nulls_of(args.nulls))))


def main():
    args = parser().parse_args()
    try:
        return args.does(args) or 0
    except SystemExit as refused:  # with a sentence, as all here
        reason = refused.code
    except OSError as error:
        reason = f"{error.filename or 'sof-fleet'}: {error.strerror}"
    except sqlite3.Error as error:
        reason = f"the database: {error}"
    print(printable(str(reason)), file=sys.stderr)
    return 2

"""Sets the energy manager of examples/ beside two simple rules of start-stop.

    compare_stop_rules REC [REC ...] --build build --u-required 10.6 COLUMNS
    compare_stop_rules --weakening 3 --build build --u-required 9

A stop is a discharge that ends in a crank, a current of -150 A: it begins with the first sample below -2 A and ends with the first below -75 A.
`experiment rules` plays each recording through the node's session and the manager's rule; a simple rule sees the voltage alone, or the clock alone.

stops: those the rule let begin. engine off: until the crank, or until the rule wanted the engine on again. to the end: the engine was off until the recorded
crank. below: such cranks whose lowest voltage was below --u-required; their share is of the stops to the end. What a crank would have been that a rule wanted
earlier is not known; the recorded one, later, is no higher on a battery that is being discharged. missed: stops not begun whose crank held.

--weakening N makes N drives of a battery that weakens: ten parts of ten minutes each, resistance from 4 to 14 mOhm, 4 % of the charge lost in each.
"""

import argparse
import collections
import os
import tempfile

import numpy as np
import yaml

from . import recordings
from .files import ROOT, read_text, write_text
from .progress import followed
from .sof import call, program, rows_of
from .tables import table

Stop = collections.namedtuple("Stop", "begin end lowest rows")  # [s], [s], [V], (time [s], voltage [V]) while the engine was off
Outcome = collections.namedtuple("Outcome", "begun off_s to_the_end below missed")
DISCHARGING = -2.0  # [A]
LONGEST_GAP = LONGEST_CRANK = 5.0  # [s]
MARGIN = 0.2  # [V], of the manager
I_CRANKING, T_CRANKING = -200.0, 0.5  # [A], [s], of the least crank that the manager reckons with
REST_VOLTAGE = 12.2  # [V], of the rule by voltage
LONGEST_S = 60.0  # of the rule by time
CRANK_CURRENT = -150.0  # [A]
PARTS, PART_S = 10, 600.0  # of a drive of a battery that weakens


def stops_of(t, i, u):
    """Every stop of a recording; one with a gap inside is left out."""
    stops, cranking = [], i <= 0.5 * CRANK_CURRENT
    for end, behind in recordings.runs(cranking):
        begin = end
        while begin > 0 and i[begin - 1] < DISCHARGING and t[begin] - t[begin - 1] <= LONGEST_GAP and not cranking[begin - 1]:
            begin -= 1
        if begin < end and np.min(i[end:behind]) <= CRANK_CURRENT and t[behind - 1] - t[end] <= LONGEST_CRANK:
            stops.append(Stop(float(t[begin]), float(t[end]), float(np.min(u[end:behind])), (t[begin:end], u[begin:end])))
    return stops


def outcome(stops, off_until, u_required):
    """Counts of a rule. off_until: for each stop the moment [s] until which the rule lets the engine be off, None where it lets no stop begin."""
    begun = [(stop, until) for stop, until in zip(stops, off_until) if until is not None]
    whole = [stop for stop, until in begun if until >= stop.end]
    return Outcome(len(begun), sum(min(until, stop.end) - stop.begin for stop, until in begun), len(whole),
                   sum(stop.lowest < u_required for stop in whole),
                   sum(until is None and stop.lowest >= u_required for stop, until in zip(stops, off_until)))


def by_voltage(stop, least):
    """Off while the voltage is at least `least` [V]."""
    time, voltage = stop.rows
    if voltage[0] < least:
        return None
    low = np.flatnonzero(voltage < least)
    return time[low[0]] if len(low) else stop.end


def by_manager(stops, decisions):
    """decisions: rows (stop, time [s], may_stop) in order."""
    until = [None] * len(stops)
    over = set()
    for number, time, may in decisions:
        if number in over:
            continue
        if may:
            until[number] = stops[number].end
        else:
            over.add(number)
            until[number] = time if until[number] is not None else None
    return until


def decide(experiment, path, columns, stops, options):
    """Rows of `experiment rules` on a recording."""
    with tempfile.NamedTemporaryFile("w", suffix=".csv") as file:
        file.write("begin_s,end_s\n" + "".join(f"{s.begin!r},{s.end!r}\n" for s in stops))
        file.flush()
        rows = rows_of([experiment, "rules", path, "--stops", file.name, *columns, *options])
    return [(int(r["stop"]), r["time_s"], bool(r["may_stop"])) for r in rows]


def weakening(sof, seed, path):
    """A drive of a battery that weakens from part to part, written as CSV; the parts follow each other without a gap."""
    scenario = yaml.safe_load(read_text(os.path.join(ROOT, "config", "scenarios", "city_drive.yaml")))
    whole = []
    with tempfile.TemporaryDirectory() as folder:
        for part in range(PARTS):
            scenario.update(soc=0.85 - 0.04 * part, duration_s=PART_S, seed=100 * seed + part)
            scenario["battery"] = {"r_ohmic_ohm": 0.004 + 0.01 * part / (PARTS - 1)}
            scenario["profile"]["net_charge_ah"] = -2.0
            plan, made = os.path.join(folder, "part.yaml"), os.path.join(folder, "part.csv")
            write_text(plan, yaml.safe_dump(scenario))
            call([sof, "simulate", plan, made])
            t, i, u = recordings.read(made)
            whole.append((t + part * PART_S, i, u))
    recordings.write(path, *(np.concatenate(each) for each in zip(*whole)))


def cells(label, rule, count, o):
    share = f"{100.0 * o.below / o.to_the_end:.1f} %" if o.to_the_end else "-"
    return [label, rule, f"{o.begun} of {count}", f"{o.off_s:.0f} s", o.to_the_end, o.below, share, o.missed]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0], epilog="\n".join(__doc__.split("\n")[1:]),
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="*", metavar="REC", help="CSV files")
    parser.add_argument("--weakening", type=int, default=0, metavar="N", help="also N simulated drives of a battery that weakens")
    parser.add_argument("--build", default="build", help="build folder; it needs the target experiment")
    parser.add_argument("--u-required", type=float, default=7.2, help="[V], what a crank has to hold")
    recordings.add_column_arguments(parser)
    return parser.parse_args()


def judge(args, path, names, label):
    columns = recordings.column_options(names, args.discharge_positive)
    stops = stops_of(*recordings.read(path, names, args.discharge_positive))
    options = ["--u-required", str(args.u_required), "--margin", str(MARGIN), f"--i-cranking={I_CRANKING}", "--t-cranking", str(T_CRANKING)]
    decisions = decide(program(args.build, "experiment"), path, columns, stops, options)
    rules = [("manager", by_manager(stops, decisions)),
             (f"voltage at least {REST_VOLTAGE:g} V", [by_voltage(s, REST_VOLTAGE) for s in stops]),
             (f"at most {LONGEST_S:g} s", [s.begin + LONGEST_S for s in stops]),
             ("always", [s.end for s in stops])]
    return [(label, name, len(stops), outcome(stops, until, args.u_required)) for name, until in rules]


def total(rows):
    """The rows of all recordings added up by rule."""
    for rule in dict.fromkeys(row[1] for row in rows):
        counts, outcomes = zip(*(row[2:] for row in rows if row[1] == rule))
        yield "all", rule, sum(counts), Outcome(*map(sum, zip(*outcomes)))


def main():
    args = arguments()
    names = recordings.columns_of(args)[0]
    rows = []
    for path in args.recordings:
        rows += judge(args, path, names, os.path.splitext(os.path.basename(path))[0])
    sof = program(args.build, "sof") if args.weakening else None
    for seed in followed(range(1, args.weakening + 1), "weakening drive"):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "drive.csv")
            weakening(sof, seed, path)
            rows += judge(args, path, recordings.COLUMNS, f"weakening {seed}")
    if not rows:
        raise SystemExit("nothing to compare: give recordings, or --weakening N")
    several = len({row[0] for row in rows}) > 1
    head = ["recording", "rule", "stops", "engine off", "to the end", f"below {args.u_required:g} V", "share", "missed"]
    print("\n".join(table(head, [cells(*row) for row in rows + (list(total(rows)) if several else [])])))

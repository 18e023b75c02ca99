"""Window quality of windows and coverage of intervals, by experiment. Prints both.

    make study [DATA=folder with startstop_car/]

Simulates data sets 1 to 3 with eight seeds each (sof simulate), fits windows of every recording and
scores what they predict (`experiment windows`), plays every recording through a session
(`experiment play`): every crank and every charge of 10 s is predicted from the last sample before
it. Recordings with seeds 4 to 8, drive_2 and other_car_1 chose nothing: they are held out. Without
DATA the real recordings are left out.
"""

import argparse
import os
import statistics
import tempfile

import numpy as np
from scipy.stats import spearmanr

from .files import ROOT, write_json
from .rates import pooled
from .recordings import CAR, column_options
from .sof import program, rows_of, side_by_side, simulate
from .tables import grouped, table

SETS, SEEDS = (1, 2, 3), range(1, 9)
REAL = ("drive_1", "drive_2", "other_car_1")
GROUPS = (*(f"data_set_{one}" for one in SETS), "simulated", *REAL, "real")
UNITS = {"crank": "V", "charge": "A"}


def held_out(recording):
    if recording.startswith("data_set"):
        return recording.split("_seed_")[1][0] in "45678"
    return not recording.startswith("drive_1")


def correlation(rows, target):
    """Spearman's, of window quality with what the window's model then does; None of few rows."""
    good = [row for row in rows if target != "crank_mae" or row["cranks"] > 0]
    if len(good) < 5:
        return None
    value = spearmanr(*([row[key] for row in good] for key in ("window_quality", target))).correlation
    return None if np.isnan(value) else value


def within(rows, target):
    """Mean of the correlations inside each recording."""
    values = [correlation(some, target) for some in grouped(rows, lambda row: row["recording"]).values()]
    values = [value for value in values if value is not None]
    return statistics.mean(values) if values else float("nan")


def is_of(recording, group):
    simulated = recording.startswith("data_set")
    if group in ("simulated", "real"):
        return simulated == (group == "simulated")
    return recording.startswith(group)


def covered(rows):
    """Events, share inside [%], mean error and median width of the intervals."""
    one = pooled(rows)
    return {"events": len(rows),
            **{key: one[key] for key in ("inside_percent", "error", "width") if one}}


def coverage(session):
    """{kind: {group: covered()}} and all simulated events."""
    def of(group, kinds):
        return covered([row for row in session
                        if row["kind"] in kinds and is_of(row["recording"], group)])

    found = {kind: {group: of(group, (kind,)) for group in GROUPS} for kind in UNITS}
    return dict(found, simulated=of("simulated", UNITS))


def coverage_rows(found, groups=GROUPS):
    """One row a group and kind of events that there are."""
    return [(f"{kind}s, {group.replace('data_set_', 'data set ')}", one["events"],
             f"{one['inside_percent']:.1f} %", f"{one['error']:.3g} {unit}",
             f"{one['width']:.3g} {unit}")
            for group in groups for kind, unit in UNITS.items()
            for one in [found[kind][group]] if one["events"]]


HEAD = ("events", "number", "inside 90 %", "mean error", "median width")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--data", help="folder that holds startstop_car/")
    parser.add_argument("--json", help="file to write coverage and correlations to")
    args = parser.parse_args()
    scenarios = os.path.join(ROOT, "config", "scenarios")
    recordings = [[os.path.join(args.data, "startstop_car", name + ".csv"), *column_options(CAR)]
                  for name in REAL] if args.data else []
    with tempfile.TemporaryDirectory() as folder:
        jobs = [(os.path.join(scenarios, f"data_set_{number}.yaml"),
                 os.path.join(folder, f"data_set_{number}_seed_{seed}.csv"), seed)
                for number in SETS for seed in SEEDS]
        simulate(program(args.build, "sof"), jobs)
        recordings[:0] = [[path] for _, path, _ in jobs]
        binary = program(args.build, "experiment")
        windows, session = (
            sum(side_by_side(lambda one: rows_of([binary, name, *one]), recordings, "recording"), [])
            for name in ("windows", "play"))
    held = [row for row in windows if held_out(row["recording"])]
    found = dict(coverage(session),
                 all_q=correlation(held, "q_whole"), all_crank=-correlation(held, "crank_mae"),
                 in_q=within(held, "q_whole"), in_crank=-within(held, "crank_mae"))
    write_json(args.json, found)
    print("\n".join(table(HEAD, coverage_rows(found))))
    print("\nRank correlation of window quality on {} held-out windows, over all and within a "
          "recording: Q_dyn {:.2f} and {:.2f}, crank error {:.2f} and {:.2f}.".format(
              len(held), *(found[key] for key in ("all_q", "in_q", "all_crank", "in_crank"))))

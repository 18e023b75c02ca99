"""Answers of the first minutes: pairs of trips of one battery, the state file of the first given to the second.

    trips BUILD --data FOLDER [--parked S] [--json FILE]

Plays every pair through a session (trips_experiment) and prints, for minutes 0-1, 1-5, 5-15 and later of the second trip: how many standing answers were
valid, errors of cranks and charges, coverage and width of their 90 % intervals. The same second trip without a state file stands below.
"""

import argparse
import csv
import io
import os
import subprocess
import tempfile

import numpy as np

from . import recordings
from .files import write_json
from .sof import program
from .tables import table

AGES = ((0.0, 60.0, "0-1"), (60.0, 300.0, "1-5"), (300.0, 900.0, "5-15"), (900.0, np.inf, "later"))
LONGEST_S = 3600.0  # of a trip
# recording and range of the first and of the second trip; a name alone is cut in the middle
# of cars that crank; other_car_1 and ev_12v have no crank in these stretches
PAIRS = (("drive_1a", "drive_1b"), ("drive_1b", "drive_2a"), ("drive_2a", "drive_2b"), ("drive_1a", "drive_2b"), "small_car")


def halves(name, data):
    time, current, voltage = recordings.measured(data, name)
    middle = len(time) // 2
    return [[column[part] for column in (time, current, voltage)] for part in (slice(0, middle), slice(middle, None))]


def trips_of(pair, data):
    first, second = halves(pair, data) if isinstance(pair, str) else [recordings.measured(data, one) for one in pair]
    keep = lambda columns, mask: [column[mask] for column in columns]
    return (keep(first, first[0] > first[0][-1] - LONGEST_S), keep(second, second[0] < second[0][0] + LONGEST_S))


def played(binary, trips, parked, folder):
    """Rows of trips_experiment, a list a trip."""
    paths = []
    for n, trip in enumerate(trips):
        paths.append(os.path.join(folder, f"trip_{n}.csv"))
        recordings.write(paths[-1], *trip)
    out = subprocess.run([binary, *paths, "--parked", str(parked)], capture_output=True, text=True)
    if out.returncode:
        raise SystemExit(out.stderr)
    rows = list(csv.DictReader(io.StringIO(out.stdout)))
    return [[row for row in rows if row["trip"] == os.path.basename(path)] for path in paths]


# What parking changes in the long run (src/estimation/posterior.cpp): of a value, of u_dc [V]; and how soon [s].
PARKED, PARKED_U_DC_V, PARKED_TIME = 0.05, 0.08, 86400.0


def change(name, first, second):
    """(change of a parameter from trip to trip, standard error of the two fits): of the value, of u_dc [V]."""
    (a, std_a), (b, std_b) = ((float(row["measured"]), float(row["expected"])) for row in (first, second))
    scale = 1.0 if name == "u_dc" else 0.5 * (a + b)
    return (b - a) / scale, np.hypot(std_a, std_b) / scale


def changes(pairs, parked):
    """Rows of a table: each base parameter's change between the fits of two trips, by car, and what parking allows."""
    names, seen = ("r_discharge", "r_charge", "c2", "beta", "u_dc"), {}
    for pair, (first, second) in pairs:
        rows = [{row["kind"]: row for row in trip if row["kind"] in names and row["basis"] == "this_trip"} for trip in (first, second)]
        for name in set(rows[0]) & set(rows[1]):
            seen.setdefault(name, {}).setdefault("small_car" if pair == "small_car" else "start-stop car", []).append(change(name, rows[0][name], rows[1][name]))
    allowed = np.sqrt(1.0 - np.exp(-parked / PARKED_TIME))
    spread = lambda some: np.sqrt(max(0.0, np.mean([d**2 - s**2 for d, s in some])))  # beyond the fits' own errors
    out = []
    for name in (one for one in names if one in seen):
        shown = (lambda x: f"{1e3 * x:.0f} mV") if name == "u_dc" else (lambda x: f"{100.0 * x:.0f} %")
        cells_of = [f"{len(seen[name][car])}: {shown(np.sqrt(np.mean([d**2 for d, _ in seen[name][car]])))}, {shown(spread(seen[name][car]))}" if car in seen[name] else "-"
                    for car in ("start-stop car", "small_car")]
        out.append([name, *cells_of, shown(allowed * (PARKED_U_DC_V if name == "u_dc" else PARKED))])
    return out


def figures(rows):
    """{kind: {age: figures}} of rows."""
    out = {}
    for low, high, name in AGES:
        of_age = [row for row in rows if low <= float(row["time_s"]) < high]
        valid = [row for row in of_age if row["kind"] == "valid"]
        one = {"asked": len(valid)}
        for key, column in (("crank", "measured"), ("stop", "expected"), ("charge", "lower")):
            one["valid_" + key] = sum(int(row[column]) for row in valid)
        widths = [float(row["upper"]) for row in valid if float(row["upper"]) >= 0.0]
        one["width_v"] = float(np.median(widths)) if widths else None
        for kind in ("crank", "charge"):
            some = [[float(row[key]) for key in ("measured", "expected", "lower", "upper")] for row in of_age if row["kind"] == kind]
            one[kind] = [[m - e, l <= m <= u, u - l] for m, e, l, u in some]
        out[name] = one
    return out


def pooled(all_figures, age):
    """Figures of one age over all pairs: of shares, errors and widths."""
    ones = [figures_of[age] for figures_of in all_figures]
    asked = sum(one["asked"] for one in ones)
    out = {f"valid_{key}_percent": 100.0 * sum(one["valid_" + key] for one in ones) / asked for key in ("crank", "stop", "charge")}
    for kind in ("crank", "charge"):
        some = [event for one in ones for event in one[kind]]
        errors, inside, widths = (np.array([event[k] for event in some]) for k in range(3))
        out[kind + "s"] = {"count": len(some), "error": float(np.mean(np.abs(errors))) if some else None, "inside_percent": 100.0 * float(np.mean(inside)) if some else None,
                           "width": float(np.median(widths)) if some else None}
    widths = [one["width_v"] for one in ones if one["width_v"] is not None]
    out["standing_width_v"] = float(np.median(widths)) if widths else None
    return out


HEAD = ("minutes", "valid crank, stop, charge [%]", "cranks: mean error, inside, width [V]", "charges: mean error, inside, width [A]")


def cells(age, one):
    events = ["{count}: {error:.2f}, {inside_percent:.0f} %, {width:.1f}".format(**one[kind]) if one[kind]["count"] else "0" for kind in ("cranks", "charges")]
    return [age, "{valid_crank_percent:.0f}, {valid_stop_percent:.0f}, {valid_charge_percent:.0f}".format(**one), *events]


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--data", required=True)
    parser.add_argument("--parked", type=float, default=43200.0, help="[s] between the trips")
    parser.add_argument("--json")
    a = parser.parse_args(given)
    binary = program(a.build, "trips_experiment")
    played_rows, pairs = {"state_file": [], "no_state_file": []}, []
    with tempfile.TemporaryDirectory() as folder:
        for pair in PAIRS:
            trips = trips_of(pair, a.data)
            both = played(binary, trips, a.parked, folder)
            pairs.append((pair, both))
            played_rows["state_file"].append(figures(both[-1]))
            played_rows["no_state_file"].append(figures(played(binary, trips[1:], a.parked, folder)[-1]))
    results = {which: {age: pooled(rows, age) for _, _, age in AGES} for which, rows in played_rows.items()}
    for title, which in (("second trip, state file of the first", "state_file"), ("the same trip, no state file", "no_state_file")):
        print(title + "\n")
        print("\n".join(table(HEAD, [cells(age, one) for age, one in results[which].items()])) + "\n")
    print("parameters, from the last fit of a trip to the last of the next: pairs, RMS of the change, the same beyond the fits' own errors\n")
    print("\n".join(table(("parameter", "start-stop car", "small_car", f"parking of {a.parked:.0f} s allows"), changes(pairs, a.parked))))
    if a.json:
        write_json(a.json, results)
    return 0

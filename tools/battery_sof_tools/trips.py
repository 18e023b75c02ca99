"""Answers of the first minutes: pairs of trips of one battery, the state file of the first given to the second.

    trips BUILD --data FOLDER [--parked S] [--json FILE]

Plays every pair through a session (trips_experiment) and prints, for minutes 0-1, 1-5, 5-15 and later of the second trip: how many standing answers were
valid, errors of cranks and charges, coverage and width of their 90 % intervals. The same second trip without a state file stands below.
"""

import argparse
import os
import tempfile

import numpy as np

from . import recordings
from .files import write_json
from .rates import pooled
from .sof import program, rows_of
from .tables import table

AGES = ((0.0, 60.0, "0-1"), (60.0, 300.0, "1-5"), (300.0, 900.0, "5-15"), (900.0, np.inf, "later"))
LONGEST_S = 3600.0  # of a trip
# recording and range of the first and of the second trip; a name alone is cut in the middle
# of cars that crank; other_car_1 and ev_12v have no crank in these stretches
PAIRS = (("drive_1a", "drive_1b"), ("drive_1b", "drive_2a"), ("drive_2a", "drive_2b"), ("drive_1a", "drive_2b"), "small_car")


def pairs_of(data, folder):
    """Paths of the recordings of every pair."""
    for number, pair in enumerate(PAIRS):
        paths = [os.path.join(folder, f"pair_{number}_{n}.csv") for n in range(2)]
        for path, trip in zip(paths, trips_of(pair, data)):
            recordings.write(path, *trip)
        yield paths


def trips_of(pair, data):
    """The end of the first and the beginning of the second."""
    if isinstance(pair, str):
        whole = recordings.measured(data, pair)
        first, second = ([column[part] for column in whole] for part in (slice(0, len(whole[0]) // 2), slice(len(whole[0]) // 2, None)))
    else:
        first, second = (recordings.measured(data, one) for one in pair)
    keep = lambda columns, mask: [column[mask] for column in columns]
    return (keep(first, first[0] > first[0][-1] - LONGEST_S), keep(second, second[0] < second[0][0] + LONGEST_S))


def played(binary, paths, parked):
    """Rows of trips_experiment, of the last trip."""
    rows = rows_of([binary, *paths, "--parked", str(parked)])
    return [row for row in rows if row["trip"] == os.path.basename(paths[-1])]


def of_kind(rows, kind):
    return [row for row in rows if row["kind"] == kind]


def figures(plays, low, high):
    """Figures of one age over all plays: of shares, errors and widths."""
    plays = [[row for row in rows if low <= row["time_s"] < high] for rows in plays]
    every = [row for rows in plays for row in rows]
    valid = of_kind(every, "valid")
    out = {f"valid_{key}_percent": 100.0 * sum(row[column] for row in valid) / len(valid)
           for key, column in (("crank", "measured"), ("stop", "expected"), ("charge", "lower"))}
    for kind in ("crank", "charge"):
        one = pooled(of_kind(every, kind)) or {"count": 0}
        out[kind + "s"] = {key: one.get(key) for key in ("count", "error", "inside_percent", "width")}
    known = [[row["upper"] for row in of_kind(rows, "valid") if row["upper"] >= 0.0] for rows in plays]
    medians = [np.median(some) for some in known if some]
    out["standing_width_v"] = float(np.median(medians)) if medians else None
    return out


EVENTS = "{count}: {error:.2f}, {inside_percent:.0f} %, {width:.1f}"
HEAD = ("minutes", "valid crank, stop, charge [%]", "cranks: mean error, inside, width [V]", "charges: mean error, inside, width [A]")


def cells(age, one):
    events = [EVENTS.format(**one[kind]) if one[kind]["count"] else "0" for kind in ("cranks", "charges")]
    return [age, "{valid_crank_percent:.0f}, {valid_stop_percent:.0f}, {valid_charge_percent:.0f}".format(**one), *events]


def stated(second):
    """Sentence on the first valid answers about cranks of second trips."""
    firsts = [min((row["time_s"] for row in of_kind(rows, "valid") if row["measured"]), default=None) for rows in second]
    some = [one for one in firsts if one is not None]
    return f"first valid crank answer: median {np.median(some):.0f} s, latest {max(some):.0f} s; none in {len(firsts) - len(some)} of {len(firsts)}" if some else "no valid crank answer"


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--data", required=True)
    parser.add_argument("--parked", type=float, default=43200.0, help="[s] between the trips")
    parser.add_argument("--json")
    a = parser.parse_args(given)
    binary = program(a.build, "trips_experiment")
    after, alone = [], []  # second trips, with the state file of the first and without
    with tempfile.TemporaryDirectory() as folder:
        for paths in pairs_of(a.data, folder):
            after.append(played(binary, paths, a.parked))
            alone.append(played(binary, paths[1:], a.parked))
    results = {}
    for which, plays, words in (("state_file", after, "state file of the first"), ("no_state_file", alone, "no state file")):
        results[which] = {age: figures(plays, low, high) for low, high, age in AGES}
        taken = sum(bool(of_kind(rows, "swap")) for rows in plays)
        print(f"second trip, {words}, same battery: {stated(plays)}; taken for another battery in {taken}\n")
        print("\n".join(table(HEAD, [cells(age, one) for age, one in results[which].items()])) + "\n")
    write_json(a.json, results)

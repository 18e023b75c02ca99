"""Stops of real cars: what was expected of voltage and crank, before the stop and while it lasts.

    stops BUILD --data FOLDER [--json FILE]

Plays each recording through a session (`experiment stops`). A stop is a discharge of at least 10 s between -2 and -75 A. Before it: the voltage 10 and 30 s later, by
the model alone and with the correction by past stops. While it lasts: a profile of the currents that flow is queried 10 s or more into the stop; of its lower
bounds nine and a half in ten hold where the interval is a 90 % one.
"""

import argparse
import os
import tempfile

from . import recordings, sof
from .files import write_json
from .rates import pooled, rms
from .tables import table

# recordings with stops, capacity [Ah]
STOPS = {"drive_1a": 72.0, "drive_1b": 72.0, "drive_2a": 72.0, "drive_2b": 72.0, "small_car": 60.0}


def rows_of(binary, name, data):
    """Rows of `experiment stops`."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "drive.csv")
        recordings.write(path, *recordings.measured(data, name))
        return sof.rows_of([binary, "stops", path, "--capacity", str(STOPS[name])])


def intervals(rows):
    """Count, RMS error, share inside and above the lower bound [%], median width."""
    one = pooled(rows)
    return {key: one[key] for key in ("count", "rms", "inside_percent", "above_percent", "width")} if one else None


def figures(rows):
    kind = lambda name: [row for row in rows if row["kind"] == name]
    stops = [row for row in kind("stop") if row["basis"] == "this_trip"]  # a window of this trip was fitted before them
    return {"before": intervals(stops), "modelled_rms": rms([row["measured"] - row["modelled"] for row in stops]),
            "during": intervals([row for row in kind("voltage") if row["look_s"] >= 10.0])}


HEAD = ("recording", "before: stops, model alone, corrected [mV], inside", "during: RMS [mV], inside, lower bounds hold")


def cells(name, one):
    shown = lambda key, text: text.format(**{**one[key], "rms": 1e3 * one[key]["rms"]}, alone=1e3 * (one["modelled_rms"] or 0.0)) if one[key] else "-"
    return [name, shown("before", "{count}: {alone:.0f}, {rms:.0f}, {inside_percent:.0f} %"), shown("during", "{count}: {rms:.0f}, {inside_percent:.0f} %, {above_percent:.0f} %")]


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("--data", required=True)
    parser.add_argument("--json")
    a = parser.parse_args(given)
    binary = sof.program(a.build, "experiment")
    rows = {name: rows_of(binary, name, a.data) for name in STOPS}
    results = {name: figures(some) for name, some in rows.items()}
    results["all"] = figures([row for some in rows.values() for row in some])
    print("\n".join(table(HEAD, [cells(name, one) for name, one in results.items()])))
    write_json(a.json, results)

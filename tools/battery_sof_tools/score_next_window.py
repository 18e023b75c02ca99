"""Fits a model to each window of a recording, predicts the next window, and compares the errors with those of a baseline without physics.

    score_next_window REC [REC ...] [--effects IDS] [--start paper] [--json OUT.json] [--sof SOF] COLUMNS
    score_next_window REC --split 0.75 COLUMNS

Windows of --window seconds begin at the first sample and every --window from there; one counts when it and its successor each hold at least 80 %
of the samples that the recording's median interval promises and no gap beyond 60 s, engine on or off. `sof identify` fits the window, `sof predict` runs
the model on through the successor. With --split the first part of the recording is fitted and the rest predicted.

share: explained variation, 1 - RMS error / standard deviation, of the current where a source controls the voltage, of the voltage elsewhere, and of both together.
10 s, 60 s: median error of the mean current after a discharge ends. cranks: mean error of the lowest voltage. baseline: a line fit, the median of past charges, and
a line through past cranks of the fitted window. ridge: the voltage by a ridge regression on currents and their memories (benchmark/ridge.py), fitted to the
samples of the window at which no source controls the voltage, or to all where those are fewer than LEAST; ridge_all: to all. "inside": share of events in their 90 % interval.
"""

import argparse
import json
import os
import tempfile
import time

import numpy as np

from . import recordings, sof
from .benchmark.ridge import ridge_voltage
from .files import write_text
from .progress import followed
from .rates import pooled


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("recordings", nargs="+", help="CSV files")
    parser.add_argument("--sof", default="sof", help="path of the command sof")
    parser.add_argument("--effects", help="ids of effects for sof identify (default: sof identify chooses them)")
    parser.add_argument("--start", choices=("robust", "paper"), help="initial state for sof identify: estimated, or as in the paper")
    parser.add_argument("--capacity-ah", type=float, help="nominal capacity for sof identify [Ah]")
    parser.add_argument("--window", type=float, default=900.0, help="length of the window that is fitted, and of the one that is predicted [s] (default: 900)")
    parser.add_argument("--split", type=float, help="share of the recording's time that is fitted; the rest is predicted")
    parser.add_argument("--json", help="file to write every window's scores to")
    recordings.add_column_arguments(parser)
    return parser.parse_args()


def covered(t, start, window, interval):
    """Whether enough of [start, start + window) was recorded."""
    inside = t[(t >= start) & (t < start + window)]
    edges = np.concatenate(([start], inside, [start + window]))
    return len(inside) >= 0.8 * window / interval and np.max(np.diff(edges)) <= 60.0


def stretches_of(t, window):
    """(begin, begin of the next window, its end) of every pair that is whole, and how many there may be."""
    interval = np.median(np.diff(t))
    places = np.arange(t[0], t[-1] - 2.0 * window, window)
    return [(s, s + window, s + 2.0 * window) for s in places if covered(t, s, window, interval) and covered(t, s + window, window, interval)], len(places)


def run(command, end):
    """JSON of a call of sof, or nothing when it has no answer. subprocess.TimeoutExpired at the end on time.monotonic(), where there is one."""
    done = sof.completed(command + ["--json", "-"], timeout=None if end is None else max(0.0, end - time.monotonic()))
    return json.loads(done.stdout) if done.returncode == 0 else None


def score(command, recording, columns, t, ends, options=(), end=None, with_ridge=False):
    """What sof predict says of the second of two neighbouring stretches after fitting the first; none where sof refuses. A sample belongs to one of them.

    options: of sof identify. end: as of run(). with_ridge: whether the ridge regression is scored.
    """
    before = t[t < ends[1]]
    with tempfile.TemporaryDirectory() as folder:
        model, fitted, predicted = (os.path.join(folder, name) for name in ("model.yaml", "fitted.csv", "predicted.csv"))
        fit = run([command, "identify", recording, *columns, "--from", repr(float(ends[0])), "--to", repr(float(before[-1])), "--out", model, *options], end)

        def predict(some, path):
            return run([command, "predict", model, recording, *columns, "--from", repr(float(some[0])), "--to", repr(float(some[-1])), "--csv", path], end)
        ahead = fit and predict(t[(t >= ends[1]) & (t < ends[2])], predicted)
        if not ahead:
            return None
        ridge = ridge_scores(fitted, predicted, ahead["cranks"]) if with_ridge and predict(before[before >= ends[0]], fitted) else {}
    return {**ridge, "window_quality": fit["window_quality"], "fit_ms": fit["fit_ms"], "effects": fit["effects"], "parameters": fit["parameters"], "start_s": ends[0],
            "model": ahead["mixed"] or from_current(ahead), "baseline": ahead["baseline"], "q_dyn": ahead["q_dyn_percent"]}


def from_current(ahead):
    """A model without a source: the current drives throughout, Q_dyn is the share."""
    return {"share_percent": ahead["q_dyn_percent"], "current_share_percent": None, "voltage_share_percent": ahead["q_dyn_percent"], "charges": [],
            "charges_60s": [], "cranks": ahead["cranks"], "crank_mae_v": ahead["crank_mae_v"]}


def ridge_scores(fitted, predicted, cranks):
    """Of the ridge regressions, as sof has them of the others: they say nothing of the current. fitted, predicted: what sof predict wrote of both stretches; cranks:
    those of the second."""
    before, rows = (np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8") for path in (fitted, predicted))
    kept, free = (one["driven_by"] != "voltage" for one in (before, rows))
    series = [np.concatenate((before[key], rows[key])) for key in ("time_s", "current_a")]
    spread = np.std(rows["voltage_v"][free]) if free.any() else 0.0

    def scores(some):
        voltage = ridge_voltage(*series, before["voltage_v"], np.flatnonzero(some))

        def lowest(crank):
            during = (rows["time_s"] >= crank["time_s"] - 0.01) & (rows["time_s"] < crank["time_s"] + CRANK_S) & (rows["current_a"] <= 0.5 * crank["current_a"])
            return float(np.min(voltage[during]))
        return {"share_percent": None, "current_share_percent": None, "charges": [], "charges_60s": [],
                "voltage_share_percent": 100.0 * float(1.0 - np.sqrt(np.mean((rows["voltage_v"] - voltage)[free] ** 2)) / spread) if spread else None,
                "cranks": [dict(one, predicted_min_v=lowest(one)) for one in cranks]}
    every = np.ones(len(before), bool)
    return {"ridge": scores(kept if kept.sum() >= LEAST else every), "ridge_all": scores(every)}


CRANK_S = 5.0  # longest crank
LEAST = 60  # samples that a ridge regression is fitted to
RIDGES = ("ridge", "ridge_all")
SHARES = ("share_percent", "current_share_percent", "voltage_share_percent")
ERRORS = (("charges_10s_a", "{:.2f} A"), ("charges_60s_a", "{:.2f} A"), ("cranks_mv", "{:.0f} mV"))


def shares(found, who, key):
    return np.array([f[who][key] for f in found if f[who][key] is not None], float)


def events(found, who):
    """Charges of 10 and 60 s, and cranks, pooled over windows."""
    charge, crank = ([what + unit for what in ("measured", "predicted")] + [what + unit[-2:] for what in ("lower", "upper")]
                     for unit in ("_a", "_min_v"))
    return [pooled([one for f in found for one in f[who][kind]], keys)
            for kind, keys in (("charges", charge), ("charges_60s", charge), ("cranks", crank))]


def figures(found):
    """Medians over windows, and events of all of them."""
    of = {"windows": len(found)}
    for who in ("baseline", *(one for one in RIDGES if all(one in f for f in found)), "model"):
        short, long, cranks = events(found, who)
        of[who] = {key: float(np.median(values)) for key in SHARES
                   if len(values := shares(found, who, key))}
        of[who].update({f"charges_{key}s_a": one["median_error"] for key, one in ((10, short), (60, long)) if one})
        if cranks:
            of[who]["cranks_mv"] = 1e3 * cranks["error"]
    for name, one, unit in (("cranks", cranks, "v"), ("charges", short, "a")):  # of the model
        of[name] = {"count": one["count"], "error_" + unit: one["error"], "width_" + unit: one["width"], "inside_percent": one["inside_percent"]} if one else None
    return of


def quartiles(values):
    if len(values) == 0:
        return "-"
    return "{1:.1f} ({0:.0f} {2:.0f})".format(*np.percentile(values, [25, 50, 75]))


def summary(label, found):
    if not found:
        print(f"{label}: no window")
        return
    of, row = figures(found), "  {:<9} {:>18} {:>18} {:>18} {:>9} {:>9} {:>10}"
    print(f"{label}: {len(found)} windows; share in %: median (quartiles)")
    print(row.format("", "both", "current", "voltage", "10 s", "60 s", "cranks"))
    for who in [one for one in ("model", "baseline", *RIDGES) if one in of]:
        print(row.format(who, *(quartiles(shares(found, who, key)) for key in SHARES),
                         *(form.format(of[who][key]) if key in of[who] else "-"
                           for key, form in ERRORS)))
    text = "{}: {inside_percent:.0f} % of {count} inside, "
    inside = [(text + width).format(name, **of[key])
              for name, key, width in (("cranks", "cranks", "{width_v:.3g} V wide"),
                                       ("10 s", "charges", "{width_a:.3g} A wide")) if of[key]]
    print("  90 % intervals  " + ("; ".join(inside) or "no event"))
    both = [[f[who]["share_percent"] for who in ("model", "baseline")] for f in found]
    worse = sum(None not in one and one[0] < one[1] for one in both)
    fit_ms = np.median([f["fit_ms"] for f in found])
    print(f"  {worse} windows where the baseline explains more; fit {fit_ms:.0f} ms (median)")


def main():
    args = arguments()
    columns = recordings.column_options(*recordings.columns_of(args))
    options = [word for name in ("effects", "start") if getattr(args, name) for word in ("--" + name, getattr(args, name))] + recordings.capacity_options(args.capacity_ah)
    found = []
    for recording in args.recordings:
        t = recordings.read(recording, *recordings.columns_of(args))[0]
        name, mine = os.path.splitext(os.path.basename(recording))[0], []
        if args.split:
            stretches = [(t[0], t[0] + args.split * (t[-1] - t[0]), t[-1] + 1.0)]
        else:
            stretches, possible = stretches_of(t, args.window)
            print("{}: {} of {} windows are whole and followed by a whole one".format(name, len(stretches), possible), flush=True)
        for ends in followed(stretches, name):
            scores = score(args.sof, recording, columns, t, ends, options, with_ridge=True)
            if scores:
                mine.append(dict(scores, recording=name))
            else:
                print("{} {:>7.0f} s  refused".format(name, ends[0]), flush=True)
        summary(name, mine)
        found += mine
    if len(args.recordings) > 1:
        summary("all", found)
    write_text(args.json, json.dumps(found, indent=1))

"""Plots of the pages: a crank over the length of the stop, and a real crank and a real charge.

    page_drawings --build B                a crank over the length of the stop, of the example drive
    page_drawings --build B --data D       also a crank and a charge of a real car, and predictions

The diagrams beside them (docs/pictures/*.svg) are written by hand.
"""

import argparse
import json
import os
import tempfile

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from .files import ROOT
from .recordings import CAR, column_options
from .sof import call, program

INK, BLUE, BAND, RED = "#1b1f24", "#0969a8", "#9ec5e8", "#b3261e"
STOPS = [1, 2, 3, 5, 8, 12, 18, 25, 35, 45, 60, 75, 90, 120, 150, 180, 210, 240, 270]  # [s]
LIMIT = 11.5  # [V]
WINDOW = 900.0  # [s] fitted, and the next predicted
matplotlib.rcParams.update({
    "svg.hashsalt": "battery_sof", "font.size": 11, "axes.spines.top": False,
    "axes.spines.right": False, "svg.fonttype": "none", "font.family": "DejaVu Sans"})


def answer(command, folder):
    """What a command of sof writes with --json."""
    return json.loads(call([*command, "--json", "-"], folder))


def crank_over_stop(sof, folder, path):
    """Lowest voltage of a crank after stops of every length, of the example drive."""
    call([sof, "demo", "drive.csv"], folder)
    call([sof, "identify", "drive.csv", "--out", "model.yaml"], folder)
    query = ("--i-load", "-20", "--t-stop", ",".join(map(str, STOPS)), "--i-cranking", "-200")
    found = answer([sof, "map", "model.yaml", *query, "--u-required", str(LIMIT)], folder)
    lower, upper = found["u_min_lower"], found["u_min_upper"]
    within = [stop for stop, code in zip(STOPS, found["u_min_code"]) if code == 0]
    figure, axes = plt.subplots(figsize=(7.6, 3.6), layout="constrained")
    axes.fill_between(STOPS, lower, upper, color=BAND, alpha=0.6, linewidth=0,
                      label="90 % interval")
    axes.plot(STOPS, found["u_min"], color=BLUE, linewidth=2, label="lowest voltage of the crank")
    axes.axhline(LIMIT, color=RED, linestyle="--", linewidth=1.4, label=f"limit, {LIMIT:g} V")
    if len(within) < len(STOPS):
        axes.axvspan(within[-1], STOPS[-1], color="#d8dee4", alpha=0.6, linewidth=0)
        axes.text((within[-1] + STOPS[-1]) / 2, max(upper),
                  "answer not valid:\nmore than 2 % of the charge", ha="center", va="top",
                  fontsize=9, color=INK)
    last = [stop for stop, low in zip(STOPS, lower) if low >= LIMIT][-1]
    axes.annotate("90 % interval\nmeets the limit", (last, LIMIT), (last + 8, LIMIT + 0.2),
                  fontsize=9, color=RED, arrowprops={"arrowstyle": "->", "color": RED}, va="center")
    axes.set_xlim(0, STOPS[-1])
    axes.set_ylim(min(lower) - 0.08, max(upper) + 0.02)
    axes.set_xlabel("length of the stop at -20 A [s]")
    axes.set_ylabel("voltage [V]")
    axes.set_title("Crank of 1 s at -200 A after a stop", fontsize=11, loc="left")
    axes.legend(loc="lower center", ncols=3, frameon=False, fontsize=9)
    figure.savefig(path, metadata={"Date": None})


def draw_event(axes, rows, time, kind, quantity, place):
    """Measured and predicted samples around an event. kind: what drives the model there."""
    unit, ran = quantity[1], rows[rows["driven_by"] == kind]
    axes.plot(rows["time_s"] - time, rows["_".join(quantity)], color=INK, marker="o", markersize=3,
              linewidth=1, label="measured")
    times = ran["time_s"] - time
    axes.plot(times, ran[f"predicted_{unit}"], color=BLUE, marker="s", markersize=3,
              linewidth=0, label="predicted")
    axes.vlines(times, ran[f"lower_{unit}"], ran[f"upper_{unit}"], color=BAND,
                linewidth=3, zorder=0, label="90 % interval")
    axes.set_xlabel("time [s]")
    axes.legend(frameon=False, fontsize=9, loc=place)


def measured_and_predicted(sof, data, folder, path):
    """A real crank and charge, those with the median error, by a model of the 15 min before."""
    path_of_drive = os.path.join(os.path.abspath(data), "startstop_car", "drive_1.csv")
    drive = [path_of_drive, *column_options(CAR)]
    begin, middle, end = (f"+{k * WINDOW:g}" for k in (2, 3, 4))
    call([sof, "identify", *drive, "--from", begin, "--to", middle, "--out", "model.yaml"], folder)
    found = answer([sof, "predict", "model.yaml", *drive, "--from", middle, "--to", end,
                    "--csv", "predicted.csv"], folder)
    rows = np.genfromtxt(os.path.join(folder, "predicted.csv"), delimiter=",", names=True,
                         dtype=None, encoding="utf-8")

    def near(time, before, after):
        return rows[(time - before <= rows["time_s"]) & (rows["time_s"] <= time + after)]

    def typical(events, measured, predicted):
        """The event whose error is the median of all."""
        errors = sorted(events, key=lambda one: abs(one[measured] - one[predicted]))
        return errors[len(errors) // 2]

    crank = typical(found["mixed"]["cranks"], "measured_min_v", "predicted_min_v")
    charge = typical(found["mixed"]["charges"], "measured_a", "predicted_a")
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.4, 3.6), layout="constrained")
    at = crank["time_s"]
    draw_event(left, near(at, 12, 12), at, "current", ("voltage", "v"), "lower right")
    left.set_title("A crank: the current is given", fontsize=11, loc="left")
    left.set_ylabel("voltage [V]")
    at = charge["time_s"]
    draw_event(right, near(at, 0, 45), at, "voltage", ("current", "a"), "upper right")
    right.set_title("A charge: the voltage is given", fontsize=11, loc="left")
    right.set_ylabel("current [A], positive into the battery")
    figure.savefig(path, metadata={"Date": None})
    print(f"crank of {crank['time_s']:g} s: measured {crank['measured_min_v']:.2f} V, "
          f"predicted {crank['predicted_min_v']:.2f} V; charge of {charge['time_s']:g} s: "
          f"measured {charge['measured_a']:.1f} A, predicted {charge['predicted_a']:.1f} A")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"), help="build folder")
    parser.add_argument("--data", help="folder of the measured recordings: draws what needs them")
    parser.add_argument("--out", default=os.path.join(ROOT, "docs", "pictures"))
    args = parser.parse_args()
    sof = program(args.build, "sof")
    with tempfile.TemporaryDirectory(prefix="drawings_") as folder:
        crank_over_stop(sof, folder, os.path.join(args.out, "crank_over_stop.svg"))
        if args.data:
            out = os.path.join(args.out, "measured_and_predicted.svg")
            measured_and_predicted(sof, args.data, folder, out)
    print(f"drawings are in {args.out}")

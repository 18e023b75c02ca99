"""Plots of what `sof` answers: a crank over the length of the stop, and a real crank and a real charge."""

import csv
import json
import os

from ..sof import call

INK, BLUE, BAND, RED = "#1b1f24", "#0969a8", "#9ec5e8", "#b3261e"
STOPS = [1, 2, 3, 5, 8, 12, 18, 25, 35, 45, 60, 75, 90, 120, 150, 180, 210, 240, 270]  # [s]
LIMIT = 11.5  # [V]
WINDOW = 900.0  # [s] fitted, and the next predicted


def plotter():
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "battery_sof", "font.size": 11, "axes.spines.top": False, "axes.spines.right": False, "svg.fonttype": "none",
                                "font.family": "DejaVu Sans"})
    import matplotlib.pyplot as plt

    return plt


def save(figure, path):
    figure.savefig(path, metadata={"Date": None})


def answer(command, folder):
    """What a command of sof writes with --json."""
    path = os.path.join(folder, "answer.json")
    call([*command, "--json", path], folder)
    with open(path) as file:
        return json.load(file)


def crank_over_stop(sof, folder, path):
    """Lowest voltage of a crank after stops of every length, with its 90 % interval, of the example drive."""
    call([sof, "demo", "drive.csv"], folder)
    call([sof, "identify", "drive.csv", "--out", "model.yaml"], folder)
    found = answer([sof, "map", "model.yaml", "--i-load", "-20", "--t-stop", ",".join(map(str, STOPS)), "--i-cranking", "-200", "--u-required", str(LIMIT)], folder)
    within = [code == 0 for code in found["u_min_code"]]
    plt = plotter()
    figure, axes = plt.subplots(figsize=(7.6, 3.6), layout="constrained")
    axes.fill_between(STOPS, found["u_min_lower"], found["u_min_upper"], color=BAND, alpha=0.6, linewidth=0, label="90 % interval")
    axes.plot(STOPS, found["u_min"], color=BLUE, linewidth=2, label="lowest voltage of the crank")
    axes.axhline(LIMIT, color=RED, linestyle="--", linewidth=1.4, label=f"limit, {LIMIT:g} V")
    beyond = [stop for stop, is_within in zip(STOPS, within) if not is_within]
    if beyond:
        last = max(stop for stop, is_within in zip(STOPS, within) if is_within)
        axes.axvspan(last, STOPS[-1], color="#d8dee4", alpha=0.6, linewidth=0)
        axes.text((last + STOPS[-1]) / 2, max(found["u_min_upper"]), "answer not valid:\nmore than 2 % of the charge", ha="center", va="top", fontsize=9, color=INK)
    held = [stop for stop, lower in zip(STOPS, found["u_min_lower"]) if lower >= LIMIT]
    axes.annotate("90 % interval\nmeets the limit", (held[-1], LIMIT), (held[-1] + 8, LIMIT + 0.2), fontsize=9, color=RED, arrowprops={"arrowstyle": "->", "color": RED}, va="center")
    axes.set_xlim(0, STOPS[-1])
    axes.set_ylim(min(found["u_min_lower"]) - 0.08, max(found["u_min_upper"]) + 0.02)
    axes.set_xlabel("length of the stop at -20 A [s]")
    axes.set_ylabel("voltage [V]")
    axes.set_title("Crank of 1 s at -200 A after a stop", fontsize=11, loc="left")
    axes.legend(loc="lower center", ncols=3, frameon=False, fontsize=9)
    save(figure, path)


def rows_of(path):
    with open(path, newline="") as file:
        return [{name: float(value) if value not in ("", "voltage", "current") else value for name, value in row.items()} for row in csv.DictReader(file)]


def middle(events, error):
    """The event whose error is the median of all."""
    return sorted(events, key=error)[len(events) // 2]


def measured_and_predicted(sof, data, folder, path):
    """A crank and a charge of a real car, the ones with the median error, from a model of the quarter of an hour before."""
    columns = ["--time-column", "t_s", "--current-column", "current_A", "--voltage-column", "voltage_V"]
    drive = os.path.join(os.path.abspath(data), "startstop_car", "drive_1.csv")
    begin = 2 * WINDOW
    call([sof, "identify", drive, *columns, "--from", f"+{begin:g}", "--to", f"+{begin + WINDOW:g}", "--out", "model.yaml"], folder)
    found = answer([sof, "predict", "model.yaml", drive, *columns, "--from", f"+{begin + WINDOW:g}", "--to", f"+{begin + 2 * WINDOW:g}", "--csv", "predicted.csv"], folder)
    rows = rows_of(os.path.join(folder, "predicted.csv"))
    crank = middle(found["mixed"]["cranks"], lambda one: abs(one["measured_min_v"] - one["predicted_min_v"]))
    charge = middle(found["mixed"]["charges"], lambda one: abs(one["measured_a"] - one["predicted_a"]))
    plt = plotter()
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.4, 3.6), layout="constrained")

    def near(time, before, after):
        return [row for row in rows if time - before <= row["time_s"] <= time + after]

    def draw(axes, shown, time, kind, unit, place):
        times = [row["time_s"] - time for row in shown]
        axes.plot(times, [row[f"{'voltage' if unit == 'v' else 'current'}_{unit}"] for row in shown], color=INK, marker="o", markersize=3, linewidth=1, label="measured")
        ran = [row for row in shown if row["driven_by"] == kind]
        axes.plot([row["time_s"] - time for row in ran], [row[f"predicted_{unit}"] for row in ran], color=BLUE, marker="s", markersize=3, linewidth=0, label="predicted")
        axes.vlines([row["time_s"] - time for row in ran], [row[f"lower_{unit}"] for row in ran], [row[f"upper_{unit}"] for row in ran], color=BAND, linewidth=3, zorder=0, label="90 % interval")
        axes.set_xlabel("time [s]")
        axes.legend(frameon=False, fontsize=9, loc=place)

    draw(left, near(crank["time_s"], 12, 12), crank["time_s"], "current", "v", "lower right")
    left.set_title("A crank: the current is given", fontsize=11, loc="left")
    left.set_ylabel("voltage [V]")
    draw(right, near(charge["time_s"], 0, 45), charge["time_s"], "voltage", "a", "upper right")
    right.set_title("A charge: the voltage is given", fontsize=11, loc="left")
    right.set_ylabel("current [A], positive into the battery")
    save(figure, path)
    print(f"crank of {crank['time_s']:g} s: measured {crank['measured_min_v']:.2f} V, predicted {crank['predicted_min_v']:.2f} V; "
          f"charge of {charge['time_s']:g} s: measured {charge['measured_a']:.1f} A, predicted {charge['predicted_a']:.1f} A")

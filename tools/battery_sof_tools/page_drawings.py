"""Drawings of the pages, each with the numbers that it shows inside it.

    page_drawings --build B                those of simulated drives, and the node with its topics and services
    page_drawings --build B --data D       also a crank and a charge of a real car, and cranks measured and predicted
    page_drawings --build B --play         also two trips of the node, in the environment of B/devel/setup.bash; some two minutes

A drawing is two functions: what it shows, as numbers that `sof` gives, and how they are drawn. Some are drawn a second time for a narrow
screen, as NAME_narrow.svg. The numbers stand in the SVG file (numbers_of()), so that a test finds a drawing that is behind its command,
whichever version of matplotlib drew it. The diagrams beside them (circuit, node_states and the two sequences) are written by hand.
"""

import argparse
import json
import os
import re
import tempfile
from html import unescape

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from . import effect_drawing, layer_drawing, node_drawing, recordings, score_next_window, trip_drawing
from .files import ROOT, read_text, write_text
from .recordings import CAR, column_options
from .sof import call, program

INK, GREY, BLUE, BAND, RED, GREEN = "#1b1f24", "#57606a", "#0969a8", "#9ec5e8", "#b3261e", "#1a7f37"
SCENARIO = os.path.join(ROOT, "config", "scenarios", "cold_morning.yaml")
DIGITS = 5  # of a number that a drawing keeps
matplotlib.rcParams.update({
    "svg.hashsalt": "battery_sof", "font.size": 10, "axes.spines.top": False,
    "axes.spines.right": False, "svg.fonttype": "none", "font.family": "DejaVu Sans"})


def answer(command, folder):
    """What a command of sof writes with --json."""
    return json.loads(call([*command, "--json", "-"], folder))


def kept(value):
    """Numbers as a drawing keeps them."""
    if isinstance(value, dict):
        return {key: kept(each) for key, each in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [kept(each) for each in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def numbers_of(path):
    """What a drawing shows; None where it does not say."""
    found = re.search("<dc:description>(.*?)</dc:description>", read_text(path), re.S)
    return json.loads(unescape(found[1])) if found else None


def save(figure, numbers, path):
    """Under another name first, so that a drawing is whole or not there."""
    beside = path + ".part"
    figure.savefig(beside, format="svg", metadata={"Date": None, "Description": json.dumps(numbers)})
    plt.close(figure)
    write_text(path, re.sub(r"[ \t]+\n", "\n", read_text(beside)))
    os.remove(beside)


# ---------------------------------------------------------------------------------------------------- crank_over_stop
STOPS = [1, 2, 3, 5, 8, 12, 16, 20, 24, 28, 32, 36, 40, 45, 50, 55, 60, 70, 80, 90, 105, 120]  # [s]
STOP = 20.0  # [s], of the question that is marked
QUESTION = ("--i-load", "-15", "--i-cranking", "-550", "--t-cranking", "0.4", "--u-required", "7.2")
LIMIT = 7.2  # [V]


def crank_over_stop(sof, folder):
    """A crank after stops of every length, and the two answers about it."""
    call([sof, "simulate", SCENARIO, "cold.csv"], folder)
    call([sof, "identify", "cold.csv", "--from", "0", "--to", "900", "--out", "cold.yaml"], folder)
    crank = answer([sof, "crank", "cold.yaml", *QUESTION, "--t-stop", str(STOP)], folder)
    stop_time = answer([sof, "stop-time", "cold.yaml", *QUESTION], folder)
    over = answer([sof, "map", "cold.yaml", *QUESTION, "--t-stop", ",".join(map(str, STOPS))], folder)
    return {"crank": [crank[key] for key in ("u_min", "lower", "upper")],
            "stop_time": [stop_time[key] for key in ("t_stop", "lower")],
            **{key: over[key] for key in ("u_min", "u_min_lower", "u_min_upper", "u_min_code")}}


def draw_crank_over_stop(numbers, narrow=False):
    lower, upper = numbers["u_min_lower"], numbers["u_min_upper"]
    figure, axes = plt.subplots(figsize=(4.2, 5.2) if narrow else (7.6, 4.2), layout="constrained")
    axes.fill_between(STOPS, lower, upper, color=BAND, alpha=0.6, linewidth=0, label="90 % interval")
    axes.plot(STOPS, numbers["u_min"], color=BLUE, linewidth=2, label="lowest voltage of the crank")
    axes.axhline(LIMIT, color=RED, linestyle="--", linewidth=1.4, label="required by the starter, 7.2 V")
    value, low, high = numbers["crank"]
    axes.errorbar([STOP], [value], [[value - low], [high - value]], color=INK, capsize=5, marker="o", markersize=6, linewidth=1.6, zorder=5)
    verdict = f"{value:.2f} V, 90 % between\n{low:.2f} and {high:.2f} V: holds,\nthe lower end is above the limit" if narrow else f"{value:.2f} V, 90 % between {low:.2f} and {high:.2f} V:\nholds, the lower end is above the limit"
    axes.annotate(f"sof crank --t-stop {STOP:.0f}\n{verdict}", (STOP, high), (STOP + (16 if narrow else 8), max(upper) + 0.04), fontsize=9, va="top", color=INK, arrowprops={"arrowstyle": "->", "color": INK, "shrinkB": 4})
    ends, assured = numbers["stop_time"]
    bottom = min(lower) - 0.3
    for time, text, away in ((assured, f"sof stop-time\nassured to {assured:.0f} s", 0.03), (ends, f"sof stop-time\nexpected end {ends:.0f} s", 0.19 if narrow else 0.03)):
        axes.plot([time, time], [bottom, LIMIT], color=GREEN, linewidth=1.4, linestyle=":")
        axes.plot([time], [LIMIT], color=GREEN, marker="D", markersize=6, zorder=5)
        axes.text(time + 1.5, bottom + away, text, fontsize=9, color=GREEN, va="bottom")
    axes.set_xlim(0, STOPS[-1])
    axes.set_ylim(bottom, max(upper) + 0.06)
    axes.set_xlabel("length of the stop, at -15 A [s]")
    axes.set_ylabel("voltage [V]")
    axes.set_title("Crank of 0.4 s at -550 A after a stop:" + ("\n" if narrow else " ") + "an old battery at -15 degC", fontsize=10, loc="left")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14 if narrow else -0.16), ncols=1 if narrow else 3, frameon=False, fontsize=9)
    return figure


# ---------------------------------------------------------------------------------------------------- three_answers
# What is put into the drive: driving, a stop, inrush and cranking of the starter, and a recharge that the alternator limits.
PHASES = ((30.0, 6.0), (36.0, -18.0), (0.25, -555.0), (0.6, -280.0), (40.0, 250.0))
INSERTED = 400.0  # [s]
BEFORE, AFTER = 14.0, 70.0  # [s] that are shown, from the beginning of the stop
T_SOF2 = 10.0  # [s]
ENDS = [2, 4, 6, 8, 10, 12, 15, 18, 21, 24, 27, 30, 33, 36, 39, 42, 45, 48, 51, 54, 57, 60, 63, 66]  # [s], of stops


def three_answers(sof, folder):
    """A stop, a crank and a recharge, and what a model of the time before expects of the crank."""
    inserts = "\ninserts:\n  - at_s: %g\n    phases:\n" % INSERTED
    inserts += "".join("      - {duration_s: %g, current_a: %g}\n" % phase for phase in PHASES)
    write_text(os.path.join(folder, "stop.yaml"), read_text(SCENARIO) + inserts)
    call([sof, "simulate", "stop.yaml", "stop.csv", "--duration", "600"], folder)
    time, current, voltage = np.loadtxt(os.path.join(folder, "stop.csv"), delimiter=",", skiprows=1, usecols=(0, 1, 2), unpack=True)
    in_crank = np.flatnonzero((current < -450.0) & (time > INSERTED + PHASES[0][0] + PHASES[1][0]))[0]
    begin = time[in_crank] - PHASES[1][0]
    call([sof, "identify", "stop.csv", "--from", "0", "--to", f"{begin:.2f}", "--out", "before.yaml"], folder)
    # 550 A is what the window has seen of a crank's current at least.
    question = ("--i-load", str(PHASES[1][1]), "--i-cranking", "-550", "--t-cranking", "0.25", "--u-required", str(LIMIT))
    over = answer([sof, "map", "before.yaml", *question, "--t-stop", ",".join(map(str, ENDS))], folder)
    held = (time >= begin + sum(phase[0] for phase in PHASES[1:4])) & (time < begin + sum(phase[0] for phase in PHASES[1:4]) + T_SOF2)
    shown = (time >= begin - BEFORE) & (time <= begin + AFTER)
    fine = np.abs(time - time[in_crank]) < 1.5
    some = shown & (fine | (np.arange(len(time)) % 20 == 0))
    return {"time": (time[some] - begin).round(2), "current": current[some].round(1), "voltage": voltage[some].round(3),
            "mean_charge": float(current[held].mean()), "held": float(np.median(voltage[held])), "expected": over["u_min"]}


def draw_three_answers(numbers, narrow=False):
    def lines(text):
        """A text with fewer line breaks on a wide drawing: those after a space are for a narrow one."""
        return text.replace(" \n", "\n") if narrow else text.replace(" \n", " ")

    time, current, voltage = (np.array(numbers[key]) for key in ("time", "current", "voltage"))
    stop, recharge = PHASES[1][0], sum(phase[0] for phase in PHASES[1:4])
    expected = np.array(numbers["expected"])
    figure, (above, below) = plt.subplots(2, 1, figsize=(4.2, 6.6) if narrow else (8.4, 6.0), sharex=True, height_ratios=(3, 2), layout="constrained")
    for axes in (above, below):
        axes.axvspan(0, stop, color="#f0f2f5", linewidth=0)
        axes.axvspan(recharge, recharge + T_SOF2, color="#e6f2e8", linewidth=0)
    above.plot(time, voltage, color=INK, linewidth=1.3)
    above.axhline(LIMIT, color=RED, linestyle="--", linewidth=1.2)
    above.text(-BEFORE + 0.5, LIMIT + 0.08, "u_required", color=RED, fontsize=9, va="bottom")
    above.plot(ENDS, expected, color=BLUE, linewidth=1.6, linestyle=(0, (5, 2)))
    above.text(1.5, expected[0] + 0.35, lines("expected lowest \nvoltage of a crank,\nif the stop \nended here"), color=BLUE, fontsize=9, va="bottom")
    lowest = int(np.argmin(voltage))
    above.plot([time[lowest]], [voltage[lowest]], color=BLUE, marker="o", markersize=7, zorder=5)
    above.annotate(lines("SOF1: lowest \nvoltage\nof the crank"), (time[lowest], voltage[lowest]), (time[lowest] + 7, voltage[lowest] + (2.0 if narrow else 1.4)), fontsize=10, fontweight="bold", color=BLUE, va="center",
                   arrowprops={"arrowstyle": "->", "color": BLUE, "shrinkB": 5})
    end = float(np.interp(-LIMIT, -expected, ENDS))
    bottom = LIMIT - (2.1 if narrow else 0.9)
    above.plot([end, end], [bottom, LIMIT], color=GREEN, linestyle=":", linewidth=1.4)
    above.plot([end], [LIMIT], color=GREEN, marker="D", markersize=7, zorder=5)
    above.annotate("", (0, bottom + 0.25), (end, bottom + 0.25), arrowprops={"arrowstyle": "<->", "color": GREEN, "shrinkA": 0, "shrinkB": 0})
    above.text(end / 2, bottom + 0.32, lines("stop time: longest stop \nafter which a crank \nstill holds u_required"), color=GREEN, fontsize=9 if narrow else 10, fontweight="bold", ha="center", va="bottom")
    above.text(recharge + T_SOF2 + 1, numbers["held"] - 0.2, lines("u_boost, held \nby the \nalternator"), fontsize=9, color=GREEN, va="top")
    above.set_ylim(bottom - 0.05, numbers["held"] + 1.3)
    above.set_ylabel("voltage [V]")
    top = numbers["held"] + 1.2
    for x, text in ((-BEFORE / 2, "driving"), (stop / 2, lines("stop: \nt_stop at i_load")), ((recharge + AFTER) / 2, "recharge")):
        above.text(x, top, text, ha="center", va="top", fontsize=10)
    above.annotate("crank", (stop + 0.4, numbers["held"] - 0.2), (stop - (10 if narrow else 5), numbers["held"] + (-0.6 if narrow else 0.3)), fontsize=10, ha="center", va="center", arrowprops={"arrowstyle": "->", "color": INK})
    low, peak = -120.0, float(current.max())
    below.plot(time, np.maximum(current, low - 20), color=INK, linewidth=1.3)
    below.axhline(0, color=GREY, linewidth=0.6)
    below.plot([recharge, recharge + T_SOF2], [numbers["mean_charge"]] * 2, color=GREEN, linewidth=2.4)
    below.annotate(lines("SOF2: mean \ncurrent\nover t_sof2 \nat u_boost"), (recharge + T_SOF2, numbers["mean_charge"]), (recharge + T_SOF2 + (5 if narrow else 3), 0.8 * peak), fontsize=10, fontweight="bold", color=GREEN, va="center",
                   arrowprops={"arrowstyle": "->", "color": GREEN})
    below.annotate("", (recharge, -50), (recharge + T_SOF2, -50), arrowprops={"arrowstyle": "<->", "color": GREEN, "shrinkA": 0, "shrinkB": 0})
    below.text(recharge + T_SOF2 + 1, -50, "t_sof2", fontsize=9, color=GREEN, va="center")
    below.text(stop - 1.5, low + 22, lines(f"i_cranking: to {min(numbers['current']):.0f} A, \nover t_cranking"), fontsize=9, ha="right", va="center")
    below.text(stop / 2, PHASES[1][1] - 5, "i_load", fontsize=9, ha="center", va="top")
    below.set_ylim(low, 1.1 * peak)
    below.set_ylabel("current [A],\npositive into the battery")
    below.set_xlabel("time since the engine was stopped [s]")
    below.set_xlim(-BEFORE, AFTER)
    return figure


# ---------------------------------------------------------------------------------------------------- recordings
WINDOW, FAST_WINDOW = 900.0, 240.0  # [s] fitted, and the next predicted: what the node fits at 1 Hz, and at 100 Hz
SEEDS = (1, 2, 3, 4, 5, 6)  # of simulated drives
EFFECT = "current_dependent_resistance"  # that the simulated battery has
DRIVES = ("drive_1.csv", "drive_2.csv")  # those with cranks


def car(data, name):
    return [os.path.join(os.path.abspath(data), "startstop_car", name), *column_options(CAR)]


def pairs(cranks):
    return [[one[key] for key in ("measured_min_v", "predicted_min_v", "lower_v", "upper_v")] for one in cranks]


def next_cranks(sof, folder, recording, columns, times, window, fit=()):
    """Cranks of each window by a model of the window before it, as docs/accuracy.md counts them. Failure where sof has an error.

    fit: options of sof identify."""
    found = []
    for begin, middle, end in score_next_window.stretches_of(times, window)[0]:
        first, second = ([f"{some[0]:.6f}", f"{some[-1]:.6f}"] for some in (times[(times >= begin) & (times < middle)], times[(times >= middle) & (times < end)]))
        fitted = answer([sof, "identify", recording, *columns, "--from", first[0], "--to", first[1], "--out", "next.yaml", *fit], folder)
        if fitted["status"] == "converged":
            report = answer([sof, "predict", "next.yaml", recording, *columns, "--from", second[0], "--to", second[1]], folder)
            found += pairs(report["cranks"])
    return found


def calibration(sof, folder, data):
    found = {"simulated": [], "with_effect": [], "real": []}
    for seed in SEEDS:
        path = os.path.join(folder, "seed.csv")
        call([sof, "simulate", os.path.join(ROOT, "config", "scenarios", "city_drive.yaml"), path, "--seed", str(seed), "--duration", "1200"])
        times = recordings.read_plain(path)[0]
        found["simulated"] += next_cranks(sof, folder, path, (), times, FAST_WINDOW)
        found["with_effect"] += next_cranks(sof, folder, path, (), times, FAST_WINDOW, ("--effects", EFFECT))
    for name in DRIVES:
        path, *columns = car(data, name)
        found["real"] += next_cranks(sof, folder, path, columns, recordings.read(path, CAR)[0], WINDOW)
    return found


def draw_calibration(numbers, narrow=False):
    figure = plt.figure(figsize=(4.2, 10.5) if narrow else (8.4, 8.0), layout="constrained")
    grid = figure.add_gridspec(*((3, 1) if narrow else (2, 2)))
    places = (grid[0], grid[1], grid[2]) if narrow else (grid[0, 0], grid[0, 1], grid[1, :])
    for place, key, title in zip(places, ("simulated", "with_effect", "real"), ("Simulated, 100 Hz, circuit", "The same, with the missing effect", "A start-stop car, 1 Hz")):
        axes = figure.add_subplot(place)
        measured, predicted, lower, upper = np.array(numbers[key]).T
        inside = (lower <= measured) & (measured <= upper)
        for some, color, light, marker, word in ((inside, BLUE, BAND, "o", "inside"), (~inside, RED, "#f0b8b4", "s", "outside")):
            axes.errorbar(predicted[some], measured[some], xerr=[(predicted - lower)[some], (upper - predicted)[some]], color=color, ecolor=light, marker=marker,
                          markersize=3.6, linewidth=0, elinewidth=1.2, label=f"{word} the interval: {some.sum()}")
        ends = [min(lower.min(), measured.min()), max(upper.max(), measured.max())]
        axes.plot(ends, ends, color=INK, linewidth=0.9)
        axes.set_ylim(measured.min() - 0.15 * np.ptp(measured), measured.max() + 0.4 * np.ptp(measured))
        axes.set_title(f"{title}: {100 * inside.mean():.0f} % inside", fontsize=10, loc="left")
        axes.set_xlabel("predicted, with its 90 % interval [V]")
        axes.set_ylabel("measured lowest voltage [V]")
        axes.legend(frameon=False, fontsize=9, loc="upper left")
    return figure


def course(rows, time, before, after, kind, quantity):
    """Measured and predicted samples around an event. kind: what drives the model there."""
    near = rows[(time - before <= rows["time_s"]) & (rows["time_s"] <= time + after)]
    ran = near[near["driven_by"] == kind]
    unit = quantity[1]
    return {"measured": [near["time_s"] - time, near["_".join(quantity)]],
            "predicted": [ran["time_s"] - time, *(ran[f"{name}_{unit}"] for name in ("predicted", "lower", "upper"))]}


def measured_and_predicted(sof, folder, data):
    """A real crank and charge, those with the median error, by a model of the 15 min before."""
    drive = car(data, "drive_1.csv")
    begin, middle, end = (f"+{k * WINDOW:g}" for k in (2, 3, 4))
    call([sof, "identify", *drive, "--from", begin, "--to", middle, "--out", "model.yaml"], folder)
    found = answer([sof, "predict", "model.yaml", *drive, "--from", middle, "--to", end,
                    "--csv", "predicted.csv"], folder)
    rows = np.genfromtxt(os.path.join(folder, "predicted.csv"), delimiter=",", names=True,
                         dtype=None, encoding="utf-8")

    def typical(events, measured, predicted):
        """The event whose error is the median of all."""
        errors = sorted(events, key=lambda one: abs(one[measured] - one[predicted]))
        return errors[len(errors) // 2]["time_s"]

    crank = typical(found["mixed"]["cranks"], "measured_min_v", "predicted_min_v")
    charge = typical(found["mixed"]["charges"], "measured_a", "predicted_a")
    return {"crank": course(rows, crank, 12, 12, "current", ("voltage", "v")), "charge": course(rows, charge, 0, 45, "voltage", ("current", "a"))}


def draw_course(axes, shown, place):
    axes.plot(*shown["measured"], color=INK, marker="o", markersize=3, linewidth=1, label="measured")
    times, predicted, lower, upper = shown["predicted"]
    axes.plot(times, predicted, color=BLUE, marker="s", markersize=3, linewidth=0, label="predicted")
    axes.vlines(times, lower, upper, color=BAND, linewidth=3, zorder=0, label="90 % interval")
    axes.set_xlabel("time [s]")
    axes.legend(frameon=False, fontsize=9, loc=place)


def draw_measured_and_predicted(numbers, narrow=False):
    figure, (left, right) = plt.subplots(*((2, 1) if narrow else (1, 2)), figsize=(4.2, 6.6) if narrow else (9.4, 3.6), layout="constrained")
    draw_course(left, numbers["crank"], "lower right")
    left.set_title("A crank: the current is given", fontsize=11, loc="left")
    left.set_ylabel("voltage [V]")
    draw_course(right, numbers["charge"], "upper right")
    right.set_title("A charge: the voltage is given", fontsize=11, loc="left")
    right.set_ylabel("current [A], positive into the battery")
    return figure


# Drawings by what they need beside a build.
SIMULATED = {"crank_over_stop": (crank_over_stop, draw_crank_over_stop, lambda numbers: draw_crank_over_stop(numbers, True)),
             "three_answers": (three_answers, draw_three_answers, lambda numbers: draw_three_answers(numbers, True)),
             "effect_signatures": (effect_drawing.signatures, lambda numbers: effect_drawing.draw(numbers, 5, 8.8), lambda numbers: effect_drawing.draw(numbers, 2, 4.1))}
MEASURED = {"measured_and_predicted": (measured_and_predicted, draw_measured_and_predicted, lambda numbers: draw_measured_and_predicted(numbers, True)),
            "calibration": (calibration, draw_calibration, lambda numbers: draw_calibration(numbers, True))}
PLAYED = {"trips_of_the_node": (trip_drawing.trips, lambda found: trip_drawing.draw(found, 8.4, 9), lambda found: trip_drawing.draw(found, 4.4, 7))}
# Diagrams from the sources, by the name of their file.
DIAGRAMS = {"node_interface": node_drawing.drawing, "node_interface_narrow": node_drawing.narrow_drawing,
            "layers": lambda: layer_drawing.drawing(layer_drawing.WIDE),
            "layers_narrow": lambda: layer_drawing.drawing(layer_drawing.NARROW)}


def files_of(drawings):
    """Each file of some drawings with the function that draws it, and the name of the drawing."""
    return {name + ending: (name, draw) for name, (_, *draws) in drawings.items() for ending, draw in zip(("", "_narrow"), draws)}


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=os.path.join(ROOT, "build"), help="build folder")
    parser.add_argument("--data", help="folder of the measured recordings: draws what needs them")
    parser.add_argument("--play", action="store_true", help="draw what needs the node: the trips that are played to it")
    parser.add_argument("--out", default=os.path.join(ROOT, "docs", "pictures"))
    parser.add_argument("--only", help="name of one drawing")
    args = parser.parse_args()
    sof, drawn = program(args.build, "sof"), 0
    with tempfile.TemporaryDirectory(prefix="drawings_") as folder:
        node = program(args.build, "battery_sof_node") if args.play else None
        for drawings, parts in ((SIMULATED, (sof, folder)), (MEASURED, (sof, folder, args.data)), (PLAYED, (sof, node, folder))):
            for name, (shown, *_) in drawings.items():
                if all(parts) and args.only in (None, name):
                    drawn += 1
                    numbers = kept(shown(*parts))
                    for file, (of, draw) in files_of(drawings).items():
                        if of == name:
                            save(draw(numbers), numbers, os.path.join(args.out, file + ".svg"))
    for name, drawing in DIAGRAMS.items():
        if args.only in (None, name, name.replace("_narrow", "")):
            drawn += 1
            write_text(os.path.join(args.out, name + ".svg"), drawing())
    if not drawn:
        raise SystemExit(f"page_drawings: {args.only} is not drawn; there is no such drawing, or it needs --data or --play")
    print(f"drawings are in {args.out}")

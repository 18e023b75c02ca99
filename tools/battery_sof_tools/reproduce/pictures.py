"""The page's pictures."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend is chosen first)

from ..files import ROOT  # noqa: E402
from .data import progress, read_columns  # noqa: E402
from .tables import errors  # noqa: E402

PICTURES = os.path.join(ROOT, "docs", "pictures")  # or below what --docs says


def save(figure, name):
    figure.savefig(os.path.join(PICTURES, name), dpi=100)
    plt.close(figure)
    progress("picture " + name)


def thin(axis):
    axis.grid(alpha=0.3)
    axis.spines[["top", "right"]].set_visible(False)


def picture_prediction(data, title, name):
    figure, (top, middle, bottom) = plt.subplots(3, 1, sharex=True, figsize=(9, 6), height_ratios=[3, 1.3, 1.5],
                                                 constrained_layout=True)
    minutes = [t / 60.0 for t in data["time_s"]]
    top.plot(minutes, data["voltage_v"], "k", linewidth=0.8, label="reference (Fig. 4)")
    top.plot(minutes, data["predicted_v"], color="tab:orange", linestyle="--", linewidth=0.9, label="model (Fig. 3)")
    top.set_ylabel("voltage [V]")
    top.set_title(title, loc="left")
    top.legend(frameon=False, loc="lower left", ncols=2)
    middle.plot(minutes, errors(data), color="tab:red", linewidth=0.7)
    middle.set_ylabel("error [V]")
    bottom.plot(minutes, data["current_a"], color="tab:blue", linewidth=0.7)
    bottom.set_ylabel("current [A]")
    bottom.set_xlabel("time [min]")
    for axis in (top, middle, bottom):
        thin(axis)
    save(figure, name)


def picture_windows(rows, recording):
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(9, 6), constrained_layout=True)
    for k, (name, color) in enumerate((("paper", "0.55"), ("paper, start on an edge", "tab:red"), ("default", "tab:blue"))):
        mine = [r for r in rows if r["recording"] == recording and r["setting"] == name]
        at = [int(r["window"]) + 0.27 * (k - 1) for r in mine]
        top.bar(at, [max(float(r["q_hour_percent"]), -20.0) for r in mine], 0.25, color=color, label=name)
        for x, r in zip(at, mine):
            if float(r["q_hour_percent"]) < -20.0:
                top.annotate("{:.0f}".format(float(r["q_hour_percent"])), (x, -17.0), color="white", ha="center", fontsize=7)
        top.plot(at, [float(r["q_window_percent"]) for r in mine], "k_", markersize=9)
        bottom.bar(at, [float(r["crank_mae_v"]) for r in mine], 0.25, color=color,
                   yerr=[float(r["crank_sd_v"]) for r in mine], error_kw={"linewidth": 0.8})
    top.set_ylabel("Q_dyn, hour [%]")
    top.set_title("Bars: the hour predicted; dashes: the window itself", loc="left", fontsize=10)
    top.set_ylim(-25.0, 118.0)
    top.legend(frameon=False, ncols=3, loc="upper left")
    bottom.set_ylabel("crank error, deviation [V]")
    bottom.set_ylim(0.0, 0.2)
    bottom.set_xlabel("identification window")
    bottom.set_xticks(range(1, 12))
    for axis in (top, bottom):
        thin(axis)
    save(figure, "reproduction_fig7_8.png")


def picture_excitation(data):
    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(9, 4.5), constrained_layout=True)
    minutes = [t / 60.0 for t in data["time_s"]]
    top.plot(minutes, data["voltage_v"], "k", linewidth=0.5)
    top.set_ylabel("voltage [V]")
    bottom.plot(minutes, data["current_a"], color="tab:blue", linewidth=0.5)
    bottom.set_ylabel("current [A]")
    bottom.set_xlabel("time [min]")
    for axis in (top, bottom):
        for start in (12.0, 17.5, 23.0):
            axis.axvspan(start, start + 4.0, color="0.85")
        thin(axis)
    top.set_title("Data set 1, windows 3, 4 and 5", loc="left")
    save(figure, "reproduction_fig5.png")


def picture_impedance(path):
    data = read_columns(path)
    figure, axis = plt.subplots(figsize=(6, 4), constrained_layout=True)
    keep = [n for n, f in enumerate(data["frequency_hz"]) if f <= 100.0]
    for real, imaginary, style, label in (("analytic_real_ohm", "analytic_imag_ohm", "k-", "analytic"),
                                          ("real_ohm", "imag_ohm", "C1o", "simulated model")):
        axis.plot([1e3 * data[real][n] for n in keep], [-1e3 * data[imaginary][n] for n in keep], style,
                  markersize=3, linewidth=0.9, label=label)
    axis.set_xlabel("real part [mOhm]")
    axis.set_ylabel("- imaginary part [mOhm]")
    axis.legend(frameon=False)
    thin(axis)
    save(figure, "reproduction_impedance.png")
    return max(abs(complex(data["real_ohm"][n], data["imag_ohm"][n])
                   / complex(data["analytic_real_ohm"][n], data["analytic_imag_ohm"][n]) - 1.0) for n in keep)

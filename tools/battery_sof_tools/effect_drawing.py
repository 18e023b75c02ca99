"""What each effect of the catalogue adds to the voltage of the base circuit, for docs/effects.md: `sof predict` on one profile, with the effect and without.

The profile is a stop, a crank, a recharge and a rest. The models are MODEL.yaml files of the catalogue's magnitudes on one circuit.
"""

import copy
import json
import os

import matplotlib.pyplot as plt
import numpy as np
import yaml

from .files import ROOT, read_text, write_json
from .sof import call

INK, GREY, BLUE, CRANK, RECHARGE = "#1b1f24", "#57606a", "#0969a8", "#fbe3e0", "#e6f2e8"
SCENARIO = os.path.join(ROOT, "config", "scenarios", "city_drive.yaml")
CIRCUIT = {"r_discharge": 0.005, "r_charge": 0.006, "c2": 1000.0, "beta": 22.0, "u_dc": 12.7}
# Where a magnitude of the catalogue has no effect, or has it after the profile's end.
VALUES = {"exchange_current": 2.0, "contact_time": 65.0}
RATE, END = 100.0, 160.0  # [Hz], [s]
STOP, CRANK_BEGIN, CRANK_END, RECHARGE_END = 10.0, 30.0, 31.0, 91.0  # [s]: where each begins, and the last ends
PHASES = ((STOP, CRANK_BEGIN, -15.0), (CRANK_BEGIN, CRANK_END, -300.0), (CRANK_END, RECHARGE_END, 40.0))  # from, to [s], current [A]
# The time axis is stretched around the crank: time [s] and place on the axis.
TIMES, PLACES = (0.0, STOP, 29.5, 31.7, RECHARGE_END, END), (0.0, 0.05, 0.22, 0.45, 0.75, 1.0)
SHOWN = np.unique(np.concatenate([np.arange(0.0, END, 1.5), np.arange(STOP, STOP + 3.0, 0.2), np.arange(29.5, 31.7, 0.02),
                                  np.arange(31.7, 36.0, 0.2), np.arange(RECHARGE_END, RECHARGE_END + 5.0, 0.2)]).round(2))


def model(base, effects, catalogue):
    """A model of the base circuit and effects at their magnitudes, at rest at time 0."""
    made = copy.deepcopy(base)
    made["effects"] = [name for name in catalogue if name in effects]
    for name, value in CIRCUIT.items():
        made["parameters"][name].update(value=value, std_error=1e-6 * value, determined=True, at_bound=False)
    further = {}
    for effect in map(catalogue.get, made["effects"]):
        for one in effect["parameters"]:
            value = float(VALUES.get(one["name"], one["magnitude"]))
            made["parameters"][one["name"]] = {"value": value, "std_error": 1e-6 * abs(value) or 1e-9, "unit": one["unit"],
                                               "at_bound": False, "determined": True, "held": one["held"]}
        for one in effect["states"]:
            further[one["name"]] = {"value": 0.0 if one["begins_as_u_c2"] else one["rest"], "std_error": 1e-6, "unit": one["unit"]}
    made["correlation"] = np.eye(len(made["parameters"]) + 1 + len(further)).tolist()
    made["state"] = {"time_s": 0.0, "u_c2_v": 0.0, "u_c2_std_v": 1e-6, "current_a": 0.0, **({"further": further} if further else {})}
    return made


def signatures(sof, folder):
    """Times, the base circuit's current and voltage, and by the name of each effect what it adds [mV]."""
    call([sof, "simulate", SCENARIO, "drive.csv", "--duration", "240"], folder)
    call([sof, "identify", "drive.csv", "--from", "0", "--to", "240", "--out", "base.yaml"], folder)
    base = yaml.safe_load(read_text(os.path.join(folder, "base.yaml")))
    catalogue = {one["id"]: one for one in json.loads(call([sof, "effects", "--json", "-"]))["effects"]}
    time = np.arange(0.0, END, 1.0 / RATE)
    current = np.zeros_like(time)
    for begin, end, value in PHASES:
        current[(time >= begin) & (time < end)] = value
    rows = [time, current, np.full_like(time, CIRCUIT["u_dc"])]  # the measured voltage is not used
    np.savetxt(os.path.join(folder, "profile.csv"), np.transpose(rows), delimiter=",", header="time_s,current_a,voltage_v", comments="", fmt="%.6g")
    some = np.searchsorted(time, SHOWN - 0.5 / RATE)

    def voltage(effects):
        write_json(os.path.join(folder, "model.yaml"), model(base, effects, catalogue))
        call([sof, "predict", "model.yaml", "profile.csv", "--mode", "current", "--csv", "predicted.csv"], folder)
        return np.genfromtxt(os.path.join(folder, "predicted.csv"), delimiter=",", names=True, dtype=None, encoding="utf-8")["predicted_v"][some]

    added = {name: 1e3 * (voltage([name, *one["needs"]]) - voltage(one["needs"])) for name, one in catalogue.items()}
    return {"current": current[some], "voltage": voltage([]).round(4), "added_mv": {name: values.round(3) for name, values in added.items()},
            "codes": {name: one["code"] for name, one in catalogue.items()}}


def short(value):
    """Two digits, without an exponent."""
    return f"{float(f'{value:.2g}'):+g}" if abs(value) > 1e-3 else "0"


def panel(axes, values, title, corner, color):
    place = np.interp(SHOWN, TIMES, PLACES)
    for begin, end, shade in ((CRANK_BEGIN, CRANK_END, CRANK), (CRANK_END, RECHARGE_END, RECHARGE)):
        axes.axvspan(*np.interp((begin, end), TIMES, PLACES), color=shade, linewidth=0)
    axes.plot(place, values, color=color, linewidth=1.5)
    axes.set_xlim(0, 1)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.margins(y=0.12)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_title(title, fontsize=9, loc="left", pad=15, color=INK)
    axes.text(0, 1.03, corner, transform=axes.transAxes, fontsize=8.5, color=GREY, va="bottom")


def draw(numbers, columns, width):
    """Panels of the current and the voltage of the base circuit, then one of each effect."""
    added = numbers["added_mv"]
    rows = -(-(len(added) + 2) // columns)
    figure, grid = plt.subplots(rows, columns, figsize=(width, 1.32 * rows + 0.1), layout="constrained")
    grid = grid.ravel()
    panel(grid[0], numbers["current"], "current", "-300 to 40 A", INK)
    panel(grid[1], numbers["voltage"], "voltage, base circuit", f"{min(numbers['voltage']):.1f} to {max(numbers['voltage']):.1f} V", INK)
    for axes, (name, values) in zip(grid[2:], added.items()):
        words = name if len(name) < 22 else name.replace("current_dependent_", "current_dep._")
        panel(axes, values, f"{numbers['codes'][name]} {words}", f"{short(min(values))} to {short(max(values))} mV", BLUE)
        axes.axhline(0, color=GREY, linewidth=0.8, linestyle=":")
    for axes in grid[len(added) + 2:]:
        axes.set_axis_off()
    return figure

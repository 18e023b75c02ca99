"""Lines of the pages that are made of docs/results.json: one function of all figures a block."""

import re

from .. import rates, study
from ..tables import table
from ..trips import HEAD, cells

WINDOWS = {"drive_1": "drive_1", "drive_2": "drive_2", "other_car_1": "other_car_1", "small_car": "small_car/trip"}
QUARTERS = {"ev_12v": "ev_12v/load", "ageing_bench": "ageing_bench/cycles", "solar_vrla": "solar_vrla/ten_days", "agm_bench": "agm_bench/full_cycle"}
DIAGNOSED = {"drive_1": "startstop_car/drive_1", "drive_2": "startstop_car/drive_2", "other_car_1": "startstop_car/other_car_1", "small_car": "small_car/trip", "ev_12v": "ev_12v/load",
             "ageing_bench": "ageing_bench/cycles", "agm_bench": "agm_bench/full_cycle", "solar_vrla": "solar_vrla/ten_days", "leaf_cell": "leaf_cell/hppc, lithium", "frc_robot": "frc_robot/match",
             "second_match": "frc_robot/second_match"}


# ---------------------------------------------------------------------------------------------- the next window

def predictions(results, name):
    """Windows of this package and of the paper's circuit; scores of both and of the baseline; their mean errors of cranks where there are three or more."""
    ours, paper = results["next_window"][name], results["next_window_paper"][name]
    each = ours["model"], paper["model"], ours["baseline"]
    has_cranks = (ours["cranks"] or {}).get("count", 0) >= 3
    return ours, paper, each, [f"{one['cranks_mv']:.0f} mV" if has_cranks else None for one in each]


def next_window(results):
    """Explained variation, median error of charges of 60 s, mean error of cranks."""
    rows = []
    for name, label in WINDOWS.items():
        ours, paper, each, cranks = predictions(results, name)
        rows.append((f"{label}, {ours['windows']} ({paper['windows']})",
                     *(f"{one['share_percent']:.0f} %, {one['charges_60s_a']:.1f} A, {error or '-'}" for one, error in zip(each, cranks))))
    return table(("recording, windows (paper's)", "battery_sof", "the paper's circuit", "baseline"), rows)


def channels(results):
    """Explained variation of the current where a source controls the voltage, and of the voltage elsewhere."""
    rows = []
    for name, label in WINDOWS.items():
        _, _, each, _ = predictions(results, name)
        rows.append((label, *(f"{one['current_share_percent']:.0f} %, {one['voltage_share_percent']:.0f} %" for one in each)))
    return table(("recording: current, voltage", "battery_sof", "the paper's circuit", "baseline"), rows)


def next_window_short(results):
    """Explained variation, and the mean error of cranks where there are three or more."""
    labels = ("start-stop car, first drive", "the same car, second drive",
              "same model, another car", "a small start-stop car")
    rows = []
    for name, label in zip(WINDOWS, labels):
        _, _, each, cranks = predictions(results, name)
        share, *others = [f"{one['share_percent']:.0f} %" for one in each]
        rows.append((label, *(", ".join(filter(None, cell)) for cell in zip((f"**{share}**", *others), cranks))))
    return table(("recording", "battery_sof", "the paper's circuit", "baseline"), rows)


def last_quarter(results):
    rows, shown = [], (("share_percent", "{:.1f} %"), ("cranks_mv", "{:.0f} mV"))
    for name, label in QUARTERS.items():
        each = [results["last_quarter"][name][who] for who in ("model", "baseline")]
        cells = [[form.format(one[key]) for key, form in shown if key in one] for one in each]
        rows.append((label, *(", ".join(some) or "-" for some in cells)))
    return table(("recording", "battery_sof", "baseline"), rows)


# ---------------------------------------------------------------------------------------------- diagnoses

def percents(one, *keys):
    """Shares [%] side by side; a dash where nothing controls the voltage."""
    shares = [one[key] for key in keys]
    return "-" if None in shares else ", ".join(f"{share:.0f}" for share in shares)


def diagnosis(results):
    rows = []
    for name, label in DIAGNOSED.items():
        one = results["diagnosis"][name]
        rows.append((label, re.sub(r" \(.*?\)", "", "; ".join(one["reported"].split("; ")[:2])), percents(one, "base_share_percent", "extended_share_percent", "line_share_percent"),
                     ", ".join(f"{one[f'{key}_mv']:.0f}" for key in ("base", "extended", "ridge"))))
    return table(("recording", "verdict; mechanism", "explained [%]: circuit, extended, baseline", "RMS error of the voltage [mV]: circuit, extended, ridge"), rows)


def placebo(results):
    rows = []
    for name, label in DIAGNOSED.items():
        one = results["diagnosis"][name]
        if one["base_share_percent"] is None:
            columns = ["-", ", ".join(f"{one[f'{key}_mv']:.0f} mV" for key in ("base", "extended", "placebo"))]
        else:
            columns = [percents(one, *(f"{key}_{column}_percent" for key in ("base", "extended", "placebo"))) for column in ("equations", "share")]
        rows.append((label, one["placebo"], *columns))
    return table(("recording", "wrong effect", "equations alone [%]: circuit, extended, wrong", "with the residual regression: circuit, extended, wrong"), rows)


def diagnosis_summary(results):
    return [results["diagnosis"]["summary"]]


# ---------------------------------------------------------------------------------------------- drives with known truth

def coverage_short(results):
    return table(study.HEAD, study.coverage_rows(results["study"], ("real", "simulated")))


def percent(k, n):
    """k of n in percent with its 95 % interval."""
    low, high = rates.interval(k, n)
    return f"{100 * k / n:.0f} % ({100 * low:.0f} to {100 * high:.0f})"


def false_positives(one):
    """Controls in which something was reported though nothing is missing: plain ones, and those of imperfect recorders."""
    return "; ".join("{alarms} of {cases}".format(**one[kind]) for kind in ("null", "imperfect_null"))


def out_of_model(results):
    """Simulated batteries whose laws the catalogue does not have, and fault-free controls."""
    one, cases = results["out_of_model"], results["out_of_model"]["others"]
    rows = [("false positives at 100 Hz; imperfect recorders", false_positives(one)),
            ("the same, 1 Hz, 5 min", false_positives(results["nulls_1hz"])),
            ("mechanism right (95 % interval)", f"{one['right']} of {cases}: {percent(one['right'], cases)}"),
            ("wrong; none given; nothing found", f"{one['wrong']}; {one['no_mechanism']}; {one['missed']}"),
            ("hold-out error over the circuit's; ridge", f"{one['ratio']:.2f}; {one['ridge_ratio']:.2f}")]
    return table(("figure", "this version"), rows)


def preregistered(results):
    """The preregistered benchmark: laws that the catalogue has."""
    one = results["preregistered"]

    def of(key):
        return "{k} of {n}".format(**one[key])

    rows = [("false positive on a control", of("false_alarm")), ("clear effect named first", of("first_C1")), ("small effect found", of("class_C2")),
            ("effect found among other differences", of("x1_class")), ("instrument fault called physics", of("decoy_physics")), ("wrong effect named", of("false_name"))]
    return table(("case", "count"), rows)


LEVELS = (("N1", "false positive", "false_alarm", "1 of 60"), ("N2", "wrong name", "false_name", "5 %"), ("C1", "named first", "first_C1", "90 %"),
          ("C1", "named among at most three", "class_C1", "97 %"), ("C2", "named among at most three", "class_C2", "85 %"), ("C3", "named among at most three", "class_C3", ""),
          ("C3", "a base parameter biased by 10 % or more in the part shown first", "c3_biased", ""), ("C4", "named among at most three", "class_C4", "75 %"),
          ("C4", "both named", "c4_both", ""), ("C5", "warned before, named after", "c5_both", "95 %"), ("D1", "called physics", "decoy_physics", "3 %"),
          ("U1", "no name given", "unknown", "85 %"), ("X1", "named among at most three", "x1_class", "75 %"), ("X1", "some wrong name", "x1_wrong", "5 %"),
          ("C1, C2", "the strength's 95 % interval holds the true one", "coverage", "90 to 98 %"))


def preregistered_levels(results):
    """Every level of the newest preregistered run, with what was registered as its aim."""
    one = results["preregistered_quarter"]
    return table(("level", "figure", "measured", "registered aim"), [(level, what, "{k} of {n}".format(**one[key]), aim or "-") for level, what, key, aim in LEVELS])


# ---------------------------------------------------------------------------------------------- the energy manager

RULES = {"manager": "**manager**", "voltage": "voltage at least 12.2 V", "at": "at most 60 s"}


def stop_rows(figures, limits):
    """One row a limit and rule. limits: {limit: rules that are shown}."""
    rows = []
    for limit, rules in limits.items():
        for rule in rules:
            one = figures[limit][rule]
            share = f" ({100 * one['below'] / one['to_the_end']:.1f} %)" if one["below"] > 100 else ""
            rows.append((limit[:-2].replace("_", ".") + " V" if rule == "manager" else "", RULES[rule], f"{one['begun']} of {one['stops']}" if rule == "manager" else one["begun"], f"{one['off_s']:.0f} s",
                         one["to_the_end"], f"**{one['below']}**" if rule == "manager" else f"{one['below']}{share}", one["missed"]))
    return table(("limit", "rule", "stops begun", "engine off", "until the crank", "below", "missed"), rows)


def stops(results):
    return stop_rows(results["stops"], {"7_2_v": ["manager"], "10_3_v": ["manager"], "10_6_v": RULES})


def weakening(results):
    return stop_rows(results["weakening"], {"9_v": RULES})


def trips(results):
    """Second trips of cars, minute by minute: with the state file of the first trip, and cranks without one."""
    with_file, without = results["trips"]["state_file"], results["trips"]["no_state_file"]
    rows = [(*cells(age, one), cells(age, without[age])[2]) for age, one in with_file.items()]
    return table((*HEAD, "cranks, no state file"), rows)

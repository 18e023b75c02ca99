"""Lines of the pages that are made of docs/results.json: one function of all figures a block."""

import re

from .. import rates, study
from ..benchmark.preregistered import score
from ..tables import table
from ..trips import HEAD, cells

WINDOWS = {"drive_1": "drive_1", "drive_2": "drive_2", "other_car_1": "other_car_1", "small_car": "small_car/trip"}
QUARTERS = {"ev_12v": "ev_12v/load", "ageing_bench": "ageing_bench/cycles", "solar_vrla": "solar_vrla/ten_days", "agm_bench": "agm_bench/full_cycle"}
DIAGNOSED = {"drive_1": "startstop_car/drive_1", "drive_2": "startstop_car/drive_2", "other_car_1": "startstop_car/other_car_1", "small_car": "small_car/trip", "ev_12v": "ev_12v/load",
             "ageing_bench": "ageing_bench/cycles", "agm_bench": "agm_bench/full_cycle", "solar_vrla": "solar_vrla/ten_days", "leaf_cell": "leaf_cell/hppc, lithium", "frc_robot": "frc_robot/match",
             "second_match": "frc_robot/second_match"}


# ---------------------------------------------------------------------------------------------- the next window

# What is fitted and predicted beside each other, as the tables head it; rows of a recording.
PREDICTORS = {"model": "battery_sof", "circuit": "the paper's circuit", "placebo": "circuit and a wrong effect", "baseline": "line", "ridge": "ridge", "ridge_all": "ridge on all samples"}
SHORT_ROWS = (("current", "current_share_percent", "{:.0f} %"), ("voltage", "voltage_share_percent", "{:.0f} %"), ("cranks", "cranks_mv", "{:.0f} mV"))
ROWS = (("current and voltage", "share_percent", "{:.0f} %"), *SHORT_ROWS[:2], ("charges of 60 s", "charges_60s_a", "{:.1f} A"), SHORT_ROWS[2])


def side_by_side(measured, labels, rows, form="{}"):
    """One row a recording and figure, of the windows that all are fitted to; cranks where there are three or more."""
    lines = []
    for name, label in labels.items():
        one = measured[name]["common"]
        for what, key, shown in rows:
            wanted = {"cranks_mv": (measured[name]["cranks"] or {}).get("count", 0) >= 3, "share_percent": "current_share_percent" in one["model"]}
            if one["model"].get(key) is not None and wanted.get(key, True):
                values = [one.get(who, {}).get(key) for who in PREDICTORS]
                cells = ["-" if value is None else shown.format(value) for value in values]
                lines.append((form.format(label, windows=one["windows"]) + ": " + what, *cells))
    return table(("recording: what", *PREDICTORS.values()), lines)


def next_window(results):
    return side_by_side(results["next_window"], WINDOWS, ROWS, "{}, {windows} windows")


def next_window_short(results):
    labels = ("start-stop car, first drive", "the same car, second drive", "same model, another car", "a small start-stop car")
    return side_by_side(results["next_window"], dict(zip(WINDOWS, labels)), SHORT_ROWS)


def last_quarter(results):
    return side_by_side(results["last_quarter"], QUARTERS, ROWS)


def paper_start(results):
    """How many windows the paper's initial state gives a model of, and what that explains there."""
    rows = []
    for name, label in WINDOWS.items():
        one = results["next_window"][name]
        shares = [one["paper_start"].get(who, {}).get("share_percent") for who in ("paper_start", "circuit", "model")]
        cells = ["-" if share is None else f"{share:.0f} %" for share in shares]
        rows.append((label, f"{one['paper_start']['windows']} of {one['windows']}", *cells))
    return table(("recording", "windows with a model", "the paper's initial state", "the circuit there", "battery_sof there"), rows)


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


def covered(one, unit):
    """Number, share inside, mean error and width of events, by the names of score_next_window or of study."""
    if not one or not one.get("count", one.get("events")):
        return "-"
    error, width = (one.get(f"{key}_{unit.lower()}", one.get(key)) for key in ("error", "width"))
    return f"{one.get('count', one.get('events'))}: {one['inside_percent']:.0f} %, {error:.2g} {unit}, {width:.2g} {unit}"


def asked(results):
    """Every vehicle by itself: a model of 15 minutes asked about the next, and the online session asked before each event."""
    labels = {**WINDOWS, **{name: name.replace("data_set_", "simulated data set ") for name in study.GROUPS if name.startswith("data_set_")}}
    rows = [(f"{label}: {kind}s", covered(results["next_window"].get(name, {}).get(kind + "s"), unit), covered(results["study"][kind].get(name), unit))
            for name, label in labels.items() for kind, unit in study.UNITS.items()]
    return table(("recording: events", "the model of the 15 minutes before", "the online session"), [row for row in rows if set(row[1:]) != {"-"}])


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
            ("mechanism right, no false one beside it (95 % interval)", f"{one['clean']} of {cases}: {percent(one['clean'], cases)}"),
            ("mechanism right, a false one beside it", f"{one['beside']} of {cases}"),
            ("wrong; none given; nothing found", f"{one['wrong']}; {one['no_mechanism']}; {one['missed']}"),
            ("hold-out error over the circuit's; ridge", f"{one['ratio']:.2f}; {one['ridge_ratio']:.2f}"),
            ("worse than the circuit by over 2 %; withheld as no improvement", f"{one['worse']}; {one['withheld']}")]
    return table(("figure", "this version"), rows)


RUN, BEFORE, POOL = "preregistered_frozen", "preregistered_quarter", "preregistered"  # the newest run; the one before it; two before that, pooled


def k_of_n(one):
    return "{k} of {n}".format(**one)


def preregistered(results):
    """The preregistered benchmark: laws that the catalogue has."""
    rows = [("false positive on a control", "false_alarm"), ("clear effect named first", "first_C1"), ("small effect found", "class_C2"), ("effect found among other differences", "x1_class"),
            ("instrument fault called physics", "decoy_physics"), ("wrong effect named", "false_name")]
    return table(("case", "newest run", "the run before it", "two runs before that, pooled"), [(what, *(k_of_n(results[run][key]) for run in (RUN, BEFORE, POOL))) for what, key in rows])


def levels_of(run):
    """The block of a preregistered run: every figure that it has, with what was registered as its aim."""
    def rows(results):
        for kept, figure in ((results[run].get(one.key), one) for one in score.figures([])):
            if kept and kept["n"]:
                figure = figure._replace(k=kept.get("k"), value=kept.get("value"), n=kept["n"])
                aim = (figure.target or "-") + (": missed" if score.misses(figure) else "")
                yield figure.level, figure.text, f"{figure.value:.2g} (of {figure.n})" if figure.k is None else k_of_n(kept), aim
    return lambda results: table(("level", "figure", "measured", "registered aim"), rows(results))


preregistered_levels, preregistered_levels_before = levels_of(RUN), levels_of(BEFORE)


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

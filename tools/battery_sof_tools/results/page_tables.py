"""Lines of the pages that are made of docs/results.json: one function of all figures a block."""

from .. import rates, study
from ..tables import table

WORDS = {1: "one crank", 2: "two cranks"}
WINDOWS = {"drive_1": "drive_1", "drive_2": "drive_2", "other_car_1": "other_car_1", "small_car": "small_car/trip"}
QUARTERS = {"ev_12v": "ev_12v/load, 12 V battery behind a converter", "ageing_bench": "ageing_bench/cycles", "solar_vrla": "solar_vrla/ten_days", "agm_bench": "agm_bench/full_cycle"}
DIAGNOSED = {"drive_1": "startstop_car/drive_1", "drive_2": "startstop_car/drive_2", "other_car_1": "startstop_car/other_car_1", "small_car": "small_car/trip", "ev_12v": "ev_12v/load",
             "ageing_bench": "ageing_bench/cycles", "agm_bench": "agm_bench/full_cycle", "solar_vrla": "solar_vrla/ten_days", "leaf_cell": "leaf_cell/hppc (lithium)", "frc_robot": "frc_robot/match",
             "second_match": "frc_robot/second_match"}


def none_or(value, form, none="-"):
    return none if value is None else form.format(value)


def cranks_of(windows, who):
    """Mean error, or how few they are."""
    count = (windows["cranks"] or {}).get("count", 0)
    return WORDS.get(count, "-") if count < 3 else f"{windows[who]['cranks_mv']:.0f} mV"


# ---------------------------------------------------------------------------------------------- the next window

def next_window(results):
    rows = []
    for name, label in WINDOWS.items():
        ours, paper = results["next_window"][name], results["next_window_paper"][name]
        for begin, who, one, key in ((f"{label}, {ours['windows']} windows", "battery_sof", ours, "model"), ("", f"paper's circuit, {paper['windows']} windows", paper, "model"),
                                     ("", "straight lines", ours, "baseline")):
            share = f"{one[key]['share_percent']:.1f} %"
            rows.append((begin, who, f"**{share}**" if begin else share, *(f"{one[key][f'charges_{time}s_a']:.2f} A" for time in ("10", "60")), cranks_of(one, key)))
    return table(("recording", "who", "share explained", "charges, 10 s", "charges, 60 s", "cranks"), rows)


def next_window_intervals(results):
    rows = []
    for name, label in WINDOWS.items():
        one = results["next_window"][name]
        cells = [WORDS[one["cranks"]["count"]] if one["cranks"]["count"] < 3 else "{inside_percent:.0f} % of {count}, {width_v:.2f} V".format(**one["cranks"]),
                 "{inside_percent:.0f} % of {count}, {width_a:.1f} A".format(**one["charges"])]
        rows.append((label, *cells))
    return table(("recording", "cranks inside, median width", "charges of 10 s inside, median width"), rows)


def next_window_short(results):
    labels = {"drive_1": "start-stop car, first drive", "drive_2": "the same car, second drive", "other_car_1": "another car of the series", "small_car": "a small start-stop car"}
    rows = []
    for name, label in labels.items():
        ours, paper = results["next_window"][name], results["next_window_paper"][name]
        cells = [f"{one[key]['share_percent']:.0f} %" for one, key in ((ours, "model"), (paper, "model"), (ours, "baseline"))]
        if ours["cranks"]["count"] < 3:
            cells[0] = f"**{cells[0]}**, {WORDS[ours['cranks']['count']]}"
        else:
            errors = (cranks_of(ours, "model"), cranks_of(paper, "model"), cranks_of(ours, "baseline"))
            cells = [f"{f'**{cell}**' if n == 0 else cell}, {'cranks ' if name == 'drive_1' and n == 0 else ''}{error}" for n, (cell, error) in enumerate(zip(cells, errors))]
        rows.append((f"{label}, {ours['windows']} windows", *cells))
    return table(("recording", "battery_sof", "the paper's circuit", "straight lines"), rows)


def last_quarter(results):
    rows = []
    for name, label in QUARTERS.items():
        one = results["last_quarter"][name]
        rows.append((label, *(none_or(one[who].get("share_percent"), "{:.1f} %") + (f", cranks {one[who]['cranks_mv']:.0f} mV" if "cranks_mv" in one[who] else "") for who in ("model", "baseline"))))
    return table(("recording", "battery_sof", "straight lines"), rows)


# ---------------------------------------------------------------------------------------------- diagnoses

def diagnosis(results):
    rows = []
    for name, label in DIAGNOSED.items():
        one = results["diagnosis"][name]
        shares = [none_or(one[f"{side}_share_percent"], "{:.0f}") for side in ("base", "extended")]
        rows.append((label, one["told"], ", ".join(f"{one[f'{key}_mv']:.0f}" for key in ("base", "extended", "ridge", "line")), "" if shares == ["-", "-"] else ", ".join(shares), f"{one['seconds']:.0f}"))
    return table(("recording", "verdict; mechanism (probability); effects", "RMS [mV]: circuit, extended, ridge regression, straight line", "share [%]: circuit, extended", "time [s]"), rows)


def diagnosis_summary(results):
    return [results["diagnosis"]["summary"]]


def small_car_verdict(results):
    """What sof diagnose prints first; the mark says that tests do not run it."""
    return ["<!-- not run: the recording is not part of the repository -->", ""] + ["    " + line for line in results["small_car"]["verdict"]] + [""]


# ---------------------------------------------------------------------------------------------- drives with known truth

def coverage(results):
    return study.coverage_table(results["study"]).splitlines()


def coverage_short(results):
    rows = []
    for group in ("real", "simulated"):
        for kind, unit in study.UNITS.items():
            one = results["study"][kind][group]
            rows.append((f"{kind}s, {group}", one["events"], f"{one['inside_percent']:.1f} %", f"{one['error']:.3g} {unit}", f"{one['width']:.3g} {unit}"))
    return table(("events", "number", "inside 90 %", "mean error", "median width"), rows)


def percent(k, n, digits=0):
    """k of n in percent with its 95 % interval."""
    low, high = rates.interval(k, n)
    return f"{100 * k / n:.{digits}f} % ({100 * low:.{digits}f} to {100 * high:.{digits}f})"


def alarms(*parts):
    """Alarms of plain and of imperfect nulls with their share; kinds of several seeds are added up."""
    cells = []
    for kind in ("null", "imperfect_null"):
        k, n = (sum(part[kind][key] for part in parts) for key in ("alarms", "cases"))
        cells.append(f"{k} of {n}: {percent(k, n, 1)}")
    return "; ".join(cells)


def out_of_model(results):
    seeds = [results[name] for name in ("out_of_model", "out_of_model_34", "out_of_model_24")]
    rows = [["alarms where there is nothing: plain; imperfect recorders", *map(alarms, seeds)],
            ["the same at one sample a second, 5 minutes", "seeds 41 and 43: " + alarms(results["nulls_1hz"]), "", "seeds 31 and 33: " + alarms(results["nulls_1hz_before"])],
            ["mechanism right (another beside it)", *("{right} ({beside}) of {others}: ".format(**one) + percent(one["right"], one["others"]) for one in seeds)],
            ["wrong mechanism; an alarm without one; missed", *("{wrong}; {no_mechanism}; {missed} of {others}".format(**one) for one in seeds)],
            ["hold-out error, extended over circuit, geometric mean; at most half; worse than the circuit", *("{ratio:.2f}; {half} of {others}; {worse}".format(**one) for one in seeds)],
            ["hold-out error, ridge regression over circuit; extended ahead of it", *("{ridge_ratio:.2f}; {ahead_of_ridge} of {others}".format(**one) for one in seeds)]]
    return table(("", "today: seed 36", "the version before: seed 34", "seed 24"), rows)


def mechanism_probability(results):
    """Mechanisms right, by the probability that was stated and by seed."""
    seeds = {name: one for name, one in reversed(results["mechanism_probability"].items()) if name != "all"}
    rows = []
    for stated, label in (("below_0_5", "below 0.5"), ("0_5_to_0_7", "0.5 to 0.7"), ("0_7", "0.7")):
        cells = ["{right} of {cases}".format(**one[stated]) + (f": {percent(one[stated]['right'], one[stated]['cases'])}" if stated == "0_7" else "") for one in seeds.values()]
        rows.append((label, *cells))
    return table(("stated", *(f"right, {name.replace('_', ' ')}" for name in seeds)), rows)


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
    return table(("limit", "rule", "stops begun", "engine off", "to the end", "below", "missed"), rows)


def stops(results):
    return stop_rows(results["stops"], {"7_2_v": RULES, "9_v": ["manager"], "9_5_v": ["manager"], "10_v": ["manager"], "10_3_v": RULES, "10_6_v": RULES})


def weakening(results):
    return stop_rows(results["weakening"], {"9_v": RULES})


def proof_quick(results):
    one = results["proof_quick"]

    def rate(*keys):
        return "; ".join("{k} of {n}".format(**one[key]) for key in keys)

    errors = "; ".join("{value:.2f} ({n} cases)".format(**one[key]) for key in ("charge_current_error_a", "crank_mae_v"))
    return table(("level", "figure", "quick set"), [
        ("N1", "false alarm", rate("false_alarm")),
        ("N2", "name of tier P or I, no true id in its class", rate("false_name")),
        ("C1", "first name true; truth in a class of at most three", rate("first_C1", "class_C1")),
        ("C2", "truth in a class of at most three; some name wrong; nothing said", rate("class_C2", "wrong_C2", "c2_missed")),
        ("C3", "wrong name in the first five minutes; truth in the class on the whole", rate("c3_short_wrong", "class_C3")),
        ("C4", "truth in the class; both named", rate("class_C4", "c4_both")),
        ("C5", "warned before and named after", rate("c5_both")),
        ("D1", "fault named as physics", rate("decoy_physics")),
        ("U1", "called unknown", rate("unknown")),
        ("X1", "truth in some class; some name wrong", rate("x1_class", "x1_wrong")),
        ("C1, X1", "held-out charge current error, extended / base, median; cranks' minima", errors)])

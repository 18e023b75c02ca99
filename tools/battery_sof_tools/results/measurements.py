"""What is measured: the commands, what of their output is kept, and how long they take.

Figures have their unit in their name. BUILD, DATA and OUT in a command are the build folder, the folder of the measured recordings and a folder of
its own. `text` of a kept() is what the commands printed, one after the other.
"""

import collections
import os
import re

from .. import recordings
from ..benchmark.measured import ratio, summary, whole_recordings
from ..files import read_json
from ..page_pictures import PICTURES
from ..rates import geometric_mean
from ..score_next_window import RIDGES
from ..score_next_window import figures as of_windows

# commands; kept(out, text): figures; minutes on one free core; whether DATA is needed; files that the commands write below OUT/docs in place of docs/
Measurement = collections.namedtuple("Measurement", "commands kept minutes data files", defaults=(False, ()))
NAMES = {one: one.split("/")[1] if one.startswith(("startstop", "frc")) else one.split("/")[0] for one in whole_recordings()}
NAMES["frc_robot/match"] = "frc_robot"
STEMS = {one.split("/")[1]: name for one, name in NAMES.items()}
CAR = "--time-column t_s --current-column current_A --voltage-column voltage_V"
SOF = "--sof BUILD/devel/lib/battery_sof/sof"
SCORE = "scripts/score_next_window "
DRIVES = "DATA/startstop_car/drive_1.csv DATA/startstop_car/drive_2.csv DATA/startstop_car/other_car_1.csv " + CAR
SMALL_CAR = "DATA/small_car/trip.csv"


# ---------------------------------------------------------------------------------------------- scores of predictions

# What a window is fitted with: what this package does by itself; no effects; a wrong one; no effects and the paper's initial state.
FITTED = {"model": "", "circuit": "--effects none", "placebo": "--effects current_offset", "paper_start": "--effects none --start paper"}


def scored(out, _):
    """Of every recording of the JSON files of score_next_window, and of the drives of one series together: what the package says; all that is fitted beside it on
    the windows that have a model of each of the first three; and the windows with the paper's initial state."""
    found = {who: [one for name in sorted(os.listdir(out)) if name.startswith(who) for one in read_json(os.path.join(out, name))] for who in FITTED}
    groups = {name: [name] for name in dict.fromkeys(STEMS[one["recording"]] for one in found["model"])}
    groups.update({"drives": ["drive_1", "drive_2", "other_car_1"]} if "drive_1" in groups else {})
    return {group: beside({who: {(one["recording"], one["start_s"]): one for one in some if STEMS[one["recording"]] in names} for who, some in found.items()})
            for group, names in groups.items()}


def beside(windows):
    """windows: {who: {window: scores}}. What has a model of none is left out."""
    common = set.intersection(*(set(windows[who]) for who in ("model", "circuit", "placebo") if windows[who]))
    of = {who: of_windows([one for window, one in some.items() if window in common]) for who, some in windows.items() if some and who != "paper_start"}
    figures = dict(of_windows(list(windows["model"].values())), common={"windows": len(common), "baseline": of["model"]["baseline"], **{one: of["model"][one] for one in RIDGES if one in of["model"]},
                                                                        **{who: one["model"] for who, one in of.items()}})
    paper = windows["paper_start"]
    both = {who: of_windows([some[window] for window in paper if window in some])["model"] for who, some in windows.items()} if paper else {}
    return dict(figures, paper_start={"windows": len(paper), **both})


def score_commands(number, what):
    """Of every way to fit, on one recording or more."""
    return tuple(" ".join(filter(None, (SCORE + what, SOF, options, f"--json OUT/{who}_{number}.json"))) for who, options in FITTED.items())


def split_commands(path, number):
    one = next(one for one in whole_recordings().values() if one.path == path)
    options = recordings.column_options(one.columns, one.discharge_positive) if one.columns != recordings.COLUMNS else []
    return score_commands(number, " ".join([f"DATA/{path} --split 0.75", *options, *recordings.capacity_options(one.capacity_ah)]))


# ---------------------------------------------------------------------------------------------- diagnoses

def diagnosed(out, _):
    """Figures of every recording as diagnose_measured writes them, and who is ahead."""
    found = read_json(os.path.join(out, "measured.json"))
    figures = {NAMES[name]: {"reported": one["told"], **{f"{key}_mv": 1e3 * one[key] for key in ("base", "extended", "ridge", "line")},
                             **dict(zip(("base_share_percent", "extended_share_percent", "line_share_percent"), one["shares"])),
                             **dict(zip(("base_equations_percent", "extended_equations_percent"), one["equations"])), "placebo": one["placebo"]["effect"], "placebo_mv": 1e3 * one["placebo"]["extended"],
                             "placebo_share_percent": one["placebo"]["share"], "placebo_equations_percent": one["placebo"]["equations"], "seconds": one["seconds"]} for name, one in found.items()}
    return dict(figures, recordings=len(found), ratio=geometric_mean([ratio(one) for one in found.values()]), summary=summary(found),
                ridge_ahead=sum(one["ridge"] < one["extended"] for one in found.values()), line_ahead=sum(one["line"] < one["extended"] for one in found.values()))


def one_diagnosis(out, _):
    """All that docs/reading-a-diagnosis.md says of one: its JSON, flat."""
    answer = read_json(os.path.join(out, "answer.json"))
    figures = {"mechanisms": {one["id"]: one["probability"] for one in answer["mechanisms"]}, "source_percent": 100 * answer["charger_share"],
               "learnable_mv": 1e3 * answer["relevance"]["rmse_v"], "evidence": {one["id"]: one["evidence"] for one in answer["candidates"]}}
    for part in ("train", "holdout"):
        for model in ("base", "extended"):
            metrics = answer["fit"][model][part]
            figures[f"{model}_{part}"] = {"rmse_mv": 1e3 * metrics["rmse_v"], "largest_v": metrics["max_abs_v"], "cranks": metrics["cranks"],
                                          "cranks_mv": 1e3 * metrics["crank_mae_v"], "charge_current_error_a": metrics["charge_current_error_a"],
                                          **{key: metrics[key] for key in ("share_percent", "current_share_percent", "voltage_share_percent")}}
    figures["ridge_mv"], figures["line_mv"] = (1e3 * answer[one]["rmse_v"] for one in ("baseline", "baseline_line"))
    figures["episodes"] = {one["regime"]: one["episodes"] for one in answer["regimes"] if one["statistic"] == "mean"}
    figures["mean_mv"] = {one["regime"]: 1e3 * one["value"] for one in answer["regimes"] if one["statistic"] == "mean"}
    figures["compared_mv"] = {one["regime"]: {"base": 1e3 * one["base_rmse_v"], "extended": 1e3 * one["extended_rmse_v"]} for one in answer["fit"]["regimes"]}
    figures["change_percent"] = {one["parameter"]: {} for one in answer["parameter_bias"]}
    for one in answer["parameter_bias"]:
        figures["change_percent"][one["parameter"]][one["regime"]] = 100 * one["change"]
    return figures


# ---------------------------------------------------------------------------------------------- benchmarks of the diagnosis

def out_of_model(out, _):
    cases = read_json(os.path.join(out, "cases.json"))["cases"]
    others = [one for one in cases if one["kind"] == "other_form"]
    figures = {kind: {"alarms": sum(one["outcome"] == "alarm" for one in cases if one["kind"] == kind),
                      "cases": sum(one["kind"] == kind for one in cases)} for kind in ("null", "imperfect_null")}
    count = collections.Counter(one["outcome"] for one in others)
    ratios = [one["ratio"] for one in others if one["ratio"] is not None]
    ridges = [one["ridge_v"] / one["base_v"] for one in others if one["ridge_v"] and one["base_v"]]
    withheld = sum(one["withheld_v"] is not None for one in others)
    return dict(figures, withheld=withheld, others=len(others), right=count["right"] + count["beside"], clean=count["right"], beside=count["beside"], wrong=count["wrong"], no_mechanism=count["none"], missed=count["missed"],
                ratio=geometric_mean(ratios), half=sum(one <= 0.5 for one in ratios), worse=sum(one > 1.02 for one in ratios), ridge_ratio=geometric_mean(ridges),
                ahead_of_ridge=sum(one["extended_v"] < one["ridge_v"] for one in others if one["ratio"] is not None and one["ridge_v"]))


def fleet_nulls(_, text):
    """Alarms and judged recordings of two tables of sof-fleet judge, added up."""
    figures = {}
    for kind in ("null", "imperfect_null"):
        rows = [re.search(r"(\d+) of (\d+)", line) for line in text.splitlines() if line.startswith(f"| {kind} |")]
        figures[kind] = {"alarms": sum(int(row[1]) for row in rows), "cases": sum(int(row[2]) for row in rows)}
    return figures


def proof(out, _):
    """k of n, or the value, of every figure of a scored proof."""
    return {key: {"k": one["k"], "n": one["n"]} if one["k"] is not None else {"value": one["value"], "n": one["n"]}
            for key, one in read_json(os.path.join(out, "score.json"))["figures"].items()}


# ---------------------------------------------------------------------------------------------- speed

def ratio_of(text, line):
    """Median and range of the last ratio of a line of bench or bench_composed that begins so."""
    row = next(one for one in text.splitlines() if one.startswith(line))
    least, most = re.findall(r"(\d+\.\d+) \.\. +(\d+\.\d+)", row)[-1]
    median = float(re.findall(r"\d+\.\d+", row[:row.rindex(f"{least} ..")])[-1])
    return {"ratio": median, "least": float(least), "most": float(most)}


def over_fastest_ceres(text):
    """That of the variant of Ceres of which it is lowest, and how the table calls that one."""
    names = {row[:row.index("  ")] for row in text.splitlines() if row.startswith("Ceres ")}
    return min(({**ratio_of(text, name + "  "), "variant": name, "variants": len(names)} for name in sorted(names)), key=lambda one: one["ratio"])


def speed(_, text):
    one_window, composed = text[:text.index("base + 3 effects")], text[text.index("base + 3 effects"):]
    return {"search_over_ceres": over_fastest_ceres(one_window), "search_over_bounded_ceres": ratio_of(one_window, "Ceres autodiff, plain, QR, bounds"),
            "composed_over_ceres": over_fastest_ceres(composed), "composed_ms": float(re.search(r"^ours: compressed, then full rate +(\d+)", composed, re.M)[1])}


def queries(_, text):
    rows = re.findall(r"work of a question: 99 % within ([\d.]+) ms, longest ([\d.]+) ms.*\n.*sample: 99 % within ([\d.]+) ms, longest ([\d.]+) ms", text)
    keys = ("work_p99_ms", "work_longest_ms", "delay_p99_ms", "delay_longest_ms")
    return {name: dict(zip(keys, map(float, row))) for name, row in zip(("base", "effects"), rows)}


def stops(_, text):
    """Rows of compare_stop_rules by limit and rule; of several recordings those of all."""
    figures, limit = {}, None
    for line in text.splitlines():
        cells = [one.strip() for one in line.strip("|").split("|")]
        if line.startswith("| recording"):
            limit = re.search(r"below ([\d.]+) V", line)[1].replace(".", "_") + "_v"
        elif cells[0] == "all":
            begun, count = map(int, cells[2].split(" of "))
            figures.setdefault(limit, {})[cells[1].split(" ")[0]] = {"begun": begun, "stops": count, "off_s": float(cells[3].split()[0]), "to_the_end": int(cells[4]),
                                                                     "below": int(cells[5]), "missed": int(cells[7])}
    return figures


def as_written(name):
    """Figures as a command writes them."""
    return lambda out, _: read_json(os.path.join(out, name + ".json"))


RULES = "scripts/compare_stop_rules --build BUILD "
TWO_DRIVES = "DATA/startstop_car/drive_1.csv DATA/startstop_car/drive_2.csv " + CAR
OUT_OF_MODEL = "scripts/out_of_model --build BUILD --out OUT --seed {} --kinds null=10,imperfect_null=20,other_form=58 --json OUT/cases.json"


def nulls_of(seed):
    cases, fleet = f"OUT/{seed}", f"OUT/fleet_{seed}"
    return (f"scripts/out_of_model --build BUILD --out {cases} --seed {seed} --rate 1 --duration 300 --kinds null=300,imperfect_null=300 --only-draw",
            f"scripts/sof-fleet run {cases}/recordings --out {fleet} --build BUILD", f"scripts/sof-fleet judge {fleet}")


MEASUREMENTS = {
    "next_window": Measurement((*score_commands(1, DRIVES), *score_commands(2, SMALL_CAR)), scored, 10, True),
    "last_quarter": Measurement(sum((split_commands(path, n) for n, path in enumerate(("ev_12v/load.csv", "ageing_bench/cycles.csv", "solar_vrla/ten_days.csv", "agm_bench/full_cycle.csv"))), ()),
                                scored, 3, True),
    "trips": Measurement(("scripts/trips BUILD --data DATA --json OUT/trips.json",), as_written("trips"), 2, True),
    "stop_voltage": Measurement(("scripts/stops BUILD --data DATA --json OUT/stops.json",), as_written("stops"), 1, True),
    "diagnosis": Measurement(("scripts/diagnose_measured BUILD --data DATA --json OUT/measured.json",), diagnosed, 3, True),
    "same_diagnosis": Measurement(("scripts/same_diagnosis BUILD --data DATA --jobs 2 --json OUT/same_diagnosis.json",), as_written("same_diagnosis"), 20, True),
    "small_car": Measurement((f"BUILD/devel/lib/battery_sof/sof diagnose {SMALL_CAR} --threads 1 --json OUT/answer.json --report OUT/page.html",
                              "scripts/page_pictures OUT/page.html OUT/docs/pictures"), one_diagnosis, 0.5, True, tuple(f"pictures/{one}" for one in PICTURES)),
    "study": Measurement(("scripts/study BUILD --data DATA --json OUT/study.json",), as_written("study"), 10, True),
    "reproduction": Measurement(("scripts/reproduce BUILD --json OUT/reproduction.json",), as_written("reproduction"), 8),
    "proof_quick": Measurement(("scripts/proof quick --build BUILD --seal test/proof/quick --out OUT/quick --json OUT/score.json",), proof, 5, False),
    "stops": Measurement(tuple(f"{RULES}{TWO_DRIVES} --u-required {limit}" for limit in ("7.2", "9", "9.5", "10", "10.3", "10.6")), stops, 3, True),
    "weakening": Measurement((f"{RULES}--weakening 10 --u-required 9",), stops, 20, False),
    "out_of_model": Measurement((OUT_OF_MODEL.format(36),), out_of_model, 40, False),
    "nulls_1hz": Measurement((*nulls_of(41), *nulls_of(43)), fleet_nulls, 120, False),
    "speed": Measurement(("scripts/bench BUILD", "scripts/bench_composed BUILD"), speed, 5, False),
    "queries": Measurement(("scripts/with_ros bash -c '. BUILD/devel/setup.sh && exec scripts/bench_queries BUILD 60'",), queries, 4, False),
}

"""Whether `sof diagnose` finds where model and recording deviate: changes that are limited in time or to a regime, concealed in recordings (docs/validation.md).

    scripts/locating BUILD --out DIR [--seed 1] [--bases 12] [--data FOLDER] [--minutes M] [--jobs 1]

A base is a recording that `draw_scenario` simulates, three in four by the base circuit, the others with another structure; with --data, half an hour of each
measured drive as well. Each base is asked as it is (the control), with one change limited in time, and with one limited to a regime:

    resistance     v + R i, R 3 to 10 mOhm, within a stretch of 60 to 300 s
    unseen load    v + a (1 - exp(-t / 30 s)) within such a stretch, |a| 20 to 60 mV, t since its beginning
    crank          v + R i, R 1 to 3 mOhm, where the current is below -150 A
    charge         v + a (1 - exp(-t / 10 s)) in charges longer than 10 s at more than 2 A, |a| 20 to 60 mV, t since the charge's beginning
    rest           v + a (1 - exp(-t / 30 s)) at rest, |a| 10 to 30 mV, t since the rest's beginning

Only the voltage is changed, and it is written in the steps of its sensor. Stretches lie before the last quarter, which a diagnosis keeps for its comparison
and in which it locates nothing. Time: recall is the share of the stretch that is covered by the reported ones, precision the share of these that lies in the stretch
or within 30 s of it; found means half of each. Of a base that has a mismatch of its own, stretches that touch none of the control's are scored as well.
Regime: which has the largest mean or end among those reported as significant, and which are reported at all.

The baseline is what an engineer would do without a diagnosis: `sof identify --effects none` and `sof predict` of the same rows, and of the error the minute with the
largest RMS, or all minutes with more than twice the median RMS; of regimes the one with the largest RMS.

DIR keeps the answers, so that a run that was cut off goes on, and figures.json has the counts.
"""

import argparse
import functools
import math
import os
import random
import statistics
import tempfile
import time

import numpy as np

from .. import recordings
from ..files import require_same, write_json
from ..rates import wilson_90
from ..sof import RECORDING, Failure, call, diagnose, program, run
from ..tables import grouped, table
from . import laws
from .causes import CAPACITY_AH
from .generator import KIND_OF, seed_of
from .runner import ANSWERS, complete, kept_for

FIGURES = "figures.json"
PATIENCE_S = 400.0
CONTROL, RESISTANCE, UNSEEN_LOAD = "control", "resistance", "unseen load"
CRANK, CHARGE, REST = "crank", "charge", "rest"
IN_TIME, IN_REGIME = (RESISTANCE, UNSEEN_LOAD), (CRANK, CHARGE, REST)
# The product's words for the regimes that a change is put into.
REGIMES_OF = {CRANK: {"crank"}, CHARGE: {"long charge"}, REST: {"post-charge rest", "post-discharge rest", "rest before any load"}}
MIN_EPISODES = 5              # docs/physics.md#regimes: fewer are not tested
CIRCUIT, STRUCTURE, MEASURED = "circuit", "other structure", "measured"
# Of simulated bases, in turn.
SIMULATED = ("null", "null", "null", "structural_null", "null", "null", "null", "porous_null")
DURATION_S = (1200.0, 1800.0)
STRETCH_S = 1800.0            # of a measured drive
TRAINING = 0.75               # share of the samples in which a diagnosis locates
MARGIN_S = 60.0               # from the beginning of a recording to that of a stretch
SMALLEST_CHANGE_V = 5e-3      # RMS over a stretch: it is drawn again where it has less, as a resistance has at rest
DRAWS = 50
BESIDE_S = 30.0               # of a stretch, that count as inside
HALF = 0.5
KEPT = ("regime", "statistic", "episodes", "value", "lower", "upper", "p_value", "alarm")  # of a finding
WINDOW_S, STRIDE_S = 60.0, 10.0  # of the baseline
CLEAR = 2.0                   # times the median RMS
CRANK_A, LOAD_A, LONG_S, LONG_A, STEP_S, GAP_S = -150.0, 0.5, 10.0, 2.0, 0.1, 5.0  # src/diagnosis/regimes.hpp


# -------------------------------------------------------------------------------------------------- time

def union(stretches):
    """The same times without overlaps, in order."""
    merged = []
    for begin, end in sorted(stretches):
        if merged and begin <= merged[-1][1]:
            merged[-1][1] = max(merged[-1][1], end)
        else:
            merged.append([begin, end])
    return merged


def length(stretches):
    """[s] in one of the stretches or more."""
    return sum(end - begin for begin, end in union(stretches))


def common(stretches, begin, end):
    """[s] of them from begin to end."""
    return length([(max(a, begin), min(b, end)) for a, b in stretches if min(b, end) > max(a, begin)])


def time_score(reported, truth):
    """Recall, precision (None where nothing is reported) and whether half of each is reached. truth: (begin, end)."""
    begin, end = truth
    said = length(reported)
    recall = common(reported, begin, end) / (end - begin)
    precision = common(reported, begin - BESIDE_S, end + BESIDE_S) / said if said > 0.0 else None
    return {"recall": recall, "precision": precision, "found": recall >= HALF and precision is not None and precision >= HALF}


# -------------------------------------------------------------------------------------------------- regimes

def runs_of_loads(t, current):
    """Sign (-1, 0, 1) of every sample's discharge, rest or charge, and (begin, end) of the runs, ends excluded.

    As src/diagnosis/regimes.hpp: on means over 0.1 s, a load begins beyond 0.5 A and ends below half of that; a gap ends it.
    """
    step = max(1, round(STEP_S / float(np.median(np.diff(t)))))
    means = np.add.reduceat(current, np.arange(0, len(t), step)) / np.diff(np.append(np.arange(0, len(t), step), len(t)))
    signs, sign, new = [], 0, [True] + list(np.diff(t[::step]) > GAP_S + step * STEP_S)
    for one in means:
        if sign * one < 0.5 * LOAD_A:
            sign = 0
        if not sign and abs(one) > LOAD_A:
            sign = 1 if one > 0.0 else -1
        signs.append(sign)
    begins = [k for k in range(len(signs)) if new[k] or signs[k] != signs[k - 1]]
    bounds = [k * step for k in begins] + [len(t)]
    return np.repeat(signs, step)[:len(t)], list(zip(bounds, bounds[1:]))


def episodes_of(regime, t, current):
    """(begin, end) of the episodes of a regime that a change is put into."""
    if regime == CRANK:
        return recordings.runs(current < CRANK_A)
    signs, runs = runs_of_loads(t, current)
    if regime == REST:
        return [(a, b) for a, b in runs if signs[a] == 0]
    return [(a, b) for a, b in runs if signs[a] > 0 and t[b - 1] - t[a] > LONG_S and current[a:b].mean() > LONG_A]


def regime_score(findings, regime):
    """Whether a regime is the first by size of those that are significant, and whether it is one of them at all. findings: as of the JSON."""
    significant, names = [one for one in findings if one["alarm"]], REGIMES_OF[regime]
    sized = sorted((one for one in significant if one["statistic"] != "slope"), key=lambda one: -abs(one["value"])) or significant
    return {"first": bool(sized) and sized[0]["regime"] in names, "among": any(one["regime"] in names for one in significant),
            "others": len({one["regime"] for one in significant} - names)}


# -------------------------------------------------------------------------------------------------- changes

def amplitude(dice, low, high):
    """A size drawn from low to high, of either sign."""
    return dice.choice((-1.0, 1.0)) * dice.uniform(low, high)


def rising(t, begin, end, time_constant):
    """1 - exp(-t / time constant) from sample `begin` to `end`, zero elsewhere."""
    change = np.zeros(len(t))
    change[begin:end] = -np.expm1((t[begin] - t[begin:end]) / time_constant)
    return change


def change_in_time(kind, t, current, dice):
    """The change of the voltage [V], and its label. Failure where no stretch shows one."""
    last = t[int(TRAINING * len(t)) - 1]
    for _ in range(DRAWS):
        duration = dice.uniform(60.0, 300.0)
        from_s = dice.uniform(t[0] + MARGIN_S, last - duration)
        begin, end = np.searchsorted(t, (from_s, from_s + duration))
        if kind == RESISTANCE:
            size = dice.uniform(3e-3, 10e-3)
            change = np.where((np.arange(len(t)) >= begin) & (np.arange(len(t)) < end), size * current, 0.0)
        else:
            size = amplitude(dice, 20e-3, 60e-3)
            change = size * rising(t, begin, end, 30.0)
        if end > begin and math.sqrt(np.mean(change[begin:end] ** 2)) >= SMALLEST_CHANGE_V:
            return change, {"size": size, "from_s": float(t[begin]), "to_s": float(t[end - 1])}
    raise Failure(f"no stretch in which the {kind} shows")


def change_in_regime(kind, t, current, dice):
    """As change_in_time(). Failure where the regime does not occur before the last quarter."""
    episodes = episodes_of(kind, t, current)
    before = sum(int(end) <= TRAINING * len(t) for _, end in episodes)
    if not before:
        raise Failure(f"no {kind} before the last quarter")
    if kind == CRANK:
        size = dice.uniform(1e-3, 3e-3)
        change = np.where(current < CRANK_A, size * current, 0.0)
    else:
        low, high, time_constant = (20e-3, 60e-3, 10.0) if kind == CHARGE else (10e-3, 30e-3, 30.0)
        size = amplitude(dice, low, high)
        change = size * sum((rising(t, begin, end, time_constant) for begin, end in episodes), np.zeros(len(t)))
    return change, {"size": size, "episodes": before}


# -------------------------------------------------------------------------------------------------- the baseline

def baseline_of(t, current, error):
    """Stretches by the RMS error of minutes, and the regime with the largest RMS error."""
    begins = np.arange(t[0], max(t[-1] - WINDOW_S, t[0]) + 1e-9, STRIDE_S)
    square = np.concatenate(([0.0], np.cumsum(error**2)))
    first, last = np.searchsorted(t, begins), np.searchsorted(t, begins + WINDOW_S)
    filled = last > first
    begins, rms = begins[filled], np.sqrt((square[last] - square[first])[filled] / (last - first)[filled])
    clear = rms > CLEAR * np.median(rms)
    signs, _ = runs_of_loads(t, current)
    long = np.zeros(len(t), bool)
    for begin, end in episodes_of(CHARGE, t, current):
        long[begin:end] = True
    masks = {CRANK: current < CRANK_A, CHARGE: long, "short charge": (signs > 0) & ~long, "discharge": (signs < 0) & (current >= CRANK_A), REST: signs == 0}
    sizes = {name: float(np.sqrt(np.mean(error[mask] ** 2))) for name, mask in masks.items() if mask.any()}
    worst = float(begins[np.argmax(rms)])
    return {"worst": [[worst, worst + WINDOW_S]], "clear": union((float(one), float(one) + WINDOW_S) for one in begins[clear]), "regime": max(sizes, key=sizes.get)}


def baseline(sof, recording, folder, last_s):
    """baseline_of() the circuit's error up to a time."""
    model, rows = (os.path.join(folder, name) for name in ("model.yaml", "rows.csv"))
    window = ("--from", "0", "--to", f"{last_s:.6f}")
    call([sof, "identify", recording, "--effects", "none", *window, "--out", model], patience_s=PATIENCE_S)
    if not os.path.exists(model):
        raise Failure("sof identify: no model was written")
    call([sof, "predict", model, recording, *window, "--csv", rows], patience_s=PATIENCE_S)
    t, current, voltage, predicted = np.genfromtxt(rows, delimiter=",", skip_header=1, usecols=(0, 1, 2, 3)).T
    shown = np.isfinite(predicted) & np.isfinite(voltage)
    return baseline_of(t[shown], current[shown], (voltage - predicted)[shown])


# -------------------------------------------------------------------------------------------------- cases

def turns(kinds, count, dice):
    """`count` of the kinds, as many of each as there can be, in an order of the dice."""
    drawn = [kinds[k % len(kinds)] for k in range(count)]
    dice.shuffle(drawn)
    return drawn


def plan(seed, count, data=None):
    """Cases, three of each base."""
    dice = random.Random(seed_of(seed, "locating"))
    bases = [{"base": kind, "group": CIRCUIT if kind == "null" else STRUCTURE} for kind in (SIMULATED[k % len(SIMULATED)] for k in range(count))]
    bases += [{"base": name, "group": MEASURED} for name in sorted(CAPACITY_AH)] if data else []
    in_time, in_regime = turns(IN_TIME, len(bases), dice), turns(IN_REGIME, len(bases), dice)
    return [{"name": f"base_{number:03d}_{what}", "kind": kind, "base_seed": seed_of(seed, "base", number), "seed": seed_of(seed, "case", number, kind), **base}
            for number, base in enumerate(bases, 1) for what, kind in zip("abc", (CONTROL, in_time[number - 1], in_regime[number - 1]))]


def base_of(build, data, case, folder):
    """Time, current and voltage of a base; the time begins at 0."""
    if case["group"] == MEASURED:
        t, i, u = recordings.measured(data, case["base"])
        shown = t < t[0] + STRETCH_S
        return t[shown] - t[0], i[shown], u[shown]
    path = os.path.join(folder, "base.csv")
    duration = random.Random(case["base_seed"]).uniform(*DURATION_S)
    run([program(build, "draw_scenario"), "--kind", KIND_OF[case["base"]], "--seed", str(case["base_seed"]), "--duration", f"{duration:.0f}",
         "--out", path, "--label", os.path.join(folder, "label.json")])
    return recordings.read_plain(path)


def answered(build, data, case):
    """What is true of a case, what is reported, and what the baseline says."""
    sof, dice = program(build, "sof"), random.Random(case["seed"])
    with tempfile.TemporaryDirectory(prefix="locating_") as folder:
        t, current, voltage = base_of(build, data, case, folder)
        truth, shown = {}, voltage
        if case["kind"] != CONTROL:
            change, truth = (change_in_time if case["kind"] in IN_TIME else change_in_regime)(case["kind"], t, current, dice)
            shown = laws.in_steps(voltage, voltage + change, case["seed"])
        path = os.path.join(folder, RECORDING)
        recordings.write(path, t, current, shown)
        said = diagnose(sof, path, patience_s=PATIENCE_S)
        measured = baseline(sof, path, folder, t[int(TRAINING * len(t)) - 1])
    return {**case, "truth": truth, "verdict": said["verdict"], "effects": [one["id"] for one in said["effects"]],
            "stretches": [[one["from_s"], one["to_s"]] for one in said["mismatch"]], "stretch_regimes": [one["regime"] for one in said["mismatch"]],
            "regimes": [{key: one[key] for key in KEPT} for one in said["regimes"]],
            "duration_s": float(t[-1] - t[0]), "baseline": measured}


# -------------------------------------------------------------------------------------------------- counts

# What is scored in time: words, and the stretches of a case beside its control.
REPORTED = {"sof": ("sof diagnose", lambda row, _: row["stretches"]), "new": ("the same without the control's", lambda row, control: apart(row["stretches"], control["stretches"] if control else [])),
            "worst": ("baseline: worst minute", lambda row, _: row["baseline"]["worst"]), "clear": ("baseline: minutes above twice the median", lambda row, _: row["baseline"]["clear"])}


def counted(rows, key):
    return [sum(bool(row[key]) for row in rows), len(rows)]


def middle(values):
    values = [one for one in values if one is not None]
    return statistics.median(values) if values else None


def apart(stretches, others):
    """Those that have no time in common with the others."""
    return [one for one in stretches if not common(others, *one)]


def time_figures(rows, controls):
    """Counts over cases that are limited in time, of the product and of both baselines. controls: {base_seed: row}."""
    found = {"cases": len(rows)}
    for name in REPORTED:
        scores = [time_score(REPORTED[name][1](row, controls.get(row["base_seed"])), (row["truth"]["from_s"], row["truth"]["to_s"])) for row in rows]
        found[name] = {"found": counted(scores, "found"), "inside": [sum((one["precision"] or 0.0) >= HALF for one in scores), len(scores)],
                       "recall": middle(one["recall"] for one in scores), "precision": middle(one["precision"] for one in scores)}
    return found


def regime_figures(rows):
    """Counts over cases that are limited to a regime."""
    scores = [regime_score(row["regimes"], row["kind"]) for row in rows]
    return {"cases": len(rows), **{key: counted(scores, key) for key in ("first", "among")}, "others": middle(one["others"] for one in scores),
            "testable": sum(row["truth"]["episodes"] >= MIN_EPISODES for row in rows), "baseline": [sum(row["baseline"]["regime"] == row["kind"] for row in rows), len(rows)]}


def control_figures(rows):
    """How often something is located where nothing was put in."""
    return {"cases": len(rows), "stretch": [sum(bool(row["stretches"]) for row in rows), len(rows)], "regime": [sum(any(one["alarm"] for one in row["regimes"]) for row in rows), len(rows)],
            "share": middle(length(row["stretches"]) / (TRAINING * row["duration_s"]) for row in rows), "clear": [sum(bool(row["baseline"]["clear"]) for row in rows), len(rows)]}


def figures(rows):
    """{group of bases: {kind: counts}}."""
    judged = [row for row in rows if "failed" not in row]
    in_time = functools.partial(time_figures, controls={row["base_seed"]: row for row in judged if row["kind"] == CONTROL})
    found = {"cases": len(rows), "answered": len(judged), "groups": {}}
    for group, members in grouped(judged, lambda row: row["group"]).items():
        by_kind = grouped(members, lambda row: row["kind"])
        of = found["groups"][group] = {}
        for kinds, count in (((CONTROL,), control_figures), (IN_TIME, in_time), (IN_REGIME, regime_figures)):
            shown = [kind for kind in kinds if kind in by_kind]
            of.update({kind: count(by_kind[kind]) for kind in shown})
            if len(shown) > 1:
                of["all in time" if kinds == IN_TIME else "all in a regime"] = count([row for kind in shown for row in by_kind[kind]])
    return found


def share_of(counts):
    """"k of n (.. to .. %)"."""
    low, high = wilson_90(*counts)
    return f"{counts[0]} of {counts[1]} ({100 * low:.0f} to {100 * high:.0f} %)"


def percent(value):
    return "-" if value is None else f"{100 * value:.0f} %"


def tables(found):
    """Lines of the three tables: in time, in a regime, controls."""
    in_time, in_regime, controls = [], [], []
    for group, of in found["groups"].items():
        for kind, one in of.items():
            if "share" in one:
                controls.append((group, share_of(one["stretch"]), percent(one["share"]), share_of(one["regime"]), share_of(one["clear"])))
            elif "sof" in one:
                for name, (words, _) in REPORTED.items():
                    if name == "new" and group == CIRCUIT:
                        continue  # nothing of their own
                    in_time.append((group, kind, words, share_of(one[name]["found"]), share_of(one[name]["inside"]), percent(one[name]["recall"]), percent(one[name]["precision"])))
            else:
                in_regime.append((group, kind, share_of(one["first"]), share_of(one["among"]), f"{one['others']:g}", share_of(one["baseline"]), f"{one['testable']} of {one['cases']}"))
    return [*table(("bases", "change", "by", "found", "precision of half", "recall, median", "precision, median"), in_time), "",
            *table(("bases", "change", "its regime first", "its regime among those reported", "others reported, median", "baseline: largest RMS", "five episodes"), in_regime), "",
            *table(("bases, nothing put in", "a stretch is reported", "share of the time, median", "a regime is reported", "baseline: a minute is reported"), controls)]


def main(given=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("--out", required=True, help=f"folder of answers and {FIGURES}: a run that was cut off goes on")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bases", type=int, default=12, help="simulated recordings, three cases of each")
    parser.add_argument("--data", help="folder of measured recordings, for three cases of each drive more")
    parser.add_argument("--minutes", type=float, default=math.inf, help="end after the case that passes these")
    parser.add_argument("--jobs", type=int, default=1)
    a = parser.parse_args(given)
    kept_for(a.out, program(a.build, "sof"))
    cases, ends = plan(a.seed, a.bases, a.data), time.monotonic() + 60.0 * a.minutes
    require_same(os.path.join(a.out, "plan.json"), {"cases": cases}, "other cases")
    rows = complete(os.path.join(a.out, ANSWERS), functools.partial(answered, a.build, a.data), cases, a.jobs, "located", enough=lambda _: time.monotonic() > ends)
    asked = [rows[case["name"]] for case in cases if case["name"] in rows]
    found = figures(asked)
    print("\n".join(tables(found)))
    failed = [f"{row['name']}: {row['failed']}" for row in asked if "failed" in row]
    print(f"\n{len(asked)} of {len(cases)} cases were asked, {len(failed)} without an answer", *failed, sep="\n")
    write_json(os.path.join(a.out, FIGURES), found)
    return 0

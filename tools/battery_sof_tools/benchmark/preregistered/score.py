"""What is counted of preregistered cases: rates with their intervals, mechanisms, who was taken for whom, and what went wrong."""

import collections
import json
import statistics

from ...rates import rate
from ...tables import grouped, table
from .. import scorers
from ..answers import class_of, counted, first_class
from ..scorers import Figure, entry, written
from . import judged, levels
from .judged import is_silent

WITH_TRUTH = ("C1", "C2", "C3", "C4", "C5", "X1")


def rates(key, level, text, right, target="", levels=None):
    """A figure: how many of what right(case) lists are true, over the cases of the levels ("all": of every level)."""
    def figure(cases):
        every = [bool(one) for case in of_levels(cases, levels or (level,)) for one in right(case)]
        return Figure(key, level, text, sum(every), len(every), None, target)
    return figure


def count(key, level, text, right, target=""):
    """A figure: for how many cases of a level right(case) is true."""
    return rates(key, level, text, lambda case: [right(case)], target)


def middle(key, level, text, value, target="", levels=None, of=statistics.median):
    """A figure: the middle of value(case), where it has one."""
    def figure(cases):
        values = [one for one in map(value, of_levels(cases, levels or (level,))) if one is not None]
        return Figure(key, level, text, None, len(values), of(values) if values else None, target)
    return figure


def of_levels(cases, levels):
    return cases if levels == ("all",) else [case for level in levels for case in cases if case.level == level]


def ratio(key, text, target):
    return middle(key, "C1, X1", f"held-out {text}, extended / base, median", lambda case: case.over_base(metric=key), target, ("C1", "X1"))


def of_strength(part):
    return lambda case: (judged.strength_found(case) or (None, None))[part]


def names_of_one():
    for level, target in (("C1", ">= 97 %"), ("C2", ">= 85 %"), ("C3", ""), ("C4", ">= 75 %"), ("C5", ">= 95 %")):
        yield count(f"first_{level}", level, "first name true", judged.first_true, ">= 90 %" if level == "C1" else "")
        yield count(f"class_{level}", level, "truth in the first class, at most three names", judged.class_true, target)
        yield count(f"wrong_{level}", level, "some name of tier P or I wrong", judged.wrong_names)
        if level != "C4":
            yield count(f"itself_{level}", level, "added effect named itself, first or not, without its companion's help", judged.named_itself)


# Every metric of the benchmark (docs/physics.md#cases-with-known-truth), in its order.
FIGURES = (
    count("false_alarm", "N1", "false alarm: any verdict but no_mismatch", lambda c: c.verdict != "no_mismatch", "<= 1/60"),
    count("false_name", "N2", "false name: tier P or I, no true id in its class", judged.wrong_names, "<= 5 %"),
    count("false_alone", "N2", "of these with no piece of structure in the class", judged.names_without_structure),
    count("false_physics", "N2", "a name of tier P, no true id in its class", judged.wrong_physics),
    *names_of_one(),
    middle("class_size", "C1", "mean size of the first class", lambda c: len(first_class(c.answer)) or None, "<= 1.5", of=statistics.mean),
    count("c1_unknown", "C1", "called unknown", lambda c: c.verdict == "unknown", "<= 5 %"),
    count("c1_missed", "C1", "nothing said", lambda c: is_silent(c.answer)),
    count("c2_missed", "C2", "nothing said", lambda c: is_silent(c.answer)),
    count("c3_short_wrong", "C3", "first five minutes: a wrong name", judged.wrong_before, "<= 3 %"),
    count("c3_short_silent", "C3", "first five minutes: nothing said", lambda c: is_silent(c.short)),
    count("c3_short_right", "C3", "first five minutes: truth in the first class", lambda c: judged.class_true(c, c.short)),
    count("c3_hidden", "C3", "cases whose first five minutes leave z < 5", lambda c: c.label.get("z_short", 9.0) < 5.0),
    count("c3_biased", "C3", "of these with a base parameter biased by 10 % or more there", lambda c: c.label.get("as_wanted")),
    middle("c3_bias", "C3", "largest bias of a base parameter there, median", lambda c: abs(c.label["bias"]) if "bias" in c.label else None),
    middle("c4_ratio", "C4", "RMS together over that of the larger part, median", lambda c: c.label.get("ratio"), "< 0.4"),
    count("c4_both", "C4", "both effects named", judged.both_named),
    count("c5_warned", "C5", "warned before", judged.warned, ">= 95 %"),
    count("c5_both", "C5", "warned before and named after", lambda c: judged.warned(c) and judged.class_true(c), ">= 95 %"),
    count("c5_short_wrong", "C5", "a wrong name before", judged.wrong_before),
    count("decoy_physics", "D1", "fault named as physics", judged.wrong_physics, "<= 3 %"),
    count("decoy_structure", "D1", "fault named as structure", lambda c: judged.wrong_names(c, tiers="S")),
    count("decoy_found", "D1", "fault found: in a named class, or the instruments' screen speaks", judged.fault_found),
    count("unknown", "U1", "called unknown", lambda c: c.verdict == "unknown", ">= 85 %"),
    # A falling C_2 counts as out of the catalogue, which has it as a drift (docs/physics.md#cases-with-known-truth).
    count("unknown_or_drift", "U1", "called unknown, or a falling C_2 by the name that P10 has for it",
          lambda c: c.verdict == "unknown" or c.label["id"] == "capacitance_fall" and first_class(c.answer) == ["parameter_drift"]),
    count("unknown_named", "U1", "given a name of tier P",
          lambda c: c.verdict != "unknown" and any(one["id"] in c.catalogue.physics for one in c.answer["effects"])),
    count("x1_class", "X1", "truth in some named class, at most three names", judged.any_class_true, ">= 75 %"),
    count("x1_wrong", "X1", "some name of tier P or I wrong", judged.wrong_names, "<= 5 %"),
    middle("rho", "C1, C4, X1", "recovered fraction of the held-out error, median", judged.recovered, ">= 0.85", WITH_TRUTH),
    middle("rho_C1", "C1", "recovered fraction, median", judged.recovered),
    middle("rho_X1", "X1", "recovered fraction, median", judged.recovered),
    ratio("charge_current_error_a", "charge current error", "<= 0.3"),
    ratio("crank_mae_v", "cranks' minima", "<= 0.3"),
    ratio("rmse_v", "RMSE", ""),
    middle("strength_error", "C1, C2", "relative error of the strength, median", of_strength(0), "<= 10 %", ("C1", "C2")),
    rates("weak_names", "all", "names of tier P or I with evidence below 20 that are right", judged.weak_names),
    rates("coverage", "C1, C2", "95 % interval holds the true strength",
          lambda c: [one for one in (of_strength(1)(c),) if one is not None], "90 to 98 %", ("C1", "C2")))
# Bounds for a tenth of the benchmark, as a share of the cases: a set this small shows only what is clearly broken, and one case may always fail.
BOUNDS = (("false_alarm", "most", 0.17), ("false_physics", "most", 0.34), ("class_C1", "least", 0.70), ("c3_short_wrong", "most", 0.34),
          ("decoy_physics", "most", 0.34), ("x1_wrong", "most", 0.50))


def figures(cases):
    return [figure(cases) for figure in FIGURES]


def broken(report):
    """Sentences about figures beyond BOUNDS; empty when all is well."""
    by_key = {figure.key: figure for figure in report["figures"]}
    said = [f"not judged: {one}" for one in report["failed"]]
    for key, kind, part in BOUNDS:
        one = by_key[key]
        allowed = max(1, int(part * one.n)) if kind == "most" else min(one.n - 1, -int(-part * one.n // 1))
        if one.k > allowed if kind == "most" else one.k < allowed:
            said.append(f"{one.level}, {one.text}: {one.k} of {one.n}, at {kind} {allowed} expected")
    return said


# ------------------------------------------------------------------------------------------------ by mechanisms: a right mechanism with a wrong name in it is half of an answer

LEVELS = ("N2", "C1", "C2", "C3", "C4", "C5", "D1", "X1")  # of which the catalogue has what is true
COUNTS = {"right": "right mechanism", "beside": "of these another mechanism beside it", "wrong": "only wrong mechanisms", "none": "an alarm without a mechanism", "missed": "missed"}
# The count of names that a level's mechanisms stand beside.
BY_NAME = {"N2": ("no wrong name of tier P or I", lambda case: not judged.wrong_names(case)),
           "D1": ("fault found", judged.fault_found), "X1": ("in some class of at most three", judged.any_class_true)}
CLASS = ("in the first class, at most three", judged.class_true)


def by_mechanism(cases):
    """Counts by level of what has a mechanism; (mechanisms named, cases) where none of the catalogue's is true; and how often stated probabilities are right."""
    levels = {}
    for level, mine in grouped(cases, lambda case: case.level).items():
        if level in LEVELS:
            found = counted(mine)
            text, right = BY_NAME.get(level, CLASS)
            levels[level] = dict(found, n=len(mine), by_name=(text, sum(bool(right(case)) for case in mine)), right=found["right"] + found["beside"],
                                 missed=found["missed"] + found["short"])
    alarms = {level: (sum(bool(case.said) for case in mine), len(mine)) for level in ("N1", "U1") for mine in [of_levels(cases, (level,))] if mine}
    return {"levels": {level: levels[level] for level in LEVELS if level in levels}, "alarms": alarms, "reliability": scorers.reliability(cases)}


def mechanism_lines(of):
    """Markdown of by_mechanism()."""
    rows = [[level, one["by_name"][0], rate(one["by_name"][1], one["n"])] + [rate(one[key], one["n"]) for key in COUNTS]
            for level, one in of["levels"].items()]
    text = ["### By mechanisms", ""] + table(["level", "of names", "right by name", *COUNTS.values()], rows)
    if of["alarms"]:
        text += ["", "A mechanism named where none is true: " + "; ".join(f"{level} {rate(k, n)}" for level, (k, n) in of["alarms"].items()) + "."]
    return text + [""] + table(["stated probability of a mechanism", "right"], [(name, rate(k, n)) for name, k, n in of["reliability"]])


def mechanism_entries(of):
    """by_mechanism() for programs."""
    return {"levels": {level: dict({key: entry(one[key], one["n"]) for key in COUNTS}, by_name=dict(entry(one["by_name"][1], one["n"]), what=one["by_name"][0]))
                       for level, one in of["levels"].items()},
            "alarms": {level: entry(k, n) for level, (k, n) in of["alarms"].items()},
            "reliability": [dict(entry(k, n), probability=name) for name, k, n in of["reliability"]]}


# ------------------------------------------------------------------------------------------------ case by case

def confusion(cases):
    """Counts by (row, column): the truth's level and id against the first name, or the verdict in brackets where nothing is named."""
    counts = collections.Counter()
    for case in cases:
        row = case.label["id"] if case.label["id"] != "-" else case.label["family"]
        heard = first_class(case.answer)
        counts[f"{case.level} {row}", heard[0] if heard and case.verdict != "unknown" else f"({case.verdict})"] += 1
    return counts


WRONG = {"N1": lambda case: case.verdict != "no_mismatch", "N2": judged.wrong_names,
         "C3": lambda case: not judged.class_true(case) or judged.wrong_before(case),
         "C5": lambda case: not judged.class_true(case) or not judged.warned(case) or judged.wrong_before(case),
         "D1": lambda case: judged.wrong_physics(case) or not judged.fault_found(case),
         "U1": lambda case: case.verdict != "unknown",
         "X1": lambda case: not judged.any_class_true(case) or judged.wrong_names(case)}


def went_wrong(case):
    """Whether something is wrong with the answers to a case."""
    return bool(WRONG.get(case.level, lambda one: not judged.class_true(one) or judged.wrong_names(one))(case))


def told_of(case):
    """A failure in one line: case, truth, how hard it was, what was said."""
    label = case.label
    hard = ", ".join(f"{key} {label[key]:g}" for key in ("z", "z_whole", "z_short", "ratio") if label.get(key) is not None)
    text = f"{label['name']} {case.level} {label['family']} {label['id']} scale {'x'.join(f'{s:g}' for s in label['scale'])}"
    for name, answer in case.answers.items():
        names = ", ".join(f"{'|'.join(class_of(one))} {one['evidence'] or 0:.0f}" for one in answer["effects"])
        near = ", ".join(f"{one['id']} {one['evidence'] or 0:.0f}" for one in answer["candidates"][:2] if one["rejected_because"])
        text += f" | {name}: {answer['verdict']}" + (f" [{names}]" if names else "") + (f" (rejected: {near})" if near else "")
    return text + (f" | {hard}" if hard else "")


def score(said, cases, failed):
    """Everything that is reported. said: what the seal says of itself."""
    return {"seal": said, "cases": cases, "failed": failed, "figures": figures(cases), "confusion": confusion(cases),
            "mechanisms": by_mechanism(cases),
            "wrong": [told_of(case) for case in sorted(cases, key=lambda c: (c.level, c.label["id"])) if went_wrong(case)]}


def as_json(report):
    """The figures for programs."""
    figures_of = {one.key: {"level": one.level, "what": one.text, "k": None, "n": one.n, "value": one.value, **entry(one.k, one.n)} for one in report["figures"]}
    return json.dumps({"seal": report["seal"], "figures": figures_of, "mechanisms": mechanism_entries(report["mechanisms"])}, indent=2)


def confusion_lines(counts):
    """Lines of confusion(), in the order of the levels."""
    place = {one.level: k for k, one in enumerate(levels.STRATA)}
    rows = {row for row, _ in counts}
    for row in sorted(rows, key=lambda row: (place.get(row.split()[0], len(place)), row)):
        heard = [(count, column) for (truth, column), count in counts.items() if truth == row]
        yield f"  {row:44s} " + ", ".join(f"{column} {count}" for count, column in sorted(heard, reverse=True))


def as_text(report):
    said = report["seal"]
    lines = [f"{said['cases']} cases sealed from {said['frozen_commit']}, "
             f"labels SHA-256 {said['labels_sha256']}", ""]
    lines += [f"{one.level:8s} {one.text:68s} {written(one):42s} {one.target}".rstrip()
              for one in report["figures"]]
    lines += [""] + mechanism_lines(report["mechanisms"])
    lines += ["", "who was taken for whom (truth: first name, or verdict in brackets)"]
    lines += confusion_lines(report["confusion"])
    lines += ["", f"what went wrong ({len(report['wrong'])} cases)"]
    lines += ["  " + one for one in report["wrong"]]
    if report["failed"]:
        lines += ["", "not judged"] + ["  " + one for one in report["failed"]]
    return "\n".join(lines) + "\n"

"""What is counted of preregistered cases: rates with their intervals, mechanisms, who was taken for whom, and what went wrong."""

import collections
import json
import re
import statistics

from ...rates import rate
from ...tables import grouped, table
from .. import scorers
from ..answers import class_of, counted, first_class
from ..scorers import Figure, entry, written
from . import judged, levels

WITH_TRUTH = ("C1", "C2", "C3", "C4", "C5", "X1")


def rates(key, level, text, right, target="", levels=None):
    """A figure: how many of what right(case) lists are true, over the cases of the levels."""
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
    return [case for level in levels for case in cases if case.level == level]


def ratio(key, text, target):
    return middle(key, "C1, X1", f"held-out {text}, extended / base, median", lambda case: case.over_base(metric=key), target, ("C1", "X1"))


def of_strength(part):
    return lambda case: (judged.strength_found(case) or (None, None))[part]


def of_concealed(right):
    """For rates(): right(case) of the cases that conceal what they were made to."""
    return lambda case: [right(case)] if case.label["as_wanted"] else []


# Of every level what has a registered aim, or stands on a page, in the gate or in BOUNDS (docs/physics.md#cases-with-known-truth).
FIGURES = (
    count("false_alarm", "N1", "false positive: any verdict but no_mismatch", lambda c: c.verdict != "no_mismatch", "<= 1/60"),
    count("false_name", "N2", "wrong name: physics or an instrument, nothing true in its class", judged.wrong_names, "<= 5 %"),
    count("false_physics", "N2", "wrong name of physics, nothing true in its class", judged.wrong_physics),
    count("first_C1", "C1", "first name true", judged.first_true, ">= 90 %"),
    *(count(f"class_{level}", level, "truth in the first class, at most three names", judged.class_true, target)
      for level, target in (("C1", ">= 97 %"), ("C2", ">= 85 %"), ("C3", ""), ("C4", ">= 75 %"), ("C5", ">= 95 %"))),
    middle("class_size", "C1", "mean size of the first class", lambda c: len(first_class(c.answer)) or None, "<= 1.5", of=statistics.mean),
    count("c1_unknown", "C1", "called unknown", lambda c: c.verdict == "unknown", "<= 5 %"),
    count("c3_short_wrong", "C3", "first five minutes: a wrong name", judged.wrong_before, "<= 3 %"),
    count("c3_biased", "C3", "first five minutes: a base parameter biased by 10 % or more", lambda c: c.label.get("as_wanted")),
    count("c6_concealed", "C6", "first five minutes: a base parameter biased by 10 % and 3 standard errors, the residual raised by 10 % at most",
          lambda c: c.label["as_wanted"]),
    *(rates(f"c6_{key}", "C6", "of these, " + text, of_concealed(right)) for key, text, right in (
        ("short_named", "first five minutes: truth in the first class", lambda c: judged.class_true(c, c.short)),
        ("short_wrong", "first five minutes: a wrong name", judged.wrong_before),
        ("named", "the whole: truth in the first class, at most three names", judged.class_true),
        ("mechanism", "the whole: its mechanism named", lambda c: c.outcome in ("right", "beside")),
        ("wrong", "the whole: a wrong name", judged.wrong_names))),
    middle("c4_ratio", "C4", "RMS together over that of the larger part, median", lambda c: c.label.get("ratio"), "< 0.4"),
    count("c4_both", "C4", "both effects named", judged.both_named),
    count("c5_warned", "C5", "warned before", judged.warned, ">= 95 %"),
    count("c5_both", "C5", "warned before and named after", lambda c: judged.warned(c) and judged.class_true(c), ">= 95 %"),
    count("decoy_physics", "D1", "fault named as physics", judged.wrong_physics, "<= 3 %"),
    count("unknown", "U1", "called unknown", lambda c: c.verdict == "unknown", ">= 85 %"),
    count("x1_class", "X1", "truth in some named class, at most three names", judged.any_class_true, ">= 75 %"),
    count("x1_wrong", "X1", "some wrong name of physics or an instrument", judged.wrong_names, "<= 5 %"),
    middle("rho", "C1, C4, X1", "recovered fraction of the held-out error, median", judged.recovered, ">= 0.85", WITH_TRUTH),
    *(rates(f"{key}_{level}", level, text, lambda case, outcome=outcome: [case.outcome == outcome]) for level in ("C1", "C2", "X1") for key, text, outcome in (
        ("clean", "mechanism right, no false one beside it", "right"), ("beside", "mechanism right, a false one beside it", "beside"))),
    rates("withheld", "C1, C4, X1", "extended model withheld, no improvement on the hold-out", lambda case: [] if case.withheld is None else [case.withheld], "", WITH_TRUTH),
    ratio("charge_current_error_a", "charge current error", "<= 0.3"),
    ratio("crank_mae_v", "cranks' minima", "<= 0.3"),
    middle("strength_error", "C1, C2", "relative error of the strength, median", of_strength(0), "<= 10 %", ("C1", "C2")),
    rates("coverage", "C1, C2", "95 % interval holds the true strength",
          lambda c: [one for one in (of_strength(1)(c),) if one is not None], "90 to 98 %", ("C1", "C2")))
# Bounds for a tenth of the benchmark, as a share of the cases: a set this small shows only what is clearly broken, and one case may always fail.
BOUNDS = (("false_alarm", "most", 0.17), ("false_physics", "most", 0.34), ("class_C1", "least", 0.70), ("c3_short_wrong", "most", 0.34),
          ("decoy_physics", "most", 0.34), ("x1_wrong", "most", 0.50))


def misses(figure):
    """Whether a figure is beyond its registered aim; None without an aim or a case."""
    numbers = [float(one) / float(of or 1) for one, of in re.findall(r"([\d.]+)(?:/(\d+))?", figure.target)]
    value = figure.value if figure.k is None else figure.k / figure.n if figure.n else None
    if not numbers or value is None:
        return None
    value *= 100.0 if "%" in figure.target else 1.0
    return not (numbers[0] <= value <= numbers[1] if len(numbers) > 1 else value >= numbers[0] if figure.target.startswith(">=") else
                value <= numbers[0] if figure.target.startswith("<=") else value < numbers[0])


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

LEVELS = ("N2", "C1", "C2", "C3", "C4", "C5", "C6", "D1", "X1")  # of which the catalogue has what is true
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
         "C6": lambda case: not judged.class_true(case) or judged.wrong_before(case),
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
    hard = ", ".join(f"{key} {label[key]:g}" for key in ("z", "z_whole", "z_short", "ratio", "bias", "raised") if label.get(key) is not None)
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
    return json.dumps({"seal": report["seal"], "figures": figures_of}, indent=2)


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

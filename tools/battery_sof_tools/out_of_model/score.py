"""Counts alarms, mechanisms and held-out errors (docs/validation.md)."""

import collections
import json
import os
import statistics

from .. import mechanisms, tables
from ..files import read_json
from ..rates import geometric_mean, rate, spread
from .cases import ANSWERS, LABELS, RIDGES, path


class Case:
    """A label, the answer to it, the catalogue of effects (None: mechanisms as the answer has them), seconds and the ridge's hold-out RMSE [V]."""

    def __init__(self, label, answer, catalogue=None, seconds=None, ridge_v=None, name=""):
        self.label, self.answer, self.catalogue, self.seconds, self.ridge_v, self.name = label, answer, catalogue, seconds, ridge_v, name

    @property
    def kind(self):
        return self.label["kind"]

    @property
    def verdict(self):
        return self.answer["verdict"]

    @property
    def alarmed(self):
        return self.verdict not in (mechanisms.QUIET, mechanisms.SHORT)

    def said(self):
        """{mechanism: probability} of the answer's own mechanism and those of its effects."""
        return mechanisms.mechanisms_of(self.answer, self.catalogue)

    def outcome(self):
        """Of another form: right, beside (right, and another mechanism too), wrong, none (alarm, no mechanism), missed, short."""
        return mechanisms.outcome(self.verdict, self.said(), {self.label["mechanism"]})

    def holdout(self, side):
        fit = self.answer.get("fit") or {}
        return ((fit.get(side) or {}).get("holdout") or {}).get("rmse_v")

    def ratio(self):
        """Hold-out error of the extended model over the base's; None without both."""
        base, extended = self.holdout("base"), self.holdout("extended")
        return extended / base if base and extended is not None else None

    def claims(self):
        """(mechanism, probability, whether it is true) of every mechanism that is named with a probability; each mechanism once."""
        return mechanisms.claims(self.said(), {self.label["mechanism"]})


def opened(out, catalogue=None):
    """Judged cases and what could not be judged."""
    cases, failed = [], []
    for case in read_json(os.path.join(out, "plan.json"))["cases"]:
        name = case["name"]
        label, answer, ridge = (path(out, folder, name, "json") for folder in (LABELS, ANSWERS, RIDGES))
        if not os.path.exists(label) or not os.path.exists(answer):
            failed.append(f"{name}: " + ("not drawn" if not os.path.exists(label) else "not asked"))
            continue
        said = read_json(answer)
        if "failed" in said:
            failed.append(f"{name}: {said['failed']}")
            continue
        baseline = read_json(ridge)["rmse_v"] if os.path.exists(ridge) else None
        cases.append(Case(read_json(label), said["answer"], catalogue, said["seconds"], baseline, name))
    return cases, failed


def null_figures(cases, kind):
    """Rows (what, figure) of one kind of null."""
    some = [one for one in cases if one.kind == kind]
    judged = [one for one in some if one.verdict != mechanisms.SHORT]
    ratios = [one.ratio() for one in some if one.ratio() is not None]
    return [("alarms", rate(sum(one.alarmed for one in judged), len(judged))),
            ("insufficient data", rate(len(some) - len(judged), len(some))),
            ("a mechanism named", rate(sum(bool(one.said()) for one in judged), len(judged))),
            ("extended worse than base by over 2 %", rate(sum(one > 1.02 for one in ratios), len(ratios)))]


def mechanism_figures(some):
    counts = collections.Counter(one.outcome() for one in some)
    judged = len(some) - counts["short"]
    return [("mechanism right", rate(counts["right"] + counts["beside"], judged)),
            ("right, another mechanism beside it", rate(counts["beside"], judged)),
            ("wrong mechanism", rate(counts["wrong"], judged)),
            ("alarm without a mechanism", rate(counts["none"], judged)),
            ("missed", rate(counts["missed"], judged)),
            ("insufficient data", rate(counts["short"], len(some)))]


def error_figures(some):
    ratios = [one.ratio() for one in some if one.ratio() is not None]
    beside = [one for one in some if one.ratio() is not None and one.ridge_v]
    over_base = [one.ridge_v / one.holdout("base") for one in beside]
    return [("hold-out error, extended over base", spread(ratios)),
            ("at most half the base's", rate(sum(one <= 0.5 for one in ratios), len(ratios))),
            ("extended worse than base by over 2 %", rate(sum(one > 1.02 for one in ratios), len(ratios))),
            ("hold-out error, ridge over base", spread(over_base)),
            ("extended better than ridge", rate(sum(one.holdout("extended") < one.ridge_v for one in beside), len(beside)))]


def reliability(cases):
    """(bin, claims that are right, claims) over all kinds; a mechanism named of a null is wrong."""
    return mechanisms.reliability([claim for one in cases for claim in one.claims()])


def seconds_row(cases):
    taken = sorted(one.seconds for one in cases if one.seconds is not None)
    if not taken:
        return "no case"
    return f"median {statistics.median(taken):.1f}, nine in ten below {taken[int(0.9 * (len(taken) - 1))]:.1f}, longest {taken[-1]:.1f}"


def as_markdown(cases, failed):
    lines = []

    def add(title, rows):
        lines.extend(["", f"**{title}**", ""] + tables.table(["", ""], rows))

    for kind, title in (("null", "Plain nulls"), ("imperfect_null", "Imperfect nulls")):
        if any(one.kind == kind for one in cases):
            add(f"{title} ({sum(one.kind == kind for one in cases)})", null_figures(cases, kind))
    others = [one for one in cases if one.kind == "other_form"]
    if others:
        add(f"Other forms ({len(others)})", mechanism_figures(others) + error_figures(others))
        lines.extend(mechanism_table(others))
    claimed = reliability(cases)
    if any(n for _, _, n in claimed):
        add("Probability of mechanisms, and how many were right", [(name, rate(k, n)) for name, k, n in claimed])
    else:
        lines.extend(["", "No answer names a mechanism with a probability."])
    add("Time", [("seconds a case", seconds_row(cases))])
    return "\n".join(lines[1:] + ([""] + [f"Not judged: {one}" for one in failed] if failed else [])) + "\n"


def mechanism_table(others):
    """One row a mechanism and one a form: outcomes, and what is left of the hold-out error."""
    groups = collections.defaultdict(list)
    for one in others:
        groups[(one.label["mechanism"], "")].append(one)
        groups[(one.label["mechanism"], one.label["form"])].append(one)
    rows = [mechanism_row(f"- {form}" if form else f"**{mechanism}**", groups[mechanism, form]) for mechanism, form in sorted(groups)]
    return [""] + tables.table(["mechanism, form", "cases", "right", "beside", "wrong", "none", "missed", "taken for", "extended / base",
                                "ridge / base"], rows)


def mechanism_row(title, some):
    counts = mechanisms.counted(one.outcome() for one in some)
    taken = collections.Counter(mechanism for one in some if one.outcome() == "wrong" for mechanism in one.said())
    ratios = [one.ratio() for one in some if one.ratio() is not None]
    ridges = [one.ridge_v / one.holdout("base") for one in some if one.ridge_v and one.holdout("base")]
    return [title, len(some)] + [counts[one] for one in ("right", "beside", "wrong", "none", "missed")] + [
        ", ".join(f"{name} {k}" for name, k in taken.most_common())] + [
            f"{geometric_mean(values):.2f}" if values else "" for values in (ratios, ridges)]


def as_json(cases, failed):
    """Every case with what was found of it, for looking closer."""
    rows = []
    for one in cases:
        rows.append({"name": one.name, **{key: one.label.get(key) for key in ("kind", "mechanism", "form", "drive", "seed", "duration_s",
                                                                             "sample_rate_hz", "visible_rms_v")},
                     "verdict": one.verdict, "mechanisms": sorted(one.said()), "ratio": one.ratio(), "ridge_v": one.ridge_v,
                     "base_v": one.holdout("base"), "extended_v": one.holdout("extended"), "seconds": one.seconds,
                     "effects": [effect.get("id") for effect in one.answer.get("effects") or []],
                     "outcome": one.outcome() if one.kind == "other_form" else ("alarm" if one.alarmed else one.verdict)})
    return json.dumps({"cases": rows, "failed": failed}, indent=1)

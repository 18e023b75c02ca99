"""Opens the labels and counts: the table of rates with their intervals, who was taken for whom, and what went wrong."""

import collections
import json
import os
import statistics

from ..files import digest, lines_of
from ..rates import interval, rate
from . import by_mechanism, judged
from .names import holds
from .run import ANSWERS, TOLD
from .seal import opened

WITH_TRUTH = ("C1", "C2", "C3", "C4", "C5", "X1")
SIDES = ("base", "extended", "told")
SHOWN_ERRORS = ("rmse_v", "charge_current_error_a", "crank_mae_v")
Figure = collections.namedtuple("Figure", "key level text k n value target")  # a rate k of n, or a value over n cases


def cases_of(sealed, results, catalogue):
    """Judged cases, what could not be judged, and what the seal says; nothing is opened unless both digests are right."""
    path = os.path.join(results, ANSWERS)
    with open(os.path.join(results, "answers.sha256")) as f:
        if f.read().strip() != digest(path):
            raise SystemExit(f"{path} is not what was answered: its digest is another than answers.sha256 says")
    said, labels = opened(sealed)
    answers = {one["name"]: one for one in lines_of(path)}
    told = {one["name"]: one.get("answer") for one in lines_of(os.path.join(results, TOLD))}
    cases, failed = [], []
    for label in labels:
        one = answers.get(label["name"], {"failed": label.get("failed", "no answer")})
        if "failed" in one:
            failed.append(f"{label['name']} {label['level']} {label['family']} {label['id']}: {one['failed']}")
        else:
            cases.append(judged.Case(label, one["answers"], told.get(label["name"]), catalogue))
    return said, cases, failed


class Figures:
    """Cases by level, and the figures made of them so far."""

    def __init__(self, cases):
        self.cases = cases
        self.at = collections.defaultdict(list)
        for case in cases:
            self.at[case.level].append(case)
        self.out = []

    def count(self, key, level, text, right, target):
        self.out.append(Figure(key, level, text, sum(bool(right(case)) for case in self.at[level]), len(self.at[level]), None, target))

    def middle(self, key, level, text, values, target, of=statistics.median):
        values = [value for value in values if value is not None]
        self.out.append(Figure(key, level, text, None, len(values), of(values) if values else None, target))


def verdict_is(*wanted):
    return lambda case: case.whole["verdict"] in wanted


def figures(cases):
    """Every metric of the benchmark (docs/physics.md#cases-with-known-truth) that can be had, in its order."""
    to = Figures(cases)
    for part in (alarms_without_physics, names_of_one, short_recordings, names_of_two, decoys_and_unknowns, what_is_recovered):
        part(to)
    return to.out


def alarms_without_physics(to):
    to.count("false_alarm", "N1", "false alarm: any verdict but no_mismatch", lambda c: c.whole["verdict"] != "no_mismatch", "<= 1/60")
    to.count("false_name", "N2", "false name: tier P or I, no true id in its class", judged.wrong_names, "<= 5 %")
    to.count("false_alone", "N2", "of these with no piece of structure in the class", judged.names_without_structure, "")
    to.count("false_physics", "N2", "a name of tier P, no true id in its class", lambda c: judged.wrong_names(c, tiers="P"), "")


def names_of_one(to):
    for level, target in (("C1", ">= 97 %"), ("C2", ">= 85 %"), ("C3", ""), ("C4", ">= 75 %"), ("C5", ">= 95 %")):
        to.count(f"first_{level}", level, "first name true", judged.first_true, ">= 90 %" if level == "C1" else "")
        to.count(f"class_{level}", level, "truth in the first class, at most three names", judged.class_true, target)
        to.count(f"wrong_{level}", level, "some name of tier P or I wrong", judged.wrong_names, "")
        if level != "C4":
            to.count(f"itself_{level}", level, "added effect named itself, first or not, without its companion's help", judged.named_itself, "")
    sizes = [len(judged.first_class(c.whole)) for c in to.at["C1"] if c.whole["effects"]]
    to.middle("class_size", "C1", "mean size of the first class", sizes, "<= 1.5", statistics.mean)
    to.count("c1_unknown", "C1", "called unknown", verdict_is("unknown"), "<= 5 %")
    to.count("c1_missed", "C1", "nothing said", verdict_is(*judged.SAYS_NOTHING), "")
    to.count("c2_missed", "C2", "nothing said", verdict_is(*judged.SAYS_NOTHING), "")


def short_recordings(to):
    to.count("c3_short_wrong", "C3", "first five minutes: a wrong name", lambda c: judged.wrong_names(c, c.short), "<= 3 %")
    to.count("c3_short_silent", "C3", "first five minutes: nothing said", lambda c: c.short["verdict"] in judged.SAYS_NOTHING, "")
    to.count("c3_short_right", "C3", "first five minutes: truth in the first class", lambda c: judged.class_true(c, c.short), "")
    to.count("c3_hidden", "C3", "cases whose first five minutes leave z < 5", lambda c: c.label.get("z_short", 9.0) < 5.0, "")
    to.count("c3_biased", "C3", "of these with a base parameter biased by 10 % or more there", lambda c: c.label.get("as_wanted"), "")
    to.middle("c3_bias", "C3", "largest bias of a base parameter there, median", [abs(c.label["bias"]) for c in to.at["C3"] if "bias" in c.label], "")


def names_of_two(to):
    to.middle("c4_ratio", "C4", "RMS together over that of the larger part, median", [c.label.get("ratio") for c in to.at["C4"]], "< 0.4")
    to.count("c4_both", "C4", "both effects named",
             lambda c: all(any(holds(judged.class_of(e), [one]) for e in c.whole["effects"]) for one in c.label["id"].split("+")), "")
    to.count("c5_warned", "C5", "warned before", judged.warned, ">= 95 %")
    to.count("c5_both", "C5", "warned before and named after", lambda c: judged.warned(c) and judged.class_true(c), ">= 95 %")
    to.count("c5_short_wrong", "C5", "a wrong name before", lambda c: judged.wrong_names(c, c.short), "")


def decoys_and_unknowns(to):
    to.count("decoy_physics", "D1", "fault named as physics", lambda c: judged.wrong_names(c, tiers="P"), "<= 3 %")
    to.count("decoy_structure", "D1", "fault named as structure", lambda c: judged.wrong_names(c, tiers="S"), "")
    to.count("decoy_found", "D1", "fault found: in a named class, or the instruments' screen speaks", judged.fault_found, "")
    to.count("unknown", "U1", "called unknown", verdict_is("unknown"), ">= 85 %")
    # A falling C_2 counts as out of the catalogue, which has it as a drift (docs/physics.md#cases-with-known-truth).
    to.count("unknown_or_drift", "U1", "called unknown, or a falling C_2 by the name that P10 has for it",
             lambda c: c.whole["verdict"] == "unknown" or c.label["id"] == "capacitance_fall" and judged.first_class(c.whole) == ["parameter_drift"], "")
    to.count("unknown_named", "U1", "given a name of tier P",
             lambda c: c.whole["verdict"] != "unknown" and any(e["id"] in c.catalogue.physics for e in c.whole["effects"]), "")
    to.count("x1_class", "X1", "truth in some named class, at most three names", judged.any_class_true, ">= 75 %")
    to.count("x1_wrong", "X1", "some name of tier P or I wrong", judged.wrong_names, "<= 5 %")


def what_is_recovered(to):
    shown = to.at["C1"] + to.at["X1"]
    with_truth = [c for level in WITH_TRUTH for c in to.at[level]]
    to.middle("rho", "C1, C4, X1", "recovered fraction of the held-out error, median", map(judged.recovered, with_truth), ">= 0.85")
    to.middle("rho_C1", "C1", "recovered fraction, median", map(judged.recovered, to.at["C1"]), "")
    to.middle("rho_X1", "X1", "recovered fraction, median", map(judged.recovered, to.at["X1"]), "")
    for metric, text in (("charge_current_error_a", "charge current error"), ("crank_mae_v", "cranks' minima"), ("rmse_v", "RMSE")):
        to.middle(metric, "C1, X1", f"held-out {text}, extended / base, median", [judged.left_of(c, metric) for c in shown],
                  "" if metric == "rmse_v" else "<= 0.3")
    found = [one for one in map(judged.strength_found, to.at["C1"] + to.at["C2"]) if one]
    to.middle("strength_error", "C1, C2", "relative error of the strength, median", [error for error, _ in found], "<= 10 %")
    weak = [right for case in to.cases for right in judged.weak_names(case)]
    to.out.append(Figure("weak_names", "all", "names of tier P or I with evidence below 20 that are right", sum(weak), len(weak), None, ""))
    to.out.append(Figure("coverage", "C1, C2", "95 % interval holds the true strength", sum(inside for _, inside in found), len(found), None,
                         "90 to 98 %"))


def written(figure):
    if figure.k is not None:
        return rate(figure.k, figure.n)
    return "no case" if figure.value is None else f"{figure.value:.3g} (n = {figure.n})"


def before_after(cases):
    """By level and truth: cases, and medians of the held-out errors of base model, extended model and the model that was reported the truth."""
    groups = collections.defaultdict(list)
    for case in cases:
        if case.whole["holdout"] and case.level in WITH_TRUTH:
            groups[case.level, case.label["id"]].append(case)
    return {key: dict({"cases": len(mine)}, **{f"{side}_{metric}": middle_of(mine, side, metric) for metric in SHOWN_ERRORS for side in SIDES})
            for key, mine in groups.items()}


def middle_of(cases, side, metric):
    """Median over the cases that have it; None without one."""
    from_told = [case.told["holdout"]["extended"].get(metric) for case in cases if case.told and case.told.get("holdout")]
    values = from_told if side == "told" else [case.whole["holdout"][side].get(metric) for case in cases]
    values = [abs(value) for value in values if value is not None]
    return statistics.median(values) if values else None


def confusion(cases):
    """Counts by (row, column): the truth's level and id against the first name, or the verdict in brackets where nothing is named."""
    counts = collections.Counter()
    for case in cases:
        row = case.label["id"] if case.label["id"] != "-" else case.label["family"]
        heard = judged.first_class(case.whole)
        said = case.whole["verdict"]
        counts[f"{case.level} {row}", "(unknown)" if said == "unknown" else heard[0] if heard else f"({said})"] += 1
    return counts


def went_wrong(case):
    """What is wrong with the answers to a case; empty when nothing is."""
    wrong = {"N1": lambda: case.whole["verdict"] != "no_mismatch", "N2": lambda: judged.wrong_names(case),
             "C3": lambda: not judged.class_true(case) or judged.wrong_names(case, case.short),
             "C5": lambda: not judged.class_true(case) or not judged.warned(case) or judged.wrong_names(case, case.short),
             "D1": lambda: judged.wrong_names(case, tiers="P") or not judged.fault_found(case),
             "U1": lambda: case.whole["verdict"] != "unknown",
             "X1": lambda: not judged.any_class_true(case) or judged.wrong_names(case)}
    return bool(wrong.get(case.level, lambda: not judged.class_true(case) or judged.wrong_names(case))())


def told_of(case):
    """A failure in one line: case, truth, how hard it was, what was said."""
    label = case.label
    hard = ", ".join(f"{key} {label[key]:g}" for key in ("z", "z_whole", "z_short", "ratio") if label.get(key) is not None)
    text = f"{label['name']} {case.level} {label['family']} {label['id']} scale {'x'.join(f'{s:g}' for s in label['scale'])}"
    for name, answer in case.answers.items():
        names = ", ".join(f"{'|'.join(judged.class_of(e))} {e['evidence'] or 0:.0f}" for e in answer["effects"])
        near = ", ".join(f"{c['id']} {c['evidence'] or 0:.0f}" for c in answer["candidates"][:2] if c["rejected_because"])
        text += f" | {name}: {answer['verdict']}" + (f" [{names}]" if names else "") + (f" (rejected: {near})" if near else "")
    return text + (f" | {hard}" if hard else "")


def score(sealed, results, catalogue):
    """Everything that is reported."""
    said, cases, failed = cases_of(sealed, results, catalogue)
    return {"seal": said, "cases": cases, "failed": failed, "figures": figures(cases), "confusion": confusion(cases),
            "before_after": before_after(cases), "families": by_mechanism.scored(cases),
            "wrong": [told_of(case) for case in sorted(cases, key=lambda c: (c.level, c.label["id"])) if went_wrong(case)]}


def as_json(report):
    """The figures for programs."""
    def entry(figure):
        low, high = interval(figure.k, figure.n) if figure.k is not None and figure.n else (None, None)
        return {"level": figure.level, "what": figure.text, "k": figure.k, "n": figure.n, "value": figure.value, "lower": low, "upper": high}
    return json.dumps({"seal": report["seal"], "figures": {one.key: entry(one) for one in report["figures"]},
                       "families": by_mechanism.entries(report["families"])}, indent=2)

"""Counts what was named of what was put in, beside what was named of the recording as it is."""

import collections

from .. import mechanisms
from ..rates import geometric_mean, rate, wilson
from ..tables import table
from .plan import ZERO

WORSE = 1.02  # extended over base, that counts as worse


class Case:
    """A row and the answer to the recording without anything in it."""

    def __init__(self, row, unchanged):
        self.row, self.answer, self.before = row, row["answer"], unchanged
        self.truth = None if row["kind"] == ZERO else row["kind"]

    @property
    def new(self):
        """Mechanisms named with it and not without it."""
        return set(self.answer["mechanisms"]) - set(self.before["mechanisms"])

    @property
    def judged(self):
        """Whether the mechanism can be newly named: it was not before."""
        return self.truth is not None and self.truth not in self.before["mechanisms"]

    @property
    def outcome(self):
        """right, beside, wrong, none or missed, of what is newly named; missed: the answer is the same as without."""
        if self.truth in self.new:
            return "beside" if self.new - {self.truth} else "right"
        return "wrong" if self.new else "missed"

    @property
    def part(self):
        """Named, or accepted as a part of what is unknown."""
        return self.truth in self.new or self.truth in set(self.answer["parts"]) - set(self.before["parts"])

    def over_base(self, side):
        held = self.answer["holdout_v"]
        return held[side] / held["base"] if held["base"] and held[side] is not None else None


def cases_of(rows, unchanged):
    """Cases, what could not be drawn, and what failed."""
    cases = [Case(row, unchanged[row["recording"]]) for row in rows if "answer" in row]
    return cases, [row for row in rows if "not_drawn" in row], [row for row in rows if "failed" in row]


def counted(right, some):
    return rate(sum(bool(right(one)) for one in some), len(some), wilson)


def figures(cases):
    """(what, figure, aim)"""
    zero, put_in = [one for one in cases if one.truth is None], [one for one in cases if one.truth]
    judged = [one for one in put_in if one.judged]
    ratios = [one.over_base("extended") for one in cases if one.over_base("extended") is not None]
    beside = [one for one in cases if one.over_base("ridge") is not None and one.over_base("extended") is not None]
    return [
        ("zero: nothing new named", counted(lambda one: not one.new, zero), ">= 95 %"),
        ("zero: the verdict is as without", counted(lambda one: one.answer["verdict"] == one.before["verdict"], zero), ""),
        ("put in: its mechanism newly named", counted(lambda one: one.truth in one.new, judged), ">= 90 %"),
        ("of these with another beside it", counted(lambda one: one.outcome == "beside", judged), ""),
        ("put in: only another mechanism newly named", counted(lambda one: one.outcome == "wrong", judged), ""),
        ("put in: nothing new named", counted(lambda one: one.outcome == "missed", judged), ""),
        ("put in: its mechanism newly named or a new part of what is unknown", counted(lambda one: one.part, judged), ""),
        ("not judged, its mechanism is named without it too", f"{len(put_in) - len(judged)} of {len(put_in)}", ""),
        ("of these still named", counted(lambda one: one.truth in one.answer["mechanisms"], [one for one in put_in if not one.judged]), ""),
        ("hold-out error, extended over base, geometric mean", mean_of(ratios), ""),
        ("hold-out error, ridge regression over base, geometric mean", mean_of([one.over_base("ridge") for one in beside]), ""),
        ("extended ahead of the ridge regression", counted(lambda one: one.over_base("extended") < one.over_base("ridge"), beside), ""),
        ("extended worse than base by over 2 %", rate(sum(one > WORSE for one in ratios), len(ratios), wilson), "")]


def mean_of(ratios):
    return f"{geometric_mean(ratios):.2f} (n = {len(ratios)})" if ratios else "no case"


def by_group(cases, key, title):
    """One row a group: of what is judged, what was named; what of nothing was named new."""
    groups = collections.defaultdict(list)
    for one in cases:
        groups[key(one)].append(one)
    rows = []
    for name, some in sorted(groups.items()):
        judged, zero = [one for one in some if one.judged], [one for one in some if one.truth is None]
        counts = collections.Counter(one.outcome for one in judged)
        heard = collections.Counter(mechanism for one in judged if one.outcome == "wrong" for mechanism in one.new)
        rows.append([name, len(judged), counts["right"], counts["beside"], counts["wrong"], counts["missed"],
                     sum(one.truth is not None for one in some) - len(judged),
                     f"{sum(bool(one.new) for one in zero)} of {len(zero)}" if zero else "",
                     ", ".join(f"{mechanism} {k}" for mechanism, k in heard.most_common())])
    return table([title, "judged", "right", "beside", "wrong", "missed", "named before", "zero: something new", "taken for"], rows)


def as_markdown(rows, unchanged):
    cases, not_drawn, failed = cases_of(rows, unchanged)
    drawn = [one.row["drawn"] for one in cases if one.truth]
    lines = [f"{len(cases)} cases: {len(drawn)} with a law in them, {len(cases) - len(drawn)} at zero; {len(not_drawn)} could not be drawn, {len(failed)} failed.", ""]
    lines += table(["figure", "measured (95 %, Wilson)", "aim"], figures(cases)) + [""]
    lines += by_group([one for one in cases if one.truth], lambda one: one.truth, "mechanism put in") + [""]
    lines += by_group(cases, lambda one: one.row["recording"], "recording") + [""]
    claimed = [claim for one in cases if one.truth for claim in
               mechanisms.claims({mechanism: p for mechanism, p in one.answer["mechanisms"].items() if mechanism in one.new}, {one.truth})]
    lines += table(["stated probability of a newly named mechanism", "share that is what was put in"],
                   [(name, rate(k, n, wilson)) for name, k, n in mechanisms.reliability(claimed)]) + [""]
    lines += table(["recording as it is", "verdict", "mechanisms", "too small to tell, below [mV]"],
                   [(name, answer["verdict"], ", ".join(answer["mechanisms"]), f"{1e3 * answer['limit_v']:.1f}")
                    for name, answer in sorted(unchanged.items()) if "failed" not in answer])
    missing = collections.Counter((row["recording"], row["kind"]) for row in not_drawn)
    if missing:
        lines += ["", "Could not be drawn: " + ", ".join(f"{kind} in {name} {k}" for (name, kind), k in sorted(missing.items())) + "."]
    return "\n".join(lines + [f"Failed: {row['name']}: {row['failed']}" for row in failed]) + "\n"

"""Counts of cases of any benchmark, and the rows they are printed in."""

import collections
import statistics

from ..rates import interval, rate, spread
from .answers import BINS, SHORT, counted

HALF, WORSE = 0.5, 1.02  # held-out error over the base's, that counts as half and as worse
# A rate of k in n, or a value over n cases; level: of which cases.
Figure = collections.namedtuple("Figure", "key level text k n value target")


def written(figure):
    if figure.k is not None:
        return rate(figure.k, figure.n)
    return "no case" if figure.value is None else f"{figure.value:.3g} (n = {figure.n})"


def entry(k, n):
    """A rate for programs."""
    low, high = interval(k, n) if k is not None and n else (None, None)
    return {"k": k, "n": n, "lower": low, "upper": high}


def share(right, cases, of=interval):
    """Rate of the cases for which right(case) is true. of: which interval."""
    cases = list(cases)
    return rate(sum(bool(right(one)) for one in cases), len(cases), of)


def over_base(cases, side="extended"):
    return [one.over_base(side) for one in cases if one.over_base(side) is not None]


def worse(cases):
    return "extended worse than base by over 2 %", share(lambda one: one > WORSE, over_base(cases))


def error_rows(cases):
    """Held-out errors of extended model, base model and ridge regression."""
    beside = [one for one in cases if one.over_base() is not None and one.over_base("ridge") is not None]
    return [("hold-out error, extended over base", spread(over_base(cases))),
            ("at most half the base's", share(lambda one: one <= HALF, over_base(cases))),
            worse(cases),
            ("extended model withheld", share(lambda one: one.withheld, cases)),
            ("hold-out error, ridge over base", spread(over_base(beside, "ridge"))),
            ("extended better than ridge", share(lambda one: one.held("extended") < one.held("ridge"), beside))]


def control_rows(cases):
    """Of recordings that lack nothing: whatever is said is false."""
    judged = [one for one in cases if one.verdict != SHORT]
    return [("alarms", share(lambda one: one.alarmed, judged)),
            ("insufficient data", share(lambda one: one.verdict == SHORT, cases)),
            ("a mechanism named", share(lambda one: one.said, judged)),
            worse(cases)]


def outcome_rows(cases):
    """What was named of what is there."""
    counts = counted(cases)
    judged = len(cases) - counts["short"]
    return [("mechanism right", rate(counts["right"] + counts["beside"], judged)),
            *((text, rate(counts[one], judged)) for one, text in (
                ("beside", "right, another mechanism beside it"), ("wrong", "wrong mechanism"),
                ("none", "alarm without a mechanism"), ("missed", "missed"))),
            ("insufficient data", rate(counts["short"], len(cases)))]


def set_rows(cases):
    """Of the likely mechanisms, whose probabilities add up to 0.9, where there are any."""
    sets = [(one.answer.get("mechanisms"), one.label["mechanism"]) for one in cases]
    sets = [(mechanisms, mechanism) for mechanisms, mechanism in sets if mechanisms]
    size = statistics.mean(len(mechanisms) for mechanisms, _ in sets) if sets else None
    return [("likely mechanisms have the right one", share(lambda one: one[1] in one[0], sets)),
            ("how many they are", "no case" if size is None else f"{size:.2f}")]


def reliability(cases):
    """(bin, claims that are right, claims) by stated probability; a mechanism that is named of a null is wrong."""
    claims, rows = [claim for one in cases for claim in one.claims], []
    for low, high in BINS:
        inside = [true for _, p, true in claims if low <= p < high or p == high == 1.0]
        rows.append((f"{low:g} to {high:g}", sum(inside), len(inside)))
    return rows


def reliability_rows(cases):
    return [(name, rate(k, n)) for name, k, n in reliability(cases)]

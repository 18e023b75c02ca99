"""The same cases counted by families of physics: a right family with a wrong name in it is half of an answer."""

from .. import mechanisms
from ..rates import interval, rate
from ..tables import table
from . import judged

LEVELS = ("N2", "C1", "C2", "C3", "C4", "C5", "D1", "X1")  # of which the catalogue has what is true
SENSOR_FAULT = "sensor_fault"
# What is counted of a level, in its order, and the count of names it stands beside.
COUNTS = (("right", "right family"), ("beside", "of these another family beside it"), ("wrong", "only wrong families"),
          ("none", "an alarm without a family"), ("missed", "missed"))
BY_NAME = {"N2": ("no wrong name of tier P or I", lambda case: not judged.wrong_names(case)),
           "D1": ("fault found", judged.fault_found), "X1": ("in some class of at most three", judged.any_class_true)}
CLASS = ("in the first class, at most three", judged.class_true)


def said(case, answer=None):
    """{family: probability} of an answer; a sensor fault says instruments."""
    answer = answer or case.whole
    named = mechanisms.mechanisms_of(answer, case.catalogue)
    if answer["verdict"] == SENSOR_FAULT:
        named.setdefault(case.catalogue.sensors, None)
    return named


def outcome(case):
    """One of families.OUTCOMES: right is a family of what was added, beside is none that is true."""
    named = said(case)
    true, added = case.mechanisms_of(case.truths), case.mechanisms_of(case.added)
    only = mechanisms.outcome(case.whole["verdict"], named, true)
    if only in ("right", "beside") and not set(named) & added:  # the structure's own family is true, but not what was asked for
        return "missed" if only == "right" else "wrong"
    return only


def counts(cases):
    """{level: {count: k, "n": cases, "by_name": (text, k)}} of the levels that have cases."""
    table_of = {}
    for level in LEVELS:
        mine = [case for case in cases if case.level == level]
        if not mine:
            continue
        found = mechanisms.counted(map(outcome, mine))
        text, right = BY_NAME.get(level, CLASS)
        table_of[level] = {"n": len(mine), "by_name": (text, sum(bool(right(case)) for case in mine)), "right": found["right"] + found["beside"],
                           "beside": found["beside"], "wrong": found["wrong"], "none": found["none"], "missed": found["missed"] + found["short"]}
    return table_of


def alarms(cases):
    """{level: (families named, cases)} where none of the catalogue's is true."""
    return {level: (sum(bool(said(case)) for case in mine), len(mine)) for level in ("N1", "U1")
            for mine in [[case for case in cases if case.level == level]] if mine}


def reliability(cases):
    """(bin, right, claims) over every level; a family named where none of the catalogue's is true is wrong."""
    return mechanisms.reliability([claim for case in cases for claim in mechanisms.claims(said(case), case.mechanisms_of(case.truths))])


def scored(cases):
    return {"levels": counts(cases), "alarms": alarms(cases), "reliability": reliability(cases)}


def lines(of):
    """Markdown of scored()."""
    rows = [[level, one["by_name"][0], rate(one["by_name"][1], one["n"])] + [rate(one[key], one["n"]) for key, _ in COUNTS]
            for level, one in of["levels"].items()]
    text = ["### By families", ""] + table(["level", "of names", "right by name"] + [title for _, title in COUNTS], rows)
    if of["alarms"]:
        text += ["", "A family named where none is true: " + "; ".join(f"{level} {rate(k, n)}" for level, (k, n) in of["alarms"].items()) + "."]
    return text + [""] + table(["stated probability of a family", "right"], [(name, rate(k, n)) for name, k, n in of["reliability"]])


def entries(of):
    """scored() for programs."""
    def entry(k, n):
        low, high = interval(k, n) if n else (None, None)
        return {"k": k, "n": n, "lower": low, "upper": high}
    return {"levels": {level: dict({key: entry(one[key], one["n"]) for key, _ in COUNTS},
                                   by_name=dict(entry(one["by_name"][1], one["n"]), what=one["by_name"][0]))
                       for level, one in of["levels"].items()},
            "alarms": {level: entry(k, n) for level, (k, n) in of["alarms"].items()},
            "reliability": [dict(entry(k, n), probability=name) for name, k, n in of["reliability"]]}

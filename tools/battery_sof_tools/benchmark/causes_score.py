"""What came out of causes that were put into measured recordings (causes.py): names that are new, and errors on the last quarter beside baselines."""

import collections
import math
import statistics

from ..rates import wilson, rate
from ..tables import table
from . import answers

BANDS = ((2.0, 4.0), (4.0, 8.0), (8.0, 16.0), (16.0, 32.0))  # of z; what is reached beyond them counts in the nearest
SINGLE, SHAM, PAIR = "single", "sham", "pair"
ALWAYS = "acceptance"
AIM_FALSE, AIM_GAIN = 0.05, 0.5
HELD = ("rmse_v", "share_percent", "equations_share_percent")
REGRESSION, SAME, WRONG, ORACLE, DIAGNOSIS = "circuit + regression", "+ what was named before", "+ a wrong effect", "+ the true effect (oracle)", "diagnosis"
MODELS = ("mean", "line", "ridge", "circuit", REGRESSION, SAME, WRONG, ORACLE, DIAGNOSIS)


def essentials(diagnosis):
    """What is kept of an answer: as every benchmark does, and errors on the last quarter by model."""
    fit = diagnosis.get("fit") or {}
    shown = {"base": (fit.get("base") or {}).get("holdout"), "extended": ((fit.get("extended") or fit.get("base")) or {}).get("holdout"),
             "line": diagnosis.get("baseline_line"), "ridge": diagnosis.get("baseline")}
    return dict(answers.essentials(diagnosis), errors={side: {key: one.get(key) for key in HELD} if one else None for side, one in shown.items()})


class Case:
    """A row with its label, beside the answer to the stretch without anything in it."""

    def __init__(self, row, label, before):
        self.row, self.label, self.kind = row, label, label["kind"]
        self.truths = set(label["mechanisms"])
        self.before = set(answers.mechanisms_of(before, None))
        self.new = set(answers.mechanisms_of(row["answer"], None)) - self.before
        self.right, self.wrong = self.new & self.truths, self.new - self.truths

    @property
    def judged(self):
        """Whether a truth can be newly named: one was not before."""
        return bool(self.truths - self.before)

    @property
    def band(self):
        """Of the smallest z of its causes."""
        z = min(one["z"] for one in self.label["causes"])
        return next((one for one in BANDS if z < one[1]), BANDS[-1])

    def always(self):
        """(right, wrong, false) of a rule that names ALWAYS whatever it is shown."""
        new = {ALWAYS} - self.before
        return len(new & self.truths), len(new - self.truths)

    def shown(self):
        """{model: its metrics on the last quarter, or None}."""
        of = self.row["answer"]["errors"]
        return {"line": of["line"], "ridge": of["ridge"], REGRESSION: of["base"], DIAGNOSIS: of["extended"],
                **{model: self.row.get(key, {}).get("errors") for model, key in ((SAME, "same"), (WRONG, "wrong"), (ORACLE, "oracle"))}}

    def volts(self):
        """{model: RMS error of the voltage [V]} on the last quarter; None where there is none."""
        return dict({name: one and one["rmse_v"] for name, one in self.shown().items()}, mean=self.row["mean_v"], circuit=None)

    def errors(self):
        """The same, and of current and voltage what is not explained [%] where a charger regulates the voltage."""
        shown = self.shown()
        if not shown[REGRESSION] or shown[REGRESSION]["share_percent"] is None:
            return self.volts()
        found = {name: 100.0 - one["share_percent"] if one and one["share_percent"] is not None else None for name, one in shown.items()}
        return dict(found, mean=100.0, circuit=100.0 - shown[REGRESSION]["equations_share_percent"])


def cases_of(rows, labels, unchanged):
    """Cases, and what failed: (name, kind or None, why)."""
    judged = [Case(row, labels[row["name"]], unchanged[row["stretch"]]) for row in rows if "answer" in row]
    return judged, [(row["name"], labels.get(row["name"], {}).get("kind"), row["failed"]) for row in rows if "failed" in row]


def ratio(cases, errors, model, beside=REGRESSION):
    """(geometric mean of a model's error over another's, cases that have both)."""
    found = [one for one in map(errors, cases) if one[model] and one[beside]]
    return (math.exp(statistics.mean(math.log(one[model] / one[beside]) for one in found)) if found else None), len(found)


def gain_share(cases, beside=REGRESSION):
    """The diagnosis' mean gain over another model as a share of the oracle's, both mean logarithms; None where the oracle gains nothing."""
    found = [one.errors() for one in cases if one.kind == SINGLE]
    found = [one for one in found if all(one[name] for name in (beside, DIAGNOSIS, ORACLE))]
    def gain(name):
        return statistics.mean(math.log(one[beside] / one[name]) for one in found)
    return gain(DIAGNOSIS) / gain(ORACLE) if found and gain(ORACLE) > 0.0 else None


def names_of(cases):
    """Counts of newly named mechanisms."""
    return {"cases": len(cases), "judged": sum(one.judged for one in cases), "right": sum(len(one.right) for one in cases), "wrong": sum(len(one.wrong) for one in cases),
            "nothing": sum(not one.new for one in cases), "always_right": sum(one.always()[0] for one in cases), "always_wrong": sum(one.always()[1] for one in cases)}


def figures(cases, failed):
    of = {kind: [one for one in cases if one.kind == kind] for kind in (SINGLE, SHAM, PAIR)}
    both = of[SINGLE] + of[PAIR]
    shams = names_of(of[SHAM])
    return {"single": names_of(of[SINGLE]), "pairs": names_of(of[PAIR]), "shams": len(of[SHAM]), "false": len(of[SHAM]) - shams["nothing"], "always_false": shams["always_wrong"],
            "right_minus_wrong": sum(len(one.right) - len(one.wrong) for one in both), "gain_share": gain_share(cases), "gain_share_over_named": gain_share(cases, SAME), "failed": len(failed),
            "over_regression": {name: ratio(of[SINGLE], Case.errors, name) for name in MODELS}, "volts_over_regression": {name: ratio(of[SINGLE], Case.volts, name) for name in MODELS}}


def names_row(title, cases):
    found = names_of(cases)
    return (title, found["cases"], found["judged"], found["right"], found["wrong"], found["nothing"], f"{found['always_right']}, {found['always_wrong']}")


def written(found):
    value, count = found
    return "-" if value is None else f"{value:.2f} ({count})"


def as_markdown(cases, failed):
    found = figures(cases, failed)
    single, pairs, shams = ([one for one in cases if one.kind == kind] for kind in (SINGLE, PAIR, SHAM))
    def in_band(some, band):
        return [one for one in some if one.band == band]
    head = ("", "cases", "truth not named before", "right new names", "wrong new names", "nothing new", f"always {ALWAYS}: right, wrong")
    rows = [names_row(f"z {low:g} to {high:g}", in_band(single, (low, high))) for low, high in BANDS]
    rows += [names_row("all single", single), names_row("pairs", pairs), names_row("shams", shams)]
    lines = [f"{len(single)} single causes, {len(shams)} shams, {len(pairs)} pairs; {len(failed)} not drawn or not answered.", ""] + table(head, rows)
    mechanisms = collections.defaultdict(list)
    for one in single:
        mechanisms[one.label["causes"][0]["mechanism"]].append(one)
    lines += [""] + table(head, [names_row(name, some) for name, some in sorted(mechanisms.items())])
    errors = [(name, written(found["over_regression"][name]), written(found["volts_over_regression"][name])) for name in MODELS]
    lines += [""] + table(("single causes, last quarter: over circuit + regression (cases)", "unexplained, or RMS", "RMS of the voltage"), errors)
    gained, further = ("the oracle gains nothing" if found[key] is None else f"{100 * found[key]:.0f} %" for key in ("gain_share", "gain_share_over_named"))
    lines += [""] + table(("figure", "measured", "aim"), [
        ("shams: something new named", rate(found["false"], found["shams"], wilson), f"at most {100 * AIM_FALSE:g} %"),
        ("right minus wrong new names", str(found["right_minus_wrong"]), "above 0"),
        ("gain over circuit + regression, of the oracle's", gained, f"{100 * AIM_GAIN:g} %"),
        ("the same over what was named before", further, "")])
    return "\n".join(lines + [""] + [f"Failed: {name}: {why}" for name, _, why in failed]) + "\n"

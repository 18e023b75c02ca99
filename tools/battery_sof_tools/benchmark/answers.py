"""What is kept of an answer of `sof diagnose`, and a case of any benchmark: its label, the answer, and what follows from the two."""

import collections

from ..sof import diagnose

QUIET, SHORT = "no_mismatch", "insufficient_data"
SAYS_NOTHING = (QUIET, SHORT)
BINS = ((0.0, 0.5), (0.5, 0.7), (0.7, 0.9), (0.9, 1.0))  # of a stated probability
# Of what has a mechanism: right; right and another beside it; only others; an alarm without a mechanism; silence; too little data.
OUTCOMES = ("right", "beside", "wrong", "none", "missed", "short")
METRICS = ("rmse_v", "q_dyn_percent", "crank_mae_v", "charge_bias_v", "charge_current_error_a", "max_abs_v")
OF_EFFECT = ("id", "mechanism", "probability", "confidence", "evidence")
OF_PARAMETER = ("name", "value", "lower", "upper", "at_bound")
OF_CANDIDATE = ("id", "evidence", "mechanism", "holdout_gain_percent", "rejected_because")
# Classes that no recording distinguishes (docs/physics.md#effects-that-cannot-be-distinguished): naming one names the other.
ALIKE = [{"current_offset", "parasitic_load"}, {"fast_arc", "sensor_lag"}, {"inductance", "time_skew"}]
LARGEST_CLASS = 3


def essentials(diagnosis):
    """What is scored of an answer."""
    def several(key):
        return diagnosis.get(key) or []
    fit = diagnosis.get("fit") or {}
    held = {side: (fit.get(side) or {}).get("holdout") or {} for side in ("base", "extended")}
    return {
        "verdict": diagnosis["verdict"],
        "effects": [dict({key: one.get(key) for key in OF_EFFECT}, indistinguishable_from=one.get("indistinguishable_from", []),
                         parameters=[{key: p.get(key) for key in OF_PARAMETER} for p in one.get("parameters", ())]) for one in several("effects")],
        "candidates": [{key: one.get(key) for key in OF_CANDIDATE} for one in several("candidates")],
        "holdout": {side: {metric: held[side].get(metric) for metric in METRICS} for side in held} if fit else None,
        "withheld_v": diagnosis.get("withheld_rmse_v"),
        "hidden": [one["id"] for one in several("detection_limits") if not one["visible"]],
        "instrument": diagnosis.get("instrument"), "next_experiment": diagnosis.get("next_experiment"),
        "mechanism": diagnosis.get("mechanism"), "probability": diagnosis.get("probability"),
        "mechanisms": [one["id"] for one in several("mechanisms")]}


def asked(sof, recording, *options, patience_s=None):
    return essentials(diagnose(sof, recording, *options, patience_s=patience_s))


def with_alike(names):
    """The names and all that count as one of them."""
    return set(names).union(*(group for group in ALIKE if group & set(names)))


def holds(names, truths):
    """Whether one of the names is, or counts as, one of the truths."""
    return not with_alike(truths).isdisjoint(names)


def class_of(effect):
    """Names that an effect is tied with, itself the first."""
    return [effect["id"], *effect["indistinguishable_from"]]


def first_class(answer):
    """The strongest finding and what it is tied with."""
    return class_of(answer["effects"][0]) if answer["effects"] else []


def mechanisms_of(answer, catalogue):
    """{mechanism: probability or None} of the answer's own mechanism and those of its effects; the
    first that is said of a mechanism counts.

    catalogue: gives the mechanism of an effect whose answer has none; may be None.
    """
    said = {answer["mechanism"]: answer.get("probability")} if answer.get("mechanism") else {}
    for effect in answer.get("effects") or []:
        mechanism = effect.get("mechanism") or (catalogue and catalogue.mechanism(effect.get("id")))
        if mechanism and said.get(mechanism) is None:
            said[mechanism] = effect.get("probability")
    return said


def outcome(verdict, said, truths):
    """One of OUTCOMES.  said: mechanisms named.  truths: mechanisms that are there, at least one."""
    if verdict in SAYS_NOTHING:
        return "missed" if verdict == QUIET else "short"
    if set(said) & set(truths):
        return "beside" if set(said) - set(truths) else "right"
    return "wrong" if said else "none"


class Case:
    """A label, the answer to it (see essentials), the catalogue of effects (None: mechanisms as the answer has them), seconds, and the
    hold-out RMSE of a ridge regression [V]. Benchmarks say what is true, and of what is said what counts, in classes of their own."""

    def __init__(self, label, answer, catalogue=None, seconds=None, ridge_v=None):
        self.label, self.answer, self.catalogue, self.seconds, self.ridge_v = label, answer, catalogue, seconds, ridge_v

    @property
    def verdict(self):
        return self.answer["verdict"]

    @property
    def alarmed(self):
        return self.verdict not in SAYS_NOTHING

    @property
    def truths(self):
        """Mechanisms that are there."""
        return {self.label["mechanism"]}

    @property
    def said(self):
        """{mechanism: probability} that count as named."""
        return mechanisms_of(self.answer, self.catalogue)

    @property
    def outcome(self):
        return outcome(self.verdict, self.said, self.truths)

    @property
    def withheld(self):
        """Whether the extended model was no improvement on the hold-out, so that the base model was handed on (its own error counts all the same); None where
        the answer was kept without it."""
        return self.answer["withheld_v"] is not None if "withheld_v" in self.answer else None

    @property
    def claims(self):
        """(mechanism, probability, whether it is there) of every mechanism that is named with a probability; each mechanism once."""
        return [(mechanism, p, mechanism in self.truths) for mechanism, p in self.said.items() if p is not None]

    def held(self, side, metric="rmse_v"):
        """Held-out error of "base", "extended" or "ridge"; None where there is none."""
        return self.ridge_v if side == "ridge" else ((self.answer["holdout"] or {}).get(side) or {}).get(metric)

    def over_base(self, side="extended", metric="rmse_v"):
        """Size of a held-out error over that of the base model; None where either is missing."""
        base, other = self.held("base", metric), self.held(side, metric)
        return abs(other) / abs(base) if base and other is not None else None


def counted(cases):
    """Counts of all OUTCOMES."""
    counts = collections.Counter(one.outcome for one in cases)
    return {one: counts[one] for one in OUTCOMES}

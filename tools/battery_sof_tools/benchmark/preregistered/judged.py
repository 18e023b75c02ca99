"""One preregistered case judged: what was said against what is true."""

from .. import answers
from ..answers import LARGEST_CLASS, SAYS_NOTHING, class_of, first_class, holds, with_alike

SENSOR_FAULT = "sensor_fault"
# Strength in the label -> parameter of the product, and how one follows from the other.
STRENGTHS = {
    "cpe2": ("dispersion", lambda s: 1.0 - s["cpe2_exponent"]),
    "current_dependent_resistance": ("low_current_resistance", lambda s: s["r_x_ohm"]),
    "second_electrode": ("b3", lambda s: 1.0 / s["electrode3_beta_per_v"]),
    "gassing": ("gassing_current", lambda s: s["gas_current_a"]),
    "charge_acceptance": ("inverse_limiting_current", lambda s: 1.0 / s["lead_ion_limit_a"]),
    "sulphate_history": ("inverse_history_charge", lambda s: 1.0 / s["sulphate_ah"]),
    "acid_transport": ("acid_resistance_1", lambda s: s["acid_1_ohm"]),
    "ocv_soc": ("ocv_slope", lambda s: s["u0_slope_v"] / 50.0),  # of 50 Ah, as every battery of the generator
    "ocv_hysteresis": ("hysteresis_voltage", lambda s: s["hysteresis_v"])}


PREREGISTERED_WORDS = {"effect": "named", "mechanism": "unknown", "unexplained": "unknown"}


class Case(answers.Case):
    """A label, the answers to it (of "whole", and of "short" where its beginning was shown first), what the model did that was reported the
    truth (None without), and the catalogue of effects."""

    def __init__(self, label, shown, told, catalogue):
        super().__init__(label, shown["whole"], catalogue)
        self.answers, self.short, self.told = shown, shown.get("short"), told

    @property
    def verdict(self):
        """In the words of the preregistered labels."""
        return PREREGISTERED_WORDS.get(self.answer["verdict"], self.answer["verdict"])

    @property
    def level(self):
        return self.label["level"]

    @property
    def true_names(self):
        """Everything true of the case."""
        return self.label["expected"]["effects"] or [self.label["id"]]

    @property
    def added(self):
        """What was added, with its companion: on another structure, the structure's own members are not it."""
        if self.level != "X1":
            return self.true_names
        of_physics = {"porous_effect": lambda one: one != "ocv_soc" and (one != "acid_transport" or self.label["id"] == one)}
        wanted = of_physics.get(self.label["family"], lambda one: True)
        return [one for one in self.true_names if one in self.catalogue.physics and wanted(one)]

    def mechanisms_of(self, names):
        """Mechanisms of names and of what counts as one of them."""
        return {self.catalogue.mechanism(one) for one in with_alike(names)} - {None}

    @property
    def truths(self):
        return self.mechanisms_of(self.true_names)

    @property
    def said(self):
        """A sensor fault says instruments."""
        named = super().said
        if self.verdict == SENSOR_FAULT:
            named.setdefault(self.catalogue.sensors, None)
        return named

    @property
    def outcome(self):
        """Right is a mechanism of what was added, beside is none that is true."""
        only = super().outcome
        if only in ("right", "beside") and not set(self.said) & self.mechanisms_of(self.added):  # the structure's own mechanism is true, but not what was asked for
            return "missed" if only == "right" else "wrong"
        return only


def is_silent(answer):
    return answer["verdict"] in SAYS_NOTHING


def first_true(case):
    return holds(first_class(case.answer)[:1], case.added)


def class_true(case, answer=None):
    heard = first_class(answer or case.answer)
    return len(heard) <= LARGEST_CLASS and holds(heard, case.added)


def some_class_holds(case, names):
    return any(len(class_of(one)) <= LARGEST_CLASS and holds(class_of(one), names) for one in case.answer["effects"])


def named_itself(case):
    """What was added is in some named class, its companion not counting for it."""
    return some_class_holds(case, [case.label["id"]])


def any_class_true(case):
    return some_class_holds(case, case.added)


def both_named(case):
    return all(any(holds(class_of(one), [name]) for one in case.answer["effects"]) for name in case.label["id"].split("+"))


def wrong_names(case, answer=None, tiers="PI"):
    """Names of these tiers whose class holds nothing that is true."""
    return [one["id"] for one in (answer or case.answer)["effects"]
            if case.catalogue.tier(one["id"]) in tiers and not holds(class_of(one), case.true_names)]


def wrong_physics(case):
    return wrong_names(case, tiers="P")


def wrong_before(case):
    """Names, of the beginning alone, that are wrong."""
    return wrong_names(case, case.short)


def names_without_structure(case):
    """Wrong names whose class offers no piece of structure either."""
    wrong = wrong_names(case)
    return [one["id"] for one in case.answer["effects"] if one["id"] in wrong and not set(class_of(one)) & case.catalogue.structure]


def warned(case):
    """Before its regime came: said to be unseen, or named by the next experiment of a verdict that names nothing."""
    unseen = holds(case.short["hidden"], case.true_names)
    return unseen or (is_silent(case.short) and any(one in case.short["next_experiment"] for one in case.true_names))


def fault_found(case):
    """An instrument fault is in a named class, or the screen of the instruments speaks of one."""
    return any(holds(class_of(one), case.true_names) for one in case.answer["effects"]) or \
        (case.verdict == SENSOR_FAULT and bool(case.answer["instrument"]))


def recovered(case):
    """Share of what knowing the truth gains that the tool gains, on held-out data; None where truth gains under 5 %."""
    if not case.told or not case.told.get("holdout"):
        return None
    base, tool, known = case.held("base"), case.held("extended"), case.told["holdout"]["extended"]["rmse_v"]
    return (base - tool) / (base - known) if base - known > 0.05 * base else None


def strength_found(case):
    """(relative error, whether the 95 % interval holds it) of the added effect's strength; None where not named or not plain."""
    name = case.label["id"]
    named = [one for one in case.answer["effects"] if holds([one["id"]], [name])]
    if name not in STRENGTHS or not named or named[0]["id"] != name:
        return None
    parameter, expected = STRENGTHS[name]
    found = [one for one in named[0]["parameters"] if one["name"] == parameter]
    truth = expected(case.label["strength"]) if found else None
    if not truth:
        return None
    low, high = found[0]["lower"], found[0]["upper"]
    return abs(found[0]["value"] / truth - 1.0), (low is None or low <= truth) and (high is None or truth <= high)

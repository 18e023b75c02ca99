"""One case judged: what was said against what is true."""

import dataclasses

from ..sof import Catalogue
from .names import LARGEST_CLASS, alike, holds, with_alike

SAYS_NOTHING = ("no_mismatch", "insufficient_data")
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


@dataclasses.dataclass
class Case:
    """A label, the answers to it, what the model did that was reported the truth (None without), and the catalogue of effects."""
    label: dict
    answers: dict
    told: dict
    catalogue: Catalogue

    @property
    def level(self):
        return self.label["level"]

    @property
    def truths(self):
        """Everything true of the case."""
        return self.label["expected"]["effects"] or [self.label["id"]]

    @property
    def added(self):
        """What was added, with its companion: on another structure, the structure's own members are not it."""
        if self.level != "X1":
            return self.truths
        of_physics = {"porous_effect": lambda one: one != "ocv_soc" and (one != "acid_transport" or self.label["id"] == one)}
        wanted = of_physics.get(self.label["family"], lambda one: True)
        return [one for one in self.truths if one in self.catalogue.physics and wanted(one)]

    def mechanisms_of(self, names):
        """Families of names and of what counts as one of them."""
        return {self.catalogue.mechanism(one) for one in with_alike(names)} - {None}

    @property
    def whole(self):
        return self.answers["whole"]

    @property
    def short(self):
        return self.answers.get("short")


def first_class(answer):
    """The strongest finding and what it is tied with."""
    return class_of(answer["effects"][0]) if answer["effects"] else []


def class_of(effect):
    return [effect["id"]] + list(effect["indistinguishable_from"])


def first_true(case):
    heard = first_class(case.whole)
    return bool(heard) and holds(heard[:1], case.added)


def class_true(case, answer=None):
    heard = first_class(answer or case.whole)
    return 0 < len(heard) <= LARGEST_CLASS and holds(heard, case.added)


def named_itself(case):
    """What was added is in some named class, its companion not counting for it."""
    return any(len(class_of(e)) <= LARGEST_CLASS and holds(class_of(e), [case.label["id"]]) for e in case.whole["effects"])


def any_class_true(case):
    return any(len(class_of(e)) <= LARGEST_CLASS and holds(class_of(e), case.added) for e in case.whole["effects"])


def wrong_names(case, answer=None, tiers="PI"):
    """Names of these tiers whose class holds nothing that is true."""
    effects = (answer or case.whole)["effects"]
    return [e["id"] for e in effects if case.catalogue.tier(e["id"]) in tiers and not holds(class_of(e), case.truths)]


def weak_names(case, below=20.0):
    """For every class that a name of tier P or I leads with little evidence, in every answer to the case: whether it holds a truth."""
    right = []
    for answer in case.answers.values():
        classes = {frozenset(class_of(e)): e for e in reversed(answer["effects"])}  # its first name represents a class
        right += [holds(class_of(e), case.truths) for e in classes.values()
                  if 0.0 < (e["evidence"] or 0.0) < below and case.catalogue.tier(e["id"]) in "PI"]
    return right


def names_without_structure(case):
    """Wrong names whose class offers no piece of structure either."""
    wrong = wrong_names(case)
    return [e["id"] for e in case.whole["effects"] if e["id"] in wrong and not set(class_of(e)) & case.catalogue.structure]


def warned(case):
    """Before its regime came: said to be unseen, or named by the next experiment of a verdict that names nothing."""
    answer = case.short
    unseen = holds(answer["hidden"], case.truths)
    return unseen or (answer["verdict"] in SAYS_NOTHING and any(one in answer["next_experiment"] for one in case.truths))


def fault_found(case):
    """A decoy's fault is in a named class, or the screen of the instruments speaks of one."""
    return any(holds(class_of(e), case.truths) for e in case.whole["effects"]) or \
        (case.whole["verdict"] == "sensor_fault" and bool(case.whole["instrument"]))


def recovered(case):
    """Share of what knowing the truth gains that the tool gains, on held-out data; None where truth gains under 5 %."""
    if not case.told or not case.told.get("holdout"):
        return None
    base, tool = (case.whole["holdout"][side]["rmse_v"] for side in ("base", "extended"))
    known = case.told["holdout"]["extended"]["rmse_v"]
    return (base - tool) / (base - known) if base - known > 0.05 * base else None


def left_of(case, metric):
    """Size of an error with the extended model over that of the base model; None where either is missing."""
    base, extended = (case.whole["holdout"][side].get(metric) for side in ("base", "extended"))
    return abs(extended) / abs(base) if base and extended is not None else None


def strength_found(case):
    """(relative error, whether the 95 % interval holds it) of the added effect's strength; None where not named or not plain."""
    name = case.label["id"]
    named = [e for e in case.whole["effects"] if alike(e["id"], name)]
    if name not in STRENGTHS or not named or named[0]["id"] != name:
        return None
    parameter, expected = STRENGTHS[name]
    found = [p for p in named[0]["parameters"] if p["name"] == parameter]
    if not found:
        return None
    truth = expected(case.label["strength"])
    if not truth:
        return None
    low, high = found[0]["lower"], found[0]["upper"]
    inside = (low is None or low <= truth) and (high is None or truth <= high)
    return abs(found[0]["value"] / truth - 1.0), inside

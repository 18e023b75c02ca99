"""A fleet of drawn recordings beside what is true of them: alarms, false discoveries and power.

The labels are those that `out_of_model --only-draw` writes: FOLDER/labels/NAME.json of FOLDER/recordings/NAME.csv. A battery whose recordings are all nulls lacks nothing.
"""

import collections
import os
import statistics

from ..rates import rate
from ..benchmark.generator import as_planned
from ..benchmark.out_of_model import LABELS, path
from ..tables import table
from . import database, discoveries, stored

LAW = "other_form"          # the kind of recordings with a law; the others are nulls
SILENT = "no_mismatch"
PLAUSIBLE = 0.01            # [V], kPlausible of the diagnosis
UNJUDGED = "insufficient_data"


def label_of(recording):
    folder, name = os.path.split(recording)
    label = path(os.path.dirname(folder), LABELS, os.path.splitext(name)[0], "json")
    if not os.path.exists(label):
        raise SystemExit(f"{recording}: no label {label}; only recordings of out-of-model cases --only-draw can be judged")
    return as_planned(stored.read(label, stored.LABEL, "out-of-model cases --only-draw writes it"))


def left_on_training(base):
    """RMS that the circuit leaves of the training part [V], by recording."""
    found = {}
    for recording, answer in database.answers(base, "diagnose"):
        rmse = (((answer.get("fit") or {}).get("base") or {}).get("train") or {}).get("rmse_v")
        if rmse is not None:
            found[recording] = rmse
    return found


def judged(base, nulls=None):
    """Lines of two tables. nulls: gains of recordings that lack nothing, or None."""
    kinds, lacking, left = collections.defaultdict(list), set(), collections.defaultdict(list)
    rms = left_on_training(base)
    for row in base.execute("SELECT recording, r.battery, r.path, v.verdict, v.mechanism FROM recording r JOIN verdict v USING (recording) ORDER BY recording"):
        label = label_of(row["path"])
        if row["verdict"] != UNJUDGED:
            kinds[label["kind"]].append((row["verdict"], row["mechanism"], label.get("mechanism")))
            left[label["kind"]] += [rms[row["recording"]]] if row["recording"] in rms else []
        if label["kind"] == LAW:
            lacking.add(row["battery"])
    residuals = {kind: f"{1e3 * statistics.median(some):.1f}; {1e3 * max(some):.1f}; {sum(one > PLAUSIBLE for one in some)}" for kind, some in left.items() if some}
    rows = [(kind, len(those), rate(sum(verdict != SILENT for verdict, _, _ in those), len(those)), rate(sum(mechanism is not None for _, mechanism, _ in those), len(those)),
             rate(sum(mechanism == true for _, mechanism, true in those), len(those)) if kind == LAW else "", residuals.get(kind)) for kind, those in sorted(kinds.items())]
    every = discoveries.batteries(base, nulls)
    found = [one for one in every if one.found]
    false = sum(one.name not in lacking for one in found)
    power = rate(len(found) - false, sum(one.name in lacking for one in every))
    return [*table(("kind", "judged", "a verdict", "a mechanism", "the right mechanism", "the circuit leaves [mV]: median; most; above 10"), rows), "",
            *table(("batteries found", "of these lack nothing", "power"), [(len(found), rate(false, len(found)), power)])]

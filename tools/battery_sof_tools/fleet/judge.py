"""A fleet of drawn recordings beside what is true of them: alarms, false discoveries and power.

The labels are those that `out_of_model --only-draw` writes: FOLDER/labels/NAME.json of FOLDER/recordings/NAME.csv. A battery whose recordings are all nulls lacks nothing.
"""

import collections
import os

from ..rates import rate
from ..benchmark.generator import as_planned
from ..benchmark.out_of_model import LABELS, path
from ..tables import table
from . import database, discoveries, stored

LAW = "other_form"          # the kind of recordings with a law; the others are nulls
SILENT = "no_mismatch"
UNJUDGED = "insufficient_data"


def label_of(recording):
    folder, name = os.path.split(recording)
    label = path(os.path.dirname(folder), LABELS, os.path.splitext(name)[0], "json")
    if not os.path.exists(label):
        raise SystemExit(f"{recording}: no label {label}; only recordings of out-of-model cases --only-draw can be judged")
    return as_planned(stored.read(label, stored.LABEL, "out-of-model cases --only-draw writes it"))


def judged(base, nulls=None):
    """Lines of two tables. nulls: gains of recordings that lack nothing, or None."""
    kinds, lacking = collections.defaultdict(list), set()
    for row in base.execute("SELECT recording, r.battery, r.path, v.verdict, v.mechanism FROM recording r JOIN verdict v USING (recording) ORDER BY recording"):
        label = label_of(row["path"])
        if row["verdict"] != UNJUDGED:
            kinds[label["kind"]].append((row["verdict"], row["mechanism"], label.get("mechanism")))
        if label["kind"] == LAW:
            lacking.add(row["battery"])
    rows = [(kind, len(those), rate(sum(verdict != SILENT for verdict, _, _ in those), len(those)), rate(sum(mechanism is not None for _, mechanism, _ in those), len(those)),
             rate(sum(mechanism == true for _, mechanism, true in those), len(those)) if kind == LAW else "") for kind, those in sorted(kinds.items())]
    every = discoveries.batteries(base, nulls)
    found = [one for one in every if one.found]
    false = sum(one.name not in lacking for one in found)
    power = rate(len(found) - false, sum(one.name in lacking for one in every))
    return [*table(("kind", "judged", "a verdict", "a mechanism", "the right mechanism"), rows), "",
            *table(("batteries found", "of these lack nothing", "power"), [(len(found), rate(false, len(found)), power)])]

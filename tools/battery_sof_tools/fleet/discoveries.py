"""Which batteries of a fleet lack something, with the share of false ones among them held (docs/fleet.md).

A recording's statistic is the ln evidence that its extended model gains over the base circuit, 0 where no mechanism is reported. With nulls, recordings of batteries that lack
nothing, it has a p-value: the share of nulls that gain as much. Without, exp(gain) / TRIED is taken for an e-value, and 1 / e represents p (Wang and Ramdas 2022): that holds the
rate where the evidence is what it says, and it is not in short recordings at 1 Hz (docs/fleet.md has figures).
"""

import collections
import math

import numpy as np
from statsmodels.stats.multitest import multipletests

from ..tables import grouped

RATE = 0.1
TRIED = 50      # things that a diagnosis tries (docs/diagnosis.md): the best of them is taken
MIN_LOG = -700.0  # of a probability, exp() of less is 0

Battery = collections.namedtuple("Battery", "name vehicle_type recordings mechanism probability p found")


def gains(base):
    """(battery, vehicle type, mechanism, probability, gain) of every recording that was judged."""
    rows = base.execute("SELECT r.battery, r.vehicle_type, v.mechanism, v.probability, v.gain, v.verdict FROM recording r JOIN verdict v USING (recording) ORDER BY r.battery, recording")
    return [(row["battery"], row["vehicle_type"] or "", row["mechanism"], row["probability"], max(0.0, row["gain"] or 0.0) if row["mechanism"] else 0.0)
            for row in rows if row["verdict"] != "insufficient_data"]


def p_of_battery(values, nulls):
    """Of one battery's recordings: Bonferroni with nulls, else the mean of e-values."""
    values = np.asarray(values, float)
    if nulls is not None:
        # Of the best one the share of nulls that reach it, the recording itself counted.
        return min(1.0, len(values) * (1.0 + float(np.sum(np.asarray(nulls) >= values.max()))) / (1.0 + len(nulls)))
    log_e = np.logaddexp.reduce(values) - math.log(len(values) * TRIED)
    return math.exp(min(0.0, max(MIN_LOG, -log_e)))


def batteries(base, nulls=None):
    """Every battery with a judged recording, the surest finding first. nulls: gains of recordings that lack nothing."""
    by_name = grouped(gains(base), lambda row: row[0])
    if not by_name:
        return []
    p = [p_of_battery([row[4] for row in rows], nulls) for rows in by_name.values()]
    found = multipletests(p, alpha=RATE, method="fdr_bh")[0]
    made = []
    for (name, rows), value, is_found in zip(by_name.items(), p, found):
        told = max(rows, key=lambda row: (row[4], row[3] or 0.0))
        made.append(Battery(name, told[1], len(rows), told[2], told[3], value, bool(is_found and told[2])))
    return sorted(made, key=lambda one: (not one.found, one.p, one.name))


def mechanisms(found):
    """By mechanism: batteries reported, those that stand in the fleet, how many of them are expected to be of that mechanism, and the median probability."""
    counted = []
    for name, told in grouped([one for one in found if one.mechanism], lambda one: one.mechanism).items():
        standing = [one for one in told if one.found]
        sure = [one.probability or 0.0 for one in standing]
        counted.append((name, len(told), standing, sum(sure), float(np.median(sure)) if sure else None))
    return sorted(counted, key=lambda row: (-len(row[2]), row[0]))

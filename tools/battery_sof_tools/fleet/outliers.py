"""Which batteries deviate from the others of their type: parameters beside the median of those of the same type that were fitted with the same effects.

    z = (x - median) / sqrt(s^2 + std^2 + f^2),     s = 1.4826 median |x - median|,   f = 5 %, or 50 mV

in logarithms where a parameter is positive by nature. f: no fleet knows a battery better, also where most fits stand at the same prior. A battery has the median of its recordings. Two-sided p of a normal distribution, Benjamini-Hochberg over all.
"""

import collections
import math

import numpy as np
from scipy.stats import norm
from statsmodels.stats.multitest import multipletests

from .discoveries import RATE

LEVELS = ("u_dc",)  # voltages: differences count, not ratios
DETERMINED = "abs(p.value) < 1e30 AND p.std > 0 AND p.std < 1e30 AND p.determined = 1 AND p.at_bound = 0"  # and not held
OF_RECORDING = "p.source = 'identify' AND " + DETERMINED
LEAST = 8           # batteries of a type, for a median and a spread
MIN_STD = 0.05    # of a logarithm, or of volts: no fleet knows a battery better than this

Outlier = collections.namedtuple("Outlier", "battery vehicle_type name value unit median z found")


def values(base):
    """(vehicle type, effects, name) -> {battery: [(value, std)]}, unit by name; parameters that a fit determined inside their bounds."""
    rows = base.execute(f"SELECT r.battery, r.vehicle_type, p.* FROM parameter p JOIN recording r USING (recording) "
                        f"WHERE {OF_RECORDING} ORDER BY recording")
    found, units = collections.defaultdict(lambda: collections.defaultdict(list)), {}
    for row in rows:
        found[row["vehicle_type"] or "", row["effects"], row["name"]][row["battery"]].append((row["value"], row["std"]))
        units[row["name"]] = row["unit"]
    return found, units


def coordinate(name, value, std):
    """What is compared: logarithm and relative error, or the value itself."""
    return (value, std) if name in LEVELS or value <= 0.0 else (math.log(value), std / value)


def of_type(vehicle_type, name, by_battery, unit):
    """Outliers, found or not, with their p, of one parameter."""
    names = sorted(by_battery)
    middle = [np.median(by_battery[battery], axis=0).tolist() for battery in names]  # value, std
    x, s = np.array([coordinate(name, *pair) for pair in middle]).T
    away = x - np.median(x)
    z = away / np.sqrt((1.4826 * np.median(np.abs(away)))**2 + s**2 + MIN_STD**2)
    median = float(np.median([value for value, _ in middle]))
    return [Outlier(battery, vehicle_type, name, value, unit, median, float(one), False) for battery, (value, _), one in zip(names, middle, z)]


def outliers(base):
    """Batteries and parameters that deviate, the farthest first; and how many were compared."""
    found, units = values(base)
    every = [one for (vehicle_type, _, name), by_battery in sorted(found.items()) if len(by_battery) >= LEAST for one in of_type(vehicle_type, name, by_battery, units[name])]
    if not every:
        return [], 0
    stands = multipletests([2.0 * norm.sf(abs(one.z)) for one in every], alpha=RATE, method="fdr_bh")[0]
    return sorted((one._replace(found=True) for one, yes in zip(every, stands) if yes), key=lambda one: -abs(one.z)), len(every)

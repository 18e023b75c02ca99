"""Rates with their intervals, means of ratios, and predictions with theirs."""

import functools
import statistics

import numpy as np


def interval(k, n, method="exact", level=0.95):
    """95 % interval of a rate of k in n (Clopper and Pearson 1934)."""
    from scipy.stats import binomtest  # half a second
    return tuple(binomtest(int(k), int(n)).proportion_ci(level, method))


wilson = functools.partial(interval, method="wilson")  # by the score test (Wilson 1927)
wilson_90 = functools.partial(interval, method="wilson", level=0.9)


def rate(k, n, of=interval):
    """"k of n = .. % (.. to .. %)", or that there is no case."""
    if not n:
        return "no case"
    low, high = of(k, n)
    return f"{k} of {n} = {100 * k / n:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"


def geometric_mean(values):
    """None without a value; what is below 1e-12 counts as that."""
    return statistics.geometric_mean(max(one, 1e-12) for one in values) if values else None


def spread(ratios):
    """Median and geometric mean in words."""
    if not ratios:
        return "no case"
    return f"median {statistics.median(ratios):.3f}, geometric mean {geometric_mean(ratios):.3f} (n = {len(ratios)})"


def rms(errors):
    return float(np.sqrt(np.mean(np.square(errors)))) if len(errors) else None


def pooled(events, keys=("measured", "expected", "lower", "upper")):
    """Errors of predicted events, share inside and above the lower bound [%], median width; empty without an event."""
    if not events:
        return {}
    measured, expected, low, high = np.array([[one[key] for key in keys] for one in events], float).T
    error = np.abs(measured - expected)
    return {"count": len(events), "error": float(np.mean(error)), "median_error": float(np.median(error)),
            "rms": rms(error),
            "inside_percent": 100.0 * float(np.mean((low <= measured) & (measured <= high))),
            "above_percent": 100.0 * float(np.mean(low <= measured)),
            "width": float(np.median(high - low))}

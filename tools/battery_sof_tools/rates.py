"""Rates with their intervals, and means of ratios."""

import math
import statistics

Z_95 = 1.959963984540054  # of the normal distribution, two-sided 95 %


def interval(k, n):
    """95 % interval of a rate of k in n (Clopper and Pearson 1934)."""
    from scipy.stats import beta
    low = beta.ppf(0.025, k, n - k + 1) if k else 0.0
    high = beta.ppf(0.975, k + 1, n - k) if k < n else 1.0
    return low, high


def wilson(k, n):
    """95 % interval of a rate of k in n by the score test (Wilson 1927)."""
    middle, half = k + 0.5 * Z_95**2, Z_95 * math.sqrt(k * (n - k) / n + 0.25 * Z_95**2)
    return max(0.0, (middle - half) / (n + Z_95**2)), min(1.0, (middle + half) / (n + Z_95**2))


def rate(k, n, of=interval):
    """"k of n = .. % (.. to .. %)", or that there is no case."""
    if not n:
        return "no case"
    low, high = of(k, n)
    return f"{k} of {n} = {100 * k / n:.1f} % ({100 * low:.1f} to {100 * high:.1f} %)"


def geometric_mean(values):
    """None without a value; what is below 1e-12 counts as that."""
    return math.exp(statistics.fmean(math.log(max(one, 1e-12)) for one in values)) if values else None


def spread(ratios):
    """Median and geometric mean in words."""
    if not ratios:
        return "no case"
    return f"median {statistics.median(ratios):.3f}, geometric mean {geometric_mean(ratios):.3f} (n = {len(ratios)})"

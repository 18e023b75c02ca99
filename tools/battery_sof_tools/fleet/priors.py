"""What a fleet teaches a single battery: mean and covariance of parameters by type of vehicle, as PRIORS.yaml.

Each battery b has parameters x_b = m + e_b, e_b ~ N(0, V), and a fit gives y_b = x_b + f_b with the fit's covariance S_b. The moments (DerSimonian and Laird 1986; several
parameters at once: Jackson, White and Riley 2013) are turned over until they stay:

    m = (sum_b W_b)^-1 sum_b W_b y_b,   W_b = (V + S_b)^-1,     V = mean_b (y_b - m)(y_b - m)' n / (n - 1) - mean_b S_b

V is made positive by its eigenvalues. Coordinates are logarithms, but for voltages. What a fit could not determine has a wide S_b and weighs nothing.
A battery with several recordings has the mean of them, its S_b their mean over their number, so no car counts more than once.
"""

import collections
import math

import numpy as np
import yaml

from . import database, departures

SCHEMA = "battery_sof/priors/1"
LEAST = 3        # batteries, for a spread
TURNS = 50
LEAST_STD = 0.05  # of a logarithm, or of volts: no fleet knows a battery better than this


def moments(values, covariances):
    """Mean and covariance of a population from estimates (one a row) and their covariances."""
    n, k = values.shape
    mean, spread = np.mean(values, axis=0), np.atleast_2d(np.cov(values, rowvar=False))
    for _ in range(TURNS):
        weights = np.linalg.inv(spread[None] + covariances)
        mean = np.linalg.solve(weights.sum(axis=0), np.einsum("bij,bj->i", weights, values))
        away = values - mean
        before, spread = spread, positive(away.T @ away / (n - 1) - covariances.mean(axis=0))
        if np.allclose(before, spread, rtol=1e-6, atol=1e-12):
            break
    return mean, spread.reshape(k, k)


def positive(matrix):
    """The nearest one whose standard deviations are LEAST_STD at least along its axes."""
    value, axes = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return (axes * np.maximum(value, LEAST_STD**2)) @ axes.T


def fits(base, without):
    """(vehicle type, effects) -> battery -> [{name: (coordinate, std)}] of recordings, but those of the batteries left out."""
    rows = base.execute(f"SELECT r.battery, r.vehicle_type, w.effects, p.* FROM parameter p JOIN recording r USING (recording) JOIN window w USING (recording) "
                        f"WHERE {departures.DETERMINED} ORDER BY recording")
    found = collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(dict)))
    for row in rows:
        if row["battery"] not in without:
            one = found[row["vehicle_type"] or "", row["effects"]][row["battery"]][row["recording"]]
            one[row["name"]] = departures.coordinate(row["name"], row["value"], row["std"])
    return {kind: {battery: list(each.values()) for battery, each in batteries.items()} for kind, batteries in found.items()}


def common(batteries):
    """Names that all recordings of at least LEAST batteries determine; a name that few have would leave few batteries."""
    counted = collections.Counter(name for each in batteries.values() for name in {name for one in each for name in one})
    return sorted(name for name in counted if counted[name] >= max(LEAST, len(batteries) // 2))


def estimate(each, names):
    """One battery's mean and variances over its recordings; NaN where it determined nothing."""
    pairs = [[one[name] for one in each if name in one] for name in names]
    mean = np.array([np.mean([value for value, _ in found]) if found else np.nan for found in pairs])
    return mean, np.array([np.mean([std**2 for _, std in found]) / len(found) if found else np.nan for found in pairs])


def population(batteries):
    """(names, mean, covariance, number) of one type of vehicle and one set of effects, or None where too few are known."""
    names = common(batteries)
    if not names or len(batteries) < LEAST:
        return None
    mean, variance = (np.array(one) for one in zip(*(estimate(each, names) for each in batteries.values())))
    known = np.isfinite(mean)
    mean = np.where(known, mean, np.nanmean(mean, axis=0))
    variance = np.where(known, variance, 1e6 * (np.nanvar(mean, axis=0) + LEAST_STD**2))
    return (names, *weighed(mean, variance, known), len(batteries))


def weighed(mean, variance, known):
    """Moments over batteries of which some determined a part: each parameter's spread from those that did, correlations from those that determined all."""
    centre, spread = zip(*(moments(mean[known[:, k], k:k + 1], variance[known[:, k], k:k + 1, None]) for k in range(mean.shape[1])))
    std = np.sqrt([one[0, 0] for one in spread])
    whole = known.all(axis=1)
    correlation = np.eye(len(std))
    if whole.sum() > 3 * len(std):
        joint = moments(mean[whole], np.array([np.diag(one) for one in variance[whole]]))[1]
        correlation = joint / np.sqrt(np.outer(np.diag(joint), np.diag(joint)))
    return np.array([one[0] for one in centre]), correlation * np.outer(std, std)


def described(kind, made):
    names, mean, covariance, batteries = made
    std = np.sqrt(np.diag(covariance))
    parameters = {name: {"value": float(m if name in departures.LEVELS else math.exp(m)), "std": float(s), "logarithmic": name not in departures.LEVELS}
                  for name, m, s in zip(names, mean, std)}
    correlation = (covariance / np.outer(std, std)).round(6).tolist()
    return {"vehicle_type": kind[0], "effects": [one for one in kind[1].split(",") if one], "batteries": batteries, "parameters": parameters, "correlation": correlation}


def make(folder, without=()):
    """What PRIORS.yaml holds. without: batteries to leave out, as for a comparison on them; all types together stand under no type."""
    found = fits(database.open_read(folder), set(without))
    together = collections.defaultdict(dict)
    for (_, effects), batteries in found.items():
        together["", effects].update(batteries)
    populations = {kind: population(batteries) for kind, batteries in {**found, **together}.items()}
    return {"schema": SCHEMA, "priors": [described(kind, populations[kind]) for kind in sorted(populations) if populations[kind]]}


def write(folder, out, without=()):
    told = make(folder, without)
    if not told["priors"]:
        raise SystemExit(f"{folder}: no type of vehicle has {LEAST} batteries with parameters")
    with open(out, "w") as file:
        file.write("# What a fleet says of a battery before it is measured. std: of the logarithm where logarithmic. correlation: rows and columns the parameters.\n")
        yaml.safe_dump(told, file, sort_keys=False)
    return told

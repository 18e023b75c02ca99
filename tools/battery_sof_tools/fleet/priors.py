"""What a fleet teaches a single battery: parameters by type of vehicle, as PRIORS.yaml.

A fit w of battery b reports y_bw = m + c_b + d_bw + f_bw: the fleet's mean, what is the battery's own, c ~ N(0, C), what changes from window to window (charge,
temperature), d ~ N(0, D), and the fit's error with its variance s_bw^2. By moments (DerSimonian and Laird 1986), in turns until they stay:

    D = mean of the variances inside batteries - mean s^2,     v_b = (D + mean_w s_bw^2) / n_b
    m = sum W_b y_b / sum W_b,   W_b = (C + v_b)^-1,           C = cov(y_b) - mean v_b

The next window of another battery of the type is N(m, C + D).
Coordinates are logarithms, but for voltages. No car counts more than another, however long its recordings. Correlations are of C; `sof identify` does not read them.
"""

import collections
import math

import numpy as np
import yaml

from . import database, outliers

SCHEMA = "battery_sof/priors/1"
LEAST = 3         # batteries, for a spread
TURNS = 50


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
    """The nearest one whose standard deviations are outliers.MIN_STD at least along its axes."""
    value, axes = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return (axes * np.maximum(value, outliers.MIN_STD**2)) @ axes.T


def fits(base, without):
    """(vehicle type, effects) -> battery -> name -> [(coordinate, std)]: the windows that a recording was scored on, else the one that was identified."""
    rows = base.execute(f"SELECT r.battery, r.vehicle_type, p.* FROM parameter p JOIN recording r USING (recording) WHERE {outliers.DETERMINED} "
                        "AND (p.source LIKE 'score%' OR p.source = 'identify' AND NOT EXISTS (SELECT 1 FROM score s WHERE s.recording = p.recording)) ORDER BY recording, p.source")
    found = collections.defaultdict(lambda: collections.defaultdict(lambda: collections.defaultdict(list)))
    for row in rows:
        if row["battery"] not in without:
            found[row["vehicle_type"] or "", row["effects"]][row["battery"]][row["name"]].append(outliers.coordinate(row["name"], row["value"], row["std"]))
    return found


def inside(batteries, name):
    """D: variance from window to window of one battery, without the errors of fits; 0 where no battery has two windows."""
    squares, count, errors = 0.0, 0, []
    for known in batteries.values():
        value, std = np.array(known.get(name) or np.empty((0, 2))).T
        if len(value) > 1:
            squares += np.sum((value - value.mean())**2)
            count += len(value) - 1
            errors.extend(std**2)
    return max(0.0, squares / count - float(np.median(errors))) if count else 0.0


def means(batteries, name, window_variance):
    """Each battery's mean of a parameter and its variance v_b; NaN where it determined nothing."""
    pairs = []
    for known in batteries.values():
        each = np.array(known.get(name) or np.empty((0, 2)))
        pairs.append((each[:, 0].mean(), (window_variance + np.median(each[:, 1]**2)) / len(each)) if len(each) else (np.nan, np.nan))
    return np.array(pairs).T


def population(batteries):
    """Names, mean, C, D and the number of one type of vehicle and one set of effects, or None where too few are known."""
    counted = collections.Counter(name for known in batteries.values() for name in known)
    names = sorted(name for name in counted if counted[name] >= max(LEAST, len(batteries) // 2))
    if not names:
        return None
    window = np.array([inside(batteries, name) for name in names])
    mean, variance = (np.array(one).T for one in zip(*(means(batteries, name, d) for name, d in zip(names, window))))
    centre, spread = between(mean, variance)
    return names, centre, spread, window, len(batteries)


def between(mean, variance):
    """m and C over batteries of which some determined a part: spreads from those that did, correlations from those that determined all."""
    known = np.isfinite(mean)
    centre, spread = zip(*(moments(mean[known[:, k], k:k + 1], variance[known[:, k], k:k + 1, None]) for k in range(mean.shape[1])))
    std = np.sqrt([one[0, 0] for one in spread])
    whole, correlation = known.all(axis=1), np.eye(len(std))
    if whole.sum() > 3 * len(std):
        joint = moments(mean[whole], np.array([np.diag(one) for one in variance[whole]]))[1]
        correlation = joint / np.sqrt(np.outer(np.diag(joint), np.diag(joint)))
    return np.array([one[0] for one in centre]), correlation * np.outer(std, std)


def described(kind, made):
    names, mean, spread, window, batteries = made
    std = np.sqrt(np.diag(spread))
    parameters = {name: {"value": float(m if name in outliers.LEVELS else math.exp(m)), "std": float(math.sqrt(s**2 + d)), "logarithmic": name not in outliers.LEVELS,
                         "std_of_window": float(math.sqrt(d))} for name, m, s, d in zip(names, mean, std, window)}
    correlation = (spread / np.outer(std, std)).round(6).tolist()
    return {"vehicle_type": kind[0], "effects": [one for one in kind[1].split(",") if one], "batteries": batteries, "parameters": parameters, "correlation": correlation}


def make(folder, without=()):
    """What PRIORS.yaml holds. without: batteries to leave out, as for a comparison on them. All types together stand under no type."""
    base = database.open_read(folder)
    found = fits(base, set(without))
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

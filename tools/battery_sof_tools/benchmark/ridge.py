"""A ridge regression of the voltage on currents and their memories: what needs no physics."""

import math

import numpy as np

TRAINING = 0.75  # share of the samples that `sof diagnose` learns from


def low_pass(x, interval, tau):
    from scipy.signal import lfilter
    share = 1.0 - math.exp(-interval / tau)
    return lfilter([share], [1.0, share - 1.0], x, zi=[(1.0 - share) * x[0]])[0]


def ridge_columns(time_s, current):
    """Currents, their memories and reservoirs, one after the other; no physics, no state."""
    interval, span = float(np.median(np.diff(time_s))), time_s[-1] - time_s[0]
    taus = [tau for tau in (.1, .3, 1, 3, 10, 30, 100, 300, 1000, 3000) if .9 * interval <= tau < span / 3]
    charge, discharge = np.maximum(current, 0.0), np.maximum(-current, 0.0)
    for one in (current, charge, np.arcsinh(current / 5.0), np.arcsinh(charge / 2.0)):
        yield one
        for tau in taus:
            yield low_pass(one, interval, tau)
    yield np.cumsum(current) * interval / 3600.0
    for tau in (tau for tau in taus if tau >= 1):
        stock = low_pass(discharge, interval, tau) * tau
        for size in (5.0, 50.0, 500.0):
            yield size / (size + stock)
            yield charge * size / (size + stock)


def standardised(columns, rows=slice(None)):
    """Columns as a matrix, each with mean 0 and deviation 1 over some rows."""
    return np.array([(one - one[rows].mean()) / (one[rows].std() + 1e-12) for one in columns]).T


def weights(x, y, penalty):
    """Ridge weights of y, whose mean is 0, on standardised columns."""
    return np.linalg.solve(x.T @ x / len(x) + penalty * np.eye(x.shape[1]), x.T @ y / len(x))


def chosen_penalty(x, y):
    """The penalty that block cross-validation chooses."""
    blocks = np.array_split(np.arange(len(x)), 6)
    others = [np.setdiff1d(np.arange(len(x)), block) for block in blocks]
    return min((10.0 ** k for k in range(-5, 3)), key=lambda penalty: sum(
        ((x[block] @ weights(x[rest], y[rest], penalty) - y[block]) ** 2).sum() for rest, block in zip(others, blocks)))


def ridge_voltage(time_s, current, voltage, rows):
    """[V] of the samples beyond those of the voltage, by a ridge regression on ridge_columns() of all, fitted to rows; its penalty by block cross-validation."""
    x, level = standardised(ridge_columns(time_s, current), rows), voltage[rows].mean()
    y = voltage[rows] - level
    return level + x[len(voltage):] @ weights(x[rows], y, chosen_penalty(x[rows], y))


def ridge_rmse(time_s, current, voltage, max_rows=30000):
    """Its hold-out RMSE [V] on what follows the first TRAINING of the samples."""
    first_held = int(TRAINING * len(time_s))
    ahead = ridge_voltage(time_s, current, voltage[:first_held], np.arange(0, first_held, max(1, first_held // max_rows)))
    return float(np.sqrt(np.mean((ahead - voltage[first_held:]) ** 2)))

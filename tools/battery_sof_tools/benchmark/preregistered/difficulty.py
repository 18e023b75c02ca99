"""How large an added effect is for someone who knows the battery's noise: z, what is left of it after the base circuit has been fitted.

The recording is noise-free and averaged to 10 Hz; cells near edges are left out. The base circuit is fitted to it by Gauss-Newton
under the case's own noise (white, first-order correlated, random walk, both channels' white parts), by generalised least squares:
with the noise's two states eliminated by a banded Cholesky factor, the whitened products of residual and Jacobian are exact.
z = sqrt(e' S^-1 e) of the residual e that the fit leaves.
"""

import dataclasses

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from ...recordings import read_plain
from . import base_circuit as base

CELL = 10              # samples of 100 Hz in one averaged cell
EDGE_A, EDGE_SPAN = 5.0, 5      # an edge: a change [A] within so many samples
BEFORE, BEHIND = 10, 15         # samples left out around an edge
RESISTANCE_STEP, OTHER_STEP = 1e-7, 1e-6   # of the central differences: [Ohm]; logarithm or [V]
TRIES, SETTLED = 25, 1e-5       # of Gauss-Newton; relative fall of the cost that ends it


@dataclasses.dataclass
class Fit:
    parameters: np.ndarray
    residual: np.ndarray   # [V], cells
    kept: np.ndarray       # cells away from edges
    z: float
    z_start: float         # with the true parameters, before anything is absorbed
    errors: np.ndarray     # standard errors of the parameters under the case's noise


def cells(values):
    count = len(values) // CELL
    return values[:count * CELL].reshape(count, CELL, -1).mean(axis=1)


def away_from_edges(current):
    """True for cells without a sample near an edge."""
    near = np.zeros(len(current) + 1, dtype=int)
    for at in np.flatnonzero(np.abs(current[EDGE_SPAN:] - current[:-EDGE_SPAN]) > EDGE_A):
        near[max(at - BEFORE, 0)] += 1
        near[min(at + EDGE_SPAN + BEHIND, len(current))] -= 1
    return ~(cells(np.cumsum(near)[:-1].astype(float))[:, 0] > 0.0)


def white_variance(acquisition, resistance):
    """Of a sample of the voltage [V^2], both channels' noise and rounding in it."""
    of_voltage = acquisition["voltage_white_v"] ** 2 + acquisition["voltage_step_v"] ** 2 / 12.0
    return of_voltage + resistance ** 2 * (acquisition["current_white_a"] ** 2 + acquisition["current_step_a"] ** 2 / 12.0)


class Noise:
    """Products under the inverse covariance of white + correlated + walking noise, cells left out having none."""

    def __init__(self, acquisition, resistance, kept, interval):
        white = white_variance(acquisition, resistance)
        self.weight = kept / (white / CELL)
        keep = np.exp(-interval / acquisition["voltage_correlation_time_s"])
        spread = max(acquisition["voltage_correlated_v"], 1e-6) ** 2
        walk = 1.0 / (max(acquisition["voltage_walk_v_per_sqrt_min"], 1e-6) ** 2 * interval / 60.0)
        innovation = 1.0 / (spread * (1.0 - keep ** 2))
        inner = np.arange(len(kept)) < len(kept) - 1
        outer = np.arange(len(kept)) > 0
        band = np.zeros((3, 2 * len(kept)))  # upper form; unknowns: walk and correlated part of each cell in turns
        band[2, 0::2] = self.weight + walk * inner + walk * outer
        band[2, 1::2] = self.weight + innovation * outer + innovation * keep ** 2 * inner
        band[2, 1] += 1.0 / spread
        band[1, 1::2] = self.weight
        band[0, 2::2] = -walk
        band[0, 3::2] = -innovation * keep
        self.factor = cholesky_banded(band)

    def weighted(self, columns):
        """S^-1 times columns."""
        seen = self.weight[:, None] * columns
        states = cho_solve_banded((self.factor, False), np.repeat(seen, 2, axis=0))
        return seen - self.weight[:, None] * (states[0::2] + states[1::2])


def measured(path):
    """Interval [s], current [A] and voltage [V]."""
    time, current, voltage = read_plain(path)
    return time[1] - time[0], current, voltage


def noise_of(label, current, interval, kept=None):
    kept = away_from_edges(current) if kept is None else kept
    start = base.true_parameters(label)
    return Noise(label["truth"]["acquisition"], 0.5 * (start[0] + start[1]), kept, CELL * interval), kept


def fitted(label, recording):
    """The base circuit fitted to a noise-free recording (see measured)."""
    interval, current, voltage = recording
    noise, kept = noise_of(label, current, interval)
    steps = np.array([RESISTANCE_STEP] * 2 + [OTHER_STEP] * 4)
    now, damping, best, z_start = base.true_parameters(label), 1e-6, None, None
    for _ in range(TRIES):
        around = np.concatenate([now[:, None], now[:, None] + np.diag(steps)], axis=1)
        model = cells(base.simulate(around, current, interval) - voltage[:, None])
        columns = np.column_stack([model[:, 0], (model[:, 1:] - model[:, :1]) / steps])
        products = columns.T @ noise.weighted(columns)
        z_start = float(np.sqrt(max(products[0, 0], 0.0))) if z_start is None else z_start
        if best is not None and not products[0, 0] < best[0]:
            damping = max(10.0 * damping, 1e-4)
            if damping > 1e6 or abs(products[0, 0] - best[0]) < SETTLED * best[0]:
                break
        else:
            done = best is not None and best[0] - products[0, 0] < SETTLED * products[0, 0]
            best, damping = (products[0, 0], now, columns[:, 0], products), damping / 10.0
            if done:
                break
        normal = best[3][1:, 1:]
        move = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), best[3][1:, 0])
        now = best[1] + np.clip(move, -1.0, 1.0)
    return Fit(best[1], best[2], kept, float(np.sqrt(max(best[0], 0.0))), z_start, standard_errors(best[3][1:, 1:]))


def standard_errors(normal):
    """Of the parameters but the level, which a walking one takes up whole: its error is infinite, and no other's depends on it."""
    errors, others = np.full(len(normal), np.inf), np.arange(len(normal)) != base.U_DC
    errors[others] = np.sqrt(np.diag(np.linalg.inv(normal[np.ix_(others, others)])))
    return errors


def difference(label, recording, one, other):
    """z of what two fits to recordings of one seed leave differently: an effect beside a companion that both have."""
    interval, current, _ = recording
    count = min(len(one.residual), len(other.residual))
    noise, _ = noise_of(label, current, interval, one.kept[:count] & other.kept[:count])
    apart = (one.residual[:count] - other.residual[:count])[:, None]
    return float(np.sqrt(max((apart.T @ noise.weighted(apart)).item(), 0.0)))


BIASED = ("r_discharge", "r_charge", "c2", "beta")


def largest_bias(label, fit, start=None):
    """Largest relative error of r_discharge, r_charge, C_2 and beta, and whose it is; start: from these parameters, not the true ones."""
    start = base.true_parameters(label) if start is None else start
    apart = (fit.parameters - start)[:4]
    relative = np.append(apart[:2] / start[:2], np.expm1(apart[2:]))
    worst = int(np.argmax(np.abs(relative)))
    return float(relative[worst]), BIASED[worst]


def bias_in_errors(label, fit, parameter, start=None):
    """That of a parameter in its standard errors."""
    start = base.true_parameters(label) if start is None else start
    k = BIASED.index(parameter)
    return float(abs(fit.parameters[k] - start[k]) / fit.errors[k])


def raised(label, residual):
    """What a residual [V] makes of the RMS of a sample's noise, as a factor: 1 where it is nothing."""
    acquisition, start = label["truth"]["acquisition"], base.true_parameters(label)
    noise = white_variance(acquisition, 0.5 * (start[0] + start[1])) + acquisition["voltage_correlated_v"] ** 2
    return float(np.sqrt(1.0 + np.mean(residual ** 2) / noise))


def raw_error(label, recording):
    """Measured minus base circuit with its true parameters [V], cells; nothing is fitted or left out."""
    interval, current, voltage = recording
    return cells(voltage[:, None] - base.simulate(base.true_parameters(label)[:, None], current, interval))[:, 0]

"""Base + three effects fitted with scipy.optimize.least_squares, as one would write it in Python.

One step after another in plain floats: lead ions feed back on the double layer, so a drive has no form that numpy could
take at once. Scheme and step control as in bench/composed_ceres.cpp; coordinates, bounds, priors and weights as handed over.
"""

import math

import numpy as np
from scipy.optimize import least_squares

TOLERANCE = 4e-5  # [V] between one implicit step and its halves


class Layer:
    """Double layer and lead ions: C du/dt = i - [p exp(b u / 2) - exp(-b u / 2)], I_0 = 1 A."""

    def __init__(self, c2, beta, inverse_limit, refill_time):
        self.c2, self.half_beta, self.inverse_limit, self.refill_time = c2, 0.5 * beta, inverse_limit, refill_time
        self.suggested = 1.0

    def euler(self, u, p, current, h, guess):
        """One implicit Euler step of (u, p)."""
        exp, half_beta, inverse_limit = math.exp, self.half_beta, self.inverse_limit
        storage, refill, reach = self.c2 / h, h / self.refill_time, 2.0 / half_beta
        before, v = p, guess
        while True:
            rising = exp(half_beta * v)
            falling = 1.0 / rising
            below = 1.0 + refill * (1.0 + rising * inverse_limit)
            p = (before + refill * (1.0 + falling * inverse_limit)) / below
            excess = storage * (v - u) - current + p * rising - falling
            fall = refill * inverse_limit * (falling + p * rising) / below
            step = -excess / (storage + half_beta * (p * rising + falling - fall * rising))
            v += min(max(step, -reach), reach)
            if abs(step) < 1e-9:
                # the last step's share of the activity, to first order
                return v, p - half_beta * fall * step

    def advance(self, u, p, current, duration):
        left = duration
        while left > 0.0:
            h = self.suggested if self.suggested < 0.999 * left else left
            u_whole, p_whole = self.euler(u, p, current, h, u)
            u_half, p_half = self.euler(u, p, current, 0.5 * h, 0.5 * (u + u_whole))
            u_halves, p_halves = self.euler(u_half, p_half, current, 0.5 * h, u_whole)
            error = abs(u_whole - u_halves) + abs(math.log(p_whole / p_halves)) / self.half_beta
            wanted = h * min(max(0.9 * math.sqrt(TOLERANCE / max(error, 1e-12)), 0.2), 4.0)
            if error > TOLERANCE:
                self.suggested = wanted
                continue
            u, p = 2.0 * u_halves - u_whole, p_halves * p_halves / p_whole
            left -= h
            self.suggested = max(wanted, self.suggested if h < self.suggested else wanted)
        return u, p


class Problem:
    """Residuals of the compressed drive, and the priors behind them."""

    def __init__(self, task):
        self.task = {key: np.array(value) for key, value in task.items() if key not in ("drive", "cost")}
        self.drive = {key: np.array(value) for key, value in task["drive"].items()}
        self.root_weight = np.sqrt(self.drive["weight"])
        self.steps = list(zip(task["drive"]["held"], task["drive"]["duration"]))
        self.simulations = 0

    def physical(self, x):
        return np.where(self.task["logarithmic"], np.exp(x), x * self.task["unit"])

    def layer_voltage(self, c2, beta, inverse_limit, refill_time, u, log_activity):
        layer, p, voltage = Layer(c2, beta, inverse_limit, refill_time), math.exp(log_activity), []
        for current, duration in self.steps:
            if duration > 0.0:
                u, p = layer.advance(u, p, current, duration)
            voltage.append(u)
        return np.array(voltage)

    def acid(self, tau, first):
        """Current that relaxes towards the battery's."""
        kept, x, all_of_it = np.exp(-self.drive["duration"] / tau), first, []
        for (current, _), share in zip(self.steps, kept.tolist()):
            x = current + (x - current) * share
            all_of_it.append(x)
        return np.array(all_of_it)

    def residuals(self, x):
        self.simulations += 1
        (r_discharge, r_charge, c2, beta, u_dc, inverse_limit, refill_time, r_low, i_low, r_acid_1, tau_1, r_acid_2, tau_2,
         u, log_activity, acid_1, acid_2) = self.physical(x).tolist()
        current = self.drive["current"]
        r = np.where(current < 0.0, r_discharge, r_charge) + r_low / (1.0 + np.abs(current) / i_low)
        modelled = (u_dc + r * current + self.layer_voltage(c2, beta, inverse_limit, refill_time, u, log_activity)
                    + r_acid_1 * self.acid(tau_1, acid_1) + r_acid_2 * self.acid(tau_2, acid_2))
        priors = np.sqrt(self.task["prior_weight"]) * (x - self.task["prior_mean"])
        return np.concatenate((self.root_weight * (self.drive["voltage"] - modelled), priors))


def fit(task):
    """(coordinates, cost, simulations) at the optimum; trf with bounds and a 2-point Jacobian, SciPy's defaults."""
    problem = Problem(task)
    found = least_squares(problem.residuals, problem.task["start"],
                          bounds=(problem.task["lower"], problem.task["upper"]))
    if not found.success:
        raise RuntimeError("SciPy did not converge: {}".format(found.message))
    return found.x, 2.0 * found.cost, problem.simulations

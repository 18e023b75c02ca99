"""Eq. 3 of the paper minimised with scipy.optimize.least_squares, as one would write it in numpy.

The state's step is a Moebius map of E = exp(beta u_c2 / 2), E' = (E a + P) / (E P + b), so a window is a product of
2 x 2 matrices. numpy has no loop for that; the window is folded into about sqrt(n) stretches that are multiplied up side
by side (as vectors), and joined one by one. The derivatives are those of the step, carried along in the same way.
"""

import numpy as np
from scipy.optimize import least_squares

MAGNITUDE = np.array([0.008, 0.010, 1000.0, 20.0, 12.0, 1.0])  # Table I; u_dc, first state
LOWER = np.array([0.001, 0.001, 100.0, 1.0, -np.inf, -2.0])
UPPER = np.array([0.1, 0.1, 5000.0, 1000.0, np.inf, 2.0])


class Window:
    """The samples and what of them does not depend on the unknowns; symbols as in closed_form_step.hpp."""

    def __init__(self, window, i0):
        held, duration, self.current, self.voltage, weight = (
            np.array(window[key]) for key in ("held_current", "duration", "current", "voltage", "weight"))
        self.size = held.size
        self.root_weight = np.sqrt(weight)
        radius = np.sqrt(held * held + 4.0 * i0 * i0)
        larger = (radius + np.abs(held)) / (2.0 * i0)
        e_plus = np.where(held < 0.0, 1.0 / larger, larger)
        self.rows = int(np.sqrt(self.size))  # samples of a stretch
        self.e_plus = self._folded(e_plus, 1.0)
        self.m = 1.0 / self.e_plus
        self.half_rate_dt = self._folded(0.5 * radius * duration, 0.0)

    def _folded(self, values, padding):
        """Stretches as columns: one row holds the k-th sample of every stretch."""
        missing = -self.size % self.rows
        return np.pad(values, (0, missing), constant_values=padding).reshape(-1, self.rows).T.copy()

    def _unfolded(self, values):
        return values.T.ravel()[:self.size]

    def states(self, c2, beta, first):
        """u_c2 and its derivatives to c2, beta and the first state."""
        decay = self.half_rate_dt * (beta / c2)
        D = np.exp(-decay)
        P = -np.expm1(-decay)
        a, b = self.e_plus + self.m * D, self.e_plus * D + self.m
        after = self._recursion(a, b, P, np.exp(0.5 * beta * first))
        flat = np.concatenate(([np.exp(0.5 * beta * first)], after.T.ravel()[:-1]))
        before = flat.reshape(-1, self.rows).T
        num, den = before * a + P, before * P + b
        survival = D * (self.e_plus + self.m) ** 2 * before / (num * den)
        slope_to_d = ((before * self.m - 1.0) * den - (self.e_plus - before) * num) / (num * den)
        d_log_rate = self._unfolded(self._affine(survival, -decay * D * slope_to_d))
        d_first = np.cumprod(self._unfolded(survival))
        u = 2.0 / beta * np.log(self._unfolded(after))
        d_log_rate *= 2.0 / beta
        return u, -d_log_rate / c2, (d_log_rate + first * d_first - u) / beta, d_first

    def _recursion(self, a, b, P, E):
        """E after every sample."""
        product = np.empty((4,) + a.shape)  # the matrices [[p, q], [r, s]] from a stretch's start to each sample
        p, q, r, s = a[0], P[0], P[0], b[0]
        product[:, 0] = p, q, r, s
        for k in range(1, self.rows):
            p, q, r, s = a[k] * p + P[k] * r, a[k] * q + P[k] * s, P[k] * p + b[k] * r, P[k] * q + b[k] * s
            size = p + q + r + s  # keeps the product inside the range of a double
            p, q, r, s = p / size, q / size, r / size, s / size
            product[:, k] = p, q, r, s
        start = np.empty(a.shape[1])
        for n, (p, q, r, s) in enumerate(product[:, -1].T.tolist()):
            start[n] = E
            E = (p * E + q) / (r * E + s)
        return (product[0] * start + product[1]) / (product[2] * start + product[3])

    def _affine(self, factor, force):
        """x after every sample of x' = factor x + force, from 0."""
        gain, offset = np.empty_like(factor), np.empty_like(factor)
        gain[0], offset[0] = factor[0], force[0]
        for k in range(1, self.rows):
            gain[k] = factor[k] * gain[k - 1]
            offset[k] = factor[k] * offset[k - 1] + force[k]
        start = np.empty(factor.shape[1])
        x = 0.0
        for n in range(start.size):
            start[n] = x
            x = gain[-1, n] * x + offset[-1, n]
        return gain * start + offset


class Problem:
    """Residuals and Jacobian of the six normalised unknowns; a point's simulation serves both."""

    def __init__(self, window):
        self.window = window
        self.discharge = np.minimum(window.current, 0.0)
        self.charge = np.maximum(window.current, 0.0)
        self.point, self.simulated = None, None
        self.simulations = 0

    def _states(self, x):
        if self.point is None or not np.array_equal(self.point, x):
            c2, beta, first = (x * MAGNITUDE)[[2, 3, 5]]
            self.point, self.simulated = x.copy(), self.window.states(c2, beta, first)
            self.simulations += 1
        return self.simulated

    def residuals(self, x):
        r_discharge, r_charge, _, _, u_dc, _ = x * MAGNITUDE
        modelled = u_dc + r_discharge * self.discharge + r_charge * self.charge + self._states(x)[0]
        return self.window.root_weight * (modelled - self.window.voltage)

    def jacobian(self, x):
        _, d_c2, d_beta, d_first = self._states(x)
        columns = (self.discharge, self.charge, d_c2, d_beta, np.ones_like(d_c2), d_first)
        return self.window.root_weight[:, None] * (np.column_stack(columns) * MAGNITUDE)


CONTENDERS = {
    "SciPy lm, analytic Jacobian": {"method": "lm", "analytic": True},
    "SciPy trf, bounds, analytic Jacobian": {"method": "trf", "analytic": True},
    "SciPy trf, bounds, 2-point Jacobian": {"method": "trf", "analytic": False},
}


def fit(window, i0, method, analytic):
    """(unknowns, cost, simulations) at the optimum, from Table I's magnitudes; "lm" is MINPACK's, without bounds."""
    problem = Problem(Window(window, i0))
    bounds = {} if method == "lm" else {"bounds": (LOWER / MAGNITUDE, UPPER / MAGNITUDE)}
    start = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    found = least_squares(problem.residuals, start, jac=problem.jacobian if analytic else "2-point", method=method,
                          **bounds)
    if not found.success:
        raise RuntimeError("SciPy {} did not converge: {}".format(method, found.message))
    return found.x * MAGNITUDE, 2.0 * found.cost, problem.simulations

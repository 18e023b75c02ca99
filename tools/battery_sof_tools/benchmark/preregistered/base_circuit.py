"""The base circuit (docs/physics.md#base-circuit), simulated by an exact step. Written for the benchmark alone: nothing of the product is in it.

    u = u_dc + u_2 + r(i) i,   r = r_discharge (i < 0) or r_charge (i >= 0)
    C_2 du_2/dt = i - 2 I_0 sinh(beta u_2 / 2)

For current held over dt, x = tanh(beta u_2 / 4) moves by a linear fractional map,
    x' = [x (R - 2 I_0 h) + i h] / [R + (2 I_0 + i x) h],   R = sqrt(i^2 + 4 I_0^2),  h = tanh(beta R dt / (4 C_2)),
and such maps compose as 2 x 2 matrices: stretches are composed side by side, then entered one after another.
"""

import numpy as np

I0 = 1.0  # [A]
R_DISCHARGE, R_CHARGE, LN_C2, LN_BETA, U_DC, U2_START = range(6)
STRETCH = 350  # samples; about the root of what a recording has


def simulate(parameters, current, interval):
    """Terminal voltage [V], one column for each column of parameters (6 rows, order above; C_2 and beta as logarithms)."""
    beta = np.exp(parameters[LN_BETA])
    step_current = np.append(0.5 * (current[1:] + current[:-1]), current[-1])
    root = np.hypot(step_current, 2.0 * I0)[:, None]
    h = np.tanh(beta * root * interval / (4.0 * np.exp(parameters[LN_C2])))
    x = states(step_current[:, None] / root * h, 2.0 * I0 / root * h, np.tanh(0.25 * beta * parameters[U2_START]))
    resistance = np.where(current[:, None] < 0.0, parameters[R_DISCHARGE], parameters[R_CHARGE])
    return parameters[U_DC] + 4.0 / beta * np.arctanh(x) + resistance * current[:, None]


def states(driven, decayed, start):
    """x before each step; a step is x' = [(1 - decayed) x + driven] / [driven x + 1 + decayed]."""
    count, columns = driven.shape
    stretches = -(-count // STRETCH)
    shape, missing = (stretches, STRETCH, columns), stretches * STRETCH - count
    b, a = (np.pad(one, ((0, missing), (0, 0))).reshape(shape) for one in (driven, decayed))
    entered = np.empty((stretches, columns))
    entered[0] = start
    top_x, top, bottom_x, bottom = composed(a, b)
    for k in range(stretches - 1):
        x = entered[k]
        entered[k + 1] = (top_x[k] * x + top[k]) / (bottom_x[k] * x + bottom[k])
    out, x = np.empty(shape), entered
    for k in range(STRETCH):
        out[:, k] = x
        x = ((1.0 - a[:, k]) * x + b[:, k]) / (b[:, k] * x + 1.0 + a[:, k])
    return np.clip(out.reshape(-1, columns)[:count], -1.0 + 1e-15, 1.0 - 1e-15)


def composed(a, b):
    """The map of each stretch as a whole: x' = (top_x x + top) / (bottom_x x + bottom)."""
    first = np.ones_like(a[:, 0])
    top_x, top, bottom_x, bottom = first, 0.0 * first, 0.0 * first, first
    for k in range(a.shape[1]):
        less, more, drive = 1.0 - a[:, k], 1.0 + a[:, k], b[:, k]
        top_x, bottom_x = less * top_x + drive * bottom_x, drive * top_x + more * bottom_x
        top, bottom = less * top + drive * bottom, drive * top + more * bottom
        scale = 1.0 / np.abs(bottom)
        top_x, top, bottom_x, bottom = top_x * scale, top * scale, bottom_x * scale, bottom * scale
    return top_x, top, bottom_x, bottom


def true_parameters(label):
    """Base values behind a label, before anything was added."""
    battery = label["truth"]["battery"]
    u0 = battery["u0_v"] + battery["u0_slope_v"] * (label["truth"]["soc_at_start"] - 0.8)
    return np.array([battery["r_ohmic_ohm"] + battery["r1_discharge_ohm"], battery["r_ohmic_ohm"] + battery["r1_charge_ohm"],
                     np.log(battery["cpe2_capacitance_f"]), np.log(battery["beta_per_v"]), u0, 0.0])

"""An effect of known strength put into a recording that was measured.

current_offset [A]; time_skew: voltage late by [s]; contact_resistance: step at an instant [ohm];
voltage_drift [V/h]; acid_transport: R LP_tau[i] [ohm]; ocv_soc: slope over charge [V/Ah];
high_rate_depletion: 0.15 V ln(1 - LP_tau[(-i)+] / i_L), strength 1/i_L [1/A].

With numpy alone; shares no code with the product. Nothing is integrated across a gap (longer than three times the median interval): a memory
decays with the time that passed, a charge stays. A step back of the clock counts as no time.
"""

import math

import numpy as np

DEPLETION_VOLTAGE = 0.15  # [V], kappa
DEEPEST = 0.95  # [1], share of the acid that may be used up


def steps(t):
    """Time that passed before every sample [s], and whether the current before it is known."""
    passed = np.maximum(np.diff(t, prepend=t[0]), 0.0)
    return passed, passed <= 3.0 * np.median(np.diff(t))


def low_pass(t, x, tau):
    """LP_tau[x]: dy/dt = (x - y) / tau with x held from sample to sample; without a drive across gaps."""
    passed, known = steps(t)
    y, out = 0.0, np.empty(len(t))
    for k in range(len(t)):
        keep = math.exp(-passed[k] / tau)
        y = keep * y + ((1.0 - keep) * x[k - 1] if k and known[k] else 0.0)
        out[k] = y
    return out


def charge(t, i):
    """[Ah] since the first sample."""
    passed, known = steps(t)
    return np.cumsum(np.where(known, passed, 0.0) * np.concatenate(([0.0], i[:-1]))) / 3600.0


def instant_of_throughput(t, i, share):
    """[s], when a share of all the charge that passes either way has passed."""
    passed = charge(t, np.abs(i))
    return float(t[np.searchsorted(passed, share * passed[-1])])


def shifted(t, u, delay):
    """Voltage that comes late by delay [s]: u(t - delay), linear between samples, as measured where a gap or the clock forbids it."""
    out, start = u.copy(), 0
    known = steps(t)[1] & (np.diff(t, prepend=t[0] - 1.0) > 0.0)
    ends = [k for k in range(1, len(t)) if not known[k]] + [len(t)]
    for end in ends:
        if end - start > 2:
            out[start:end] = np.interp(t[start:end] - delay, t[start:end], u[start:end])
        start = end
    return out


def changed(name, t, i, u, strength, tau, instant):
    """Current and voltage with the addition."""
    if name == "current_offset":
        return i + strength, u
    if name == "time_skew":
        return i, shifted(t, u, strength)
    added = {"contact_resistance": lambda: strength * i * (t > instant),
             "voltage_drift": lambda: strength * (t - t[0]) / 3600.0,
             "acid_transport": lambda: strength * low_pass(t, i, tau),
             "ocv_soc": lambda: strength * charge(t, i),
             "high_rate_depletion": lambda: DEPLETION_VOLTAGE * np.log(
                 1.0 - np.minimum(strength * low_pass(t, np.maximum(-i, 0.0), tau), DEEPEST))}
    return i, u + added[name]()

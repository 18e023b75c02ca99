"""A law put into a measured recording by `draw_scenario`, and how much of it no parameter of the base circuit can follow; effects of the catalogue,
put in at a known strength by equations of their own that share no code with the product, see changed().

Of those nothing is integrated across a gap (longer than three times the median interval): a memory decays with the time that passed, a charge stays.
A step back of the clock counts as no time.
"""

import math
import os

import numpy as np

from .. import recordings
from ..sof import Failure
from .ridge import TRAINING

MEMORIES_S = (3.0, 30.0, 100.0)  # of the linear stand-in for the double layer
PROMISED = 2.0                   # times the error that a diagnosis calls too small to tell
MIN_HELD = 0.4                 # of the size before the split, that is wanted behind it
# Strengths: 0.03 to 4 is what draw_scenario takes of a law (docs/validation.md). Heavier drives and larger limits ask for more of what adds to the
# voltage; of what changes a current no more is taken.
MIN_STRENGTH, MAX_CURRENT_STRENGTH, MAX_STRENGTH = 0.03, 4.0, 20.0
PROPORTIONAL = ("acceptance", "acid", "open_circuit", "structure", "ageing")  # their laws add a voltage in proportion to the strength
NEAR, TRIES = 0.15, 3
RESISTANCE_OHM, CHARGE_OVER_DISCHARGE = (2.5e-3, 25e-3), (0.9, 1.8)  # of a battery in use, as draw_scenario draws them, with cables
MIN_DISCHARGE_A = 0.5          # while less is drawn a source may hold the voltage
DEPLETION_VOLTAGE = 0.15         # [V], kappa
DEEPEST = 0.95                   # share of the acid that may be used up
STEPLESS = 1e-9                  # [A], [V]: numbers that are apart by less are one


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


def columns(t, i):
    """What stands in for the base circuit: level, both resistances, memories of the current."""
    return np.stack([np.ones_like(t), np.minimum(i, 0.0), np.maximum(i, 0.0)] + [low_pass(t, i, tau) for tau in MEMORIES_S], axis=1)


def followed(basis, values, rows):
    return np.linalg.lstsq(basis[rows], values[rows], rcond=None)[0]


class Beside:
    """A measured recording [s, A, V] as laws are put into it."""

    def __init__(self, t, i, u):
        self.t, self.i, self.u = t, i, u
        self.training = slice(0, int(TRAINING * len(t)))
        self.basis = columns(t, i)
        self.circuit = self.discharged_circuit()

    def discharged_circuit(self):
        """What the columns are worth where the current is the battery's own: while it is discharged; the same resistance both ways."""
        rows = self.i < -MIN_DISCHARGE_A
        both = np.column_stack([self.basis[:, 0], self.i, self.basis[:, 3:]])
        level, resistance, *memories = followed(both, self.u, rows if rows.sum() > 10 * both.shape[1] else slice(None))
        return np.array([level, resistance, resistance, *memories])

    def resistances(self):
        """[Ohm] while discharging and charging, of a battery whose laws go beside this recording."""
        discharge = float(np.clip(self.circuit[1], *RESISTANCE_OHM))
        direct = followed(self.basis, self.u, slice(None))[2]
        return discharge, discharge * float(np.clip(direct / discharge, *CHARGE_OVER_DISCHARGE))

    def visible(self, current, voltage):
        """RMS [V] before and behind the split of what other base parameters leave of a change of the recording."""
        basis = self.basis if current is self.i else columns(self.t, current)
        error = (voltage - basis @ self.circuit) - (self.u - self.basis @ self.circuit)
        rest = error - basis @ followed(basis, error, self.training)
        return [float(np.sqrt(np.mean(part**2))) for part in (rest[self.training], rest[self.training.stop:])]


def put_in(generator, beside, path, law, strength, folder):
    """Current and voltage with a law (mechanism, form, seed) in them. Failure where the law does not go that far."""
    out = os.path.join(folder, "law.csv")
    generator.inject(path, out, law, strength, beside.resistances())
    _, current, voltage = recordings.read(out)
    same = np.allclose(current, beside.i, atol=1e-6)
    return beside.i if same else current, voltage


def with_strength(generator, beside, path, law, wanted, folder):
    """(strength, visible RMS before and behind the split, current, voltage) where the wanted RMS [V] is reached.

    Failure where the law would have to be too strong, or does not show in the last part of the recording.
    """
    in_proportion = law["mechanism"] in PROPORTIONAL
    most = MAX_STRENGTH if in_proportion else MAX_CURRENT_STRENGTH
    current, voltage = put_in(generator, beside, path, law, 1.0, folder)
    strength, shown = 1.0, beside.visible(current, voltage)
    for _ in range(TRIES):
        if wanted <= shown[0] <= (1.0 + 2.0 * NEAR) * wanted:
            break
        further = min(max(strength * (1.0 + NEAR) * wanted / max(shown[0], 1e-9), MIN_STRENGTH), most)
        if further == strength:
            break
        if in_proportion:
            voltage = beside.u + further / strength * (voltage - beside.u)
        else:
            current, voltage = put_in(generator, beside, path, law, further, folder)
        strength, shown = further, beside.visible(current, voltage)
    tried = f"{law['form']} at {strength:.3g}: {1e3 * shown[0]:.3g} and {1e3 * shown[1]:.3g} mV, wanted {1e3 * wanted:.3g} mV"
    if shown[0] < wanted:
        raise Failure("too weak: " + tried)
    if shown[1] < MIN_HELD * wanted:
        raise Failure("not in the last part: " + tried)
    return strength, shown, current, voltage


def neutral(t, i, u, limit, seed):
    """A voltage with what the base circuit and its noise take up whole: a series resistance, another level, noise far below the limit."""
    dice = np.random.default_rng(seed)
    resistance, level = dice.uniform(0.0, 2e-3), dice.uniform(-0.1, 0.1)
    return u + resistance * i + level + dice.normal(0.0, 0.1 * limit, len(t)), {"resistance_ohm": resistance, "level_v": level}


def in_steps(measured, values, seed):
    """A changed channel in the steps of the sensor that measured it, as that would have shown it.

    The step is the smallest difference of two samples; where the numbers of a file are no multiples of one step, what is shown is off by up to half of it.
    What was measured stands for anything within half a step of it, so half a step is drawn and added before it is rounded. What
    has not changed stays. Without this, a held voltage is in the sensor's steps and all else is not, which no sensor shows.
    """
    differences = np.abs(np.diff(measured))
    differences = differences[differences > STEPLESS]
    if not len(differences):
        return values
    step = differences.min()
    dice = np.random.default_rng(seed)
    shown = measured[0] + step * np.round((values - measured[0]) / step + dice.uniform(-0.5, 0.5, len(values)))
    return np.where(np.abs(values - measured) > STEPLESS, shown, measured)


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
    out, known = u.copy(), steps(t)[1][1:] & (np.diff(t) > 0.0)
    for part in np.split(np.arange(len(t)), np.flatnonzero(~known) + 1):
        if len(part) > 2:
            out[part] = np.interp(t[part] - delay, t[part], u[part])
    return out


def changed(name, t, i, u, strength, tau, instant):
    """Current and voltage with an effect of the catalogue.

    current_offset [A]; current_gain: share that is shown too much; time_skew: voltage late by [s]; contact_resistance: step at an instant [ohm];
    voltage_drift [V/h]; acid_transport: R LP_tau[i] [ohm]; ocv_soc: slope over charge [V/Ah];
    high_rate_depletion: 0.15 V ln(1 - LP_tau[(-i)+] / i_L), strength 1/i_L [1/A].
    """
    if name == "current_offset":
        return i + strength, u
    if name == "current_gain":
        return i * (1.0 + strength), u
    if name == "time_skew":
        return i, shifted(t, u, strength)
    added = {"contact_resistance": lambda: strength * i * (t > instant),
             "voltage_drift": lambda: strength * (t - t[0]) / 3600.0,
             "acid_transport": lambda: strength * low_pass(t, i, tau),
             "ocv_soc": lambda: strength * charge(t, i),
             "high_rate_depletion": lambda: DEPLETION_VOLTAGE * np.log(
                 1.0 - np.minimum(strength * low_pass(t, np.maximum(-i, 0.0), tau), DEEPEST))}
    return i, u + added[name]()

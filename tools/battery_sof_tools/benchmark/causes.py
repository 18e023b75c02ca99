"""Puts causes into recordings that were measured, as the difference that each makes of a full physical model, asks `sof diagnose`, and counts (docs/validation.md).

    scripts/causes BUILD --data FOLDER --out DIR [--seed 1] [--count 420] [--shams 120] [--pairs 84] [--minutes M]
    scripts/causes BUILD ... --seal FILE      what is planned and its digest, before anything is asked
    scripts/causes BUILD ... --score          the table of what was asked so far

A porous block (`draw_scenario --into RECORDING --cause ID=STRENGTH`) runs along half an hour of a measured current twice, sound and with the
cause; the difference goes into the voltage, and into the current while a charger regulates the voltage. Instruments need no block.
A strength is searched until z is the one drawn, 2 to 32: what of the difference neither the circuit nor a ridge regression takes up, in
units of its standard error under the noise that the two leave of the unchanged recording. Shams hold what the circuit takes up whole.
What is named with the cause and not without it counts. Answers are given to the recording alone; labels lie apart until --score or the end.
"""

import argparse
import functools
import hashlib
import itertools
import json
import math
import os
import random
import sys
import time

import numpy as np

from .. import recordings
from ..files import append, lines_of, read_json, require_same, write_json
from ..sof import Failure, catalogue, diagnose, product_digest, program
from . import answers, causes_score, laws
from .generator import Generator, seed_of
from .ridge import TRAINING, chosen_penalty, ridge_columns, standardised, weights
from .runner import ANSWERS, complete, kept_for

UNCHANGED, RECORDINGS, LABELS = "unchanged.jsonl", "recordings", "labels"
SINGLE, SHAM, PAIR = "single", "sham", "pair"
PATIENCE_S = 300.0            # of one diagnosis
STRETCH_S = 1800.0
STRETCHES = 2                 # of each recording, from its beginning on
# Drives of vehicles, whose charger regulates the voltage, and the capacity of their battery [Ah].
CAPACITY_AH = {"drive_1a": 72.0, "drive_1b": 72.0, "drive_2a": 72.0, "drive_2b": 72.0, "other_car_1": 72.0, "small_car": 60.0}
SMALLEST_Z, LARGEST_Z = 2.0, 32.0
NEAR = 0.15                   # of z's logarithm, that ends the search for a strength
ACCEPTED = 0.4                # the same, of the nearest where nothing is as near
MIN_STRENGTH, MAX_STRENGTH = 0.01, 12.0
LONGEST_STEP = 6.0            # factor from one strength to the next, until the wanted z is between two
SAME_STRENGTH, TRIES = 1e-3, 30  # of a strength's logarithm, and number: ends of the search between the two
NO_Z = 1e-9
ATTEMPTS = 4                  # draws of a case: another stretch, cause and z where the first cannot be had
NORMAL_OVER_MAD = 1.4826      # standard deviation of a normal distribution over its median absolute one
SHAM_LIMIT_V = 4e-3           # laws.neutral adds a tenth of it as noise
# Of instruments: the effect of laws.changed, whose amount at strength 1 this is.
INSTRUMENTS = {"current_offset": 1.0, "time_skew": 0.3}
# The catalogue's effect that belongs to a cause, and that an oracle is given.
EFFECT_OF = {"charge_limit": "charge_acceptance", "slow_dissolution": "charge_acceptance", "slow_diffusion": "acid_transport", "more_gassing": "gassing",
             "early_hydrogen": "gassing", "lost_plates": "ocv_soc", "slow_positive": "charge_transfer", "negative_layer": "second_electrode",
             "corroding_grid": "parameter_drift", "shrinking_surface": "parameter_drift", "loose_contact": "contact_resistance",
             "current_offset": "current_offset", "time_skew": "time_skew"}
# Fewer plates bear more current each: this is true of them, too.
ALSO_TRUE = {"lost_plates": ["acid"]}
PLACEBOS = ("current_offset", "high_rate_depletion", "cpe2")  # a wrong effect, given: the first that is neither true nor named


def kinds_in_turn(counts):
    """Kinds of cases so that every first part of the list has each in its share."""
    places = [((k + 0.5) / count, kind) for kind, count in counts.items() for k in range(count)]
    return [kind for _, kind in sorted(places)]


def plan(seed, counts, mechanisms):
    """Cases under names that report nothing. counts: {kind: number}. Mechanisms take turns in an order of the seed."""
    numbers, cases = dict.fromkeys(counts, 0), []
    orders = {kind: random.Random(seed_of(seed, kind)).sample(sorted(mechanisms), len(mechanisms)) for kind in counts}
    for name, kind in enumerate(kinds_in_turn(counts), 1):
        number, order = numbers[kind], orders[kind]
        numbers[kind] += 1
        first = number % len(order)
        second = (first + 1 + number // len(order) % (len(order) - 1)) % len(order)
        truths = {SINGLE: [order[first]], SHAM: [], PAIR: [order[first], order[second]]}[kind]
        cases.append({"name": f"case_{name:04d}", "kind": kind, "seed": seed_of(seed, kind, number), "mechanisms": truths})
    return cases


def digest_of(cases):
    return hashlib.sha256(json.dumps(cases, sort_keys=True).encode()).hexdigest()


class Yardstick:
    """What circuit and ridge regression leave of a change of a recording, in units of the noise that they leave of the recording itself.

    The noise is first-order correlated, its size that of the median absolute innovation; circuit unpenalised, ridge with the penalty that cross-validation chooses on the unchanged recording.
    """

    def __init__(self, beside):
        self.beside = beside
        x, y = standardised(ridge_columns(beside.t, beside.i)), beside.u - beside.u.mean()
        self.penalty = chosen_penalty(x[beside.training], y[beside.training] - y[beside.training].mean())
        rest = y - x @ weights(x, y, self.penalty)
        self.correlation = float(np.clip((rest[1:] @ rest[:-1]) / (rest @ rest), 0.0, 0.999))
        steps = rest[1:] - self.correlation * rest[:-1]
        self.innovation = float(NORMAL_OVER_MAD * np.median(np.abs(steps - np.median(steps))))  # cranks are outliers
        self.deviation = self.innovation / math.sqrt(1.0 - self.correlation**2)

    def whitened(self, columns):
        return (columns[1:] - self.correlation * columns[:-1]) / self.innovation

    def z(self, current, voltage):
        beside = self.beside
        basis = beside.basis if current is beside.i else laws.columns(beside.t, current)
        error = (voltage - basis @ beside.circuit) - (beside.u - beside.basis @ beside.circuit)
        ridge = standardised(ridge_columns(beside.t, current))
        columns, wanted = self.whitened(np.hstack([basis, ridge])), self.whitened(error)
        held = math.sqrt(len(error) * self.penalty) / self.deviation * np.eye(ridge.shape[1])
        penalties = np.hstack([np.zeros((len(held), basis.shape[1])), held])
        found = np.linalg.lstsq(np.vstack([columns, penalties]), np.concatenate([wanted, np.zeros(len(held))]), rcond=None)[0]
        return float(np.linalg.norm(wanted - columns @ found))


def strengths_from_one(factor):
    """1, and what follows by a factor down to MIN_STRENGTH or up to MAX_STRENGTH."""
    strengths = [1.0]
    while MIN_STRENGTH < strengths[-1] < MAX_STRENGTH:
        strengths.append(min(max(strengths[-1] * factor, MIN_STRENGTH), MAX_STRENGTH))
    return strengths


def strength_of(z_at, wanted):
    """(strength, z) where z_at(strength), which rises on the whole, is near the wanted one. Failure where it does not go that far, or jumps past it."""
    from scipy.optimize import brentq  # takes its time
    tried = {}  # {a strength's logarithm: (z, logarithm of z over the wanted one)}

    def missed(at):
        if at not in tried:
            z = z_at(math.exp(at))
            tried[at] = z, math.log(max(z, NO_Z) / wanted)
        return tried[at][1] if abs(tried[at][1]) > NEAR else 0.0

    way = [math.log(one) for one in strengths_from_one(LONGEST_STEP if missed(0.0) < 0.0 else 1.0 / LONGEST_STEP)]
    ends = next((two for two in itertools.pairwise(way) if missed(two[0]) * missed(two[1]) <= 0.0), None)
    if ends:
        brentq(missed, *ends, xtol=SAME_STRENGTH, maxiter=TRIES, disp=False)
    at, (z, off) = min(tried.items(), key=lambda one: abs(one[1][1]))
    if abs(off) < ACCEPTED:
        return math.exp(at), z
    if not ends:
        raise Failure(f"z {z:.3g} at strength {math.exp(at):.3g}, wanted {wanted:.3g}")
    below, above = max((off, at) for at, (_, off) in tried.items() if off < 0.0), min((off, at) for at, (_, off) in tried.items() if off > 0.0)
    jump = " to ".join(f"{tried[at][0]:.3g} at strength {math.exp(at):.4g}" for _, at in (below, above))
    raise Failure(f"z jumps from {jump}, wanted {wanted:.3g}")


class Bench:
    """Programs, the folder of recordings, and where results are kept."""

    def __init__(self, build, data, out):
        self.sof, self.generator, self.data, self.out = program(build, "sof"), Generator(build), data, out
        kept_for(out, self.sof)
        for folder in (RECORDINGS, LABELS):
            os.makedirs(os.path.join(out, folder), exist_ok=True)
        self.causes = {mechanism: list(names) for mechanism, names in self.generator.causes().items()}
        known = catalogue(self.sof)
        for name in INSTRUMENTS:
            self.causes.setdefault(known.mechanism(name), []).append(name)
        self.unchanged = {row["name"]: row["answer"] for row in lines_of(os.path.join(out, UNCHANGED))}

    def path(self, folder, name, ending):
        return os.path.join(self.out, folder, f"{name}.{ending}")

    @functools.lru_cache(None)
    def stretch(self, recording, part):
        """Half an hour of a recording, and its yardstick; its time begins at 0."""
        t, i, u = recordings.measured(self.data, recording)
        begin = t[0] + part * STRETCH_S
        shown = (t >= begin) & (t < begin + STRETCH_S)
        beside = laws.Beside(t[shown] - t[shown][0], i[shown], u[shown])
        path = self.path(RECORDINGS, f"{recording}_{part}", "csv")
        recordings.write(path, beside.t, beside.i, beside.u)
        return beside, Yardstick(beside), path

    def changed(self, recording, part, strengths):
        """Current and voltage of a stretch with causes in it. strengths: {cause: strength}."""
        beside, _, path = self.stretch(recording, part)
        block = {name: one for name, one in strengths.items() if name not in INSTRUMENTS}
        current, voltage = beside.i, beside.u
        if block:
            out = self.path(RECORDINGS, "changed", "csv")
            self.generator.cause(path, out, block, CAPACITY_AH[recording])
            _, current, voltage = recordings.read(out)
        for name, one in strengths.items():
            if name in INSTRUMENTS:
                current, voltage = laws.changed(name, beside.t, current, voltage, one * INSTRUMENTS[name], None, None)
        return current, voltage

    def drawn(self, case, attempt):
        """The label of a case, and its current and voltage. Failure where a cause does not reach its z."""
        dice = random.Random(seed_of(case["seed"], attempt))
        recording, part = dice.choice(sorted(CAPACITY_AH)), dice.randrange(STRETCHES)
        beside, yardstick, _ = self.stretch(recording, part)
        label = {"kind": case["kind"], "recording": recording, "part": part, "attempt": attempt, "mechanisms": case["mechanisms"]}
        if case["kind"] == SHAM:
            voltage, what = laws.neutral(beside.t, beside.i, beside.u, SHAM_LIMIT_V, case["seed"] % 2**32)
            return dict(label, **what), beside.i, voltage
        causes, strengths = [], {}
        for mechanism in case["mechanisms"]:
            name, wanted = dice.choice(self.causes[mechanism]), math.exp(dice.uniform(math.log(SMALLEST_Z), math.log(LARGEST_Z)))
            sign = dice.choice((-1.0, 1.0)) if name in INSTRUMENTS else 1.0
            found, z = strength_of(lambda one: yardstick.z(*self.changed(recording, part, {name: sign * one})), wanted)
            strengths[name] = sign * found
            causes.append({"id": name, "mechanism": mechanism, "strength": sign * found, "z": z, "wanted": wanted})
        current, voltage = self.changed(recording, part, strengths)
        label["mechanisms"] = sorted({*case["mechanisms"], *(also for name in strengths for also in ALSO_TRUE.get(name, ()))})
        return dict(label, causes=causes, z=yardstick.z(current, voltage)), current, voltage

    def draw(self, case):
        """Writes recording and label of a case; returns the label. Failure where no attempt can be had."""
        path, label, why = self.path(RECORDINGS, case["name"], "csv"), self.path(LABELS, case["name"], "json"), []
        for attempt in range(ATTEMPTS):
            try:
                found, current, voltage = self.drawn(case, attempt)
            except Failure as failure:
                why.append(str(failure))
                continue
            recordings.write(path, self.stretch(found["recording"], found["part"])[0].t, current, voltage)
            write_json(label, dict(found, refused=why))
            return found
        raise Failure("not drawn: " + "; ".join(why))

    def told(self, path, *options):
        return causes_score.essentials(diagnose(self.sof, path, *options, patience_s=PATIENCE_S))

    def before(self, recording, part):
        """The answer to a stretch as it is. Failure where there was none: it is asked for once."""
        name = f"{recording}_{part}"
        if name not in self.unchanged:
            try:
                self.unchanged[name] = self.told(self.stretch(recording, part)[2])
            except Failure as failure:
                self.unchanged[name] = {"failed": str(failure)}
            append(os.path.join(self.out, UNCHANGED), {"name": name, "answer": self.unchanged[name]})
        if "failed" in self.unchanged[name]:
            raise Failure("as it is: " + self.unchanged[name]["failed"])
        return self.unchanged[name]

    def case(self, case):
        """A row: the answer, and of single causes what models leave of the last quarter that are given the effects named
        before, and one more: the true one or a wrong one."""
        label = self.draw(case)
        before, path = self.before(label["recording"], label["part"]), self.path(RECORDINGS, case["name"], "csv")
        row = {"stretch": f"{label['recording']}_{label['part']}", "answer": self.told(path), "mean_v": mean_error(path)}
        if case["kind"] == SINGLE:
            named = [one["id"] for one in before["effects"]]
            row["same"] = self.given(path, named) if named else {"effects": [], "errors": row["answer"]["errors"]["base"]}
            for key, effect in given_effects(label["causes"][0]["id"], named).items():
                row[key] = self.given(path, named, effect)
        return row

    def given(self, path, named, *more):
        """Errors with the effects that are named of the unchanged stretch, and more."""
        effects = list(dict.fromkeys([*named, *more]))
        try:
            return {"effects": effects, "errors": self.told(path, "--given", ",".join(effects))["errors"]["extended"]}
        except Failure as failure:
            return {"effects": effects, "failed": str(failure)}


def given_effects(cause, named):
    """Of an oracle and of its opposite: the cause's own effect, and one that is neither true nor named."""
    true = EFFECT_OF[cause]
    return {"oracle": true, "wrong": next(one for one in PLACEBOS if one != true and one not in named)}


def mean_error(path):
    """RMS [V] on the last quarter about the mean of the voltage before."""
    voltage = recordings.read_plain(path)[2]
    first_held = int(TRAINING * len(voltage))
    return float(np.sqrt(np.mean((voltage[first_held:] - voltage[:first_held].mean()) ** 2)))


def run(bench, cases, minutes):
    """Goes through the plan until it is done or `minutes` have passed; goes on where it was cut off."""
    ends = time.monotonic() + 60.0 * minutes

    def work(case):
        try:
            row = bench.case(case)
        except Failure as failure:
            row = {"failed": str(failure)}
        print("causes:", case["name"], "not answered: " + row["failed"] if "failed" in row else "answered", file=sys.stderr, flush=True)
        return row
    complete(os.path.join(bench.out, ANSWERS), work, cases, enough=lambda rows: time.monotonic() > ends)


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default="build")
    parser.add_argument("--data", required=True, help="folder of the recordings")
    parser.add_argument("--out", required=True, help="folder of cases, labels and answers: a run that was cut off goes on")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=420, help="cases with one cause")
    parser.add_argument("--shams", type=int, default=120, help="cases with nothing but what the circuit takes up whole")
    parser.add_argument("--pairs", type=int, default=84, help="cases with two causes")
    parser.add_argument("--minutes", type=float, default=math.inf, help="end after the case that passes these")
    parser.add_argument("--seal", help="file to write the plan's digest to, in place of a run")
    parser.add_argument("--product", help="with --seal: the commit that the build is of")
    parser.add_argument("--score", action="store_true", help="ask nothing more")
    parser.add_argument("--json", help="file of figures")
    return parser.parse_args(given)


def main(given=None):
    a = arguments(given)
    bench = Bench(a.build, a.data, a.out)
    counts = {SINGLE: a.count, SHAM: a.shams, PAIR: a.pairs}
    cases = plan(a.seed, counts, bench.causes)
    if a.seal:
        write_json(a.seal, {"seed": a.seed, "counts": counts, "plan_sha256": digest_of(cases), "product": a.product, "product_sha256": product_digest(bench.sof)})
        return
    require_same(os.path.join(a.out, "plan.json"), {"cases": cases}, "other cases")
    if not a.score:
        run(bench, cases, a.minutes)
    labels = {case["name"]: read_json(path) for case in cases if os.path.exists(path := bench.path(LABELS, case["name"], "json"))}
    judged, failed = causes_score.cases_of(lines_of(os.path.join(a.out, ANSWERS)), labels, bench.unchanged)
    sys.stdout.write(causes_score.as_markdown(judged, failed))
    if a.json:
        write_json(a.json, causes_score.figures(judged, failed))

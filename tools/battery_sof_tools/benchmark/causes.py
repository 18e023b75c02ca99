"""Puts causes into recordings that were measured, as the difference that each makes of a full physical model, asks `sof diagnose`, and counts (docs/validation.md).

    scripts/causes BUILD --data FOLDER --out DIR [--seed 1] [--count 420] [--shams 120] [--pairs 84] [--minutes M] [--sealed FILE]
    scripts/causes BUILD ... --seal FILE      what is planned and its digest, before anything is asked
    scripts/causes BUILD ... --score          the table of what was asked and sealed

A porous block (`draw_scenario --into RECORDING --cause ID=STRENGTH`) runs along half an hour of a measured current twice, sound and with the
cause; the difference goes into the voltage, and into the current while a charger regulates the voltage. Instruments need no block. What is written is
in the steps of the sensors that measured the recording.
A strength is searched until z is the one drawn, 2 to 32: what of the difference neither the circuit nor a ridge regression takes up, in
units of its standard error under the noise that the two leave of the unchanged recording. Shams hold what the circuit takes up whole.
What is named with the cause and not without it counts. Answers are given to the recording alone, and a run ends with a seal: the digests of answers
and labels. Then --score opens the labels, asks about single causes again with effects given, the true one among others, and makes the table.
A run that goes on breaks its seal and makes another; once labels were opened, nothing more is asked.
"""

import argparse
import functools
import hashlib
import json
import math
import os
import random
import sys
import time

import numpy as np

from .. import recordings
from ..files import append, digest, lines_of, read_json, require_digest, require_same, write_json
from ..sof import Failure, catalogue, diagnose, product_digest, program
from . import causes_score, laws
from .generator import Generator, seed_of
from .ridge import TRAINING, chosen_penalty, ridge_columns, standardised, weights
from .runner import ANSWERS, complete, kept_for

UNCHANGED, GIVEN, SEALED, RECORDINGS, LABELS = "unchanged.jsonl", "given.jsonl", "sealed.json", "recordings", "labels"
DIGESTS = {"answers_sha256": ANSWERS, "unchanged_sha256": UNCHANGED, "labels_sha256": LABELS}  # of a seal
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
    """(strength, z) where z_at(strength), which rises on the whole, is near the wanted one. Failure where it goes less far or jumps past it."""
    from scipy.optimize import brentq  # takes its time
    tried = {}  # {a strength's logarithm: (z, logarithm of z over the wanted one)}

    def missed(at):
        if at not in tried:
            z = z_at(math.exp(at))
            tried[at] = z, math.log(max(z, NO_Z) / wanted)
        return tried[at][1] if abs(tried[at][1]) > NEAR else 0.0

    first = missed(0.0)
    way = [math.log(one) for one in strengths_from_one(LONGEST_STEP if first < 0.0 else 1.0 / LONGEST_STEP)] if first else []
    ends = next((two for two in zip(way, way[1:]) if missed(two[0]) * missed(two[1]) <= 0.0), None)
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

    @functools.cached_property
    def unchanged(self):
        """Answers to stretches as they are, by name."""
        return {row["name"]: row["answer"] for row in lines_of(self.rows(UNCHANGED))}

    def rows(self, name):
        return os.path.join(self.out, name)

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
        """Writes recording and label of a case; of the label returns the stretch alone: recording, part. Failure where no attempt can be had."""
        path, label, why = self.path(RECORDINGS, case["name"], "csv"), self.path(LABELS, case["name"], "json"), []
        for attempt in range(ATTEMPTS):
            try:
                found, current, voltage = self.drawn(case, attempt)
            except Failure as failure:
                why.append(str(failure))
                continue
            beside, seed = self.stretch(found["recording"], found["part"])[0], case["seed"]
            recordings.write(path, beside.t, laws.in_steps(beside.i, current, [seed, 0]), laws.in_steps(beside.u, voltage, [seed, 1]))
            write_json(label, dict(found, refused=why))
            return found["recording"], found["part"]
        raise Failure("not drawn: " + "; ".join(why))

    def told(self, path, *options):
        return causes_score.essentials(diagnose(self.sof, path, *options, patience_s=PATIENCE_S))

    def before(self, recording, part):
        """Asks about a stretch as it is, once. Failure where there was no answer."""
        name = f"{recording}_{part}"
        if name not in self.unchanged:
            try:
                self.unchanged[name] = self.told(self.stretch(recording, part)[2])
            except Failure as failure:
                self.unchanged[name] = {"failed": str(failure)}
            append(self.rows(UNCHANGED), {"name": name, "answer": self.unchanged[name]})
        if "failed" in self.unchanged[name]:
            raise Failure("as it is: " + self.unchanged[name]["failed"])

    def answered(self, case):
        """A row: the answer to the recording alone, and which stretch is its unchanged one."""
        recording, part = self.draw(case)
        self.before(recording, part)
        path = self.path(RECORDINGS, case["name"], "csv")
        return {"stretch": f"{recording}_{part}", "answer": self.told(path), "mean_v": mean_error(path)}

    def with_effects(self, row, cause):
        """What models leave of a single cause's last quarter that are given the effects named before, and one more: the true one or a wrong one."""
        path, named = self.path(RECORDINGS, row["name"], "csv"), [one["id"] for one in self.unchanged[row["stretch"]]["effects"]]
        same = self.given(path, named) if named else {"effects": [], "errors": row["answer"]["errors"]["base"]}
        return {"same": same, **{key: self.given(path, named, effect) for key, effect in given_effects(cause, named).items()}}

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


def labels_of(bench, cases):
    """{name of a case: path of its label}, where there is one."""
    return {case["name"]: path for case in cases if os.path.exists(path := bench.path(LABELS, case["name"], "json"))}


def files_of(bench, cases, name):
    """What there is of answers or labels."""
    return list(labels_of(bench, cases).values()) if name == LABELS else [path for path in [bench.rows(name)] if os.path.exists(path)]


def seal(bench, cases, path):
    """Writes the digests of what was drawn and answered."""
    said = {"plan_sha256": digest_of(cases), "asked": len(lines_of(bench.rows(ANSWERS)))}
    said.update({key: digest(*files_of(bench, cases, name)) for key, name in DIGESTS.items()})
    write_json(path, said)
    print(f"answers: {said['asked']} of {len(cases)}, SHA-256 {said['answers_sha256']}, sealed in {path}")


def require_sealed(bench, cases, path):
    """SystemExit where nothing is sealed, or what is sealed has changed."""
    if not os.path.exists(path):
        raise SystemExit(f"{path} is missing: no answers are sealed yet; a run without --score seals them when it ends")
    said = read_json(path)
    if said.get("plan_sha256") != digest_of(cases):
        raise SystemExit(f"{path} does not seal answers to this plan")
    for key, name in DIGESTS.items():
        require_digest(bench.rows(name), said.get(key), path, *files_of(bench, cases, name))


def break_seal(bench, cases, path):
    """Before a run goes on. SystemExit where labels were opened, or what is sealed has changed."""
    if os.path.exists(bench.rows(GIVEN)):
        raise SystemExit(f"{bench.out}: the labels were opened, so nothing more is asked; --score makes the table again")
    if os.path.exists(path):
        require_sealed(bench, cases, path)
        os.remove(path)


def reported(work, done):
    """The same work, with a word about each case on standard error."""
    def with_word(case):
        try:
            row = work(case)
        except Failure as failure:
            row = {"failed": str(failure)}
        print("causes:", case["name"], f"not {done}: {row['failed']}" if "failed" in row else done, file=sys.stderr, flush=True)
        return row
    return with_word


def run(bench, cases, minutes, sealed):
    """Goes through the plan until it is done or `minutes` have passed, then seals; goes on where it was cut off. No label is read."""
    break_seal(bench, cases, sealed)
    ends = time.monotonic() + 60.0 * minutes
    complete(bench.rows(ANSWERS), reported(bench.answered, "answered"), cases, timed=False, enough=lambda rows: time.monotonic() > ends)
    seal(bench, cases, sealed)


def opened(bench, cases, sealed):
    """Judged cases and what failed, of sealed answers. What is told the truth is asked here: it goes on where it was cut off."""
    require_sealed(bench, cases, sealed)
    with open(bench.rows(GIVEN), "a"):
        pass  # from here on labels are read
    labels = {name: read_json(path) for name, path in labels_of(bench, cases).items()}
    rows = {row["name"]: row for row in lines_of(bench.rows(ANSWERS))}
    single = [case for case in cases if case["kind"] == SINGLE and "answer" in rows.get(case["name"], {})]
    def work(case):
        return bench.with_effects(rows[case["name"]], labels[case["name"]]["causes"][0]["id"])
    given = complete(bench.rows(GIVEN), reported(work, "given effects"), single)
    return causes_score.cases_of([{**given.get(name, {}), **row} for name, row in rows.items()], labels, bench.unchanged)


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default="build")
    parser.add_argument("--data", required=True, help="folder of the recordings")
    parser.add_argument("--out", required=True, help="folder of cases, labels and answers: what was cut off goes on")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=420, help="cases with one cause")
    parser.add_argument("--shams", type=int, default=120, help="cases with nothing but what the circuit takes up whole")
    parser.add_argument("--pairs", type=int, default=84, help="cases with two causes")
    parser.add_argument("--minutes", type=float, default=math.inf, help="end asking after the case that passes these, and seal what there is")
    parser.add_argument("--seal", help="file to write the plan's digest to, in place of a run")
    parser.add_argument("--product", help="with --seal: the commit that the build is of")
    parser.add_argument("--sealed", help="file of the answers' seal, in place of DIR/" + SEALED)
    parser.add_argument("--score", action="store_true", help="ask about no further case: open the labels of what is sealed, and make the table")
    parser.add_argument("--json", help="with --score: file of figures")
    chosen = parser.parse_args(given)
    if chosen.json and not chosen.score:
        parser.error("--json goes with --score")
    return chosen


def main(given=None):
    a = arguments(given)
    bench = Bench(a.build, a.data, a.out)
    counts = {SINGLE: a.count, SHAM: a.shams, PAIR: a.pairs}
    cases = plan(a.seed, counts, bench.causes)
    if a.seal:
        write_json(a.seal, {"seed": a.seed, "counts": counts, "plan_sha256": digest_of(cases), "product": a.product, "product_sha256": product_digest(bench.sof)})
        return
    require_same(os.path.join(a.out, "plan.json"), {"cases": cases}, "other cases")
    sealed = a.sealed or bench.rows(SEALED)
    if not a.score:
        run(bench, cases, a.minutes, sealed)
        return
    judged, failed = opened(bench, cases, sealed)
    sys.stdout.write(causes_score.as_markdown(judged, failed))
    write_json(a.json, causes_score.figures(judged, failed))

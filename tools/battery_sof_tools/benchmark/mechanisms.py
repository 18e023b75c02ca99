"""Trains the table that `sof diagnose` weighs mechanisms by (src/diagnosis/mechanism_weights.inc; docs/validation.md).

    scripts/train_mechanisms --build B --out DIR [--seed 35] [--jobs 2] [--table FILE]

Draws recordings of every out-of-catalogue law and of the catalogue's effects, their drives independent of what is added, takes what
`mechanism_evidence` says of each, and fits a softmax of seven numbers a mechanism. Every law is judged by a table that never saw it.
"""

import argparse
import functools
import json
import os
import random

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from ..files import lines_of, read_json, write_text
from ..sof import catalogue, program, run
from ..tables import table
from .generator import Generator, seed_of
from .out_of_model import LABELS, RECORDINGS, draw_missing, path
from .runner import complete

EVIDENCE = "evidence.jsonl"
LAW = "out_of_catalogue"
CATALOGUE = ("effect", "instrument_fault")
FAULTS_OF_SAMPLING = ("quantisation", "dropouts", "clipping", "aliasing")  # the instrument screen finds them
BEHIND_CHARGER = ("fresh_sulphate",)  # weighed by the blocks that it predicts, not by this table
EVIDENT = 12.0  # ln evidence by which something must be missing at all (kMinGain)
RIDGE, OWN = 3.0, 0.7  # of weights of unit inputs; how freely a mechanism's weights leave those of all
SET = 0.9
LAWS, EFFECTS = 11, 5  # cases of every out-of-catalogue law, of every effect of the catalogue
SHORTEST_S, USUALLY_LONGEST_S, LONGEST_S = 80.0, 1200.0, 3600.0
WEIGHED_FROM_S = 160.0  # the table of the repository was fitted to recordings of this length and more
JUDGED = ["", "cases", "right", "0.7 and more", "0.9 and more", "set of 0.9 has it", "mean size"]


def with_drive(added, seed, longest):
    """A case with the seed, length [s] and rate [Hz] of its drive, which is independent of what is added."""
    dice = random.Random(seed)
    return dict(added, seed=seed, independent_drive=True, duration=round(SHORTEST_S * (longest / SHORTEST_S) ** dice.random()), rate=dice.choice([1, 10, 10, 100]))


def plan(listed, seed):
    """Cases in turns over all that can be added, so that any first part of them is balanced. The first of each lasts up to an hour."""
    cases = []
    for kind, mechanism, name in listed:
        added = {"kind": kind, "id": name, **({"mechanism": mechanism} if kind == LAW else {})}
        count = LAWS if kind == LAW else EFFECTS if kind in CATALOGUE and name not in FAULTS_OF_SAMPLING + BEHIND_CHARGER else 0
        for k in range(count):
            cases.append(with_drive(dict(added, round=k / count), seed_of(seed, *added.values(), k), LONGEST_S if k == 0 else USUALLY_LONGEST_S))
    cases.sort(key=lambda one: one["round"])
    return [dict(case, name=f"case_{k:04d}") for k, case in enumerate(cases, 1)]


def evidence_of(extractor, out, case):
    """What the program says of a recording, {mechanism: [alone, lost, effect]}."""
    return json.loads(run([extractor, path(out, RECORDINGS, case["name"], "csv")]))


def gather(a, cases):
    """Evidence of every case, kept: a run that was cut off goes on."""
    work = functools.partial(evidence_of, program(a.build, "mechanism_evidence"), a.out)
    long_enough = [case for case in cases if case["duration"] >= WEIGHED_FROM_S]
    complete(os.path.join(a.out, EVIDENCE), work, long_enough, a.jobs, "weighed", timed=False)


def numbers_of(evidence):
    """Inputs of the softmax, mechanisms x 6: as numbersOf() of mechanism_evidence.cpp."""
    columns = []
    for part in np.asarray(evidence).T:
        below = part - part.max()
        columns += [np.sign(below) * np.log1p(abs(below)), part / max(part.max(), 1.0)]
    return np.array(columns).T


def evident(out, mechanisms):
    """{case: evidence} of the cases in which something is evident."""
    found = {row["name"]: np.array([row[one] for one in mechanisms]) for row in lines_of(os.path.join(out, EVIDENCE)) if "failed" not in row}
    return {name: evidence for name, evidence in found.items() if evidence[:, [0, 2]].max() >= EVIDENT}


def opened(out, known):
    """Inputs, mechanism and law of every case in which something is evident."""
    cases = evident(out, known.mechanisms)
    labels = [read_json(path(out, LABELS, name, "json")) for name in cases]
    truths = [known.mechanisms.index(label["mechanism"] if label["kind"] == LAW else known.mechanism(label["id"])) for label in labels]
    return np.array(list(map(numbers_of, cases.values()))), np.array(truths), np.array([f"{label['kind']} {label['id']}" for label in labels])


def softmax(scores):
    shares = np.exp(scores - scores.max(axis=1, keepdims=True))
    return shares / shares.sum(axis=1, keepdims=True)


def fitted(inputs, truths, weight):
    """Weights and bias of every mechanism, mechanisms x 7: Newton on the penalised likelihood. Each mechanism counts alike."""
    cases, count, numbers = inputs.shape
    unit = inputs.reshape(-1, numbers).std(axis=0)
    columns = np.zeros((cases, count, numbers + count * (numbers + 1)))
    columns[:, :, :numbers] = inputs / unit
    for k in range(count):
        own = numbers + k * (numbers + 1)
        columns[:, k, own:own + numbers] = OWN * inputs[:, k] / unit
        columns[:, k, own + numbers] = 1.0
    for k in range(count):
        weight = np.where(truths == k, weight * cases / count / max(weight[truths == k].sum(), 1e-9), weight)
    found = np.zeros(columns.shape[2])
    for _ in range(50):
        shares = softmax(columns @ found)
        mean = np.einsum("nk,nkf->nf", shares, columns)
        slope = weight @ (mean - columns[np.arange(cases), truths]) + RIDGE * found
        spread = columns - mean[:, None]
        flat = (spread * np.sqrt(weight[:, None] * shares)[:, :, None]).reshape(-1, len(found))
        step = np.linalg.solve(flat.T @ flat + RIDGE * np.eye(len(found)), slope)
        found -= step
        if abs(step).max() < 1e-7:
            break
    own = found[numbers:].reshape(count, numbers + 1)
    return np.hstack([(found[:numbers] + OWN * own[:, :numbers]) / unit, own[:, numbers:]])


def probabilities(weights, inputs):
    return softmax(np.einsum("nkf,kf->nk", inputs, weights[:, :-1]) + weights[:, -1])


def weights_of(laws):
    """An effect of the catalogue counts half: it is one of many equations of its mechanism."""
    return np.where(np.char.startswith(laws, LAW), 1.0, 0.5)


def left_out(inputs, truths, laws, folds):
    """Probabilities of every case by a table and a temperature that saw none of its fold's laws. folds: {law: fold}."""
    fold = np.array([folds[law] for law in laws])
    shares = np.zeros(inputs.shape[:2])
    for one in sorted(set(folds.values())):
        mine, others = fold == one, (inputs[fold != one], truths[fold != one], laws[fold != one])
        shares[mine] = sharpened(probabilities(fitted(*others[:2], weights_of(others[2])), inputs[mine]), exponent_of(*others))
    return shares


def exponent_of(inputs, truths, laws):
    """The largest exponent at which the set of SET holds the truth of as many laws, each by a table that did not see it."""
    shares = np.zeros(inputs.shape[:2])
    for law in sorted(set(laws)):
        mine = laws == law
        shares[mine] = probabilities(fitted(inputs[~mine], truths[~mine], weights_of(laws[~mine])), inputs[mine])
    some = np.char.startswith(laws, LAW)
    return max((one for one in np.arange(0.5, 2.01, 0.05) if held_by_set(sharpened(shares[some], one), truths[some])[0].mean() >= SET), default=0.5)


def sharpened(shares, exponent):
    """Probabilities at another temperature, one over the exponent."""
    return softmax(exponent * np.log(shares + 1e-12))


def held_by_set(shares, truths):
    """Whether the set of SET holds the truth, and its size, of every case."""
    order = np.argsort(-shares, axis=1)
    size = 1 + (np.cumsum(np.take_along_axis(shares, order, axis=1), axis=1) < SET).sum(axis=1).clip(max=shares.shape[1] - 1)
    return (order == truths[:, None]).argmax(axis=1) < size, size


def judged(title, shares, truths):
    """A row of the table of judgements."""
    holds, size = held_by_set(shares, truths)
    sure, right = shares.max(axis=1), shares.argmax(axis=1) == truths
    stated = [f"{100 * (sure >= least).mean():.0f} %, {100 * right[sure >= least].mean() if (sure >= least).any() else 0:.0f} % right" for least in (0.7, 0.9)]
    return (title, str(len(truths)), f"{100 * right.mean():.0f} %", *stated, f"{100 * holds.mean():.0f} %", f"{size.mean():.1f}")


def train(a, known):
    """Judges by laws left out, calibrates, fits to all and writes the table."""
    inputs, truths, laws = opened(a.out, known)
    names = sorted(set(laws))
    alone = left_out(inputs, truths, laws, {law: k for k, law in enumerate(names)})
    halves = left_out(inputs, truths, laws, {law: k % 2 for k, law in enumerate(names)})
    is_law = np.char.startswith(laws, LAW)
    rows = []
    for title, some in (("laws", is_law), ("effects of the catalogue", ~is_law)):
        for how, shares in (("one law left out", alone), ("half of the laws left out", halves)):
            rows.append(judged(f"{title}, {how}", shares[some], truths[some]))
    print("\n".join(table(JUDGED, rows)))
    if a.table:
        weights = exponent_of(inputs, truths, laws) * fitted(inputs, truths, weights_of(laws))
        rows = ["{" + ", ".join(f"{value:.3f}" for value in row) + f"}},  // {name}" for row, name in zip(weights, known.mechanisms)]
        about = "// Made by scripts/train_mechanisms: weights of alone, its share, lost, its share, effect, its share; bias."
        write_text(a.table, "\n".join([about, "{{", *rows, "}}", ""]))


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default="build", help="folder of the build")
    parser.add_argument("--out", required=True, help="folder of cases")
    parser.add_argument("--seed", type=int, default=35)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--table", help="file to write: src/diagnosis/mechanism_weights.inc")
    return parser.parse_args(given)


def main(given=None):
    a = arguments(given)
    generator = Generator(a.build)
    gather(a, draw_missing(generator, a.out, a.jobs, plan(generator.listed(), a.seed)))
    train(a, catalogue(program(a.build, "sof")))

"""Puts laws that no catalogue has into recordings that were measured, asks `sof diagnose`, and counts (docs/validation.md).

    proof_real BUILD --data FOLDER --out DIR [--count 200] [--minutes 30] [--seed 1] [--only RECORDING,...]
    proof_real BUILD --data FOLDER --out DIR --promised [--plain] [--only RECORDING,...]

The laws are those of `draw_scenario`, beside the recording's own current, so strong that what other parameters of the base circuit leave of them
is at least twice what the diagnosis of the unchanged recording calls too small to tell. Named is what is named with the law and not without.
With --promised the catalogue's own effects are put in, at the least strength that the answer to the unchanged recording lists (`detection_limits`).
At zero strength only what the base circuit takes up whole is changed. One row a case in DIR/answers.jsonl: a run that was cut off goes on.
"""

import argparse
import collections
import functools
import glob
import math
import os
import random
import sys
import tempfile
import time

from .. import recordings
from ..files import append, lines_of, require_same
from ..rates import wilson
from ..recordings import MEASURED
from ..sof import Failure, catalogue, program
from ..tables import table
from . import answers, laws, scorers
from .generator import Generator, seed_of
from .runner import ANSWERS, complete, diagnose_samples, kept_for

UNCHANGED = "unchanged.jsonl"
PATIENCE_S = 300.0  # of one diagnosis
ZERO = "zero"
ZEROS_A_ROUND = 2
# The cell is none of lead and acid: no lead-acid mechanism is promised of it.
NO_EFFECTS = ("leaf_cell",)
# Effects of the catalogue that are put in at a promised strength, by equations of their own (laws.py).
PROMISED = ("acid_transport", "ocv_soc", "high_rate_depletion", "contact_resistance", "voltage_drift", "current_offset", "time_skew")
INSTANT_SHARE = 0.35   # of all charge has passed when a contact changes
LONGEST_S = 3600.0     # of a stretch that is shown, from its beginning
SLOW_S = 86400.0       # the same where samples are seconds apart
SLOW_INTERVAL_S = 2.0
INSTRUMENT, LONGEST_INSTRUMENT_S = "instrument", 10800.0  # as draw_scenario --into takes them


def rounds(seed, forms, only=(), without_answer=()):
    """Cases without end, in rounds: every recording with every mechanism once and ZEROS_A_ROUND times with none, in an order of the seed.

    A case's name reports its place in the plan; the form of a mechanism is another every round.
    without_answer: recordings that were asked about as they are and got none; a round of these alone is not begun.
    """
    shown = [one for one in MEASURED if not only or one in only]
    number = 0
    while set(shown) - set(without_answer):
        cases = list(one_round(number, seed, number, shown, [(kind, kind) for kind in sorted(forms)]))
        random.Random(seed_of(seed, number)).shuffle(cases)
        yield from cases
        number += 1


def promised(seed, known, only=(), names=MEASURED):
    """Cases of one round: every recording with each of PROMISED, at the strength that its own answer calls the least to be reported, and ZEROS_A_ROUND times with none."""
    shown = [one for one in names if not only or one in only]
    for case in one_round("promised", seed, 0, shown, [(known.mechanism(effect), effect) for effect in PROMISED]):
        effect = case["name"].split("/")[2]
        yield case if case["kind"] == ZERO else dict(case, effect=effect, tau_s=known.times.get(effect))


def one_round(title, seed, turn, shown, added):
    """Every recording ZEROS_A_ROUND times with nothing in it and once with each of added: (kind, its name in the case's)."""
    for recording in shown:
        kinds = [(ZERO, f"{ZERO}/{place}") for place in range(ZEROS_A_ROUND)] + ([] if recording in NO_EFFECTS else added)
        for kind, word in kinds:
            name = f"{title}/{recording}/{word}"
            yield {"name": name, "recording": recording, "kind": kind, "seed": seed_of(seed, name), "turn": turn}


def forms_in_turn(case, forms):
    """The forms of a case's mechanism, beginning with the one whose turn it is on this recording."""
    mine = forms[case["kind"]]
    first = (case["turn"] + list(MEASURED).index(case["recording"])) % len(mine)
    return mine[first:] + mine[:first]


def stretch(t):
    """How many of the first samples are shown."""
    slow = len(t) > 1 and (t[-1] - t[0]) / (len(t) - 1) > SLOW_INTERVAL_S
    return int((t - t[0] <= (SLOW_S if slow else LONGEST_S)).sum())


def essentials(diagnosis):
    """What is kept of an answer: what every benchmark keeps, and what the answer says could be reported."""
    return dict(answers.essentials(diagnosis), limit_v=diagnosis["relevance"]["limits"]["rmse_v"],
                promised={one["id"]: one["strength"] for one in diagnosis["detection_limits"] if one["strength"] is not None})


class NotDrawn(Exception):
    """Nothing could be put in; the arguments say why."""


class Bench:
    """Programs, the folder of recordings, and where results are kept.

    plain: the folder holds CSV files (time_s, current_a, voltage_v) under any names, in place of the recordings that were measured.
    """

    def __init__(self, build, data, out, plain=False):
        self.sof, self.generator, self.data, self.out, self.plain = program(build, "sof"), Generator(build), data, out, plain
        kept_for(out, self.sof)
        self.unchanged = unchanged_in(out)
        self.without_answer = {name for name, answer in self.unchanged.items() if "failed" in answer}
        self.forms = self.generator.laws()

    @functools.lru_cache(1)
    def recording(self, name):
        """The stretch of a recording that is shown; its time begins at 0."""
        t, i, u = recordings.read(os.path.join(self.data, name + ".csv")) if self.plain else recordings.measured(self.data, name)
        count = stretch(t)
        return laws.Beside(t[:count] - t[0], i[:count], u[:count])

    def told(self, *samples):
        return essentials(diagnose_samples(self.sof, samples, PATIENCE_S))

    def before(self, name):
        """The answer to the recording as it is. Failure where there was none: it is asked for once."""
        if name not in self.unchanged:
            beside = self.recording(name)
            try:
                self.unchanged[name] = self.told(beside.t, beside.i, beside.u)
            except Failure as failure:
                self.unchanged[name] = {"failed": str(failure)}
                self.without_answer.add(name)
            append(os.path.join(self.out, UNCHANGED), {"name": name, "answer": self.unchanged[name]})
        if "failed" in self.unchanged[name]:
            raise Failure("as it is: " + self.unchanged[name]["failed"])
        return self.unchanged[name]

    def case(self, case):
        """A row: the case, what was put in, and the answer; or why there is none."""
        before, beside = self.before(case["recording"]), self.recording(case["recording"])
        try:
            drawn, current, voltage = self.changed(case, before, beside)
        except NotDrawn as reasons:
            return dict(case, not_drawn=list(reasons.args))
        shown = laws.in_steps(beside.i, current, [case["seed"], 0]), laws.in_steps(beside.u, voltage, [case["seed"], 1])
        return dict(case, drawn=drawn, answer=self.told(beside.t, *shown))

    def changed(self, case, before, beside):
        """What is put in, and current and voltage with it."""
        if case["kind"] == ZERO:
            voltage, drawn = laws.neutral(beside.t, beside.i, beside.u, before["limit_v"], case["seed"])
            return drawn, beside.i, voltage
        if "effect" in case:  # at the least strength that the answer to the unchanged recording calls enough
            strength = before["promised"].get(case["effect"])
            if strength is None:
                raise NotDrawn(f"{case['effect']} would be reported at no strength, or is reported")
            instant = laws.instant_of_throughput(beside.t, beside.i, INSTANT_SHARE)
            shown = laws.changed(case["effect"], beside.t, beside.i, beside.u, strength, case["tau_s"], instant)
            return {"form": case["effect"], "strength": strength}, *shown
        if case["kind"] == INSTRUMENT and beside.t[-1] > LONGEST_INSTRUMENT_S:
            raise NotDrawn(f"a law of an instrument takes at most {LONGEST_INSTRUMENT_S:g} s")
        return self.law(case, beside, laws.PROMISED * before["limit_v"])

    def law(self, case, beside, wanted):
        """The first form of the mechanism that shows as it should."""
        why = []
        with tempfile.TemporaryDirectory(prefix="real_") as folder:
            path = os.path.join(folder, "measured.csv")
            recordings.write(path, beside.t, beside.i, beside.u)
            for form in forms_in_turn(case, self.forms):
                law = {"mechanism": case["kind"], "form": form, "seed": case["seed"]}
                try:
                    strength, shown, current, voltage = laws.with_strength(self.generator, beside, path, law, wanted, folder)
                except Failure as failure:
                    why.append(str(failure))
                    continue
                return {"form": form, "strength": strength, "visible_v": shown[0], "visible_held_v": shown[1], "wanted_v": wanted}, current, voltage
        raise NotDrawn(*why)


def said_of(row):
    """A row in one line, as the run goes on."""
    answer = row.get("answer", {})
    said = (row["name"], row.get("drawn", {}).get("form", ""), answer.get("verdict", "no answer"), *(answers.mechanisms_of(answer, None) if answer else ()))
    print("proof_real:", *said, file=sys.stderr, flush=True)


def run(bench, seed, count, minutes, only=(), known=None, say=said_of):
    """Goes through the plan until `count` cases are asked or `minutes` have passed; goes on where it was cut off.

    known: the catalogue whose effects are put in at promised strengths, in place of laws.
    """
    ends = time.monotonic() + 60.0 * minutes
    require_same(os.path.join(bench.out, "seed.json"), seed, "cases of another seed")
    names = sorted(path[:-len(".csv")] for path in glob.glob("*.csv", root_dir=bench.data)) if bench.plain else MEASURED
    if not names:
        raise SystemExit(f"{bench.data}: no folder of recordings, expected CSV files (time_s, current_a, voltage_v)")
    cases = list(promised(seed, known, only, names)) if known else rounds(seed, bench.forms, only, bench.without_answer)

    def work(case):
        try:
            row = bench.case(case)
        except Failure as failure:
            row = dict(case, failed=str(failure))
        say(row)
        return row
    complete(os.path.join(bench.out, ANSWERS), work, cases,
             enough=lambda rows: sum("answer" in row for row in rows.values()) >= count or time.monotonic() > ends)


def unchanged_in(out):
    return {row["name"]: row["answer"] for row in lines_of(os.path.join(out, UNCHANGED))}


class Case(answers.Case):
    """A row beside the answer to the recording without anything in it: what counts as named is what is named with it and not without."""

    def __init__(self, row, unchanged):
        super().__init__(row, row["answer"])
        self.before, self.said_before = unchanged, answers.mechanisms_of(unchanged, None)
        self.truth = None if row["kind"] == ZERO else row["kind"]

    @property
    def truths(self):
        return {self.truth}

    @property
    def said(self):
        return {mechanism: p for mechanism, p in super().said.items() if mechanism not in self.said_before}

    @property
    def judged(self):
        """Whether the mechanism can be newly named: it was not before."""
        return self.truth is not None and self.truth not in self.said_before

    @property
    def outcome(self):
        """right, beside, wrong or missed, of what is newly named; missed: the answer is the same as without."""
        return answers.outcome("unknown", self.said, self.truths) if self.said else "missed"

    @property
    def part(self):
        """Named, or accepted as a part of what is unknown."""
        now, before = ({one["mechanism"] for one in answer["candidates"] if not one["rejected_because"]} for answer in (self.answer, self.before))
        return self.truth in self.said or self.truth in now - before


def cases_of(rows, unchanged):
    """Cases, what could not be drawn, and what failed."""
    cases = [Case(row, unchanged[row["recording"]]) for row in rows if "answer" in row]
    return cases, [row for row in rows if "not_drawn" in row], [row for row in rows if "failed" in row]


def share(right, cases):
    return scorers.share(right, cases, wilson)


def figures(cases):
    """(what, figure, aim)"""
    zero, put_in = [one for one in cases if one.truth is None], [one for one in cases if one.truth]
    judged = [one for one in put_in if one.judged]
    return [
        ("zero: nothing new named", share(lambda one: not one.said, zero), ">= 95 %"),
        ("zero: the verdict is as without", share(lambda one: one.verdict == one.before["verdict"], zero), ""),
        ("put in: its mechanism newly named", share(lambda one: one.truth in one.said, judged), ">= 90 %"),
        ("of these with another beside it", share(lambda one: one.outcome == "beside", judged), ""),
        ("put in: only another mechanism newly named", share(lambda one: one.outcome == "wrong", judged), ""),
        ("put in: nothing new named", share(lambda one: one.outcome == "missed", judged), ""),
        ("put in: its mechanism newly named or a new part of what is unknown", share(lambda one: one.part, judged), ""),
        ("not judged, its mechanism is named without it too", f"{len(put_in) - len(judged)} of {len(put_in)}", ""),
        ("of these still named", share(lambda one: one.truth in answers.mechanisms_of(one.answer, None), [one for one in put_in if not one.judged]), "")]


def as_markdown(rows, unchanged):
    cases, not_drawn, failed = cases_of(rows, unchanged)
    with_law = [one for one in cases if one.truth]
    lines = [f"{len(cases)} cases: {len(with_law)} with a law in them, {len(cases) - len(with_law)} at zero; {len(not_drawn)} could not be drawn, {len(failed)} failed.", ""]
    lines += table(["figure", "measured (95 %, Wilson)", "aim"], figures(cases)) + [""]
    lines += table(["recording as it is", "verdict", "mechanisms", "too small to tell, below [mV]"],
                   [(name, answer["verdict"], ", ".join(answers.mechanisms_of(answer, None)), f"{1e3 * answer['limit_v']:.1f}")
                    for name, answer in sorted(unchanged.items()) if "failed" not in answer])
    missing = collections.Counter((row["recording"], row["kind"]) for row in not_drawn)
    if missing:
        lines += ["", "Could not be drawn: " + ", ".join(f"{kind} in {name} {k}" for (name, kind), k in sorted(missing.items())) + "."]
    return "\n".join(lines + [f"Failed: {row['name']}: {row['failed']}" for row in failed]) + "\n"


def arguments(given):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", nargs="?", default="build")
    parser.add_argument("--data", help="folder of the recordings")
    parser.add_argument("--out", default="build/proof_real", help="folder of the rows")
    parser.add_argument("--count", type=int, default=200, help="cases that are asked about")
    parser.add_argument("--minutes", type=float, default=math.inf, help="end after the case that passes these")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="recordings, comma-separated")
    parser.add_argument("--promised", action="store_true", help="effects of the catalogue, each at the least strength that a diagnosis of the unchanged recording promises to tell")
    parser.add_argument("--plain", action="store_true", help="with --promised: the recordings are all FOLDER/*.csv (time_s, current_a, voltage_v), such as simulated ones that lack nothing")
    return parser.parse_args(given)


def main(given=None):
    a = arguments(given)
    if not a.data:
        raise SystemExit("--data is missing: the folder of the recordings")
    if a.plain and not a.promised:
        raise SystemExit("--plain goes with --promised alone: laws are put into the recordings that were measured")
    run(Bench(a.build, a.data, a.out, a.plain), a.seed, a.count, a.minutes, [one for one in a.only.split(",") if one],
        catalogue(program(a.build, "sof")) if a.promised else None)
    sys.stdout.write(as_markdown(lines_of(os.path.join(a.out, ANSWERS)), unchanged_in(a.out)))

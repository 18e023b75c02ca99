#!/usr/bin/env python3
"""Causes put into measured recordings: the plan, the search for a strength, what is left of a difference, and the scoring."""

import collections
import contextlib
import io
import math
import os
import tempfile
import unittest
from unittest import mock

import numpy as np

from battery_sof_tools import recordings
from battery_sof_tools.benchmark import causes, causes_score, laws
from battery_sof_tools.files import digest, read_json, write_json
from battery_sof_tools.sof import Failure

MECHANISMS = ["acceptance", "acid", "ageing", "structure"]


class Plan(unittest.TestCase):
    def test_every_first_part_has_each_kind_in_its_share(self):
        kinds = causes.kinds_in_turn({"single": 70, "sham": 20, "pair": 14})
        self.assertEqual(collections.Counter(kinds), {"single": 70, "sham": 20, "pair": 14})
        self.assertEqual(collections.Counter(kinds[:52]), {"single": 35, "sham": 10, "pair": 7})

    def test_mechanisms_take_turns_and_a_pair_has_two(self):
        cases = causes.plan(3, {"single": 8, "sham": 2, "pair": 12}, MECHANISMS)
        self.assertEqual(cases, causes.plan(3, {"single": 8, "sham": 2, "pair": 12}, MECHANISMS[::-1]))
        single = collections.Counter(one["mechanisms"][0] for one in cases if one["kind"] == "single")
        self.assertEqual(single, dict.fromkeys(MECHANISMS, 2))
        pairs = {tuple(one["mechanisms"]) for one in cases if one["kind"] == "pair"}
        self.assertEqual(len(pairs), 12)
        self.assertTrue(all(first != second for first, second in pairs))
        self.assertEqual(len({one["seed"] for one in cases}), len(cases))
        self.assertNotEqual(causes.digest_of(cases), causes.digest_of(causes.plan(4, {"single": 8, "sham": 2, "pair": 12}, MECHANISMS)))


class Strength(unittest.TestCase):
    def test_is_searched_until_z_is_near(self):
        strength, z = causes.strength_of(lambda one: 2.0 * one ** 0.8, 12.0)
        self.assertAlmostEqual(z, 2.0 * strength ** 0.8)
        self.assertLess(abs(z / 12.0 - 1.0), 0.2)

    def test_is_found_where_z_rises_so_steeply_that_proportional_steps_go_over_and_back(self):
        for wanted in (2.1, 4.0, 6.0):
            strength, z = causes.strength_of(lambda one: 9.0 * math.exp(0.7 * (one - 12.0)), wanted)  # a gas current by its voltage
            self.assertLess(abs(math.log(z / wanted)), causes.NEAR)
            self.assertAlmostEqual(z, 9.0 * math.exp(0.7 * (strength - 12.0)))
        self.assertAlmostEqual(causes.strength_of(lambda one: one ** 40.0, 1e-6)[0], 1e-6 ** (1.0 / 40.0), delta=0.01)

    def test_a_strength_of_one_is_taken_where_it_does(self):
        asked = []
        self.assertEqual(causes.strength_of(lambda one: asked.append(one) or 11.5, 12.0), (1.0, 11.5))
        self.assertEqual(asked, [1.0])

    def test_asks_for_few_z_within_the_bounds(self):
        for z_at in (lambda one: 2.0 * one ** 0.8, lambda one: 1e-4 * one ** 5.0, lambda one: 1e4 * one ** 2.0):
            asked = []
            causes.strength_of(lambda one: asked.append(one) or z_at(one), 12.0)
            self.assertLessEqual(len(asked), 10)
            self.assertEqual(len(set(asked)), len(asked))
            self.assertTrue(all(0.999 * causes.MIN_STRENGTH < one < 1.001 * causes.MAX_STRENGTH for one in asked))

    def test_a_jump_ends_at_what_is_accepted_beside_it_or_is_named(self):
        strength, z = causes.strength_of(lambda one: 3.0 if one < 2.5 else 30.0, 4.0)
        self.assertEqual(z, 3.0)
        self.assertLess(strength, 2.5)
        with self.assertRaisesRegex(Failure, "z jumps from 3 at strength 2.*to 30 at strength 2.5.*, wanted 9"):
            causes.strength_of(lambda one: 3.0 if one < 2.5 else 30.0, 9.0)

    def test_a_cause_that_does_not_go_that_far_is_refused(self):
        for z_at, told in ((lambda one: 0.01 * one, "z 0.12 at strength 12, wanted 12"), (lambda one: 0.0, "z 0 at strength .*, wanted 12"),
                           (lambda one: 20.0 + one, "z 20 at strength 0.01, wanted 12")):
            with self.assertRaisesRegex(Failure, told):
                causes.strength_of(z_at, 12.0)
        self.assertEqual(causes.strength_of(lambda one: 0.8 * one, 12.0)[1], 0.8 * 12.0)  # near enough at the bound

    def test_what_the_circuit_takes_up_is_not_seen(self):
        dice = np.random.default_rng(1)
        t = np.arange(600.0)
        i = 20.0 * np.sign(np.sin(t / 17.0)) + 10.0 * np.sin(t / 5.0)
        yardstick = causes.Yardstick(laws.Beside(t, i, 12.5 + 5e-3 * i + dice.normal(0.0, 0.01, 600)))
        voltage = yardstick.beside.u
        self.assertLess(yardstick.z(yardstick.beside.i, voltage + 0.1 + 1e-3 * i), 1e-6)
        seen = yardstick.z(yardstick.beside.i, voltage + 1e-2 * np.sin(t / 30.0))
        self.assertGreater(seen, 5.0)
        self.assertAlmostEqual(yardstick.z(yardstick.beside.i, voltage + 2e-2 * np.sin(t / 30.0)), 2.0 * seen, places=6)


def held(rmse, share=None, equations=None):
    return {"rmse_v": rmse, "share_percent": share, "equations_share_percent": equations}


def case(kind, truths, named, before=(), z=5.0, share=(50.0, 60.0, 70.0), **more):
    errors = {"base": held(0.2, share[0], 10.0), "extended": held(0.1, share[1]), "line": held(0.3, 0.0), "ridge": held(0.15)}
    def answer(names):
        return {"mechanism": None, "effects": [{"id": name, "mechanism": name, "probability": None} for name in names]}
    row = {"answer": dict(answer(named), errors=errors), "mean_v": 0.4, "oracle": {"errors": held(0.1, share[2])}, "same": {"errors": held(0.1, share[1])}, "wrong": {"failed": "no answer"}, **more}
    label = {"kind": kind, "mechanisms": truths, "causes": [{"z": z, "mechanism": one} for one in truths]}
    return causes_score.Case(row, label, answer(before))


class Bench(causes.Bench):
    """Draws and is told something at once; keeps what was asked."""

    def __init__(self, out, patience=math.inf):
        self.out, self.asked, self.patience = out, [], patience
        for folder in (causes.RECORDINGS, causes.LABELS):
            os.makedirs(os.path.join(out, folder), exist_ok=True)

    def stretch(self, recording, part):
        return None, None, self.path(causes.RECORDINGS, f"{recording}_{part}", "csv")

    def draw(self, case):
        if case["name"] == "case_0002":
            raise Failure("not drawn")
        recordings.write(self.path(causes.RECORDINGS, case["name"], "csv"), np.arange(8.0), np.zeros(8), np.full(8, 12.0))
        label = {"kind": case["kind"], "mechanisms": case["mechanisms"], "causes": [{"id": "slow_diffusion", "mechanism": one, "z": 5.0} for one in case["mechanisms"]]}
        write_json(self.path(causes.LABELS, case["name"], "json"), label)
        return "drive_1a", 0

    def told(self, path, *options):
        if len(self.asked) >= self.patience:
            raise KeyboardInterrupt
        self.asked.append((os.path.basename(path), *options))
        effects = [{"id": "fresh_sulphate", "mechanism": "acceptance", "probability": None}]
        return {"mechanism": None, "effects": effects, "errors": dict.fromkeys(("base", "extended", "line", "ridge"), held(0.1))}


class Steps(unittest.TestCase):
    """What a sensor would have shown of a changed channel."""

    MEASURED = 12.0 + 0.025 * np.random.default_rng(1).integers(0, 40, 2000)

    def test_are_those_of_what_was_measured(self):
        shown = laws.in_steps(self.MEASURED, self.MEASURED + 0.0103, 2)
        np.testing.assert_allclose((shown - 12.0) / 0.025, np.round((shown - 12.0) / 0.025), atol=1e-6)
        self.assertLessEqual(np.abs(shown - self.MEASURED - 0.0103).max(), 0.0251)
        self.assertAlmostEqual(np.mean(shown - self.MEASURED), 0.0103, delta=0.001)  # four standard errors: no bias by rounding

    def test_what_has_not_changed_stays(self):
        changed = self.MEASURED.copy()
        changed[1000:] += 0.1
        shown = laws.in_steps(self.MEASURED, changed, 3)
        self.assertTrue(np.array_equal(shown[:1000], self.MEASURED[:1000]))
        self.assertFalse(np.array_equal(shown[1000:], changed[1000:]))

    def test_a_channel_that_never_moves_has_none(self):
        self.assertTrue(np.array_equal(laws.in_steps(np.full(9, 12.0), np.linspace(12.0, 12.5, 9), 4), np.linspace(12.0, 12.5, 9)))


class Unrounded(causes.Bench):
    """Draws 10 mV and 30 mA to what was measured in steps of 25 mV and 0.1 A."""

    T, I, U = np.arange(300.0), 0.1 * np.random.default_rng(5).integers(-90, 90, 300), Steps.MEASURED[:300]

    def __init__(self, out):
        self.out = out
        for folder in (causes.RECORDINGS, causes.LABELS):
            os.makedirs(os.path.join(out, folder), exist_ok=True)

    def stretch(self, recording, part):
        return laws.Beside(self.T, self.I, self.U), None, None

    def drawn(self, case, attempt):
        return {"recording": "drive_1a", "part": 0}, self.I + 0.03, self.U + 0.01


class Written(unittest.TestCase):
    def test_recordings_are_in_the_steps_of_what_was_measured(self):
        with tempfile.TemporaryDirectory() as out:
            bench = Unrounded(out)
            bench.draw({"name": "case_0001", "seed": 7})
            _, current, voltage = recordings.read(bench.path(causes.RECORDINGS, "case_0001", "csv"))
        for values, measured, step in ((current, bench.I, 0.1), (voltage, bench.U, 0.025)):
            off = (values - measured) / step
            np.testing.assert_allclose(off, np.round(off), atol=1e-3)
            self.assertTrue(0 < np.count_nonzero(np.round(off)) < len(off))


class Order(unittest.TestCase):
    CASES = causes.plan(3, {"single": 4, "sham": 1, "pair": 1}, MECHANISMS)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out, self.seal = folder.name, os.path.join(folder.name, causes.SEALED)
        self.told = io.StringIO()
        for stream in (contextlib.redirect_stdout(self.told), contextlib.redirect_stderr(io.StringIO())):
            stream.__enter__()
            self.addCleanup(stream.__exit__, None, None, None)

    def run_all(self, bench, minutes=math.inf):
        causes.run(bench, self.CASES, minutes, self.seal)

    def refused(self, what, step=causes.opened):
        with self.assertRaisesRegex(SystemExit, what):
            step(Bench(self.out), self.CASES, *([math.inf] if step is causes.run else []), self.seal)

    def test_labels_are_read_and_effects_given_once_the_answers_are_sealed(self):
        bench = Bench(self.out)
        with mock.patch.object(causes, "read_json", side_effect=AssertionError("something was read")):
            self.run_all(bench)
        drawn = [one["name"] for one in self.CASES if one["name"] != "case_0002"]
        self.assertEqual(sorted(bench.asked), sorted((f"{name}.csv",) for name in [*drawn, "drive_1a_0"]))
        sealed = read_json(self.seal)
        self.assertEqual(sealed["answers_sha256"], digest(os.path.join(self.out, "answers.jsonl")))
        self.assertIn(f"answers: 6 of 6, SHA-256 {sealed['answers_sha256']}", self.told.getvalue())
        bench = Bench(self.out)
        judged, failed = causes.opened(bench, self.CASES, self.seal)
        self.assertEqual((len(judged), failed), (5, [("case_0002", None, "not drawn")]))
        single = [one["name"] for one in self.CASES if one["kind"] == "single" and one["name"] != "case_0002"]
        effects = ("fresh_sulphate", "fresh_sulphate,acid_transport", "fresh_sulphate,current_offset")
        self.assertEqual(sorted(bench.asked), sorted((f"{name}.csv", "--given", some) for name in single for some in effects))
        self.assertEqual(next(one.row["oracle"]["effects"] for one in judged if one.kind == "single"), ["fresh_sulphate", "acid_transport"])

    def test_what_was_cut_off_goes_on(self):
        for step in (causes.run, causes.opened):
            more = [math.inf] if step is causes.run else []
            with self.assertRaises(KeyboardInterrupt):
                step(Bench(self.out, patience=4), self.CASES, *more, self.seal)
            if step is causes.run:
                self.refused("sealed.json is missing: no answers are sealed yet")
            bench = Bench(self.out)
            step(bench, self.CASES, *more, self.seal)
            self.assertEqual(len(bench.asked), 2 if step is causes.run else 6)  # a case that was cut off is begun again
        bench = Bench(self.out)
        causes.opened(bench, self.CASES, self.seal)
        self.assertEqual(bench.asked, [])

    def test_what_is_sealed_in_part_goes_on_until_labels_are_opened(self):
        self.run_all(Bench(self.out), minutes=0.0)
        self.assertEqual(read_json(self.seal)["asked"], 0)
        self.run_all(Bench(self.out))
        self.run_all(Bench(self.out))
        self.assertEqual(read_json(self.seal)["asked"], 6)
        causes.opened(Bench(self.out), self.CASES, self.seal)
        self.refused("the labels were opened, so nothing more is asked", causes.run)

    def test_what_is_no_longer_as_it_was_sealed_is_refused(self):
        self.run_all(Bench(self.out))
        for name in ("answers.jsonl", "unchanged.jsonl", "labels/case_0001.json"):
            with open(os.path.join(self.out, name), "rb+") as file:
                whole = file.read()
                file.write(b" ")
                file.flush()
                for step in (causes.opened, causes.run):
                    self.refused(f"{name.split('/')[0]} is not what was sealed: digest [0-9a-f]{{64}}, .*sealed.json says [0-9a-f]{{64}}", step)
                file.truncate(len(whole))
        self.assertFalse(os.path.exists(os.path.join(self.out, causes.GIVEN)))
        with self.assertRaisesRegex(SystemExit, "does not seal answers to this plan"):
            causes.opened(Bench(self.out), self.CASES[1:], self.seal)
        causes.opened(Bench(self.out), self.CASES, self.seal)


class Scoring(unittest.TestCase):
    def test_only_what_is_new_counts(self):
        one = case("pair", ["acid", "ageing"], ["acid", "ageing", "structure", "acceptance"], before=["acid", "acceptance"])
        self.assertEqual((one.right, one.wrong, one.judged), ({"ageing"}, {"structure"}, True))
        self.assertFalse(case("single", ["acid"], ["acid"], before=["acid"]).judged)
        self.assertEqual(case("single", ["acceptance"], []).always(), (1, 0))
        self.assertEqual(case("sham", [], []).always(), (0, 1))

    def test_counts_shams_and_gain(self):
        cases = [case("single", ["acid"], ["acid"], z=2.5), case("single", ["ageing"], ["acid"], z=40.0), case("sham", [], ["acid"]), case("sham", [], []),
                 case("pair", ["acid", "ageing"], ["acid"])]
        found = causes_score.figures(cases, [])
        self.assertEqual((found["right_minus_wrong"], found["shams"], found["false"]), (1, 2, 1))
        # 50 % is unexplained by circuit and regression, 40 % by the diagnosis, 30 % by the oracle
        self.assertAlmostEqual(found["gain_share"], np.log(50.0 / 40.0) / np.log(50.0 / 30.0))
        self.assertAlmostEqual(found["gain_share_over_named"], 0.0)
        self.assertEqual(found["over_regression"]["mean"], (2.0, 2))
        self.assertEqual(found["over_regression"]["ridge"], (None, 0))
        self.assertAlmostEqual(found["volts_over_regression"]["ridge"][0], 0.75)
        text = causes_score.as_markdown(cases, [("case_0009", None, "not drawn")])
        self.assertIn("| z 2 to 4 | 1 | 1 | 1 | 0 | 0 |", text)
        self.assertIn("| z 16 to 32 | 1 | 1 | 0 | 1 | 0 |", text)

    def test_where_nothing_regulates_the_error_is_in_volts(self):
        found = case("single", ["acid"], [], share=(None, None, None)).errors()
        self.assertEqual((found["ridge"], found["circuit + regression"], found["circuit"]), (0.15, 0.2, None))

    def test_the_wrong_effect_is_neither_true_nor_named(self):
        self.assertEqual(causes.given_effects("slow_diffusion", []), {"oracle": "acid_transport", "wrong": "current_offset"})
        self.assertEqual(causes.given_effects("current_offset", ["high_rate_depletion"]), {"oracle": "current_offset", "wrong": "cpe2"})


if __name__ == "__main__":
    unittest.main()

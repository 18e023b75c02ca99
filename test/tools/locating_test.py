#!/usr/bin/env python3
"""Changes that are limited in time or to a regime: what is drawn, and how what is located is scored."""

import random
import unittest

import numpy as np

from battery_sof_tools.benchmark import locating
from battery_sof_tools.sof import Failure


def drive(seconds=1200, rate=10):
    """Time and current of minutes: 20 s of charge, 5 s of charge, 15 s of discharge, a start of 1 s, and rest."""
    t = np.arange(seconds * rate) / rate
    minute = t % 60.0
    return t, np.select([minute < 20.0, minute < 25.0, minute < 30.0, minute < 45.0, minute < 46.0], [20.0, 0.0, 15.0, -20.0, -250.0], 0.0)


def finding(regime, value, alarm=True, statistic="mean", half=0.1):
    return {"regime": regime, "statistic": statistic, "value": value, "lower": value - half * abs(value), "upper": value + half * abs(value), "alarm": alarm}


class Time(unittest.TestCase):
    def test_stretches_that_overlap_count_once(self):
        self.assertEqual(locating.union([(5.0, 9.0), (0.0, 3.0), (2.0, 4.0)]), [[0.0, 4.0], [5.0, 9.0]])
        self.assertEqual(locating.length([(5.0, 9.0), (0.0, 3.0), (2.0, 4.0)]), 8.0)
        self.assertEqual(locating.common([(5.0, 9.0), (0.0, 3.0), (2.0, 4.0)], 1.0, 6.0), 4.0)

    def test_half_of_the_stretch_and_half_of_what_is_reported_is_found(self):
        for reported, recall, precision, found in (
                ([(100.0, 200.0)], 1.0, 1.0, True), ([(70.0, 150.0)], 0.5, 1.0, True), ([(70.0, 149.0)], 0.49, 1.0, False),
                ([(0.0, 300.0)], 1.0, 160.0 / 300.0, True), ([(0.0, 400.0)], 1.0, 0.4, False), ([(200.0, 230.0)], 0.0, 1.0, False), ([], 0.0, None, False)):
            score = locating.time_score(reported, (100.0, 200.0))
            self.assertAlmostEqual(score["recall"], recall)
            self.assertEqual((score["precision"], score["found"]), (precision, found), reported)

    def test_what_touches_a_stretch_of_the_control_is_not_new(self):
        self.assertEqual(locating.apart([[0.0, 10.0], [20.0, 30.0]], [[5.0, 6.0], [30.0, 40.0]]), [[20.0, 30.0]])


class Regime(unittest.TestCase):
    def test_the_largest_significant_error_comes_first_and_slopes_have_no_size(self):
        said = [finding("long charge", 5.0, statistic="slope"), finding("long charge", 0.010), finding("discharge", -0.005), finding("crank", 0.9, alarm=False)]
        self.assertEqual(locating.regime_score(said, "charge"), {"first": True, "among": True, "others": 1})
        self.assertEqual(locating.regime_score(said, "crank"), {"first": False, "among": False, "others": 2})
        self.assertEqual(locating.regime_score([], "rest"), {"first": False, "among": False, "others": 0})

    def test_every_rest_is_right_where_rests_were_changed(self):
        self.assertTrue(locating.regime_score([finding("post-charge rest", 0.01)], "rest")["first"])

    def test_episodes_are_those_of_the_product(self):
        t, current = drive()
        for regime, count, duration in (("crank", 20, 1.0), ("charge", 20, 20.0)):
            episodes = locating.episodes_of(regime, t, current)
            self.assertEqual(len(episodes), count)
            self.assertTrue(all(abs((end - begin) / 10.0 - duration) < 0.11 for begin, end in episodes), regime)
        self.assertEqual(len(locating.episodes_of("rest", t, current)), 40)

    def test_a_gap_ends_a_charge(self):
        t = np.concatenate((np.arange(8.0), np.arange(60.0, 68.0)))
        self.assertEqual(locating.episodes_of("charge", t, np.full(16, 10.0)), [])


class Changes(unittest.TestCase):
    def test_a_change_is_limited_to_its_stretch_before_the_last_quarter(self):
        t, current = drive()
        for kind in locating.IN_TIME:
            for seed in range(20):
                change, truth = locating.change_in_time(kind, t, current, random.Random(seed))
                outside = (t < truth["from_s"]) | (t > truth["to_s"])
                self.assertFalse(change[outside].any())
                self.assertGreaterEqual(truth["from_s"], locating.MARGIN_S)
                self.assertLess(truth["to_s"], 0.75 * t[-1])
                self.assertTrue(59.0 < truth["to_s"] - truth["from_s"] < 301.0)

    def test_a_change_is_limited_to_its_regime(self):
        t, current = drive()
        for kind, allowed in (("crank", current < -150.0), ("charge", current == 20.0), ("rest", current == 0.0)):
            change, truth = locating.change_in_regime(kind, t, current, random.Random(1))
            self.assertTrue(change[allowed].any())
            self.assertFalse(change[~allowed].any())
            self.assertGreaterEqual(truth["episodes"], 14)

    def test_a_regime_that_does_not_occur_is_refused(self):
        t = np.arange(1000.0)
        with self.assertRaisesRegex(Failure, "no charge before the last quarter"):
            locating.change_in_regime("charge", t, np.where(t > 800.0, 20.0, -5.0), random.Random(1))

    def test_the_same_seed_gives_the_same_cases_three_a_base(self):
        cases = locating.plan(3, 12, "data")
        self.assertEqual(cases, locating.plan(3, 12, "data"))
        self.assertEqual(len(cases), 3 * 18)
        kinds = [case["kind"] for case in cases]
        self.assertEqual([kinds.count(kind) for kind in ("control", "resistance", "unseen load", "crank", "charge", "rest")], [18, 9, 9, 6, 6, 6])
        self.assertEqual(len({case["seed"] for case in cases}), len(cases))


class Baseline(unittest.TestCase):
    def test_it_takes_the_minute_and_the_regime_with_the_largest_error(self):
        t, current = drive()
        error = np.where((t >= 300.0) & (t < 420.0), 0.05, 0.001)
        said = locating.baseline_of(t, current, error)
        self.assertTrue(300.0 <= said["worst"][0][0] <= 360.0)
        self.assertTrue(locating.time_score(said["clear"], (300.0, 420.0))["found"])
        self.assertEqual(locating.baseline_of(t, current, np.where(current < -150.0, 0.1, 0.01))["regime"], "crank")
        self.assertEqual(locating.baseline_of(t, current, np.full(len(t), 0.01))["clear"], [])


class Figures(unittest.TestCase):
    def test_counts_are_kept_apart_by_what_was_put_in(self):
        baseline = {"worst": [[0.0, 60.0]], "clear": [], "regime": "rest"}
        row = {"name": "a", "group": "measured", "base_seed": 1, "kind": "control", "truth": {}, "stretches": [[300.0, 330.0]], "regimes": [finding("crank", 0.01, alarm=False)], "baseline": baseline, "duration_s": 1200.0}
        late = dict(row, kind="resistance", truth={"from_s": 100.0, "to_s": 200.0}, stretches=[[100.0, 160.0], [300.0, 380.0]])
        charge = dict(row, kind="charge", truth={"episodes": 4}, regimes=[finding("long charge", 0.01)])
        found = locating.figures([row, late, charge, {"name": "b", "failed": "no answer"}])
        self.assertEqual((found["cases"], found["answered"]), (4, 3))
        of = found["groups"]["measured"]
        self.assertEqual([of["control"][key] for key in ("stretch", "regime", "clear")], [[1, 1], [0, 1], [0, 1]])
        self.assertEqual([of["resistance"][name]["found"] for name in ("sof", "new", "worst", "clear")], [[0, 1], [1, 1], [0, 1], [0, 1]])
        self.assertEqual((of["charge"]["first"], of["charge"]["testable"], of["charge"]["baseline"]), ([1, 1], 0, [0, 1]))
        self.assertIn("| measured | charge | 1 of 1 (27 to 100 %) |", "\n".join(locating.tables(found)))


if __name__ == "__main__":
    unittest.main()

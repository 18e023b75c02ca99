#!/usr/bin/env python3
"""What the tables of measured recordings and of hard usage say of their rows."""

import os
import tempfile
import unittest

import numpy as np

from battery_sof_tools import change_study, recordings, score_next_window, simulated_pairs
from battery_sof_tools.benchmark import known_physics, measured
from battery_sof_tools.stress import kill, soak


def errors(rmse, share, equations=None):
    return {"holdout": {"rmse_v": rmse, "share_percent": share, "equations_share_percent": equations}}


def answer(extended=None, **more):
    given = {"verdict": "mismatch", "mechanism": None, "probability": None, "effects": [], "baseline": {"rmse_v": 0.04}, "baseline_line": {"rmse_v": 0.3, "share_percent": 5.0},
             "fit": {"base": errors(0.1, 10.0), "extended": extended}}
    return dict(given, **more)


class DiagnoseMeasured(unittest.TestCase):
    def test_every_recording_is_there_once_and_whole(self):
        whole = measured.whole_recordings()
        self.assertEqual(sorted(one.path for one in whole.values()), sorted({one.path for one in recordings.MEASURED.values()}))

    def test_without_an_extended_model_the_base_stands_for_it(self):
        found = measured.figures(answer())
        self.assertEqual((found["base"], found["extended"], found["shares"]), (0.1, 0.1, (10.0, 10.0, 5.0)))
        found = measured.figures(answer(errors(0.05, None)))
        self.assertEqual((found["base"], found["extended"], found["ridge"], found["line"], found["shares"]), (0.1, 0.05, 0.04, 0.3, (10.0, None, 5.0)))

    def test_what_is_told_has_each_name_once(self):
        ocv = {"id": "ocv_soc", "indistinguishable_from": ["hidden_load"]}
        rival = {"id": "hidden_load", "indistinguishable_from": ["ocv_soc"]}
        self.assertEqual(measured.told_of(answer(verdict="no_mismatch")), "no_mismatch")
        self.assertEqual(measured.told_of(answer(verdict="unexplained", mechanism="ageing")), "unexplained; ageing")
        told = measured.told_of(answer(verdict="effect", mechanism="open_circuit", probability=0.5, effects=[ocv, rival]))
        self.assertEqual(told, "effect; open_circuit (0.50); hidden_load or ocv_soc")

    def test_a_row_is_in_millivolts(self):
        wrong = {"effect": "current_offset", "extended": 0.09, "share": None, "equations": None}
        one = answer(errors(0.05, None))
        self.assertEqual(measured.row("a", one, dict(measured.figures(one), equations=measured.equations(one), placebo=wrong), 12.3),
                         ("a", "mismatch", "100, 50, 40, 300", "10, -, 5", "-, -", "current_offset: 90 mV", "12"))

    def test_the_wrong_effect_is_none_that_was_named(self):
        asked = []
        def diagnosed(*options):
            asked.append(options)
            return answer(errors(0.08, 12.0, 11.0))
        self.assertEqual(measured.placebo(diagnosed, answer()), {"effect": "current_offset", "extended": 0.08, "share": 12.0, "equations": 11.0})
        named = answer(effects=[{"id": "current_offset"}])
        self.assertEqual(measured.placebo(diagnosed, named)["effect"], "high_rate_depletion")
        self.assertEqual(asked, [("--given", "current_offset"), ("--given", "high_rate_depletion")])

    def test_the_summary_counts_who_is_ahead(self):
        found = {"a": {"base": 0.1, "extended": 0.05, "ridge": 0.04, "line": 0.3, "shares": (None, None, None), "withheld": False},
                 "b": {"base": 0.1, "extended": 0.2, "ridge": 0.3, "line": 0.1, "shares": (None, None, None), "withheld": True}}
        self.assertEqual(measured.summary(found), "Extended over base: 1.00 (geometric mean of 2). A ridge regression is ahead on 1 (a), "
                                                           "a line fit on 1 (b). Withheld as no improvement, and scored all the same: 1 (b).")

    def test_while_a_charger_regulates_the_ratio_is_of_what_is_not_explained(self):
        self.assertEqual(measured.ratio({"base": 0.1, "extended": 0.2, "shares": (20.0, 60.0, 0.0)}), 0.5)


class NextWindow(unittest.TestCase):
    def test_the_ridge_is_scored_where_no_source_controls_the_voltage_and_at_the_lowest_voltage_of_cranks(self):
        time = np.arange(1200.0)
        current = np.random.default_rng(1).uniform(-20.0, 20.0, len(time))
        current[1000:1003] = -200.0
        voltage = 12.5 + 0.01 * current
        shown, driven = np.where(np.arange(1200) % 2 == 0, voltage, 99.0), ["voltage" if n % 2 else "current" for n in range(1200)]
        with tempfile.TemporaryDirectory() as folder:
            paths = [os.path.join(folder, name) for name in ("fitted.csv", "predicted.csv")]
            for path, part in zip(paths, (slice(0, 600), slice(600, None))):
                with open(path, "w") as file:
                    file.write("time_s,current_a,voltage_v,driven_by\n")
                    file.writelines("{},{},{},{}\n".format(*row) for row in zip(time[part], current[part], shown[part], driven[part]))
            found = score_next_window.ridge_scores(*paths, [{"time_s": 1000.0, "current_a": -200.0, "measured_min_v": 10.5}])
        self.assertGreater(found["ridge"]["voltage_share_percent"], 90.0)
        self.assertLess(found["ridge_all"]["voltage_share_percent"], 0.0)
        self.assertAlmostEqual(found["ridge"]["cranks"][0]["predicted_min_v"], 10.5, delta=0.1)


class KnownPhysics(unittest.TestCase):
    def test_a_case_is_right_by_its_first_mechanism_and_compared_where_both_have_an_error(self):
        row = {"name": "deep_001", "plan": "discharge", "mechanisms": ["open_circuit", "acid"], "usable_ah": 5.0, "verdict": "effect", "effects": ["ocv_soc"], "mechanism": "acid", "likely": ["acid"],
               "held_v": {"circuit": 0.3, "extended": 0.1, "line": 0.2, "ridge": 0.05}, "shares": [None, None], "given": {"gassing": None}, "capacity_ah": [5.5, 4.8, 6.0]}
        wrong = dict(row, mechanism="ageing", likely=["ageing", "open_circuit"], capacity_ah=[7.0, 6.0, 8.0], held_v=dict(row["held_v"], ridge=None))
        silent = dict(row, mechanism=None, likely=[], capacity_ah=None, shares=[40.0, 30.0], given={"gassing": 35.0})
        found = known_physics.figures([row, wrong, silent, {"name": "x", "failed": "no answer"}])
        self.assertEqual([found[key] for key in ("cases", "answered", "right", "wrong", "in_set", "stated", "held")], [4, 3, 1, 1, 2, 2, 1])
        self.assertEqual([found[key] for key in ("beside_circuit", "not_behind_circuit", "beside_ridge", "not_behind_ridge")], [3, 2, 1, 0])
        self.assertEqual((found["explained"], found["given"]), ([40.0, 30.0], {"gassing": 35.0}))
        self.assertIn("5.5 (4.8 to 6.0)", known_physics.told(row))


class SimulatedPairs(unittest.TestCase):
    def test_a_pair_is_two_trips_of_one_battery_and_the_same_for_the_same_seed(self):
        then, now = simulated_pairs.drawn_pair("1/1")
        self.assertEqual((then, now), simulated_pairs.drawn_pair("1/1"))
        self.assertEqual(then["battery"], now["battery"])
        self.assertNotEqual(then["profile"], now["profile"])

    def test_a_change_of_the_battery_changes_what_it_says_and_leaves_the_sound_trip_alone(self):
        _, now = simulated_pairs.drawn_pair("1/2")
        changed = {name: simulated_pairs.with_change(now, name) for name, _ in simulated_pairs.BATTERY_CHANGES}
        self.assertAlmostEqual(changed["resistance +30 %"]["battery"]["r1_charge_ohm"], 1.3 * now["battery"]["r1_charge_ohm"])
        self.assertAlmostEqual(changed["capacity -30 %"]["battery"]["capacity_ah"], 0.7 * now["battery"]["capacity_ah"])
        self.assertAlmostEqual(changed["acceptance halved"]["battery"]["lead_ion_limit_a"], 0.5 * now["battery"]["lead_ion_limit_a"])
        self.assertEqual(changed["gassing"]["battery"]["gas_current_a"], 3.0)
        self.assertAlmostEqual(changed["15 K warmer"]["temperature_degc"], now["temperature_degc"] + 15.0)
        self.assertNotIn("gas_current_a", now["battery"])

    def test_changes_are_put_in_at_the_limit_that_is_stated(self):
        limits = [{"id": "contact_resistance", "strength": 0.0025, "unit": "ohm"}, {"id": "time_skew", "strength": 2.9, "unit": "s"}, {"id": "current_offset", "strength": 0.8, "unit": "A"}]
        put_in = list(change_study.at_limits({"detection_limits": limits}, 1.0))
        self.assertEqual([(one.kind, one.strength, one.effect) for one in put_in], [("contact", 2.5, "contact_resistance"), ("voltage late", 3, "time_skew"), ("offset", 0.8, "current_offset")])

    def test_the_report_counts_the_named_the_held_and_the_false(self):
        row = {"kind": None, "strength": None, "unit": None, "verdict": "changed", "first": "time_skew", "named": False, "interval_holds": None}
        sound = dict(row, verdict="no_change", first=None)
        contact = dict(row, kind="contact", strength=2.0, unit="mOhm", first="contact_resistance", named=True, interval_holds=False)
        more = dict(sound, battery="resistance +30 %", first="contact_resistance", named=True)
        text = "\n".join(change_study.simulated_report([row, sound, contact, more]))
        self.assertIn("Nothing changed, said to have changed: 1 of 2", text)
        self.assertIn("| contact_resistance | 2 (2 to 2) mOhm | 1 of 1", text)
        self.assertIn("| 0 of 1", text)
        self.assertIn("| resistance +30 % | 1 of 1", text)


class Soak(unittest.TestCase):
    def test_the_first_hour_does_not_count(self):
        rows = [(0.0, 0, 10.0, 5, 3), (0.5, 1, 30.0, 9, 9)] + [(float(hour), 1, 40.0 + 0.25 * hour, 6, 4) for hour in range(1, 9)]
        self.assertAlmostEqual(soak.slope(rows), 0.25)
        self.assertIn("Memory grows by 0.25 MB an hour of driving after the first; open files 6 to 6, threads 4 to 4.", soak.report(rows))

    def test_of_less_than_an_hour_no_growth_is_told(self):
        self.assertIn("nan", soak.report([(0.0, 0, 10.0, 5, 3), (0.5, 1, 30.0, 9, 9)])[-1])


class Kill(unittest.TestCase):
    def test_a_life_without_an_answer_is_not_counted_as_answered(self):
        cells = kill.report([(1, [], True, True), (None, ["state.yaml.part"], False, False), (4, [], True, False)])[-1]
        self.assertEqual([cell.strip() for cell in cells.strip("|").split("|")], ["3", "1", "2", "2", "4", "1"])


if __name__ == "__main__":
    unittest.main()

"""The benchmark's own arithmetic: its base circuit, its measure of difficulty, its seal, its counting."""

import contextlib
import io
import json
import os
import tempfile
import unittest

import numpy as np
from scipy.integrate import solve_ivp

from battery_sof_tools import rates
from battery_sof_tools.files import ROOT, digest, read_json
from battery_sof_tools.benchmark import scorers
from battery_sof_tools.benchmark.preregistered import base_circuit as base, command, difficulty, judged, levels, score, seal, strength
from battery_sof_tools.sof import catalogue, program

CATALOGUE = catalogue(program(os.environ["BATTERY_SOF_BUILD"], "sof"))
TRUE = np.array([5e-3, 7e-3, np.log(900.0), np.log(22.0), 12.7, 0.01])
ACQUISITION = {"voltage_white_v": 2e-3, "voltage_step_v": 1e-3, "voltage_correlated_v": 1e-3, "voltage_correlation_time_s": 3.0,
               "voltage_walk_v_per_sqrt_min": 5e-4, "current_white_a": 0.05, "current_step_a": 0.02}
LABEL = {"truth": {"acquisition": ACQUISITION, "soc_at_start": 0.8,
                   "battery": {"r_ohmic_ohm": 2e-3, "r1_discharge_ohm": 3e-3, "r1_charge_ohm": 5e-3, "cpe2_capacitance_f": 900.0,
                               "beta_per_v": 22.0, "u0_slope_v": 1.35, "u0_v": 12.7}}}


def drive(seconds, seed=1):
    """Held currents of 2 to 8 s [A] at 100 Hz."""
    dice, out = np.random.default_rng(seed), []
    while len(out) < 100 * seconds:
        out += [dice.uniform(-60.0, 40.0)] * int(100 * dice.uniform(2.0, 8.0))
    return np.array(out[:100 * seconds])


def answer(verdict, *classes, **more):
    effects = [{"id": one[0], "indistinguishable_from": list(one[1:]), "evidence": 50.0, "parameters": []} for one in classes]
    side = {"rmse_v": 0.01, "charge_current_error_a": 1.0, "crank_mae_v": 0.01}
    return dict({"verdict": verdict, "effects": effects, "candidates": [], "hidden": [], "next_experiment": "", "instrument": [],
                 "holdout": {"base": side, "extended": dict(side, rmse_v=0.004)}}, **more)


def case(level, family, name, effects, whole, short=None, told=None):
    label = {"name": "case_0001", "level": level, "family": family, "id": name, "scale": [1.0], "expected": {"effects": effects},
             "strength": {}}
    return judged.Case(label, {"whole": whole, **({"short": short} if short else {})}, told, CATALOGUE)


class BaseCircuit(unittest.TestCase):
    def test_steps_follow_the_differential_equation(self):
        current = drive(15)
        u2 = [TRUE[base.U2_START]]
        for i in 0.5 * (current[1:] + current[:-1]):
            law = lambda _, u, i=i: (i - 2.0 * np.sinh(11.0 * u)) / 900.0
            u2.append(solve_ivp(law, (0.0, 0.01), [u2[-1]], rtol=1e-10, atol=1e-12).y[0, -1])
        expected = 12.7 + np.array(u2) + np.where(current < 0.0, 5e-3, 7e-3) * current
        np.testing.assert_allclose(base.simulate(TRUE[:, None], current, 0.01)[:, 0], expected, atol=1e-8)

    def test_columns_do_not_touch_each_other(self):
        other = TRUE + np.array([1e-3, 0, 0.3, 0.2, 0.1, 0])
        together = base.simulate(np.column_stack([TRUE, other]), drive(30), 0.01)
        np.testing.assert_allclose(together[:, 1], base.simulate(other[:, None], drive(30), 0.01)[:, 0], atol=1e-12)


class Difficulty(unittest.TestCase):
    def test_weighing_is_the_inverse_covariance(self):
        kept = np.ones(40, dtype=bool)
        noise = difficulty.Noise(ACQUISITION, 6e-3, kept, 0.1)
        at = np.arange(40)
        white = (4e-6 + 1e-6 / 12 + 36e-6 * (0.05 ** 2 + 0.02 ** 2 / 12)) / difficulty.CELL
        covariance = white * np.eye(40) + 1e-6 * np.exp(-0.1 * np.abs(at[:, None] - at) / 3.0)
        covariance += 25e-8 * 0.1 / 60.0 * np.minimum(at[:, None], at)
        inverse = np.linalg.inv(covariance)
        free = inverse - np.outer(inverse.sum(1), inverse.sum(1)) / inverse.sum()  # the walk's start is anybody's guess
        np.testing.assert_allclose(noise.weighted(np.eye(40)), free, rtol=1e-5, atol=1e-4 * free.max())

    def test_the_base_circuit_alone_has_no_z(self):
        current = drive(300)
        voltage = base.simulate(TRUE[:, None], current, 0.01)[:, 0]
        fit = difficulty.fitted(LABEL, (0.01, current, voltage))
        self.assertLess(fit.z, 0.05)
        np.testing.assert_allclose(fit.parameters, TRUE, rtol=1e-4, atol=1e-4)

    def test_z_goes_with_the_strength_of_what_is_missing(self):
        current = drive(300)
        voltage = base.simulate(TRUE[:, None], current, 0.01)[:, 0]
        charge = np.cumsum(current) * 0.01 / 3600.0
        z = [difficulty.fitted(LABEL, (0.01, current, voltage + slope * charge)).z for slope in (0.01, 0.02)]
        self.assertGreater(z[0], 0.5)
        self.assertAlmostEqual(z[1] / z[0], 2.0, delta=0.05)

    def test_a_resistance_is_concealed_in_a_resistance(self):
        current = drive(300)
        voltage = base.simulate(TRUE[:, None], current, 0.01)[:, 0]
        fit = difficulty.fitted(LABEL, (0.01, current, voltage + 1e-3 * np.minimum(current, 0.0)))
        bias, parameter = difficulty.largest_bias(LABEL, fit)
        self.assertEqual(parameter, "r_discharge")
        self.assertAlmostEqual(bias, 0.2, delta=0.01)
        self.assertGreater(difficulty.bias_in_errors(LABEL, fit, parameter), strength.BIASED_IN_ERRORS)
        self.assertLess(difficulty.raised(LABEL, fit.residual[fit.kept]), strength.RAISED)
        self.assertGreater(difficulty.raised(LABEL, 3e-3 * np.ones(5)), strength.RAISED)

    def test_a_tenth_more_and_no_more_is_concealed(self):
        hidden = {"raised": 1.1, "bias": -0.1, "bias_in_errors": 3.0}
        self.assertTrue(strength.is_concealed(hidden))
        for key, value in (("raised", 1.11), ("bias", 0.09), ("bias_in_errors", 2.9)):
            self.assertFalse(strength.is_concealed(dict(hidden, **{key: value})), key)

    def test_cells_around_edges_are_left_out(self):
        current = np.where(np.arange(300) < 150, 0.0, 20.0)
        self.assertEqual(list(np.flatnonzero(~difficulty.away_from_edges(current))), [13, 14, 15, 16])

    def test_the_secant_hits_a_power_law(self):
        tried, scale = [], 1.0
        for _ in range(4):
            tried.append((scale, 120.0 * scale ** 0.8, 0.0))
            scale = strength.next_scale(tried, 20.0)
        self.assertAlmostEqual(tried[-1][1], 20.0, delta=0.5)


class Seal(unittest.TestCase):
    def test_names_and_seeds_follow_from_the_hash_alone(self):
        self.assertEqual(levels.plan("a", 1.0), levels.plan("a", 1.0))
        self.assertNotEqual([one["seed"] for one in levels.plan("a", 1.0)], [one["seed"] for one in levels.plan("b", 1.0)])

    def test_the_full_set_has_300_cases_of_distinct_seeds(self):
        cases = levels.plan("a", 1.0)
        self.assertGreaterEqual(len(cases), 300)
        self.assertEqual(len({one["seed"] for one in cases}), len(cases))

    def test_a_share_keeps_every_stratum(self):
        self.assertEqual({(one["level"], one["family"]) for one in levels.plan("a", 0.02)},
                         {(one.level, one.mechanism) for one in levels.STRATA if one.level not in levels.ON_REQUEST})

    def test_what_committed_seals_do_not_have_is_drawn_on_request_alone(self):
        self.assertEqual({one["rule"] for one in levels.plan("a", 1.0, only=["C6"])}, {"concealed"})
        self.assertFalse({one["level"] for one in levels.plan("a", 1.0)} & set(levels.ON_REQUEST))

    def test_the_command_seals_under_the_names_of_the_committed_seal(self):
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "seal")
            with contextlib.redirect_stdout(io.StringIO()):
                command.main(["seal", "--build", os.environ["BATTERY_SOF_BUILD"], "--seed-from", "a", "--share", "0.01", "--levels", "N1", "--out", out, "--jobs", "1"])
            self.assertEqual(list(read_json(os.path.join(out, "seal.json"))), list(read_json(os.path.join(ROOT, "docs", "proof", "seal.json"))))

    def test_changed_labels_are_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "labels.jsonl")
            with open(path, "w") as f:
                f.write('{"name": "case_0001"}\n')
            with open(os.path.join(folder, "seal.json"), "w") as f:
                json.dump({"labels_sha256": digest(path)}, f)
            self.assertEqual(len(seal.opened(folder)[1]), 1)
            with open(path, "a") as f:
                f.write('{"name": "case_0002"}\n')
            self.assertRaises(SystemExit, seal.opened, folder)


class Counting(unittest.TestCase):
    def test_intervals_are_those_of_clopper_and_pearson(self):
        self.assertAlmostEqual(rates.interval(0, 60)[1], 1.0 - 0.025 ** (1.0 / 60.0))
        self.assertAlmostEqual(rates.interval(1, 60)[1], 0.0894, places=4)

    def test_a_class_of_four_names_is_no_hit(self):
        four = answer("ambiguous", ("ocv_soc", "cpe2", "acid_transport", "ocv_hysteresis"))
        three = answer("ambiguous", ("ocv_soc", "cpe2", "acid_transport"))
        self.assertFalse(judged.class_true(case("C1", "effect", "acid_transport", ["acid_transport"], four)))
        self.assertTrue(judged.class_true(case("C1", "effect", "acid_transport", ["acid_transport"], three)))

    def test_a_companion_is_true_and_its_name_not_wrong(self):
        one = case("C1", "effect", "gassing", ["gassing", "charge_acceptance"], answer("named", ("charge_acceptance",)))
        self.assertTrue(judged.first_true(one))
        self.assertFalse(judged.named_itself(one))
        self.assertEqual(judged.wrong_names(one), [])

    def test_structure_is_not_what_was_added_to_it(self):
        truths = ["cpe2", "second_electrode", "acid_transport"]
        one = case("X1", "structural_effect", "acid_transport", truths, answer("several", ("cpe2",), ("ocv_soc",)))
        self.assertFalse(judged.any_class_true(one))
        self.assertEqual(judged.wrong_names(one), ["ocv_soc"])
        self.assertTrue(judged.any_class_true(case("X1", "structural_effect", "acid_transport", truths,
                                                   answer("several", ("cpe2",), ("ocv_soc", "acid_transport")))))

    def test_a_decoy_taken_for_physics_counts_unless_its_class_has_the_fault(self):
        alone = case("D1", "decoy", "voltage_drift", ["voltage_drift"], answer("named", ("ocv_soc",)))
        tied = case("D1", "decoy", "voltage_drift", ["voltage_drift"], answer("ambiguous", ("ocv_soc", "voltage_drift")))
        by_key = {one.key: one for one in score.figures([alone, tied])}
        self.assertEqual((by_key["decoy_physics"].k, by_key["decoy_physics"].n), (1, 2))
        self.assertEqual([judged.fault_found(one) for one in (alone, tied)], [False, True])

    def test_a_warning_is_a_hidden_effect_or_the_next_experiment_of_silence(self):
        for short, expected in ((answer("no_mismatch", hidden=["gassing"]), True),
                                (answer("no_mismatch", next_experiment="could not have shown gassing (side reactions)"), True),
                                (answer("named", ("cpe2",), next_experiment="To confirm gassing"), False),
                                (answer("no_mismatch"), False)):
            self.assertEqual(judged.warned(case("C5", "absent", "gassing", ["gassing"], answer("no_mismatch"), short)), expected)

    def test_the_recovered_fraction_compares_with_the_truth_told(self):
        told = answer("named", ("cpe2",))
        told["holdout"]["extended"]["rmse_v"] = 0.002
        one = case("C1", "effect", "cpe2", ["cpe2"], answer("named", ("cpe2",)), told=told)
        self.assertAlmostEqual(judged.recovered(one), 0.75)
        self.assertIsNone(judged.recovered(case("C1", "effect", "cpe2", ["cpe2"], answer("named", ("cpe2",)))))

    def test_a_right_mechanism_is_clean_or_has_a_false_one_beside_it(self):
        cases = [case("C1", "effect", "acid_transport", ["acid_transport"], answer("several", ("acid_transport",), *more, withheld_v=withheld))
                 for more, withheld in (((), None), ((("cpe2",),), 0.02), ((("cpe2",), ("ocv_soc",)), None))]
        cases.append(case("C1", "effect", "cpe2", ["cpe2"], answer("no_mismatch")))  # kept without withheld_v
        by_key = {one.key: (one.k, one.n) for one in score.figures(cases)}
        self.assertEqual([by_key[key] for key in ("clean_C1", "beside_C1", "withheld")], [(1, 4), (2, 4), (1, 3)])

    def test_an_aim_is_missed_beyond_its_bound_and_by_no_case_not_at_all(self):
        one = score.figures([])[0]
        for target, k, n, value, expected in (("<= 1/60", 1, 60, None, False), ("<= 1/60", 1, 59, None, True), (">= 85 %", 6, 7, None, False), (">= 85 %", 5, 6, None, True),
                                              ("90 to 98 %", 99, 100, None, True), ("90 to 98 %", 9, 10, None, False), ("< 0.4", None, 4, 0.4, True), ("<= 10 %", None, 8, 0.04, False),
                                              (">= 85 %", 0, 0, None, None), ("", 1, 2, None, None)):
            self.assertEqual(score.misses(one._replace(target=target, k=k, n=n, value=value)), expected, (target, k, n, value))

    def test_a_quick_set_with_wrong_clear_names_is_broken(self):
        def report(right):
            cases = [case("C1", "effect", "cpe2", ["cpe2"], answer("named", ("cpe2" if k < right else "ocv_soc",))) for k in range(4)]
            return {"figures": score.figures(cases), "failed": []}
        self.assertEqual(score.broken(report(3)), [])
        self.assertEqual(len(score.broken(report(2))), 1)
        self.assertEqual(len(score.broken(dict(report(4), failed=["case_0009"]))), 1)

    def test_the_text_holds_every_figure(self):
        cases = [case("C1", "effect", "cpe2", ["cpe2"], answer("named", ("ocv_soc",))), case("N1", "null", "-", [], answer("no_mismatch"))]
        text = score.as_text(score.score({"cases": 2, "frozen_commit": "x", "labels_sha256": "y"}, cases, ["case_0009"]))
        for figure in score.figures(cases):
            self.assertIn(figure.text, text)
        self.assertRegex(text, r"C1 +first name true +0 of 1 = 0\.0 %")
        self.assertRegex(text, r"C1 cpe2 +ocv_soc 1\n")
        self.assertRegex(text, r"not judged\n  case_0009")


def mechanism_of(level, truths, whole, family="effect", name=None):
    return case(level, family, name or truths[0], truths, whole).outcome


class Families(unittest.TestCase):
    def test_another_member_of_the_family_is_a_wrong_name_and_the_right_family(self):
        one = case("C1", "effect", "acid_transport", ["acid_transport"], answer("named", ("high_rate_depletion",)))
        self.assertEqual((judged.class_true(one), one.outcome), (False, "right"))

    def test_outcomes_are_of_families(self):
        for whole, expected in ((answer("named", ("acid_transport",)), "right"),
                                (answer("unknown", mechanism="acid"), "right"),
                                (answer("several", ("acid_transport",), ("cpe2",)), "beside"),
                                (answer("ambiguous", ("cpe2", "ocv_soc")), "wrong"),
                                (answer("unknown"), "none"), (answer("no_mismatch"), "missed"), (answer("insufficient_data"), "short")):
            self.assertEqual(mechanism_of("C1", ["acid_transport"], whole), expected, whole)

    def test_a_companion_is_a_right_family(self):
        self.assertEqual(mechanism_of("C1", ["gassing", "charge_acceptance"], answer("named", ("fresh_sulphate",))), "right")

    def test_what_no_recording_tells_apart_has_both_families(self):
        self.assertEqual(mechanism_of("C1", ["fast_arc"], answer("named", ("sensor_lag",))), "right")

    def test_the_structure_alone_is_not_what_was_added_to_it(self):
        truths = ["cpe2", "acid_transport"]
        for whole, expected in ((answer("named", ("cpe2",)), "missed"), (answer("several", ("cpe2",), ("ocv_soc",)), "wrong"),
                                (answer("several", ("cpe2",), ("acid_transport",)), "right"),
                                (answer("several", ("ocv_soc",), ("acid_transport",)), "beside")):
            self.assertEqual(mechanism_of("X1", truths, whole, "structural_effect", "acid_transport"), expected)

    def test_a_sensor_fault_says_instruments(self):
        self.assertEqual(mechanism_of("D1", ["clipping"], answer("sensor_fault"), "decoy"), "right")
        self.assertEqual(mechanism_of("C1", ["ocv_soc"], answer("sensor_fault")), "wrong")

    def test_counts_stand_beside_those_of_names(self):
        cases = [case("C1", "effect", "ocv_soc", ["ocv_soc"], answer("named", (one,))) for one in ("ocv_soc", "ocv_hysteresis", "cpe2")]
        cases.append(case("C1", "effect", "ocv_soc", ["ocv_soc"], answer("several", ("cpe2",), ("ocv_soc",))))
        cases.append(case("N1", "null", "-", [], answer("unknown", mechanism="acid", probability=0.95)))
        scored = score.by_mechanism(cases)
        row = scored["levels"]["C1"]
        self.assertEqual((row["by_name"][1], row["right"], row["beside"], row["wrong"], row["none"], row["missed"], row["n"]), (1, 3, 1, 1, 0, 0, 4))
        self.assertEqual(scored["alarms"], {"N1": (1, 1)})
        text = "\n".join(score.mechanism_lines(scored))
        self.assertIn("| C1 | in the first class, at most three | 1 of 4", text)

    def test_probabilities_are_held_against_what_is_true(self):
        cases = [case("C1", "effect", "ocv_soc", ["ocv_soc"], answer("named", ("ocv_soc",), mechanism="open_circuit", probability=0.8)),
                 case("C1", "effect", "ocv_soc", ["ocv_soc"], answer("unknown", mechanism="acid", probability=0.8)),
                 case("N1", "null", "-", [], answer("unknown", mechanism="acid", probability=1.0))]
        self.assertEqual(scorers.reliability(cases), [("0 to 0.5", 0, 0), ("0.5 to 0.7", 0, 0), ("0.7 to 0.9", 1, 2), ("0.9 to 1", 0, 1)])


if __name__ == "__main__":
    unittest.main()

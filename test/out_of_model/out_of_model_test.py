"""The judge's own arithmetic: its plan, its ridge regression, what it counts of hand-made answers, and that it goes on where it was."""

import json
import os
import stat
import tempfile
import unittest

import numpy as np

from battery_sof_tools.sof import Catalogue
from battery_sof_tools.benchmark import out_of_model, ridge, scorers
from battery_sof_tools.benchmark.answers import Case, essentials
from battery_sof_tools.files import lines_of

CATALOGUE = Catalogue({"effects": [{"id": "acid_transport", "code": "P4"}, {"id": "cpe2", "code": "S1"}],
                       "mechanisms": [{"id": "acid", "members": ["acid_transport"]}, {"id": "structure", "members": ["cpe2"]},
                                    {"id": "instrument", "members": ["clipping"]}]})
FORMS = {"acid": ["a", "b"], "ageing": ["c", "d"]}


def answer(verdict, base=0.02, extended=0.01, **more):
    fit = {side: {"holdout": {"rmse_v": v}} for side, v in (("base", base), ("extended", extended))}
    return dict({"verdict": verdict, "effects": [], "fit": fit}, **more)


def case(said, kind="other_form", mechanism="acid", form="a", ridge_v=0.015, seconds=2.0):
    label = {"kind": kind, "mechanism": mechanism if kind == "other_form" else None, "form": form if kind == "other_form" else None}
    return Case(label, essentials(said), CATALOGUE, seconds, ridge_v)


def nulls(cases, kind):
    return scorers.control_rows([one for one in cases if one.label["kind"] == kind])


def figure(rows, what):
    return dict(rows)[what]


class Plan(unittest.TestCase):
    def test_follows_from_the_seed_alone(self):
        wanted = {"null": 3, "other_form": 8}
        self.assertEqual(out_of_model.plan(wanted, 1, FORMS), out_of_model.plan(wanted, 1, FORMS))
        self.assertNotEqual(out_of_model.plan(wanted, 1, FORMS), out_of_model.plan(wanted, 2, FORMS))
        self.assertEqual([dict(case, rate=1.0) for case in out_of_model.plan(wanted, 1, FORMS)], out_of_model.plan(wanted, 1, FORMS, rate=1.0))

    def test_families_and_their_forms_take_turns(self):
        cases = out_of_model.plan({"other_form": 8}, 1, FORMS)
        self.assertEqual(sorted((one["mechanism"], one["form"]) for one in cases),
                         sorted([("acid", "a"), ("acid", "b"), ("ageing", "c"), ("ageing", "d")] * 2))

    def test_names_tell_nothing_and_seeds_are_distinct(self):
        cases = out_of_model.plan({"null": 20, "imperfect_null": 20, "other_form": 20}, 1, FORMS)
        self.assertEqual([one["name"] for one in cases], [f"case_{k:04d}" for k in range(1, 61)])
        self.assertEqual(len({one["seed"] for one in cases}), 60)
        self.assertGreater(len({one["kind"] for one in cases[:20]}), 1)

    def test_kinds_are_read_and_wrong_ones_refused(self):
        self.assertEqual(out_of_model.wanted_of("null=5,other_form=10"), {"null": 5, "other_form": 10})
        for text in ("nulls=5", "null", "null=-1"):
            self.assertRaises(SystemExit, out_of_model.wanted_of, text)


class Mechanisms(unittest.TestCase):
    def test_are_the_answers_own_and_those_of_its_effects(self):
        said = answer("several", mechanism="acid", effects=[{"id": "x", "mechanism": "structure"}])
        self.assertEqual(case(said).said.keys(), {"acid", "structure"})

    def test_come_from_the_ids_of_effects_that_give_none(self):
        self.assertEqual(case(answer("named", effects=[{"id": "acid_transport"}])).said.keys(), {"acid"})
        self.assertEqual(case(answer("named", effects=[{"id": "acid_transport", "mechanism": "ageing"}])).said.keys(), {"ageing"})

    def test_none_is_no_family(self):
        self.assertEqual(case(answer("unexplained", mechanism=None)).said, {})


class Outcomes(unittest.TestCase):
    def test_of_another_form(self):
        for said, expected in ((answer("unknown", mechanism="acid"), "right"),
                               (answer("named", effects=[{"id": "acid_transport"}]), "right"),
                               (answer("several", effects=[{"id": "acid_transport"}, {"id": "cpe2"}]), "beside"),
                               (answer("named", effects=[{"id": "cpe2"}]), "wrong"),
                               (answer("unknown"), "none"),
                               (answer("no_mismatch"), "missed"),
                               (answer("insufficient_data"), "short")):
            self.assertEqual(case(said).outcome, expected, said["verdict"])

    def test_an_alarm_on_a_null_is_any_verdict_but_no_mismatch_and_insufficient_data(self):
        verdicts = ["no_mismatch", "insufficient_data", "unknown", "sensor_fault"]
        rows = nulls([case(answer(one), kind="null") for one in verdicts], "null")
        self.assertTrue(figure(rows, "alarms").startswith("2 of 3"))
        self.assertTrue(figure(rows, "insufficient data").startswith("1 of 4"))

    def test_kinds_of_nulls_are_counted_apart(self):
        cases = [case(answer("unknown"), kind="imperfect_null"), case(answer("no_mismatch"), kind="null")]
        self.assertTrue(figure(nulls(cases, "null"), "alarms").startswith("0 of 1"))
        self.assertTrue(figure(nulls(cases, "imperfect_null"), "alarms").startswith("1 of 1"))

    def test_a_short_recording_is_neither_right_nor_missed(self):
        rows = scorers.outcome_rows([case(answer("insufficient_data")), case(answer("named", mechanism="acid"))])
        self.assertTrue(figure(rows, "mechanism right").startswith("1 of 1"))
        self.assertTrue(figure(rows, "insufficient data").startswith("1 of 2"))


    def test_a_set_is_right_where_it_has_the_mechanism_and_no_set_is_no_case(self):
        sets = [["acid"], ["structure", "acid"], ["ageing"], []]
        rows = scorers.set_rows([case(answer("named", mechanisms=[{"id": id, "probability": 0.5} for id in ids])) for ids in sets])
        self.assertTrue(figure(rows, "likely mechanisms have the right one").startswith("2 of 3"))
        self.assertEqual(figure(rows, "how many they are"), "1.33")


class Errors(unittest.TestCase):
    def test_shares_and_means_are_of_the_ratio(self):
        cases = [case(answer("named", 0.02, 0.01)), case(answer("named", 0.02, 0.02)), case(answer("named", 0.01, 0.04))]
        rows = scorers.error_rows(cases)
        self.assertTrue(figure(rows, "hold-out error, extended over base").startswith("median 1.000, geometric mean 1.260"))
        self.assertTrue(figure(rows, "at most half the base's").startswith("1 of 3"))
        self.assertTrue(figure(rows, "extended worse than base by over 2 %").startswith("1 of 3"))

    def test_what_is_withheld_counts_with_its_own_error(self):
        withheld = case(answer("named", 0.02, 0.04, withheld_rmse_v=0.04))
        self.assertEqual((withheld.withheld, withheld.over_base()), (True, 2.0))
        self.assertTrue(figure(scorers.error_rows([withheld, case(answer("named"))]), "extended model withheld").startswith("1 of 2"))

    def test_the_ridge_is_beaten_where_its_error_is_larger(self):
        cases = [case(answer("named", 0.02, 0.01), ridge_v=0.015), case(answer("named", 0.02, 0.01), ridge_v=0.005),
                 case(answer("named", 0.02, 0.01), ridge_v=None)]
        self.assertTrue(figure(scorers.error_rows(cases), "extended better than ridge").startswith("1 of 2"))

    def test_an_answer_without_a_fit_has_no_ratio(self):
        self.assertIsNone(case(dict(answer("insufficient_data"), fit=None)).over_base())
        self.assertEqual(figure(scorers.error_rows([case(dict(answer("unknown"), fit=None))]), "at most half the base's"), "no case")


class Probabilities(unittest.TestCase):
    def test_each_family_claims_once_and_nulls_make_it_wrong(self):
        said = answer("named", mechanism="acid", probability=0.95, effects=[{"id": "x", "mechanism": "acid", "probability": 0.4},
                                                                         {"id": "y", "mechanism": "structure", "probability": 0.6}])
        self.assertEqual(case(said).claims, [("acid", 0.95, True), ("structure", 0.6, False)])
        self.assertEqual(case(said, kind="null").claims, [("acid", 0.95, False), ("structure", 0.6, False)])

    def test_may_be_absent(self):
        self.assertEqual(case(answer("named", mechanism="acid")).claims, [])
        self.assertEqual(case(answer("named", probability=0.9)).claims, [])

    def test_bins_have_their_lower_end_and_the_last_both(self):
        cases = [case(answer("named", mechanism=mechanism, probability=p)) for mechanism, p in
                 (("acid", 0.2), ("acid", 0.5), ("ageing", 0.9), ("acid", 1.0))]
        self.assertEqual(scorers.reliability(cases), [("0 to 0.5", 1, 1), ("0.5 to 0.7", 1, 1), ("0.7 to 0.9", 0, 0), ("0.9 to 1", 1, 2)])


class Ridge(unittest.TestCase):
    def current(self):
        dice = np.random.default_rng(1)
        return np.repeat(dice.uniform(-50.0, 40.0, 300), 50), np.arange(15000) / 10.0

    def test_finds_what_currents_and_memories_make(self):
        current, time = self.current()
        voltage = 12.7 + 0.005 * current + 0.002 * ridge.low_pass(current, 0.1, 30.0)
        noise = np.random.default_rng(2).normal(0.0, 1e-3, len(time))
        self.assertLess(ridge.ridge_rmse(time, current, voltage + noise), 1.3e-3)

    def test_is_blind_to_what_is_not_of_the_current(self):
        current, time = self.current()
        wave = 0.02 * np.sin(2.0 * np.pi * time / 37.0)
        self.assertGreater(ridge.ridge_rmse(time, current, 12.7 + wave), 0.012)

    def test_learns_nothing_from_the_last_quarter(self):
        current, time = self.current()
        voltage = 12.7 + 0.005 * current
        voltage[11250:] += 0.1
        self.assertAlmostEqual(ridge.ridge_rmse(time, current, voltage), 0.1, delta=0.01)

    def test_a_low_pass_comes_to_rest_at_its_input(self):
        step = np.concatenate(([0.0], np.ones(1000)))
        passed = ridge.low_pass(step, 0.1, 5.0)
        self.assertEqual(passed[0], 0.0)
        self.assertAlmostEqual(passed[50], 1.0 - np.exp(-1.0), places=2)
        self.assertAlmostEqual(passed[-1], 1.0, places=6)


class Whole(unittest.TestCase):
    """With stand-ins for both programs; the one for sof says what it was shown."""

    DRAW = """#!/usr/bin/python3
import json, sys
if "--list" in sys.argv:
    print("control - -\\nout_of_catalogue acid a"); sys.exit()
o = dict(zip(sys.argv[1::2], sys.argv[2::2]))
rows = "".join(f"{k / 10:g},{(k // 50 % 3 - 1) * 20},{12.7 + (k // 50 % 3 - 1) * 0.1}\\n" for k in range(6000))
open(o["--out"], "w").write("time_s,current_a,voltage_v\\n" + rows)
json.dump({"kind": o["--kind"], "mechanism": o.get("--mechanism"), "id": o.get("--id")}, open(o["--label"], "w"))
"""
    SOF = """#!/usr/bin/python3
import json, os, sys
with open(os.environ["SHOWN"], "a") as f:
    f.write(" ".join(sys.argv[1:]) + " | " + " ".join(sorted(os.listdir("."))) + "\\n")
side = {"holdout": {"rmse_v": 0.02}}
json.dump({"verdict": "unexplained", "mechanism": "acid", "effects": [], "fit": {"base": side, "extended": side}}, open("answer.json", "w"))
"""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.programs = os.path.join(self.folder.name, "devel", "lib", "battery_sof")
        os.makedirs(self.programs)
        self.write("draw_scenario", self.DRAW)
        self.write("sof", self.SOF)
        os.environ["SHOWN"] = os.path.join(self.folder.name, "shown")

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, text):
        file = os.path.join(self.programs, name)
        with open(file, "w") as f:
            f.write(text)
        os.chmod(file, os.stat(file).st_mode | stat.S_IXUSR)

    def arguments(self, *more):
        return out_of_model.arguments(["--build", self.folder.name, "--out", os.path.join(self.folder.name, "out"),
                                  "--kinds", "null=1,other_form=2", "--jobs", "1", *more])

    def shown(self):
        with open(os.environ["SHOWN"]) as f:
            return f.read().splitlines()

    def test_shows_one_file_of_a_neutral_name_and_asks_once(self):
        out_of_model.gather(self.arguments())
        self.assertEqual(self.shown(), ["diagnose recording.csv --json answer.json --threads 1 | recording.csv"] * 3)
        kept = os.path.join(self.folder.name, "out", "answers.jsonl")
        rows = [row for row in lines_of(kept) if row["name"] != "case_0002"]
        with open(kept, "w") as file:
            file.writelines(json.dumps(row) + "\n" for row in rows)
        out_of_model.gather(self.arguments())
        self.assertEqual(len(self.shown()), 4)
        cases, failed = out_of_model.opened(self.arguments().out)
        self.assertEqual((len(cases), failed), (3, []))
        text = out_of_model.as_markdown(cases, failed)
        self.assertIn("| alarms | 1 of 1", text)
        self.assertIn("| mechanism right | 2 of 2", text)
        self.assertEqual(len(json.loads(out_of_model.as_json(cases, failed))["cases"]), 3)

    def test_answers_of_another_build_are_not_mixed_in(self):
        out_of_model.gather(self.arguments())
        self.write("sof", self.SOF + "# another\n")
        self.assertRaises(SystemExit, out_of_model.gather, self.arguments())

    def test_other_cases_are_not_mixed_in(self):
        out_of_model.gather(self.arguments())
        self.assertRaises(SystemExit, out_of_model.gather, self.arguments("--seed", "2"))

    def test_an_answer_that_fails_is_told_and_not_judged(self):
        self.write("sof", "#!/usr/bin/python3\nimport sys\nsys.exit(3)\n")
        out_of_model.gather(self.arguments())
        cases, failed = out_of_model.opened(self.arguments().out)
        self.assertEqual((len(cases), len(failed)), (0, 3))
        self.assertIn("exit code 3", out_of_model.as_markdown(cases, failed))


if __name__ == "__main__":
    unittest.main()

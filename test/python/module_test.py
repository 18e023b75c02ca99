"""The Python module beside the command `sof` on the same recording: the same numbers, and errors in the core's words."""

import dataclasses
import inspect
import json
import locale
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import typing
import unittest
from pathlib import Path

import numpy as np

import battery_sof
from battery_sof import api, results

SOF = os.environ["BATTERY_SOF_COMMAND"]
SCENARIO = Path(__file__).parents[2] / "config" / "scenarios" / "city_drive.yaml"
PAGE = Path(__file__).parents[2] / "docs" / "cpp-and-python.md"


def set_german(folder):
    """Numbers with a comma, where a German locale is installed or can be made in the folder."""
    made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE)
    if made.returncode == 0:
        os.environ["LOCPATH"] = str(folder)
    try:
        locale.setlocale(locale.LC_ALL, "de_DE.UTF-8")
    except locale.Error:
        return False
    return True


class Drive(unittest.TestCase):
    """A drive of six minutes, and what `sof` says of it."""

    @classmethod
    def setUpClass(cls):
        cls.keeper = tempfile.TemporaryDirectory(prefix="battery sof ")
        cls.addClassCleanup(cls.keeper.cleanup)
        cls.folder = Path(cls.keeper.name)
        cls.csv, cls.yaml = cls.folder / "drive.csv", cls.folder / "model.yaml"
        subprocess.run([SOF, "simulate", SCENARIO, cls.csv, "--duration", "360"], check=True, stdout=subprocess.PIPE)
        cls.told = cls.sof("identify", cls.csv, "--from", "0", "--to", "240", "--out", cls.yaml)
        cls.recording = battery_sof.Recording.from_csv(cls.csv)
        cls.model = battery_sof.identify(cls.recording, from_s=0.0, to_s=240.0)

    @staticmethod
    def sof(*arguments):
        done = subprocess.run([SOF, *map(str, arguments), "--json", "-"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if done.returncode == 2:
            raise AssertionError(done.stderr.decode())
        return json.loads(done.stdout)

    def assert_same(self, ask, told):
        """The saved model answers with the command's very numbers; the fitted one's covariance has not been through text."""
        self.assertEqual(told, dataclasses.asdict(ask(battery_sof.Model.read(self.yaml))))
        for name, value in dataclasses.asdict(ask(self.model)).items():
            if isinstance(value, float):
                self.assertAlmostEqual(value, told[name], delta=1e-9 * abs(value), msg=name)
            else:
                self.assertEqual(value, told[name], name)


class TestRecording(Drive):
    def test_arrays_and_file_give_the_same_samples(self):
        columns = np.loadtxt(self.csv, delimiter=",", skiprows=1, unpack=True)
        recording = battery_sof.Recording(*columns[:3])
        for name in ("time_s", "current_a", "voltage_v"):
            np.testing.assert_array_equal(getattr(recording, name), getattr(self.recording, name))
        self.assertEqual(len(recording), 36000)
        self.assertEqual(recording.time_s.dtype, np.float64)

    def test_what_cannot_be_a_sample_is_refused_and_counted(self):
        t = [0.0, 1.0, 1.0, 2.0, 3.0, *range(4, 20)]
        i = [1.0, math.nan, 1.0, 6000.0, math.inf, *[1.0] * 16]
        recording = battery_sof.Recording(t, i, [12.0] * 21)
        self.assertEqual((len(recording), recording.offered), (18, 21))
        self.assertEqual((recording.rejected["missing_value"], recording.rejected["not_finite"],
                          recording.rejected["out_of_range"]), (1, 1, 1))

    def test_what_is_masked_is_missing(self):
        columns = [np.arange(20.0), np.ma.masked_equal(np.arange(20), 3), np.ma.masked_inside(12.0 + np.arange(20.0), 30.5, 40.0)]
        recording = battery_sof.Recording(*columns, np.ma.masked_all(20))
        np.testing.assert_array_equal(recording.time_s, [0, 1, 2, *range(4, 19)])
        self.assertEqual(recording.rejected["missing_value"], 2)

    def test_a_file_name_that_is_not_utf8_is_read_and_named(self):
        path = os.fsdecode(os.fsencode(self.folder) + b"/n\xff.csv")
        shutil.copy(self.csv, path)
        recording = battery_sof.Recording.from_csv(path)
        self.assertEqual(recording.name, r"n\xff.csv")
        model = battery_sof.identify(recording, from_s=0.0, to_s=240.0)
        saved = Path(path).with_suffix(".yaml")
        model.save(saved)
        self.assertEqual(battery_sof.Model.read(saved).rmse_v, model.rmse_v)
        with self.assertRaisesRegex(ValueError, r'n\\xff.csv: has no column "amps"'):
            battery_sof.Recording.from_csv(path, current_column="amps")
        with self.assertRaisesRegex(RuntimeError, r"cannot write .*/n\\xff/model.yaml: No such file"):
            model.save(Path(path).with_suffix("") / "model.yaml")
        self.assertEqual(battery_sof.Recording([0], [1], [12], name=recording.name).name, recording.name)

    def test_errors_are_the_cores_sentences(self):
        with self.assertRaisesRegex(ValueError, "^current_a has 2 values, expected 3 as time_s$"):
            battery_sof.Recording([0, 1, 2], [1, 2], [12, 12, 12])
        with self.assertRaisesRegex(ValueError, "^time_s has 2 dimensions, expected one$"):
            battery_sof.Recording([[0, 1]], [1, 2], [12, 12])
        with self.assertRaisesRegex(ValueError, "^arrays: has no sample, expected at least one$"):
            battery_sof.Recording([], [], [])
        with self.assertRaisesRegex(ValueError, "back: is not sorted by time: 2 of 3 samples go back in time"):
            battery_sof.Recording([3, 2, 1], [1, 1, 1], [12, 12, 12], name="back")
        with self.assertRaisesRegex(ValueError, "none.csv: cannot be read: No such file"):
            battery_sof.Recording.from_csv(self.folder / "none.csv")
        with self.assertRaisesRegex(ValueError, 'has no column "amps"; its columns are: time_s, current_a, voltage_v'):
            battery_sof.Recording.from_csv(self.csv, current_column="amps")

    def test_the_other_sign_of_current_is_turned_round(self):
        turned = battery_sof.Recording.from_csv(self.csv, discharge_positive=True)
        np.testing.assert_array_equal(turned.current_a, -self.recording.current_a)


class TestModel(Drive):
    def test_parameters_and_scores_are_those_of_the_command(self):
        self.assertEqual([dataclasses.asdict(each) for each in self.model.parameters.values()],
                         [{**each} for each in self.told["parameters"]])
        for name in ("samples", "effects", "status", "message", "q_dyn_percent", "rmse_v", "window_quality"):
            self.assertEqual(getattr(self.model, name), self.told[name], name)
        self.assertEqual((self.model.from_s, self.model.to_s), (0.0, 240.0))
        self.assertTrue(self.model.usable)

    def test_covariance_is_that_of_the_standard_errors(self):
        count = len(self.model.parameters)
        self.assertEqual(self.model.covariance.shape, (count + 1, count + 1))
        errors = [each.std_error for each in self.model.parameters.values()]
        np.testing.assert_allclose(np.sqrt(np.diag(self.model.covariance))[:count], errors, rtol=1e-12)

    def test_the_file_is_the_one_the_command_writes(self):
        path = self.folder / "saved.yaml"
        self.model.save(path)
        lines = [[line for line in file.read_text().splitlines() if "fit_ms" not in line] for file in (path, self.yaml)]
        self.assertEqual(lines[0], lines[1])

    def test_a_model_that_was_saved_answers_as_before(self):
        path = self.folder / "again.yaml"
        self.model.save(path)
        question = dict(i_load=-15.0, t_stop=60.0, i_cranking=-400.0)
        before, after = (battery_sof.crank(model, **question) for model in (self.model, battery_sof.Model.read(path)))
        self.assertAlmostEqual(before.u_min, after.u_min, places=12)

    def test_a_recording_without_a_change_gives_no_usable_model_and_says_why(self):
        n = np.arange(1000.0)
        model = battery_sof.identify(battery_sof.Recording(n, 0 * n - 1.0, 0 * n + 12.5))
        self.assertFalse(model.usable)
        self.assertNotEqual(model.message, "")
        self.assertEqual((model.q_dyn_percent, model.rmse_v, model.state_time_s), (None, None, None))
        with self.assertRaisesRegex(ValueError, "^no model: "):
            model.save(self.folder / "unusable.yaml")
        with self.assertRaisesRegex(ValueError, "^no model: "):
            battery_sof.predict(model, self.recording)
        self.assertFalse(battery_sof.crank(model, i_load=0.0, t_stop=1.0, i_cranking=-100.0).valid)

    def test_errors_are_the_cores_sentences(self):
        with self.assertRaisesRegex(ValueError, r"no sample from 500.000 to 600.000 s; the recording holds 0.000 to 359.990 s"):
            battery_sof.identify(self.recording, from_s=500.0, to_s=600.0)
        for window in (dict(from_s=math.nan), dict(to_s=math.inf), dict(from_s=0.0, to_s=math.nan)):
            with self.assertRaisesRegex(ValueError, "^the range is .* s, expected finite times"):
                battery_sof.identify(self.recording, **window)
            with self.assertRaisesRegex(ValueError, "^the range is .* s, expected finite times"):
                battery_sof.predict(self.model, self.recording, **window)
        with self.assertRaisesRegex(ValueError, "gasing"):
            battery_sof.identify(self.recording, effects=["gasing"])
        with self.assertRaisesRegex(ValueError, 'start is "cold", expected robust or paper'):
            battery_sof.identify(self.recording, start="cold")
        broken = self.folder / "broken.yaml"
        broken.write_text("schema: other\n")
        with self.assertRaisesRegex(ValueError, 'broken.yaml: schema is "other", expected "battery_sof/model/2"'):
            battery_sof.Model.read(broken)

    def test_a_null_byte_in_a_path_is_an_error_and_writes_nothing(self):
        path = str(self.folder / "cut") + "\0off.yaml"
        for use in (self.model.save, battery_sof.Model.read, battery_sof.Recording.from_csv):
            with self.assertRaisesRegex(ValueError, "cut.*has a null byte in it"):
                use(path)
        self.assertFalse((self.folder / "cut").exists())


class TestAnswers(Drive):
    def test_crank(self):
        self.assert_same(
            lambda model: battery_sof.crank(model, i_load=-15.0, t_stop=60.0, i_cranking=-400.0, u_required=7.2),
            self.sof("crank", self.yaml, "--i-load=-15", "--t-stop=60", "--i-cranking=-400", "--u-required=7.2"))

    def test_stop_time(self):
        self.assert_same(lambda model: battery_sof.stop_time(model, i_load=-15.0, i_cranking=-400.0, u_required=8.0),
                         self.sof("stop-time", self.yaml, "--i-load=-15", "--i-cranking=-400", "--u-required=8"))

    def test_charge(self):
        self.assert_same(lambda model: battery_sof.charge(model, u_boost=14.2, t_sof2=5.0, i_limit=80.0),
                         self.sof("charge", self.yaml, "--u-boost=14.2", "--t-sof2=5", "--i-limit=80"))

    def test_a_rested_model_answers_as_with_rested(self):
        self.assert_same(
            lambda model: battery_sof.crank(model.rested(), i_load=-15.0, t_stop=60.0, i_cranking=-400.0),
            self.sof("crank", self.yaml, "--i-load=-15", "--t-stop=60", "--i-cranking=-400", "--rested"))

    def test_rested_is_an_argument_of_every_question(self):
        rested = self.model.rested()
        for ask in (lambda model, **more: battery_sof.crank(model, i_load=-15.0, t_stop=60.0, i_cranking=-250.0, **more),
                    lambda model, **more: battery_sof.stop_time(model, i_load=-15.0, i_cranking=-250.0, u_required=8.0, **more),
                    lambda model, **more: battery_sof.charge(model, u_boost=14.2, t_sof2=5.0, i_limit=80.0, **more)):
            self.assertEqual(ask(self.model, rested=True), ask(rested))
            self.assertEqual(ask(self.model, rested=False), ask(self.model))
        crank = dict(i_load=-15.0, t_stop=60.0, i_cranking=-250.0)
        self.assertNotEqual(battery_sof.crank(self.model, **crank), battery_sof.crank(self.model, rested=True, **crank))

    def test_a_question_that_is_none_is_an_error(self):
        with self.assertRaisesRegex(ValueError, "i_cranking"):
            battery_sof.crank(self.model, i_load=-15.0, t_stop=60.0, i_cranking=400.0)
        with self.assertRaisesRegex(ValueError, "u_boost"):
            battery_sof.charge(self.model, u_boost=-1.0)

    def test_a_capacity_that_is_none_is_an_error_as_in_the_command(self):
        for capacity in (math.nan, math.inf, -1.0, 0.0):
            for ask in (lambda **more: battery_sof.crank(self.model, i_load=-15.0, t_stop=60.0, i_cranking=-400.0, **more),
                        lambda **more: battery_sof.stop_time(self.model, i_load=-15.0, i_cranking=-400.0, u_required=8.0, **more),
                        lambda **more: battery_sof.charge(self.model, u_boost=14.2, **more)):
                with self.assertRaisesRegex(ValueError, f"^capacity_ah is -?{capacity:g}, expected above 0 and finite"):
                    ask(capacity_ah=capacity)
            with self.assertRaisesRegex(AssertionError, "--capacity-ah is .*, expected"):
                self.sof("charge", self.yaml, "--u-boost=14.2", f"--capacity-ah={capacity}")

    def test_prediction(self):
        prediction = battery_sof.predict(self.model, self.recording, from_s=240.0, to_s=360.0)
        path = self.folder / "prediction.csv"
        told = self.sof("predict", self.yaml, self.csv, "--from", "240", "--to", "360", "--csv", path)
        for name in ("q_dyn_percent", "rmse_v", "max_abs_v", "coverage_90", "crank_mae_v"):
            self.assertAlmostEqual(getattr(prediction, name), told[name], places=9)
        self.assertGreater(len(prediction.cranks), 0)
        self.assertEqual(len(prediction.cranks), len(told["cranks"]))
        written = np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding=None)
        for name in ("time_s", "current_a", "voltage_v", "predicted_v", "lower_v", "upper_v", "predicted_a"):
            np.testing.assert_allclose(getattr(prediction, name), written[name], atol=6e-7, err_msg=name)
        np.testing.assert_array_equal(prediction.voltage_controlled, written["driven_by"] == "voltage")

    def test_a_row_of_two_blocks_answers_in_its_own_volts(self):
        row = battery_sof.Recording(self.recording.time_s, self.recording.current_a, 2.0 * self.recording.voltage_v)
        model = battery_sof.identify(row, from_s=0.0, to_s=240.0, series_blocks=2.0)
        self.assertEqual(self.model.parameters, model.parameters)
        one, two = (battery_sof.crank(each, i_load=-15.0, t_stop=60.0, i_cranking=-400.0) for each in (self.model, model))
        self.assertAlmostEqual(2.0 * one.u_min, two.u_min, places=9)
        one = battery_sof.predict(self.model, self.recording, from_s=240.0)
        two = battery_sof.predict(model, row, from_s=240.0)
        np.testing.assert_allclose(two.predicted_v, 2.0 * one.predicted_v, rtol=1e-12)
        with self.assertRaisesRegex(ValueError, "blocks is 3.3, expected 0.5 "):
            battery_sof.identify(row, series_blocks=3.3)
        with self.assertRaisesRegex(ValueError, "blocks is 0, expected 0.5 "):
            battery_sof.diagnose(row, series_blocks=0.0)

    def test_a_direction_that_is_none_is_an_error(self):
        with self.assertRaisesRegex(ValueError, 'mode is "voltage", expected mixed, current or None'):
            battery_sof.predict(self.model, self.recording, mode="voltage")

    def test_the_locale_changes_nothing(self):
        before = locale.setlocale(locale.LC_ALL)
        self.addCleanup(os.environ.pop, "LOCPATH", None)
        self.addCleanup(locale.setlocale, locale.LC_ALL, before)
        if not set_german(self.folder):
            self.skipTest("no German locale, and no package `locales` to make one of")
        self.assertEqual(locale.format_string("%.1f", 1.5), "1,5")
        recording = battery_sof.Recording.from_csv(self.csv)
        np.testing.assert_array_equal(recording.voltage_v, self.recording.voltage_v)
        read = battery_sof.Model.read(self.yaml)
        self.assertEqual(read.rmse_v, self.told["rmse_v"])


class TestDiagnosis(Drive):
    def test_diagnosis_is_that_of_the_command(self):
        diagnosis = battery_sof.diagnose(self.recording, from_s=0.0, to_s=300.0, given=["cpe2"])
        model = self.folder / "extended.yaml"
        told = self.sof("diagnose", self.csv, "--from", "0", "--to", "300", "--given", "cpe2", "--out", model)
        for name in ("verdict", "summary", "mechanism", "probability", "next_experiment"):
            self.assertEqual(getattr(diagnosis, name), told[name], name)
        self.assertEqual(diagnosis.details["fit"], told["fit"])
        self.assertEqual(diagnosis.extended_holdout.rmse_v, told["fit"]["extended"]["holdout"]["rmse_v"])
        self.assertEqual(diagnosis.extended.effects, battery_sof.Model.read(model).effects)
        self.assertEqual(diagnosis.time_s.shape, diagnosis.extended_voltage_v.shape)
        self.assertTrue(diagnosis.effects)
        for effect, one in zip(diagnosis.effects, told["effects"]):
            self.assertEqual([each.std_error for each in effect.parameters], [each["std"] for each in one["parameters"]], effect.id)
        page = self.folder / "page.html"
        diagnosis.write_page(page)
        self.assertIn(diagnosis.summary.split(",")[0].split("'")[0], page.read_text())

    def test_what_has_changed_since_a_reference_is_that_of_the_command(self):
        now = battery_sof.Recording(self.recording.time_s, self.recording.current_a,
                                    self.recording.voltage_v + 0.01 * self.recording.current_a)
        change = battery_sof.diagnose(now, reference=self.recording)
        self.assertEqual(change.verdict, "changed")
        self.assertEqual(change.changes[0].id, "contact_resistance")
        self.assertAlmostEqual(change.changes[0].now, 0.01, delta=0.002)
        csv = self.folder / "now.csv"
        np.savetxt(
            csv, np.column_stack((now.time_s, now.current_a, now.voltage_v)), "%.9f", ",", header="time_s,current_a,voltage_v", comments="")
        told = self.sof("diagnose", csv, "--reference", self.csv)
        self.assertEqual(change.verdict, told["verdict"])
        self.assertAlmostEqual(change.changes[0].now, told["changes"][0]["now"], places=5)
        model = battery_sof.identify(self.recording)
        from_model = battery_sof.diagnose(now, reference=model)
        self.assertEqual(from_model.changes[0].id, "contact_resistance")
        self.assertAlmostEqual(from_model.changes[0].now, change.changes[0].now, delta=0.001)
        with self.assertRaisesRegex(ValueError, "reference is empty, expected at least one recording or model"):
            battery_sof.diagnose(now, reference=[])
        with self.assertRaisesRegex(ValueError, "expected without holdout_share"):
            battery_sof.diagnose(now, reference=self.recording, given=["cpe2"])

    def test_other_threads_run_while_it_works(self):
        ticks, done = [], threading.Event()

        def tick():
            while not done.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.002)

        interval = sys.getswitchinterval()
        ticker = threading.Thread(target=tick)
        ticker.start()
        begin = time.monotonic()
        battery_sof.identify(self.recording, effects=["cpe2", "gassing"])
        took = time.monotonic() - begin
        done.set()
        ticker.join()
        self.assertGreater(took, 5 * interval)
        during = [each for each in ticks if begin < each < begin + took]
        self.assertGreater(len(during), took / 0.05)

    def test_a_share_that_is_none_is_an_error(self):
        with self.assertRaisesRegex(ValueError, "holdout_share is"):
            battery_sof.diagnose(self.recording, holdout_share=2.0)


class TestPage(unittest.TestCase):
    def test_its_example_prints_what_it_says(self):
        code, output = PAGE.read_text().split("## Python\n", 1)[1].split("\nprints\n", 1)
        block = re.search(r"(?:    .*\n|\n)*    .*\n", code[code.index("    import battery_sof"):]).group()
        said = textwrap.dedent(re.search(r"(?:    .*\n)+", output).group())
        with tempfile.TemporaryDirectory(prefix="battery sof ") as folder:
            subprocess.run([SOF, "simulate", SCENARIO, "drive.csv", "--duration", "600"], check=True, cwd=folder,
                           stdout=subprocess.PIPE)
            drawing = Path(folder) / "matplotlib"
            drawing.mkdir()
            (drawing / "__init__.py").touch()
            (drawing / "pyplot.py").write_text("def __getattr__(name):\n    return lambda *values, **options: None\n")
            done = subprocess.run([sys.executable, "-c", textwrap.dedent(block)], cwd=folder, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE)
        self.assertEqual(done.stderr.decode(), "")
        self.assertEqual(done.stdout.decode(), said)
        self.assertIn("answer.valid", block)


    def test_its_session_follows_the_drive(self):
        page = PAGE.read_text()
        block = re.search(r"(?:    .*\n|\n)*    .*\n", page[page.index("    session = battery_sof.Session("):]).group()
        with tempfile.TemporaryDirectory(prefix="battery sof ") as folder:
            subprocess.run([SOF, "simulate", SCENARIO, "drive.csv", "--duration", "400"], check=True, cwd=folder,
                           stdout=subprocess.PIPE)
            program = ('import battery_sof\nrecording = battery_sof.Recording.from_csv("drive.csv")\n' + textwrap.dedent(block) +
                       "print(answer.valid)\n")
            done = subprocess.run([sys.executable, "-c", program], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.stderr.decode(), "")
        self.assertRegex(done.stdout.decode(), r"(?s)^converged after .*True\n$")


class TestSession(Drive):
    QUESTION = dict(i_load=-15.0, t_stop=60.0, i_cranking=-150.0, t_cranking=0.5)

    def followed(self):
        session, told = battery_sof.Session(capacity_ah=60.0), []
        r = self.recording
        for n in range(0, 36000, 1000):
            session.push(r.time_s[n:n + 1000], r.current_a[n:n + 1000], r.voltage_v[n:n + 1000])
            told.append(session.identify_when_due())
        return session, [one for one in told if one]

    def test_it_follows_a_drive_and_answers_as_its_model_does(self):
        session, told = self.followed()
        self.assertTrue(told)
        self.assertTrue(session.model.usable)
        self.assertGreater(session.model.samples, 1000)
        self.assertEqual(session.model.state_time_s, self.recording.time_s[-1])
        here = session.crank(u_required=7.2, **self.QUESTION)
        there = battery_sof.crank(session.model, u_required=7.2, **self.QUESTION)
        self.assertAlmostEqual(here.u_min, there.u_min, delta=1e-9)
        self.assertEqual((here.capable, here.valid), (there.capable, there.valid))
        stop = session.stop_time(i_load=-15.0, i_cranking=-150.0, u_required=7.2)
        self.assertEqual(stop.t_stop, battery_sof.stop_time(session.model, i_load=-15.0, i_cranking=-150.0, u_required=7.2).t_stop)
        self.assertIsNotNone(session.charge(u_boost=14.0).i_boost)

    def test_one_sample_at_a_time_is_the_same(self):
        one, many = battery_sof.Session(), battery_sof.Session()
        r = self.recording
        many.push(r.time_s[:50], r.current_a[:50], r.voltage_v[:50], np.full(50, 20.0))
        for n in range(50):
            one.push(r.time_s[n], r.current_a[n], r.voltage_v[n], 20.0)
        self.assertEqual(one.crank(**self.QUESTION), many.crank(**self.QUESTION))

    def test_before_the_first_sample_it_says_why_there_is_no_answer(self):
        session = battery_sof.Session()
        self.assertIsNone(session.model)
        self.assertIsNone(session.identify_when_due())
        answer = session.crank(**self.QUESTION)
        self.assertFalse(answer.valid)
        self.assertIn("no model has been identified yet", answer.message)
        self.assertTrue(session.reason)

    def test_the_model_of_an_earlier_drive_is_taken(self):
        session = battery_sof.Session()
        session.restore(self.model)
        later = self.recording.time_s[-1] + 3600.0 + 0.01 * np.arange(200)
        session.push(later, np.zeros(200), np.full(200, 12.6))
        self.assertEqual((session.model.from_s, session.model.to_s), (self.model.from_s, self.model.to_s))

    def test_wrong_settings_sizes_and_queries_are_errors(self):
        with self.assertRaisesRegex(ValueError, "capacity_ah is 0, expected above 0"):
            battery_sof.Session(capacity_ah=0.0)
        with self.assertRaisesRegex(ValueError, "series_blocks"):
            battery_sof.Session(series_blocks=-1.0)
        session = battery_sof.Session()
        with self.assertRaisesRegex(ValueError, "current_a has 1 values, expected 2 as time_s"):
            session.push([0.0, 1.0], [1.0], [12.0, 12.0])
        session.push(0.0, -1.0, 12.5)
        with self.assertRaisesRegex(ValueError, "i_cranking"):
            session.crank(i_load=-15.0, t_stop=60.0, i_cranking=150.0)


class TestDescriptions(unittest.TestCase):
    def test_everything_public_is_described_and_typed(self):
        for name in battery_sof.__all__:
            thing = getattr(battery_sof, name)
            self.assertTrue(inspect.getdoc(thing), name)
            if inspect.isfunction(thing):
                hints = typing.get_type_hints(thing, vars(api))
                self.assertEqual(set(inspect.signature(thing).parameters) | {"return"}, set(hints), name)

    def test_fields_of_results_are_typed(self):
        self.assertEqual(typing.get_type_hints(results.CrankAnswer)["u_min"], typing.Optional[float])

    def test_help_names_the_fields_of_a_crank_and_when_to_rely_on_an_answer(self):
        for name, words in (("results.CrankScore", ("time_s", "measured_min_v", "predicted_min_v", "lower_v", "[V]")),
                            ("CrankScore", ("measured_min_v",)), ("api", ("identify",)), ("crank", ("valid", "rested"))):
            done = subprocess.run([sys.executable, "-c", f"import battery_sof; help(battery_sof.{name})"],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, done.stderr.decode())
            for word in words:
                self.assertIn(word, done.stdout.decode(), name)

    def test_the_page_names_every_field_of_a_crank(self):
        page = PAGE.read_text()
        for field in dataclasses.fields(results.CrankScore):
            self.assertRegex(page, rf"\|[^|\n]*`{field.name}`[^|\n]*\|")

    def test_names_that_are_none_are_an_error(self):
        with self.assertRaisesRegex(AttributeError, "has no attribute 'crnak'"):
            battery_sof.crnak

    def test_the_stub_names_what_the_compiled_part_has(self):
        from battery_sof import _core
        stub = Path(_core.__file__).with_name("_core.pyi").read_text()
        for name in dir(_core):
            if not name.startswith("_"):
                self.assertRegex(stub, rf"(def|class) {name}\b")

    def test_version_is_the_commands(self):
        said = subprocess.run([SOF, "--version"], check=True, stdout=subprocess.PIPE).stdout.decode()
        self.assertEqual(said.strip(), "sof " + battery_sof.version())


if __name__ == "__main__":
    unittest.main()

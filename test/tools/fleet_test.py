"""sof-fleet: recordings into rows, whatever the order, the cores and what was cut off; false discoveries; the page.

Exit code 77: skipped, Snakemake or statsmodels is not installed.
"""

import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

try:
    import numpy as np
    import statsmodels  # noqa: F401
except ImportError as absent:
    print(f"SKIPPED: {absent.name} is not installed")
    sys.exit(77)
if not shutil.which("snakemake"):
    print("SKIPPED: snakemake is not installed")
    sys.exit(77)

from battery_sof_tools import recordings
from battery_sof_tools.files import ROOT
from battery_sof_tools.fleet import database, outliers, discoveries, judge, listing, page, plan, schema
from battery_sof_tools.sof import program

SOF = program(os.environ["BATTERY_SOF_BUILD"], "sof")
QUICK = ("--steps", "check,convert,identify,predict,score", "--jobs", "2", "--sof", SOF)


def drive(seed, count=240):
    """Held currents [A] once a second, and a battery of 5 mOhm."""
    dice = np.random.default_rng(seed)
    i = np.repeat(dice.uniform(-80.0, 40.0, count // 8), 8)
    t = np.arange(float(len(i)))
    slow = np.array([np.sum(i[max(0, k - 60):k + 1] * np.exp(-np.arange(min(k, 60), -1, -1) / 20.0)) for k in range(len(i))]) / 20.0
    return t, i, 12.5 + 5e-3 * i + 4e-3 * slow + dice.normal(0.0, 2e-3, len(i))


def fleet(*arguments, **more):
    return subprocess.run([sys.executable, os.path.join(ROOT, "scripts", "sof-fleet"), *arguments], capture_output=True, text=True, check=False, **more)


class Folder(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)

    def path(self, *names):
        return os.path.join(self.temporary.name, *names)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)


class Listing(Folder):
    def test_paths_of_a_list_are_beside_it_and_unknown_columns_are_named(self):
        path = self.write("list.csv", "path,battery,age_years,discharge_positive\na.csv,one,2.5,yes\nb.csv,,,\n")
        first, second = listing.entries([path])
        self.assertEqual((first["path"], first["battery"], first["age_years"], first["discharge_positive"]), (self.path("a.csv"), "one", 2.5, True))
        self.assertEqual((second["battery"], second["discharge_positive"], "age_years" in second), ("b", False, False))
        with self.assertRaisesRegex(SystemExit, "row 1: no column batery"):
            listing.entries([self.write("wrong.yaml", "- {path: a.csv, batery: x}\n")])

    def test_files_that_are_called_alike_are_batteries_of_their_own(self):
        paths = ("a/van_3/mo.csv", "a/van_4/mo.csv", "b/van_4/mo.csv", "b/van_4/mo.bag", "b/tu.csv")
        rows = listing.named([{"path": "/x/" + path} for path in paths] + [{"path": "/y/mo.csv", "battery": "mine"}])
        self.assertEqual([row["battery"] for row in rows], ["van_3/mo", "a/van_4/mo", "b/van_4/mo", "b/van_4/mo", "tu", "mine"])

    def test_the_same_content_is_one_recording_and_another_reading_of_it_is_another(self):
        self.write("a.csv", "time_s,current_a,voltage_v\n0,1,12\n")
        shutil.copy(self.path("a.csv"), self.path("b.csv"))
        keys = [plan.described(one)["key"] for one in listing.entries([self.path("a.csv"), self.path("b.csv"), self.write("l.yaml", "- {path: a.csv, discharge_positive: true}\n")])]
        self.assertEqual(keys[0], keys[1])
        self.assertNotEqual(keys[0], keys[2])

    def test_every_recording_is_in_one_group_and_no_group_is_too_large(self):
        entries = [{"key": str(k), "bytes": 1e6 * (k % 12)} for k in range(100)]
        made = plan.groups(entries, 1)
        self.assertEqual(sorted(key for group in made for key in group), sorted(one["key"] for one in entries))
        size = {one["key"]: one["bytes"] for one in entries}
        self.assertTrue(all(len(group) == 1 or sum(size[key] for key in group) <= plan.GROUP_BYTES for group in made))


class Run(Folder):
    """Four recordings and two that cannot be read, in several ways to the same rows."""

    @classmethod
    def setUpClass(cls):
        cls.kept = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.kept.cleanup)
        cls.data = os.path.join(cls.kept.name, "data")
        os.makedirs(cls.data)
        for k in range(4):
            recordings.write(os.path.join(cls.data, f"r{k}.csv"), *drive(k))
        with open(os.path.join(cls.data, "cut.csv"), "w") as file:
            file.write("time_s,current_a,voltage_v\n0,1\n")
        os.symlink("nowhere", os.path.join(cls.data, "gone.csv"))
        subprocess.run([SOF, "convert", os.path.join(cls.data, "r0.csv"), os.path.join(cls.data, "bag.bag")], check=True, capture_output=True)
        cls.out = os.path.join(cls.kept.name, "out")
        cls.told = fleet("run", cls.data, "--out", cls.out, *QUICK)
        cls.digest = database.digest(cls.out)

    def rows(self, query):
        base = sqlite3.connect(os.path.join(self.out, database.NAME))
        self.addCleanup(base.close)
        return base.execute(query).fetchall()

    def test_a_failed_recording_is_a_row_with_its_reason(self):
        self.assertEqual(self.told.returncode, 0, self.told.stderr)
        found = {name: (outcome, reason) for name, outcome, reason in self.rows("SELECT name, outcome, reason FROM recording")}
        self.assertEqual(len(found), 7)
        self.assertEqual({found[f"r{k}.csv"] for k in range(4)}, {("done", None)})
        self.assertEqual(found["bag.bag"], ("done", None))
        self.assertRegex(str(found["cut.csv"]), "failed.*line 2")
        self.assertRegex(str(found["gone.csv"]), "failed.*cannot be read")

    def test_parameters_have_their_errors_and_a_bag_the_answers_of_its_csv(self):
        value = dict(self.rows("SELECT r.name, p.value FROM parameter p JOIN recording r USING (recording) WHERE p.name = 'r_discharge' AND p.std > 0"))
        self.assertEqual(len(value), 5)
        self.assertAlmostEqual(value["bag.bag"], value["r0.csv"], places=9)
        self.assertEqual(len(self.rows("SELECT * FROM score WHERE share_percent IS NOT NULL")), 5)
        self.assertFalse([name for _, _, names in os.walk(os.path.join(self.out, "results")) for name in names if name == "recording.csv"])

    def test_order_and_cores_change_no_row(self):
        names = sorted(os.listdir(self.data), reverse=True)
        given = self.write("list.csv", "path\n" + "".join(os.path.join(self.data, name) + "\n" for name in names))
        again = fleet("run", given, "--out", self.path("one"), *QUICK, "--jobs", "1")
        self.assertEqual((again.returncode, database.digest(self.path("one"))), (0, self.digest), again.stderr)

    def test_killed_and_called_again_gives_the_same_rows(self):
        out = self.path("killed")
        first = subprocess.Popen([sys.executable, os.path.join(ROOT, "scripts", "sof-fleet"), "run", self.data, "--out", out, *QUICK], stderr=subprocess.DEVNULL, start_new_session=True)
        end = time.monotonic() + 30.0
        while time.monotonic() < end and not any("identify.json" in names for _, _, names in os.walk(out)):
            time.sleep(0.02)
        os.killpg(first.pid, signal.SIGKILL)
        first.wait()
        self.assertFalse(os.path.exists(os.path.join(out, database.NAME)))
        again = fleet("run", self.data, "--out", out, *QUICK)
        self.assertEqual((again.returncode, database.digest(out)), (0, self.digest), again.stderr)
        self.assertIn("7 done before", fleet("run", self.data, "--out", out, *QUICK).stderr)

    def test_other_steps_in_the_same_folder_are_refused(self):
        told = fleet("run", self.data, "--out", self.out, "--steps", "check", "--sof", SOF)
        self.assertEqual(told.returncode, 2)
        self.assertIn("take an empty folder", told.stderr)

    def test_the_folder_is_rebuilt_from_the_database(self):
        out = self.path("rebuilt")
        self.assertEqual(fleet("rebuild", os.path.join(self.out, database.NAME), "--out", out).returncode, 0)
        self.assertEqual(database.digest(out), self.digest)
        key = self.rows("SELECT recording FROM recording WHERE name = 'r1.csv'")[0][0]
        with open(os.path.join(plan.results(self.out, key), "model.yaml")) as one, open(os.path.join(plan.results(out, key), "model.yaml")) as other:
            self.assertEqual(one.read(), other.read())

    def test_every_table_is_a_file_of_rows(self):
        database.export(self.out, self.path("csv"))
        self.assertEqual({name[:-4] for name in os.listdir(self.path("csv"))}, set(schema.TABLES) - {"file"})
        with open(self.path("csv", "recording.csv")) as file:
            self.assertEqual(len(file.readlines()), 8)

    def test_the_page_fetches_nothing_and_escapes_names(self):
        shutil.copytree(self.out, self.path("out"))
        base = sqlite3.connect(self.path("out", database.NAME))
        base.execute("UPDATE recording SET battery = '<b>x' WHERE name = 'r1.csv'")
        base.commit()
        base.close()
        text = page.make(self.path("out"))
        self.assertIn("default-src 'none'", text)
        self.assertNotIn("<b>x", text)
        self.assertIn("&lt;b&gt;x", text)
        self.assertNotRegex(text, "(src|href)=.https?:")


class Changes(Folder):
    def test_a_recording_is_compared_with_the_first_one_of_its_battery(self):
        for name, seed, contact in (("one_day_1", 1, 0.0), ("one_day_2", 2, 0.01), ("two_day_1", 3, 0.0)):
            t, i, u = drive(seed, 3200)
            recordings.write(self.path(name + ".csv"), t, i, u + contact * i)
        given = self.write("list.csv", "path,battery\none_day_2.csv,one\none_day_1.csv,one\ntwo_day_1.csv,two\n")
        told = fleet("run", given, "--out", self.path("out"), "--steps", "check,change", "--jobs", "1", "--sof", SOF)
        self.assertEqual(told.returncode, 0, told.stderr)
        base = database.open_read(self.path("out"))
        rows = base.execute("SELECT r.name, c.reference, c.verdict, c.id, c.mechanism, c.lower, c.upper FROM change c JOIN recording r USING (recording)").fetchall()
        self.assertEqual([tuple(row)[:5] for row in rows], [("one_day_2.csv", "one_day_1.csv", "changed", "contact_resistance", "instrument")])
        self.assertLess(rows[0]["lower"], 0.01)
        self.assertGreater(rows[0]["upper"], 0.01)
        reasons = {row[0]: row[1] for row in base.execute("SELECT r.name, s.reason FROM step s JOIN recording r USING (recording) WHERE s.step = 'change'")}
        self.assertEqual(reasons["one_day_1.csv"], "not taken: it is its battery's first recording")
        self.assertEqual({row[0] for row in base.execute("SELECT outcome FROM recording")}, {"done"})
        shown = page.make(self.path("out"))
        self.assertIn("1 recording shows a change since the first one of the battery, of 1 that were compared (1 battery).", shown)
        self.assertIn("<code>contact_resistance</code>", shown)


class Made(Folder):
    """A database of made verdicts and parameters."""

    def base(self, verdicts=(), parameters=()):
        base = sqlite3.connect(":memory:")
        base.row_factory = sqlite3.Row
        for statement in schema.statements():
            base.execute(statement)
        for k, (mechanism, gain) in enumerate(verdicts):
            base.execute("INSERT INTO recording (recording, battery) VALUES (?, ?)", (f"k{k}", f"b{k}"))
            base.execute("INSERT INTO verdict (recording, verdict, mechanism, probability, gain) VALUES (?, 'named', ?, 0.7, ?)", (f"k{k}", mechanism, gain))
        for k, value in enumerate(parameters):
            base.execute("INSERT INTO recording (recording, battery, vehicle_type) VALUES (?, ?, 'van')", (f"p{k}", f"b{k}"))
            base.execute("INSERT INTO parameter VALUES (?, 'identify', '', 'r_discharge', ?, 1e-5, 'ohm', 1, 0)", (f"p{k}", value))
        return base

    def test_evidence_of_nothing_is_no_discovery_and_much_is_one(self):
        found = discoveries.batteries(self.base([("acid", 40.0), ("acid", 2.0), (None, 90.0)] + [(None, 0.0)] * 20))
        self.assertEqual([(one.name, one.found) for one in found[:2]], [("b0", True), ("b1", False)])
        self.assertEqual(sum(one.found for one in found), 1)
        self.assertEqual([row[:2] for row in discoveries.mechanisms(found)], [("acid", 2)])

    def test_drawn_recordings_are_judged_by_their_labels(self):
        base = self.base([("acid", 40.0), ("acid", 60.0), (None, 0.0), ("structure", 50.0)])
        os.makedirs(self.path("labels"))
        for k, label in enumerate(('{"kind": "out_of_catalogue", "mechanism": "acid"}', '{"kind": "control"}', '{"kind": "control"}', '{"kind": "out_of_catalogue", "mechanism": "acid"}')):
            self.write(os.path.join("labels", f"c{k}.json"), label)
            base.execute("UPDATE recording SET path = ? WHERE recording = ?", (self.path("recordings", f"c{k}.csv"), f"k{k}"))
        base.execute("UPDATE verdict SET verdict = 'no_mismatch' WHERE recording = 'k2'")
        cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in judge.judged(base)]
        start = lambda row: [cell.split(" = ")[0] for cell in row]
        self.assertEqual(start(cells[2]), ["null", "2", "1 of 2", "1 of 2", ""])
        self.assertEqual(start(cells[3]), ["other_form", "2", "2 of 2", "2 of 2", "1 of 2"])
        self.assertEqual(start(cells[-1]), ["3", "1 of 3", "2 of 2"])
        os.remove(self.path("labels", "c1.json"))
        with self.assertRaisesRegex(SystemExit, "c1.csv: no label .*c1.json; only recordings of out-of-model cases"):
            judge.judged(base)

    def test_p_values_of_nulls_hold_the_rate(self):
        dice = np.random.default_rng(4)
        rates, power = [], []
        for _ in range(40):
            nulls = dice.exponential(3.0, 500)
            verdicts = [("acid", gain) for gain in dice.exponential(3.0, 300)] + [("acid", gain) for gain in 15.0 + dice.exponential(3.0, 60)]
            found = [int(one.name[1:]) for one in discoveries.batteries(self.base(verdicts), nulls) if one.found]
            rates.append(sum(k < 300 for k in found) / max(1, len(found)))
            power.append(sum(k >= 300 for k in found) / 60.0)
        self.assertLess(np.mean(rates), discoveries.RATE)
        self.assertGreater(np.mean(power), 0.8)

    def test_a_battery_with_many_recordings_is_not_found_for_that(self):
        nulls = list(range(99))
        self.assertAlmostEqual(discoveries.p_of_battery([200.0], nulls), 0.01)
        self.assertAlmostEqual(discoveries.p_of_battery([200.0, 0.0, 0.0], nulls), 0.03)

    def test_who_deviates_is_one_whose_parameter_is_far_from_the_others(self):
        dice = np.random.default_rng(2)
        found, compared = outliers.outliers(self.base(parameters=[*(5e-3 * np.exp(0.1 * dice.normal(size=30))), 15e-3]))
        self.assertEqual((compared, [one.battery for one in found]), (31, ["b30"]))

    def test_a_difference_of_a_hundredth_is_no_outlier_though_all_others_are_alike(self):
        found, compared = outliers.outliers(self.base(parameters=[*(5e-3 * (1.0 + 1e-9 * np.arange(30))), 5.05e-3]))
        self.assertEqual((compared, found), (31, []))

    def test_a_fleet_without_verdicts_has_a_page_in_words(self):
        self.assertIn("No battery", page.headline([], [], True))


if __name__ == "__main__":
    unittest.main()

"""sof-fleet on files that are damaged, are no files, or lie: a row or a sentence, never a traceback, a hang or a file outside of its folder.

Exit code 77: skipped, Snakemake or statsmodels is not installed.
"""

import contextlib
import io
import json
import os
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest
import warnings
import zlib
from unittest import mock

try:
    import statsmodels  # noqa: F401
except ImportError as absent:
    print(f"SKIPPED: {absent.name} is not installed")
    sys.exit(77)
if not shutil.which("snakemake"):
    print("SKIPPED: snakemake is not installed")
    sys.exit(77)

from battery_sof_tools.files import ROOT, write_json
from battery_sof_tools.fleet import command, database, plan, schema, steps

RECORDINGS = 10
OPTIONS = {"window_s": 900.0, "without_pages": True}
COST = {"wall_s": 0.1, "cpu_s": 0.1}
WRONG = (None, True, -1, 10**30, 1e308, 5e-324, "", "x", "\udcff", "../../x", "/x", [], {}, [[]], [None], {"x": 1})
READERS = ("report", "digest", "judge", "export", "rebuild")
WRITERS = ("load", "report")


def parameter(value):
    return {"name": "r_discharge", "value": value, "std": 1e-4, "unit": "ohm", "determined": True, "at_bound": False}


def answers(k):
    """What the steps of a recording may have said."""
    both = {"share_percent": 60.0 + k, "crank_mae_v": 0.1}
    window = {"from_s": 0.0, "to_s": 900.0}
    return {
        "check": {"findings": [{"id": "gap", "severity": "warning", "value": 3.0, "unit": "s", "samples": 2, "what": "a gap"}], "source": {"seen": True, "share": 0.5},
                  "temperature_range_c": [10.0 + k, 12.0 + k], "samples": 100, "from_s": 0.0, "to_s": 900.0, "median_interval_s": 1.0},
        "convert": None,
        "identify": {"window": window, "samples": 100, "effects": [], "status": "converged", "window_quality": 0.5, "q_dyn_percent": 90.0, "rmse_v": 0.01,
                     "parameters": [parameter(5e-3 * 1.1**k)]},
        "predict": {"window": window, "q_dyn_percent": 90.0, "coverage_90": 0.9, "cranks": [{}], "mixed": both, "baseline": both},
        "diagnose": {"verdict": "effect", "mechanism": "acid", "probability": 0.7, "summary": "words", "evidence": {"base": 1.0, "extended": 50.0 * (k % 3)},
                     "fit": {"base": {"train": {"rmse_v": 0.02}, "holdout": {"rmse_v": 0.03}}, "extended": None},
                     "effects": [{"id": "acid_transport", "mechanism": "acid", "probability": 0.7, "parameters": [parameter(1.0)]}],
                     "candidates": [{"id": "acid_transport", "mechanism": "acid", "evidence": 3.0, "probability": 0.7, "rejected_because": None}]},
        "change": {"verdict": "changed", "summary": "words", "references": ["r0.csv"],
                   "changes": [{"id": "contact_resistance", "mechanism": "instrument", "now": 1e-3 * k, "unit": "ohm", "interval": [0.0, 2e-3 * k], "probability": 0.9,
                                "indistinguishable": ["r_discharge"]}]},
        "score": {"windows": [{"start_s": 0.0, "effects": [], "window_quality": 0.5, "parameters": [parameter(5e-3)], "baseline": both,
                               "model": {"current_share_percent": None, "voltage_share_percent": 50.0, **both}}]}}


def make_fleet(folder):
    """A fleet's folder as a run leaves it; no sof is needed."""
    data, out = os.path.join(folder, "recordings"), os.path.join(folder, "out")
    for name in (data, os.path.join(folder, "labels")):
        os.makedirs(name)
    with open(os.path.join(folder, "list.csv"), "w") as listed:
        listed.write("path,battery,vehicle_type,age_years\n" + "".join(f"recordings/r{k}.csv,b{k},van,{k}\n" for k in range(RECORDINGS)))
    for k in range(RECORDINGS):
        with open(os.path.join(data, f"r{k}.csv"), "w") as file:
            file.write(f"time_s,current_a,voltage_v\n{k},1,12\n")
        write_json(os.path.join(folder, "labels", f"r{k}.json"), {"kind": "other_form" if k % 2 else "null", "mechanism": "acid"})
    for entry in plan.make(out, [os.path.join(folder, "list.csv")], plan.STEPS, "product", OPTIONS):
        where = plan.results(out, entry["key"])
        os.makedirs(where)
        for step, answer in answers(int(entry["battery"][1:])).items():
            write_json(os.path.join(where, step + ".json"), {"step": step, "exit": 0, "reason": None, "answer": answer, "cost": COST})
    write_json(os.path.join(out, "setting.json"), {"sof": "/bin/false", "patience_s": 1.0})
    database.load(out)
    return out


def called(*arguments):
    """(exit code, standard error) of sof-fleet, in this process: an exception fails the test."""
    said = io.StringIO()
    with mock.patch.object(sys, "argv", ["sof-fleet", *arguments]), contextlib.redirect_stderr(said), contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return command.main(), said.getvalue()


def damaged_bytes(content, dice):
    """Bits turned round, bytes taken out or put in, an end that is missing."""
    content, kind = bytearray(content), dice.randrange(4)
    place = dice.randrange(len(content))
    if kind == 0:
        for _ in range(dice.choice((1, 3, 40))):
            content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    elif kind == 1:
        del content[place:]
    elif kind == 2:
        del content[place:place + dice.choice((1, 100))]
    else:
        content[place:place] = dice.randbytes(dice.choice((1, 100)))
    return bytes(content)


def damaged_value(value, dice):
    """One place in a value of JSON holds something else, or nothing."""
    value = json.loads(json.dumps(value))
    inner = value
    while True:
        keys = list(inner) if isinstance(inner, dict) else list(range(len(inner)))
        if not keys:
            return dice.choice(WRONG)
        key = dice.choice(keys)
        if isinstance(inner[key], (dict, list)) and inner[key] and dice.random() < 0.8:
            inner = inner[key]
        elif dice.random() < 0.2:
            del inner[key]
            return value
        else:
            inner[key] = dice.choice(WRONG)
            return value


class Attack(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="fleet ? ")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.out = make_fleet(os.path.join(cls.temporary.name, "made"))

    def setUp(self):
        self.here = os.path.join(self.temporary.name, self.id().rsplit(".", 1)[1])
        os.makedirs(self.here)

    def copy(self):
        out = os.path.join(self.here, "out")
        shutil.rmtree(out, ignore_errors=True)
        return shutil.copytree(self.out, out)

    def arguments(self, what, out):
        made = os.path.join(self.here, "made")
        shutil.rmtree(made, ignore_errors=True)
        more = {"report": ["--out", made + ".html"], "export": ["--csv", made], "rebuild": ["--out", made]}.get(what, [])
        return [what, os.path.join(out, database.NAME) if what == "rebuild" else out, *more]

    def require_words(self, what, out, about, codes=(0, 2)):
        """A call ends with a code, and with one sentence where it was refused."""
        try:
            code, said = called(*self.arguments(what, out))
        except BaseException as error:
            raise AssertionError(f"{what}: {about}") from error
        self.assertIn(code, codes, f"{what}: {about}: {said}")
        if code:
            self.assertEqual(said.count("\n"), 1, f"{what}: {about}: {said}")
            self.assertNotIn("not foreseen", said)
        return code, said

    def kinds_of_no_file(self, path):
        """Puts in place of a file what is none, one after the other."""
        for name, put in (("nothing", lambda: None), ("a folder", lambda: os.makedirs(path)), ("a pipe", lambda: os.mkfifo(path)), ("a device", lambda: os.symlink("/dev/zero", path)),
                          ("a loop", lambda: os.symlink(path, path)), ("empty", lambda: open(path, "w").close())):
            if os.path.isdir(path) and not os.path.islink(path):
                os.rmdir(path)
            elif os.path.lexists(path):
                os.remove(path)
            put()
            yield name

    def test_a_fleet_that_is_whole_is_read_by_every_command(self):
        for what in READERS + WRITERS:
            self.require_words(what, self.copy(), "nothing is damaged", codes=(0,))

    def test_a_damaged_database_is_a_sentence_that_names_it(self):
        out = self.copy()
        path = os.path.join(out, database.NAME)
        with open(path, "rb") as file:
            whole = file.read()
        dice, refused = random.Random(1), 0
        for trial in range(60):
            with open(path, "wb") as file:
                file.write(damaged_bytes(whole, dice))
            code, said = self.require_words(READERS[trial % len(READERS)], out, f"trial {trial}")
            refused += code == 2
            self.assertTrue(code == 0 or "damaged" in said or "schema" in said, said)
        self.assertGreater(refused, 30)
        with open(path, "wb") as file:
            file.write(whole.replace(b"tablescore", b"tablesco\xa0e").replace(b"CREATE TABLE score", b"CREATE TABL\xa0 score"))
        self.require_words("digest", out, "sqlite's own message is no UTF-8", (2,))
        for name in self.kinds_of_no_file(path):
            for what in READERS:
                self.assertIn(database.NAME, self.require_words(what, out, name, codes=(2,))[1])

    def test_cells_of_a_wrong_kind_are_a_sentence(self):
        out = self.copy()
        path, dice = os.path.join(out, database.NAME), random.Random(2)
        with open(path, "rb") as file:
            whole = file.read()
        wrong = ("NULL", "'x'", "X'ff'", "CAST(X'ff' AS TEXT)", "9e999", "-9e999", "1e300", "-1e300", "1e-320", "-1", "0", "'{}'", "'[1]'", "'\"'", "'../x'")
        for trial in range(80):
            with open(path, "wb") as file:
                file.write(whole)
            with contextlib.closing(sqlite3.connect(path)) as base, base:
                table = dice.choice(sorted(schema.TABLES))
                column = dice.choice([row[1] for row in base.execute(f"PRAGMA table_info({table})")])
                value = dice.choice(wrong)
                with contextlib.suppress(sqlite3.IntegrityError):  # one key for all
                    base.execute(f"UPDATE {table} SET {column} = {value}" + dice.choice(("", " WHERE rowid = 1")))
            for what in dice.sample(READERS, 3):
                self.require_words(what, out, f"trial {trial}: {table}.{column} = {value}")

    def test_damaged_plans_are_a_sentence_and_damaged_answers_a_row(self):
        dice = random.Random(3)
        key = sorted(os.listdir(os.path.join(self.out, "results", sorted(os.listdir(os.path.join(self.out, "results")))[0])))[0]
        names = ["fleet.json", "recordings.json"] + [os.path.join(os.path.relpath(plan.results(self.out, key), self.out), step + ".json") for step in plan.STEPS]
        for name in names:
            out = self.copy()
            path = os.path.join(out, name)
            with open(path, "rb") as file:
                whole = file.read()
            rows = 0
            for trial in range(16):
                with open(path, "wb") as file:
                    file.write(damaged_bytes(whole, dice) if trial % 2 else json.dumps(damaged_value(json.loads(whole), dice)).encode())
                rows += self.load_and_report(out, name, f"{name}, trial {trial}", WRITERS if trial < 4 else WRITERS[:1])
            self.assertGreater(rows, 3, name)
            for kind in self.kinds_of_no_file(path):
                self.load_and_report(out, name, f"{name}: {kind}", WRITERS)

    def load_and_report(self, out, name, about, calls):
        """Whether the damage was reported: by a sentence that names a plan's file, by a row that names an answer's."""
        for what in calls:
            code, said = self.require_words(what, out, about, (0,) if "results" in name else (0, 2))
            if code:
                self.assertTrue(name in said or "holds no fleet" in said, said)
                return True
        with contextlib.closing(sqlite3.connect(os.path.join(out, database.NAME))) as base:
            return bool(base.execute("SELECT * FROM step WHERE reason LIKE '%damaged%delete it and call sof-fleet run again'").fetchall())

    def test_no_file_of_a_database_lies_outside_of_the_folder(self):
        out = self.copy()
        path = os.path.join(out, database.NAME)
        with open(path, "rb") as file:
            whole = file.read()
        outside = os.path.join(self.here, "outside.json")
        for column, value in (("name", outside), ("name", "../../../../outside.json"), ("name", "a/b.json"), ("name", ".."), ("name", "x.sh"), ("name", "a\0.json"),
                              ("recording", outside), ("recording", "../../../outside"), ("recording", "..")):
            with open(path, "wb") as file:
                file.write(whole)
            with contextlib.closing(sqlite3.connect(path)) as base, base:
                base.execute(f"UPDATE file SET {column} = ? WHERE rowid = 1", (value,))
            self.require_words("rebuild", out, value, (2,))
            self.assertEqual(sorted(os.listdir(self.here)), ["out"], value)

    def test_a_file_that_unpacks_to_more_than_it_says_is_refused(self):
        out = self.copy()
        with contextlib.closing(sqlite3.connect(os.path.join(out, database.NAME))) as base, base:
            base.execute("UPDATE file SET content = ? WHERE rowid = 1", (zlib.compress(bytes(100_000_000)),))
        self.assertIn("cannot be unpacked", self.require_words("rebuild", out, "a bomb", (2,))[1])

    def test_lists_with_fields_of_a_wrong_kind_are_a_sentence(self):
        for text in ("- {path: [a, b]}", "- {path: {a: b}}", "- {path: a.csv, age_years: old}", "- {path: a.csv, age_years: .nan}", "- {path: a.csv, battery: [1]}", "- {path: null}",
                     "- 5", "5", "- &a [*a]", "- {path: a.csv, ? [1] : 2}", "{", "\x01", "- {path: '", "- " * 3000 + "5", "- {path: !!python/object:os.system x}", "- {path: " + "1" * 5000 + "}"):
            with open(os.path.join(self.here, "list.yaml"), "w") as file:
                file.write(text)
            code, said = called("run", file.name, "--out", os.path.join(self.here, "out"), "--sof", "/bin/false")
            self.assertEqual((code, said.count("\n")), (2, 1), text[:40] + said)
            self.assertIn("list.yaml", said)
        for content in (b"path,age_years\na.csv,x\n", b"path\na.csv,b\n", b"path\n" + b"a" * 200_000, b"path,battery\n,x\n"):
            with open(os.path.join(self.here, "list.csv"), "wb") as file:
                file.write(content)
            code, said = called("run", file.name, "--out", os.path.join(self.here, "out"), "--sof", "/bin/false")
            self.assertEqual((code, said.count("\n")), (2, 1), content[:40])

    def test_numbers_that_are_none_are_refused(self):
        for option in ("--jobs=0", "--jobs=-1", "--window=nan", "--window=0", "--patience=inf", "--patience=-1"):
            with self.assertRaises(SystemExit) as refused, contextlib.redirect_stderr(io.StringIO()) as said:
                called("run", self.here, "--out", self.here, option)
            self.assertEqual(refused.exception.code, 2)

    def test_whatever_a_folder_holds_is_a_row(self):
        data, sof, out = (os.path.join(self.here, name) for name in ("data", "sof", "out"))
        os.makedirs(os.path.join(data, "folder.csv"))
        with open(sof, "w") as file:
            file.write("#!/bin/sh\ncase $1 in convert) exec sleep 60;; check) for last; do :; done; echo '{\"findings\": 5}' > \"$last\"; exit 0;; esac\necho refused >&2\nexit 2\n")
        os.chmod(sof, 0o755)
        for name in (b"n\xff.csv", b"new\nline\x1b[31m.csv", b"slow.bag"):
            with open(os.path.join(data.encode(), name), "w") as file:
                file.write("time_s,current_a,voltage_v\n" + f"nan,{len(name)},12\n" * 99)
        os.mkfifo(os.path.join(data, "fifo.csv"))
        os.symlink("/dev/zero", os.path.join(data, "zero.csv"))
        os.symlink("loop.csv", os.path.join(data, "loop.csv"))
        with open(os.path.join(self.here, "list.yaml"), "w") as file:
            file.write('- {path: "a\\0b.csv"}\n- {path: /dev/zero}\n- {path: data}\n- {path: "half\\ud800.csv"}\n')
        told = subprocess.run([sys.executable, os.path.join(ROOT, "scripts", "sof-fleet"), "run", data, file.name, os.path.join(data, "fifo.csv"), "--out", out, "--sof", sof,
                               "--patience", "0.3", "--jobs", "2"], capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual(told.returncode, 0, told.stderr)
        with contextlib.closing(sqlite3.connect(os.path.join(out, database.NAME))) as base:
            reasons = dict(base.execute("SELECT name, reason FROM recording"))
            steps_of = dict(base.execute("SELECT step, s.reason FROM step s JOIN recording USING (recording) WHERE name = 'slow.bag'"))
        for name, reason in ((r"n\xff.csv", "no UTF-8, rename it"), ("fifo.csv", "not a regular file"), ("zero.csv", "not a regular file"), ("zero", "not a regular file"), ("data", "not a regular file"),
                             ("loop.csv", "symbolic links"), ("a\0b.csv", "null byte"), (r"half\ud800.csv", "no UTF-8"), ("new\nline\x1b[31m.csv", "findings is 5, expected a list")):
            self.assertIn(reason, reasons[name])
        self.assertEqual(len(reasons), 10)
        self.assertEqual(steps_of["convert"], "no answer within 0.3 s")
        self.assertEqual(called("rebuild", os.path.join(out, database.NAME), "--out", out + " again")[0], 0)
        self.assertEqual(database.digest(out), database.digest(out + " again"))

    def test_a_score_that_takes_longer_than_the_patience_is_a_row(self):
        sof, recording = os.path.join(self.here, "sof"), os.path.join(self.here, "long.csv")
        with open(sof, "w") as file:
            file.write("#!/bin/sh\nexec sleep 60\n")
        os.chmod(sof, 0o755)
        with open(recording, "w") as file:
            file.write("time_s,current_a,voltage_v\n" + "".join(f"{k},1,12\n" for k in range(100)))
        entry = plan.described({"path": recording, "battery": "long", "discharge_positive": False})
        os.makedirs(plan.results(self.here, entry["key"]))
        steps.run(self.here, entry, dict(OPTIONS, sof=sof, patience_s=0.3, steps=["score"]))
        self.assertEqual(database.told(self.here, entry["key"])["score"]["reason"], "no answer within 0.3 s")

    def test_a_step_that_fails_in_a_way_that_was_not_foreseen_is_a_row(self):
        out = self.copy()
        entry = plan.load(out)[1][0]
        with mock.patch.object(steps, "answered", side_effect=ZeroDivisionError("0 by 0")):
            os.remove(os.path.join(plan.results(out, entry["key"]), "check.json"))
            steps.run(out, entry, plan.setting_of(out, plan.load(out)[0]))
        self.assertEqual(database.told(out, entry["key"])["check"]["reason"], "not foreseen: ZeroDivisionError: 0 by 0")


if __name__ == "__main__":
    unittest.main()

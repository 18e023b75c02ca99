"""What the scripts share: intervals, files, the catalogue as `sof` prints it, recordings, laws beside them, and how answers are counted."""

import contextlib
import glob
import io
import itertools
import json
import keyword
import os
import re
import runpy
import subprocess
import sys
import tempfile
import unittest

import numpy as np

from battery_sof_tools import files, mkdocs_hooks, pages_of_sof, progress, rates, recordings, stop_rules, tables, tidy
from battery_sof_tools.benchmark import answers, laws, real, same
from battery_sof_tools.benchmark.generator import Generator
from battery_sof_tools.files import ROOT
from battery_sof_tools.sof import Catalogue, Failure, call, catalogue, program

BUILD = os.environ["BATTERY_SOF_BUILD"]
FORMS = {mechanism: ["a", "b"] for mechanism in ("acid", "ageing", "instrument")}


class Tidy(unittest.TestCase):
    def test_a_precompiled_header_is_left_out_and_nothing_else(self):
        self.assertEqual(
            tidy.without_precompiled("c++ -I '/a b' -Winvalid-pch -include /build/cmake_pch.hxx -include own.hpp -c x.cpp"),
            "c++ -I '/a b' -include own.hpp -c x.cpp")

    def test_a_header_is_looked_at_through_the_source_of_its_name_or_one_that_includes_it(self):
        sources = ["src/recording/csv.cpp", "src/recording/intake.cpp", "src/report/results.cpp"]
        self.assertEqual(tidy.sources_of(["include/battery_sof/intake.hpp", "src/recording/intake.cpp"], sources), sources[1:2])
        self.assertEqual(tidy.sources_of(["include/battery_sof/sample_list.hpp"], sources), sources[:1])
        self.assertEqual(tidy.sources_of(["docs/model.md", "test/unit/recording/csv_test.cpp", "src/gone.cpp"], sources), [])

    def test_there_is_always_something_to_look_at(self):
        for path in tidy.SAMPLE:
            self.assertTrue(os.path.isfile(os.path.join(ROOT, path)), path)


class Version(unittest.TestCase):
    def test_it_is_that_of_package_xml_where_it_cannot_be_taken_from_there(self):
        major_minor = files.version().rpartition(".")[0]
        for path, said in (("debian/changelog", f"battery-sof ({files.version()}) "), ("include/battery_sof/version.hpp", f'"{files.version()}"'),
                           ("CITATION.cff", f"\nversion: {files.version()}\n"), ("debian/control", f"\nPackage: libbattery-sof{major_minor}\n"),
                           *((path, f"find_package(battery_sof {major_minor} ") for path in ("test/outside_project/CMakeLists.txt", "examples/ros2_node/CMakeLists.txt", "docs/cpp-and-python.md"))):
            with open(os.path.join(ROOT, path), encoding="utf-8") as file:
                self.assertIn(said, file.read(), path)


class Debian(unittest.TestCase):
    def test_the_copyright_file_has_the_whole_licence(self):
        licence = files.read_text(os.path.join(ROOT, "LICENSE")).partition("All rights reserved.")[2].split()
        shown = [word for word in files.read_text(os.path.join(ROOT, "debian", "copyright")).split() if word != "."]
        self.assertEqual(shown[-len(licence):], licence)
        notice = files.read_text(os.path.join(ROOT, "src", "report", "page", "dygraphs_notice.txt"))
        self.assertIn(" ".join(notice[notice.index("Permission"):].split()), " ".join(shown))


class CompiledTogether(unittest.TestCase):
    """Files that cmake/quick_build.cmake may put into one unit, whichever eight it takes."""

    CONSTANT = re.compile(r"^(?:static )?constexpr [^=\n]*?\b(k[A-Z]\w*)\b(?:\[\w*\])? ?(?:=|{)|^const \w+ (k[A-Z]\w*)", re.M)

    @classmethod
    def shared(cls, sources):
        """Constants that two of {name: text} have."""
        where = {}
        for name, text in sources.items():
            for match in cls.CONSTANT.finditer(text):
                where.setdefault(match[1] or match[2], set()).add(name)
        return {constant: sorted(names) for constant, names in where.items() if len(names) > 1}

    def test_a_constant_of_two_files_is_seen(self):
        self.assertEqual(self.shared({"a": "constexpr double kX = 1;\n  constexpr int kLocal = 1;\n", "b": "constexpr int kX = 2;\n  constexpr int kLocal = 2;\n"}), {"kX": ["a", "b"]})

    def test_no_two_files_have_a_constant_of_one_name(self):
        together = re.findall(r"battery_sof_build_together\((\S+) ALONE ([^)]*)\)", files.read_text(os.path.join(ROOT, "CMakeLists.txt")))
        self.assertGreater(len(together), 3)
        for folder, alone in together:
            names = [name for name in os.listdir(os.path.join(ROOT, folder)) if name.endswith(".cpp") and name[:-4] not in alone.split()]
            self.assertEqual(self.shared({name: files.read_text(os.path.join(ROOT, folder, name)) for name in names}), {}, folder)


class Messages(unittest.TestCase):
    def test_no_field_is_a_keyword_of_python(self):
        paths = [path for kind in ("msg", "srv", "action") for path in glob.glob(os.path.join(ROOT, "**", f"*.{kind}"), recursive=True)
                 if not path.startswith(BUILD + os.sep)]
        self.assertTrue(paths)
        for path in paths:
            fields = re.findall(r"^[\w/]+(?:\[\d*\])? +(\w+)", files.read_text(path), re.M)
            self.assertEqual([], list(filter(keyword.iskeyword, fields)), path)


class PythonResults(unittest.TestCase):
    def test_verdicts_are_those_of_the_schemas(self):
        text = files.read_text(os.path.join(ROOT, "python", "battery_sof", "results.py"))
        listed = [set(re.findall(r"\w+", line)) - {"or"} for line in re.findall(r"verdict: str  #: (.*)", text)]
        schemas = [json.loads(files.read_text(os.path.join(ROOT, "docs", "schemas", name + ".schema.json"))) for name in ("diagnose", "diagnose-reference")]
        self.assertEqual([set(schema["properties"]["verdict"]["enum"]) for schema in schemas], listed)


class Rates(unittest.TestCase):
    def test_wilson_is_the_root_of_the_score_test(self):
        for k, n in ((0, 10), (3, 10), (9, 10), (10, 10), (45, 50)):
            for p in rates.wilson(k, n):
                if 0.0 < p < 1.0:
                    self.assertAlmostEqual(abs(k / n - p) / np.sqrt(p * (1.0 - p) / n), 1.959963984540054, places=9)
        self.assertEqual((rates.wilson(0, 10)[0], rates.wilson(10, 10)[1]), (0.0, 1.0))

    def test_a_rate_without_cases_is_no_case(self):
        self.assertEqual(rates.rate(0, 0), "no case")
        self.assertEqual(rates.rate(1, 2, rates.wilson), "1 of 2 = 50.0 % (9.5 to 90.5 %)")

    def test_a_geometric_mean_is_that_of_logarithms(self):
        self.assertAlmostEqual(rates.geometric_mean([0.5, 2.0, 8.0]), 2.0)
        self.assertIsNone(rates.geometric_mean([]))


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Progress(unittest.TestCase):
    def test_a_terminal_sees_how_far_it_is_and_the_time_left(self):
        with contextlib.redirect_stderr(Terminal()) as shown:
            self.assertEqual(list(progress.followed(range(4), "case")), [0, 1, 2, 3])
        self.assertIn("case", shown.getvalue())
        self.assertRegex(shown.getvalue(), r"4/4 \[\d\d:\d\d<\d\d:\d\d")  # passed<left

    def test_a_log_sees_a_line_now_and_then(self):
        with contextlib.redirect_stderr(io.StringIO()) as log:
            self.assertEqual(len(list(progress.followed(iter(range(12)), "case", 12))), 12)
        self.assertEqual(log.getvalue(), "case 10 of 12\ncase 12 of 12\n")

    def test_without_tqdm_a_terminal_sees_every_item(self):
        bar, progress.tqdm = progress.tqdm, None
        try:
            with contextlib.redirect_stderr(Terminal()) as shown:
                list(progress.followed("ab", "case"))
            self.assertEqual(shown.getvalue(), "case 1 of 2\ncase 2 of 2\n")
        finally:
            progress.tqdm = bar


class CliPage(unittest.TestCase):
    def test_the_page_of_the_command_is_what_its_help_says(self):
        with open(os.path.join(ROOT, "docs", "cli.md")) as file:
            page = file.read()
        self.assertEqual(page, files.with_part(page, *pages_of_sof.MARKS["cli.md"], pages_of_sof.cli(program(BUILD, "sof"))), "docs/cli.md is behind: run scripts/update_cli_page")

    def test_every_subcommand_is_found(self):
        self.assertEqual(pages_of_sof.subcommands("sof\n\nSubcommands:\n  check    looks\n  stop-time   asks\n           more\n"), ["check", "stop-time"])


    def test_an_option_of_three_subcommands_is_listed_once(self):
        own = "does it\nUsage: sof x [OPTIONS] REC\n\nPositionals:\n  REC INPUT  a recording\n\nOptions:\n  -h,--help   help\n  --shared A\n       of many\n  --own-{}    of one\n"
        helps = {name: own.format(name) for name in ("a", "b", "c")}
        self.assertEqual(pages_of_sof.shared(helps), {("a", "b", "c"): ["  --shared A\n       of many"]})
        self.assertEqual(pages_of_sof.shared({name: helps[name] for name in ("a", "b")}), {})
        self.assertEqual(pages_of_sof.section("a", helps["a"], {"  --shared A\n       of many"}), "\n## sof a\n\n    does it\n    Usage: sof x REC\n\n      --own-a    of one\n")


class Site(unittest.TestCase):
    def test_links_to_what_is_no_page_are_made_to_fit(self):
        outside = []
        self.assertEqual(mkdocs_hooks.fitted("[a](docs/node.md#states) [b](LICENSE) [c](docs/decisions) [d](https://x.org/y.md) [e](#here)", "README.md", outside.append),
                         "[a](docs/node.md#states) [b](files/LICENSE.txt) c [d](https://x.org/y.md) [e](#here)")
        self.assertEqual(outside, ["LICENSE"])
        self.assertEqual(mkdocs_hooks.fitted("![p](../pictures/circuit.svg) [r](../../README.md) [l](../../LICENSE)", "docs/decisions/0001-robust-start.md", outside.append),
                         "![p](../pictures/circuit.svg) [r](../../README.md) [l](../../files/LICENSE.txt)")
        self.assertEqual(mkdocs_hooks.fitted('<source media="m" srcset="docs/pictures/a.svg">\n<img src="docs/pictures/b.svg" alt="b">', "README.md", outside.append),
                         '<source media="m" srcset="pictures/a.svg">\n<img src="pictures/b.svg" alt="b">')

    def test_a_link_to_nothing_is_left_for_mkdocs_to_refuse(self):
        self.assertEqual(mkdocs_hooks.fitted("[x](nowhere.md)", "README.md", self.fail), "[x](nowhere.md)")


@unittest.skipIf(os.path.exists("/opt/ros/noetic"), "the packages are Debian's")
class DebianPackages(unittest.TestCase):
    def test_they_are_built_with_what_make_build_installs(self):
        built_with = set(re.findall(r"^ ([a-z0-9.+-]+),?$", self.text("debian/control").split("Package:")[0], re.MULTILINE)) - {"dh-python", "help2man"}
        listed = subprocess.run(["bash", os.path.join(ROOT, "scripts/install_dependencies"), "--list", "build"], capture_output=True, text=True, check=True).stdout.split()
        self.assertLessEqual(built_with, set(listed))
        self.assertLessEqual({package for package in listed if package.endswith("-dev")}, built_with)

    def test_their_version_is_that_of_the_package_or_one_after_it(self):
        version = re.search("<version>(.*)</version>", self.text("package.xml"))[1]
        self.assertRegex(self.text("debian/changelog").splitlines()[0], r"^battery-sof \(" + re.escape(version) + r"(\+dev)?\)")

    def test_programs_take_the_library_that_they_were_built_with(self):
        """They call more of it than its public headers show."""
        for package in ("battery-sof", "python3-battery-sof", "ros-battery-sof"):
            paragraph = re.search(f"^Package: {package}$.*?(?=^Package:|\\Z)", self.text("debian/control"), re.MULTILINE | re.DOTALL)[0]
            self.assertRegex(paragraph, r"libbattery-sof[0-9.]+ \(= \$\{binary:Version\}\)", package)

    def text(self, path):
        with open(os.path.join(ROOT, path)) as file:
            return file.read()


class Files(unittest.TestCase):
    def test_a_line_that_was_cut_off_is_left(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "rows")
            files.append(path, {"a": 1})
            with open(path, "a") as file:
                file.write('{"a": 2')
            self.assertEqual(files.lines_of(path), [{"a": 1}])
            self.assertEqual(files.lines_of(path + "none"), [])

    def test_another_value_than_the_kept_one_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "kept")
            files.require_same(path, 1, "others")
            files.require_same(path, 1, "others")
            self.assertRaises(SystemExit, files.require_same, path, 2, "others")

    def test_a_table_has_a_cell_for_every_column(self):
        self.assertEqual(tables.table(["a", "b"], [[1, None]]), ["| a | b |", "|---|---|", "| 1 |  |"])


class Effects(unittest.TestCase):
    def test_every_effect_has_a_tier_and_a_family_of_those_that_are_printed(self):
        known = catalogue(program(BUILD, "sof"))
        self.assertGreater(len(known.codes), 20)
        for name in known.codes:
            self.assertIn(known.mechanism(name), known.mechanisms)
            self.assertIn(known.tier(name), "SPI")
        self.assertEqual(known.tier("clipping"), "I")
        self.assertEqual(known.sensors, known.mechanism("clipping"))
        self.assertEqual(sorted(known.structure | known.physics | known.instrument), sorted(known.mechanism_of))

    def test_a_name_of_no_family_has_none(self):
        self.assertIsNone(Catalogue({"effects": [], "mechanisms": [{"id": "x", "members": ["y"]}]}).mechanism("z"))

    def test_a_program_that_fails_is_told_with_its_words(self):
        with self.assertRaisesRegex(Failure, "exit code 2: .*gasing"):
            call([program(BUILD, "sof"), "effects", "gasing"])

    def test_a_program_that_is_stopped_from_outside_is_no_failure(self):
        with self.assertRaisesRegex(SystemExit, "stopped from outside"):
            call(["/bin/sh", "-c", "kill -TERM $$"])
        self.assertRaises(Failure, call, ["/bin/sh", "-c", "kill -SEGV $$"])

    def test_a_page_without_marks_is_refused(self):
        marks = pages_of_sof.MARKS["effects.md"]
        page = f"before\n{marks[0]}old\n{marks[1]}after\n"
        self.assertEqual(files.with_part(page, *marks, "new\n"), page.replace("old", "new"))
        for text in ("no marks", page.replace(marks[1], "")):
            self.assertRaises(SystemExit, files.with_part, text, *marks, "new")


class Recordings(unittest.TestCase):
    def written(self, text):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        path = os.path.join(self.folder.name, "recording.csv")
        with open(path, "w") as file:
            file.write(text)
        return path

    def test_rows_with_a_missing_number_are_left_and_the_sign_is_turned(self):
        path = self.written("a,b,c\n0,1,12\n1,,12\n2,3,12.5\n")
        t, i, u = recordings.read(path, ("a", "b", "c"), True)
        self.assertEqual((list(t), list(i), list(u)), ([0.0, 2.0], [-1.0, -3.0], [12.0, 12.5]))

    def test_a_missing_column_is_named_with_those_there_are(self):
        with self.assertRaisesRegex(SystemExit, "no column volts; there are a, b"):
            recordings.read(self.written("a,b\n1,2\n"), ("a", "b", "volts"))

    def test_dates_are_seconds(self):
        path = self.written("t,i,u\n2017-03-25 07:00:00,1,12\n2017-03-25 07:01:00,1,12\n")
        t, _, _ = recordings.read(path, ("t", "i", "u"))
        self.assertEqual(t[1] - t[0], 60.0)

    def test_what_is_written_is_read(self):
        path = self.written("")
        recordings.write(path, [0.0, 0.5], [-1.0, 2.0], [12.0, 12.5])
        np.testing.assert_allclose(recordings.read(path), [[0.0, 0.5], [-1.0, 2.0], [12.0, 12.5]])

    def test_nothing_is_carried_across_a_gap_but_what_decays(self):
        t = np.array([0.0, 1.0, 2.0, 3.0, 103.0, 104.0])
        passed = laws.low_pass(t, np.ones(6), 10.0)
        self.assertLess(passed[4], 1e-3 * passed[3])


class Answers(unittest.TestCase):
    def test_the_first_that_gives_a_family_a_probability_counts(self):
        answer = {"mechanism": "acid", "probability": None, "effects": [{"id": "x", "mechanism": "acid", "probability": 0.7},
                                                                     {"id": "y", "mechanism": "acid", "probability": 0.2}]}
        self.assertEqual(answers.mechanisms_of(answer, None), {"acid": 0.7})

    def test_several_true_families_make_one_of_them_right(self):
        self.assertEqual(answers.outcome("named", {"acid": 1.0}, {"acid", "ageing"}), "right")
        self.assertEqual(answers.outcome("named", {"acid": 1.0, "structure": 1.0}, {"acid", "ageing"}), "beside")


class SameDiagnosis(unittest.TestCase):
    def test_answers_agree_in_the_likeliest_and_sets_may_overlap_all_the_same(self):
        a, b, either = {"acid": 0.9}, {"ageing": 0.9}, {"acid": 0.5, "ageing": 0.4}
        self.assertEqual(same.agreement([(a, either), (either, b), (a, b), (a, {})]), {"cases": 3, "same": 1, "changed": 2, "overlap": 2, "without": 1})

    def test_pairs_are_changes_halves_and_drives_of_one_vehicle(self):
        a, b = ({"acid": 1.0}, "effect"), ({"ageing": 1.0}, "effect")
        one, other = same.VEHICLES[0]
        changes = dict.fromkeys(same.CHANGES, a)
        found = same.figures({one: {same.AS_IT_IS: a, **changes, same.HALVES[0]: a, same.HALVES[1]: b}, other: {same.AS_IT_IS: b, **changes}})
        self.assertEqual([found[key]["same"] for key in ("neutral", "halves", "trips")], [2, 0, 0])
        self.assertEqual([found[key]["cases"] for key in ("neutral", "halves", "trips")], [4, 1, 1])


class RealPlan(unittest.TestCase):
    def rows(self, count, seed=1, **more):
        return list(itertools.islice(real.rounds(seed, FORMS, **more), count))

    def test_a_round_has_every_family_of_every_recording_once(self):
        with_laws, whole = len(recordings.MEASURED) - len(real.NO_EFFECTS), len(recordings.MEASURED)
        rows = self.rows(with_laws * len(FORMS) + whole * real.ZEROS_A_ROUND)
        kinds = [(row["recording"], row["kind"]) for row in rows if row["kind"] != real.ZERO]
        self.assertEqual((len(set(kinds)), len(kinds)), (with_laws * len(FORMS),) * 2)
        self.assertEqual({row["turn"] for row in rows}, {0})
        self.assertFalse({recording for recording, _ in kinds} & set(real.NO_EFFECTS))

    def test_cases_follow_from_the_seed_and_not_from_who_else_is_asked(self):
        self.assertEqual(self.rows(50), self.rows(50))
        self.assertNotEqual([row["seed"] for row in self.rows(50)], [row["seed"] for row in self.rows(50, seed=2)])
        self.assertEqual(len({row["seed"] for row in self.rows(400)}), 400)
        everything = {row["name"]: row for row in self.rows(400)}
        for row in self.rows(8, only=["frc_robot"]):
            if row["turn"] < 2:
                self.assertEqual(everything[row["name"]], row)

    def test_no_round_is_begun_of_recordings_that_have_no_answer(self):
        self.assertEqual(list(real.rounds(1, FORMS, ["frc_robot"], {"frc_robot"})), [])
        self.assertEqual({row["turn"] for row in self.rows(50, only=["frc_robot", "small_car"], without_answer={"frc_robot"})}, {0, 1, 2, 3, 4})

    def test_forms_take_turns(self):
        row = {"kind": "acid", "recording": "frc_robot", "turn": 0}
        self.assertNotEqual(real.forms_in_turn(row, FORMS)[0], real.forms_in_turn(dict(row, turn=1), FORMS)[0])

    def test_an_hour_is_shown_and_a_day_where_samples_are_rare(self):
        self.assertEqual(real.stretch(np.arange(10000.0)), 3601)
        self.assertEqual(real.stretch(np.arange(0.0, 1e6, 60.0)), 1441)


def drive(count=4000):
    """Held currents [A] once a second, and a battery of 5 mOhm."""
    dice = np.random.default_rng(3)
    i = np.repeat(dice.uniform(-60.0, 30.0, count // 10), 10)
    t = np.arange(float(len(i)))
    return t, i, 12.6 + 5e-3 * i + 2e-3 * laws.low_pass(t, i, 30.0) + dice.normal(0.0, 1e-3, len(t))


class Laws(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.t, cls.i, cls.u = drive()
        cls.beside = laws.Beside(cls.t, cls.i, cls.u)

    def test_what_the_base_circuit_follows_is_not_visible(self):
        followed = self.u + 3e-3 * self.i + 0.2
        self.assertLess(self.beside.visible(self.i, followed)[0], 1e-9)
        self.assertAlmostEqual(self.beside.resistances()[0], 5e-3, delta=2e-4)

    def test_a_current_that_is_shown_wrong_is_visible_through_the_resistance(self):
        wave = 2.0 * np.sin(2.0 * np.pi * self.t / 200.0)
        seen = self.beside.visible(self.i + wave, self.u)[0]
        self.assertAlmostEqual(seen, (5e-3 + 2e-3 / np.sqrt(1.0 + (2.0 * np.pi * 30.0 / 200.0)**2)) * np.sqrt(2.0), delta=2e-3)

    def test_the_noise_put_in_at_zero_is_far_below_the_limit(self):
        voltage, drawn = laws.neutral(self.t, self.i, self.u, 0.02, 5)
        self.assertLess(self.beside.visible(self.i, voltage)[0], 0.15 * 0.02)
        self.assertGreater(abs(drawn["level_v"]) + drawn["resistance_ohm"], 0.0)

    def test_a_law_is_made_as_strong_as_it_is_wanted_and_refused_beyond_its_bounds(self):
        generator = Generator(BUILD)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "measured.csv")
            recordings.write(path, self.t, self.i, self.u)
            beside = laws.Beside(*recordings.read(path))
            for mechanism, form in (("structure", "conducting_film"), ("instrument", "thermostat_load")):
                wanted = 2e-3
                strength, shown, current, _ = laws.with_strength(generator, beside, path, {"mechanism": mechanism, "form": form, "seed": 1}, wanted, folder)
                self.assertGreaterEqual(shown[0], wanted)
                self.assertLessEqual(shown[0], 1.31 * wanted)
                self.assertEqual(current is beside.i, mechanism == "structure")
                self.assertLessEqual(strength, laws.MAX_STRENGTH)
            self.assertRaisesRegex(Failure, "too weak", laws.with_strength, generator, beside, path, {"mechanism": "instrument", "form": "remanence", "seed": 1}, 1.0, folder)


def told(*named, verdict="effect", parts=()):
    return {"verdict": verdict, "effects": [{"id": one, "mechanism": one, "probability": 0.95, "indistinguishable_from": []} for one in named], "limit_v": 0.01,
            "candidates": [{"mechanism": one, "rejected_because": ""} for one in parts], "holdout": {"base": {"rmse_v": 0.1}, "extended": {"rmse_v": 0.05}}}


def put_in(kind, answer, recording="a"):
    return {"name": "x", "recording": recording, "kind": kind, "seed": 1, "turn": 0, "drawn": {"form": "f"}, "answer": answer}


class RealScore(unittest.TestCase):
    UNCHANGED = {"a": told("structure", verdict="unexplained"), "b": told(verdict="no_mismatch")}

    def figures(self, rows):
        return {what: text for what, text, _ in real.figures(real.cases_of(rows, self.UNCHANGED)[0])}

    def test_new_is_what_is_not_named_without_it(self):
        rows = [put_in("acid", told("structure", "acid")), put_in("acid", told("structure")), put_in("acid", told("ageing")),
                put_in("acid", told("acid", "ageing"), "b")]
        found = self.figures(rows)
        self.assertTrue(found["put in: its mechanism newly named"].startswith("2 of 4"))
        self.assertTrue(found["of these with another beside it"].startswith("1 of 4"))
        self.assertTrue(found["put in: only another mechanism newly named"].startswith("1 of 4"))
        self.assertTrue(found["put in: nothing new named"].startswith("1 of 4"))

    def test_a_family_that_is_named_without_it_is_not_judged(self):
        found = self.figures([put_in("structure", told("structure")), put_in("structure", told("acid"))])
        self.assertEqual(found["put in: its mechanism newly named"], "no case")
        self.assertEqual(found["not judged, its mechanism is named without it too"], "2 of 2")
        self.assertTrue(found["of these still named"].startswith("1 of 2"))

    def test_at_zero_what_is_new_is_wrong(self):
        rows = [put_in(real.ZERO, told("structure")), put_in(real.ZERO, told("structure", "acid")), put_in(real.ZERO, told(), "b")]
        found = self.figures(rows)
        self.assertTrue(found["zero: nothing new named"].startswith("2 of 3"))
        self.assertTrue(found["zero: the verdict is as without"].startswith("0 of 3"))

    def test_a_new_part_of_what_is_unknown_is_told(self):
        rows = [put_in("acid", told("structure", verdict="unexplained", parts=["acid"])), put_in("ageing", told("structure", parts=["acid"]))]
        self.assertTrue(self.figures(rows)["put in: its mechanism newly named or a new part of what is unknown"].startswith("1 of 2"))

    def test_the_page_counts_what_could_not_be_drawn(self):
        rows = [put_in("acid", told("acid")), {"name": "y", "recording": "a", "kind": "ageing", "not_drawn": ["too weak"]},
                {"name": "z", "recording": "a", "kind": "ageing", "failed": "no answer"}]
        page = real.as_markdown(rows, self.UNCHANGED)
        self.assertIn("1 cases: 1 with a law in them, 0 at zero; 1 could not be drawn, 1 failed.", page)
        self.assertIn("Could not be drawn: ageing in a 1.", page)
        self.assertIn("Failed: z: no answer", page)


class RealRun(unittest.TestCase):
    """With stand-ins for the programs' answers."""

    class Bench:
        def __init__(self, out):
            self.out, self.asked, self.plain, self.forms, self.without_answer = out, [], False, FORMS, set()

        def case(self, case):
            self.asked.append(case["name"])
            if case["kind"] == "ageing":
                raise Failure("no answer")
            return dict(case, drawn={"form": "a"}, answer=told())

    def test_goes_on_where_it_was_cut_off(self):
        with tempfile.TemporaryDirectory() as folder:
            bench = self.Bench(folder)
            real.run(bench, 1, 5, 1.0, say=lambda *_: None)
            first = list(bench.asked)
            real.run(bench, 1, 9, 1.0, say=lambda *_: None)
            rows = files.lines_of(os.path.join(folder, real.ANSWERS))
            self.assertEqual([row["name"] for row in rows], bench.asked)
            self.assertEqual(len(set(bench.asked)), len(bench.asked))
            self.assertEqual(sum("answer" in row for row in rows), 9)
            self.assertEqual(bench.asked[:len(first)], first)
            self.assertRaises(SystemExit, real.run, bench, 2, 9, 1.0)

    def test_nothing_is_asked_when_the_minutes_are_over(self):
        with tempfile.TemporaryDirectory() as folder:
            bench = self.Bench(folder)
            real.run(bench, 1, 5, 0.0, say=lambda *_: None)
            self.assertEqual(bench.asked, [])

    def test_promises_are_tried_on_every_recording_of_a_plain_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            bench, data = self.Bench(folder), os.path.join(folder, "data")
            os.makedirs(data)
            for name in ("b.csv", "a.csv", "notes.txt"):
                open(os.path.join(data, name), "w").close()
            bench.plain, bench.data = True, os.path.join(folder, "nowhere")
            self.assertRaisesRegex(SystemExit, "nowhere: no folder of recordings", real.run, bench, 1, 9, 1.0)
            bench.data = data
            real.run(bench, 1, 9, 1.0, known=catalogue(program(BUILD, "sof")), say=lambda *_: None)
            self.assertEqual([name.split("/")[1] for name in bench.asked], ["a"] * 9)

    def test_a_promise_is_kept_at_the_strength_that_was_promised(self):
        known = catalogue(program(BUILD, "sof"))
        cases = [one for one in real.promised(1, known, ["small_car"])]
        self.assertEqual([one["kind"] for one in cases[:real.ZEROS_A_ROUND]], [real.ZERO] * real.ZEROS_A_ROUND)
        self.assertEqual([one["effect"] for one in cases[real.ZEROS_A_ROUND:]], list(real.PROMISED))
        slope, lag = (next(one for one in cases if one.get("effect") == effect) for effect in ("ocv_soc", "time_skew"))
        self.assertEqual((slope["kind"], lag["kind"]), ("open_circuit", "instrument"))
        self.assertEqual([one["tau_s"] for one in cases if one.get("effect") == "acid_transport"], [50.0])

        bench = real.Bench.__new__(real.Bench)
        t = np.arange(0.0, 3600.0)
        i, u = np.full(len(t), -10.0), np.full(len(t), 12.0)
        bench.unchanged, bench.shown = {"small_car": dict(told(), promised={"ocv_soc": 0.05})}, []
        bench.recording = lambda _: laws.Beside(t, i, u)
        bench.told = lambda *shown: bench.shown.append(shown) or told("open_circuit")
        self.assertEqual(bench.case(slope)["drawn"], {"form": "ocv_soc", "strength": 0.05})
        self.assertAlmostEqual(bench.shown[0][2][-1], 12.0 - 0.05 * 10.0 * 3599.0 / 3600.0)
        self.assertIn("not_drawn", bench.case(lag))

    def test_without_the_folder_of_recordings_it_says_so(self):
        self.assertRaisesRegex(SystemExit, "--data", real.main, ["nowhere"])


class StopRules(unittest.TestCase):
    """Two stops: 5 s with a crank to 10 V, 10 s with one to 8 V."""

    def setUp(self):
        i = np.array([20.0] * 3 + [-20.0] * 5 + [-200.0] + [30.0] * 3 + [-25.0] * 10 + [-210.0, -100.0] + [30.0] * 3)
        u = np.array([13.5] * 3 + [12.5] * 5 + [10.0] + [13.5] * 3 + [12.4] * 4 + [11.9] * 6 + [9.0, 8.0] + [13.5] * 3)
        self.t = np.arange(len(i), dtype=float)
        self.stops = stop_rules.stops_of(self.t, i, u)

    def test_stops_are_discharges_that_end_in_a_crank(self):
        self.assertEqual([(s.begin, s.end, s.lowest) for s in self.stops], [(3.0, 8.0, 10.0), (12.0, 22.0, 8.0)])

    def test_a_weak_crank_and_a_gap_make_no_stop(self):
        t = np.array([0.0, 1.0, 2.0, 3.0, 103.0, 104.0])
        u = np.full(6, 12.0)
        self.assertEqual(stop_rules.stops_of(t, np.array([5.0, -5, -5, -90, -5, 5]), u), [])
        after_gap = stop_rules.stops_of(t, np.array([5.0, -5, -5, -5, -5, -200]), u)
        self.assertEqual([s.begin for s in after_gap], [103.0])

    def test_what_a_rule_allows_is_counted(self):
        always = stop_rules.outcome(self.stops, [s.end for s in self.stops], 9.0)
        self.assertEqual(always, stop_rules.Outcome(2, 15.0, 2, 1, 0))
        by_voltage = [stop_rules.by_voltage(s, 12.0) for s in self.stops]
        self.assertEqual(by_voltage, [8.0, 16.0])
        self.assertEqual(stop_rules.outcome(self.stops, by_voltage, 9.0), stop_rules.Outcome(2, 9.0, 1, 0, 0))
        self.assertEqual(stop_rules.outcome(self.stops, [None, None], 9.0), stop_rules.Outcome(0, 0, 0, 0, 1))

    def test_a_manager_that_wants_the_engine_on_is_not_asked_again_in_that_stop(self):
        decisions = [(0, 3.0, False), (0, 4.0, True), (1, 12.0, True), (1, 15.0, False), (1, 16.0, True)]
        self.assertEqual(stop_rules.by_manager(self.stops, decisions), [None, 15.0])
        self.assertEqual(stop_rules.by_manager(self.stops, [(0, 3.0, True)]), [8.0, None])


class Entries(unittest.TestCase):
    def test_every_script_of_the_package_finds_its_module_from_anywhere(self):
        folder = os.path.join(ROOT, "scripts")
        tool = runpy.run_path(os.path.join(folder, "tool"))["MODULES"]
        links = [name for name in os.listdir(folder) if os.path.islink(os.path.join(folder, name))]
        self.assertGreater(len(links), 12)
        self.assertEqual(set(tool) - set(links), set())
        for name in links:
            self.assertEqual(os.readlink(os.path.join(folder, name)), "tool")
            module = tool.get(name, name).split()[0]
            path = os.path.join(ROOT, "tools", "battery_sof_tools", *module.split(".")) + ".py"
            self.assertTrue(os.path.exists(path), name)

    def test_help_is_printed_without_a_build(self):
        for name in ("proof", "out_of_model", "proof_real", "causes", "gate", "score_next_window", "calibrate_diagnosis", "compare_stop_rules", "same_diagnosis"):
            told_of = subprocess.run([sys.executable, os.path.join(ROOT, "scripts", name), "--help"], capture_output=True, text=True, cwd="/")
            self.assertEqual(told_of.returncode, 0, told_of.stderr)
            self.assertIn("usage", told_of.stdout)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""The pages hold the figures of docs/results.json, and the gate sees what is worse."""

import copy
import re
import unittest

from battery_sof_tools.files import read_json
from battery_sof_tools.results import gate, measurements, page_tables, pages

RESULTS = read_json(pages.RESULTS)
# Pages whose measured figures all are copies, and how many there are at least.
COPIES = {"README.md": 3, "docs/accuracy.md": 10, "docs/reading-a-diagnosis.md": 20, "docs/node.md": 2, "docs/energy-manager.md": 1}


class Pages(unittest.TestCase):
    def test_every_figure_is_that_of_the_results(self):
        self.assertEqual(pages.differing(RESULTS), [], "\nscripts/update_results_pages writes the pages again")

    def test_a_figure_that_was_changed_by_hand_is_named_with_its_page(self):
        for page, least in COPIES.items():
            text = pages.open_page(page)
            copies = list(pages.FIGURE.finditer(text))
            self.assertGreaterEqual(len(copies), least, page)
            one = copies[0]
            changed = text[:one.start()] + "9" + text[one.start():]
            said = pages.differing(RESULTS, {page: changed})
            self.assertEqual(len(said), 1, said)
            self.assertIn(f"{page}: {one['id']}: the page says", said[0])

    def test_a_cell_of_a_table_that_was_changed_is_named_with_its_page(self):
        text = pages.open_page("README.md")
        table = next(one for one in pages.BLOCK.finditer(text) if one["name"] == "next_window_short")
        at = text.index(" %", table.start("lines"))
        said = pages.differing(RESULTS, {"README.md": text[:at] + "1" + text[at:]})
        self.assertEqual(len(said), 1, said)
        self.assertIn("README.md: results: next_window_short: the page says", said[0])

    def test_a_figure_that_is_in_no_results_is_named(self):
        said = []
        pages.rendered("12<!--= nothing.here --> and\n<!-- results: no_such_table -->\n<!-- end of results -->\n", RESULTS, said.append)
        self.assertEqual(len(said), 2, said)

    def test_a_figure_keeps_its_own_decimals_sign_and_thousands(self):
        self.assertEqual([pages.like(number, 1234.56) for number in ("1", "2.0", "+3", "1,000.00")], ["1235", "1234.6", "+1235", "1,234.56"])

    def test_another_picture_is_seen(self):
        results = copy.deepcopy(RESULTS)
        name, entry = next((name, entry) for name, entry in results.items() if entry["files"])
        file = next(iter(entry["files"]))
        entry["files"][file] = "0" * 64
        self.assertIn(f"docs/{file}", pages.differing(results)[0])

    def test_every_entry_says_how_and_of_which_commit(self):
        for name, entry in RESULTS.items():
            self.assertTrue(re.fullmatch(r"[0-9a-f]{7,40}", entry["commit"]), name)
            if name in measurements.MEASUREMENTS:
                self.assertEqual(entry["commands"], list(measurements.MEASUREMENTS[name].commands), name)


class Gate(unittest.TestCase):
    def verdicts(self, now, before=RESULTS):
        rows, worse = gate.held(before, now)
        return {row[0]: row[-1] for row in rows if row[-1] != "not measured"}, worse

    def changed(self, name, by):
        now = copy.deepcopy(RESULTS)
        *path, last = name.split(".")
        group = now[path[0]]["figures"]
        for key in path[1:]:
            group = group[key]
        group[last] += by
        return now

    def test_every_figure_of_it_is_committed(self):
        self.assertEqual([one.id for one in gate.FIGURES if pages.value_of(RESULTS, one.id) is None], [])

    def test_the_same_figures_are_no_worse(self):
        said, worse = self.verdicts(RESULTS)
        self.assertEqual((set(said.values()), len(said), worse), ({"ok"}, len(gate.FIGURES), 0))

    def test_less_of_what_should_be_more_is_worse(self):
        name = "next_window.drive_1.model.share_percent"
        self.assertEqual(self.verdicts(self.changed(name, -0.01))[0][name], "WORSE")
        self.assertEqual(self.verdicts(self.changed(name, 0.01))[0][name], "ok")

    def test_coverage_is_worse_the_farther_it_is_from_90(self):
        name = "study.crank.simulated.inside_percent"
        value = pages.value_of(RESULTS, name)
        away = 1.0 if value > 90.0 else -1.0
        self.assertEqual(self.verdicts(self.changed(name, away))[0][name], "WORSE")
        self.assertEqual(self.verdicts(self.changed(name, 90.0 - value))[0][name], "ok")

    def test_a_time_may_differ_by_its_scatter(self):
        name = "speed.search_over_ceres.ratio"
        scatter = gate.scatter_of(next(one for one in gate.FIGURES if one.id == name), RESULTS)
        self.assertGreater(scatter, 0.0)
        self.assertEqual(self.verdicts(self.changed(name, -0.9 * scatter))[0][name], "ok")
        self.assertEqual(self.verdicts(self.changed(name, -1.1 * scatter))[0][name], "WORSE")

    def test_what_was_not_measured_is_said(self):
        rows, worse = gate.held(RESULTS, {})
        self.assertEqual(({row[-1] for row in rows}, worse), ({"not measured"}, 0))


class Measured(unittest.TestCase):
    def test_rows_of_a_bench_are_read(self):
        text = ("Ceres autodiff, plain, QR, bounds                20.79    23.11   21.06 .. 26.98    44.15   40.91 .. 51.39      12\n"
                "Ceres autodiff, QR                            4800    13.33   12.08 .. 15.33    2.8e-07     0.18  9 values, 19 Jacobians\n")
        self.assertEqual(measurements.ratio_of(text, "Ceres autodiff, plain, QR, bounds"), {"ratio": 44.15, "least": 40.91, "most": 51.39})
        self.assertEqual(measurements.ratio_of(text, "Ceres autodiff, QR"), {"ratio": 13.33, "least": 12.08, "most": 15.33})

    def test_two_fleets_of_nulls_are_added_up(self):
        text = "| imperfect_null | 297 | 3 of 297 = 1.0 % | x |\n| null | 298 | 3 of 298 = 1 % | x |\n| null | 289 | 1 of 289 = 0.3 % | x |\n"
        self.assertEqual(measurements.fleet_nulls("", text), {"null": {"alarms": 4, "cases": 587}, "imperfect_null": {"alarms": 3, "cases": 297}})

    def test_stops_are_read_by_limit_and_rule(self):
        text = ("| recording | rule | stops | engine off | to the end | below 10.3 V | share | missed |\n|---|---|---|---|---|---|---|---|\n"
                "| drive_1 | manager | 1 of 2 | 3 s | 1 | 0 | 0.0 % | 1 |\n| all | manager | 104 of 307 | 361 s | 98 | 0 | 0.0 % | 202 |\n")
        self.assertEqual(measurements.stops("", text), {"10_3_v": {"manager": {"begun": 104, "stops": 307, "off_s": 361.0, "to_the_end": 98, "below": 0, "missed": 202}}})

    def test_what_is_compared_has_the_same_windows(self):
        def scored(start, share):
            one = {"share_percent": share, "current_share_percent": None, "voltage_share_percent": share, "charges": [], "charges_60s": [], "cranks": []}
            return (("drive_1", start), {"model": one, "baseline": one, "ridge": one})
        windows = {"model": dict([scored(0, 60.0), scored(900, 20.0)]), "circuit": dict([scored(0, 40.0)]), "placebo": dict([scored(0, 50.0), scored(900, 10.0)]),
                   "paper_start": dict([scored(900, 5.0)])}
        found = measurements.beside(windows)
        self.assertEqual((found["windows"], found["model"]["share_percent"]), (2, 40.0))
        self.assertEqual([found["common"][one]["share_percent"] for one in ("model", "circuit", "placebo")], [60.0, 40.0, 50.0])
        self.assertEqual((found["common"]["windows"], found["paper_start"]["windows"], found["paper_start"]["model"]["share_percent"]), (1, 1, 20.0))
        self.assertEqual(measurements.beside(dict(windows, paper_start={}))["paper_start"], {"windows": 0})


class Tables(unittest.TestCase):
    def test_every_registered_figure_of_a_run_is_there_with_its_aim_and_the_missed_are_marked(self):
        run = {"first_C1": {"k": 7, "n": 10}, "crank_mae_v": {"value": 0.59, "n": 15}, "clean_C1": {"k": 6, "n": 10}, "withheld": {"k": 0, "n": 0}}
        self.assertEqual(page_tables.levels_of("run")({"run": run})[2:], [
            "| C1 | first name true | 7 of 10 | >= 90 %: missed |", "| C1 | mechanism right, no false one beside it | 6 of 10 | - |",
            "| C1, X1 | held-out cranks' minima, extended / base, median | 0.59 (of 15) | <= 0.3: missed |"])

    def test_a_mechanism_right_with_a_false_one_beside_it_stands_apart(self):
        results = {name: entry["figures"] for name, entry in RESULTS.items()}
        results["out_of_model"] = dict(results["out_of_model"], others=58, clean=30, beside=17)
        lines = "\n".join(page_tables.out_of_model(results))
        self.assertIn("no false one beside it (95 % interval) | 30 of 58: 52 %", lines)
        self.assertIn("a false one beside it | 17 of 58 |", lines)


if __name__ == "__main__":
    unittest.main(verbosity=2)

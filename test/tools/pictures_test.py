#!/usr/bin/env python3
"""Pictures show what their commands give now: drawings have their numbers inside, pictures of a diagnosis its summary."""

import glob
import os
import re
import tempfile
import unittest

from battery_sof_tools import live_pictures, node_drawing, page_drawings, page_pictures
from battery_sof_tools.files import ROOT, pages_of_docs, read_text
from battery_sof_tools.sof import program

PICTURES = os.path.join(ROOT, "docs", "pictures")
BY_HAND = {name + ending for name in ("circuit", "energy_manager_sequence", "node_states", "query_sequence") for ending in (".svg", "_narrow.svg")}
WORKED = {name.replace("diagnosis", "worked") for name in page_pictures.WORKED}
ANSWERED = {**page_drawings.SIMULATED, **page_drawings.MEASURED, **page_drawings.PLAYED}  # what programs answered
DRAWN = {name + ".svg" for name in (*page_drawings.files_of(ANSWERED), *page_drawings.DIAGRAMS)}
TOLERANCE = 1e-3  # of the largest number of a list: what another compiler changes


def same(one, other):
    """Whether two drawings show the same, but for rounding."""
    if isinstance(one, dict):
        return isinstance(other, dict) and one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list):
        if not isinstance(other, list) or len(one) != len(other):
            return False
        if all(isinstance(each, (int, float)) for each in (*one, *other)):
            limit = TOLERANCE * max((abs(each) for each in one), default=0)
            return all(abs(a - b) <= limit for a, b in zip(one, other))
        return all(map(same, one, other))
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= TOLERANCE * abs(one)
    return one == other


class Pictures(unittest.TestCase):
    def test_every_picture_is_on_a_page_and_made_by_a_command_or_a_diagram_by_hand(self):
        there = {os.path.basename(path) for path in glob.glob(os.path.join(PICTURES, "*"))}
        self.assertEqual(there, BY_HAND | WORKED | DRAWN | set(page_pictures.PICTURES) | set(live_pictures.PICTURES))
        shown = set()
        for page in ("README.md", *pages_of_docs()):
            text = read_text(os.path.join(ROOT, page))
            shown |= set(re.findall(r"!\[[^\]]+\]\((?:docs/|\.\./)?pictures/([^)]+)\)", text))
            shown |= set(re.findall(r'(?:srcset|<img src)="(?:docs/)?pictures/([^"]+)"', text))
        self.assertEqual(there, shown)

    def test_drawings_show_what_sof_answers(self):
        with tempfile.TemporaryDirectory(prefix="some drawings ") as folder:
            for name, (shown, *_) in page_drawings.SIMULATED.items():
                now = page_drawings.kept(shown(program(os.environ["BATTERY_SOF_BUILD"], "sof"), folder))
                self.assertTrue(same(page_drawings.numbers_of(os.path.join(PICTURES, name + ".svg")), now), f"{name} is behind: run scripts/page_drawings")

    def test_a_narrow_drawing_has_the_numbers_of_the_wide_one(self):
        for file, (name, _) in page_drawings.files_of(ANSWERED).items():
            numbers = page_drawings.numbers_of(os.path.join(PICTURES, file + ".svg"))
            self.assertTrue(numbers, file)
            self.assertEqual(numbers, page_drawings.numbers_of(os.path.join(PICTURES, name + ".svg")), file)

    def test_every_effect_is_drawn_and_changes_the_voltage(self):
        added = page_drawings.numbers_of(os.path.join(PICTURES, "effect_signatures.svg"))["added_mv"]
        files = glob.glob(os.path.join(ROOT, "src", "model", "effects", "*.cpp"))
        self.assertEqual(set(added), {os.path.basename(file)[:-4] for file in files if "effectOf<" in read_text(file)})
        for name, values in added.items():
            self.assertGreater(max(map(abs, values)), 0.1, name)

    def test_the_trips_pass_through_the_bases_that_the_nodes_page_lists(self):
        first, second = page_drawings.numbers_of(os.path.join(PICTURES, "trips_of_the_node.svg"))
        seen = [[basis for _, _, basis in trip["basis"]] for trip in (first, second)]
        self.assertEqual([basis for k, basis in enumerate(seen[0]) if basis not in seen[0][:k]], ["NO_DATA", "population", "this_trip"])
        self.assertEqual(seen[0].count("NO_DATA"), 2)  # before the first sample, and while the sensor is silent
        self.assertEqual(seen[1], ["NO_DATA", "previous_trip", "this_trip"])
        listed = re.findall(r"^\| `(\w+)` \|", read_text(os.path.join(ROOT, "docs", "node.md")).partition("| answer_basis |")[2].partition("\n\n")[0], re.M)
        self.assertEqual(set(sum(seen, [])), {"NO_DATA", *listed})

    def test_diagrams_are_of_the_sources(self):
        for name, drawing in page_drawings.DIAGRAMS.items():
            self.assertEqual(read_text(os.path.join(PICTURES, name + ".svg")), drawing(), f"run scripts/page_drawings --only {name}")

    def test_the_node_is_drawn_with_what_it_advertises(self):
        listed = {kind: set(re.findall(r"\| `~(\w+)`[,|\s]", part)) for kind, part in parts_of_the_nodes_page().items()}
        self.assertEqual({kind: set(names) for kind, names in node_drawing.interface().items()}, listed)
        self.assertEqual({name for names in node_drawing.interface().values() for name in names} - set(node_drawing.USES), set())

    def test_pictures_of_the_worked_diagnosis_are_of_the_one_that_its_page_shows(self):
        page = " ".join(read_text(os.path.join(ROOT, "docs", "worked-diagnosis.md")).split())
        for name in WORKED:
            summary = page_pictures.summary_of(os.path.join(PICTURES, name))
            self.assertGreater(len(summary), 50, name)
            self.assertIn(" ".join(summary.split()), page, f"{name}: run scripts/page_pictures PAGE.html docs/pictures worked")

    def test_the_live_page_is_shown_with_the_fields_that_it_has(self):
        for name in live_pictures.PICTURES:
            self.assertEqual(page_pictures.summary_of(os.path.join(PICTURES, name)), live_pictures.version_of_page(), f"{name}: run scripts/live_pictures")

    def test_a_drawing_with_other_numbers_is_seen(self):
        numbers = page_drawings.numbers_of(os.path.join(PICTURES, "crank_over_stop.svg"))
        self.assertTrue(same(numbers, numbers))
        changed = dict(numbers, u_min=[value * 1.01 for value in numbers["u_min"]])
        self.assertFalse(same(numbers, changed))
        self.assertFalse(same(numbers, dict(numbers, u_min=numbers["u_min"][:-1])))
        self.assertFalse(same(numbers, {"u_min": numbers["u_min"]}))


def parts_of_the_nodes_page():
    text = read_text(os.path.join(ROOT, "docs", "node.md"))
    titles = {"topics": "## Topics", "services": "## Services", "actions": "### Identify and diagnose"}
    return {kind: text.partition(f"\n{title}\n")[2].partition("\n##")[0] for kind, title in titles.items()}


if __name__ == "__main__":
    unittest.main(verbosity=2)

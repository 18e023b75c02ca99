"""What `sof` writes with --json is what docs/schemas says, and docs/json.md is generated from it.

Exit code 77: skipped, the package python3-jsonschema is missing or too old for draft 2020-12.
"""

import copy
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

from battery_sof_tools import json_page
from battery_sof_tools.files import ROOT, read_json, read_text
from battery_sof_tools.pages_of_sof import subcommands
from battery_sof_tools.sof import call, program

try:
    from jsonschema import Draft202012Validator
except ImportError:
    print("python3-jsonschema is missing or too old")
    sys.exit(77)

SOF = program(os.environ["BATTERY_SOF_BUILD"], "sof")
CRANK = ("--i-load", "-20", "--t-stop", "30", "--i-cranking", "-200")
STOP_TIME = ("--i-load", "-20", "--i-cranking", "-200", "--u-required")
MAP = ("--i-load", "-20,-10", "--t-stop", "10,20", "--i-cranking", "-200")
UNITS = {"s": "s", "ms": "ms", "v": "V", "a": "A", "as": "As", "ah": "Ah", "j": "J", "c": "degC", "percent": "%"}  # by the ending of a key
ONE = ("--hypotheses", "current_dependent_resistance")  # keeps a diagnosis short
# name: schema, what comes behind `sof`
ANSWERS = {
    "demo": ("simulate", "demo", "again.csv", "--duration", "10"),
    "simulate": ("simulate", "simulate", os.path.join(ROOT, "config", "scenarios", "data_set_3.yaml"), "long.csv", "--duration", "600"),
    "check": ("check", "check", "drive.csv"),
    "check of faults": ("check", "check", "faults.csv"),
    "check of a temperature": ("check", "check", "warm.csv", "--temperature-column", "temperature_c"),
    "convert": ("convert", "convert", "drive.csv", "shifted.csv", "--shift-current", "0.02"),
    "identify": ("identify", "identify", "drive.csv", "--out", "model.yaml"),
    "identify with effects": ("identify", "identify", "charger.csv", "--out", "charger.yaml"),
    "identify without a model": ("identify", "identify", "faults.csv", "--out", "none.yaml"),
    "predict": ("predict", "predict", "model.yaml", "drive.csv"),
    "predict both ways": ("predict", "predict", "charger.yaml", "charger.csv"),
    "crank": ("crank", "crank", "model.yaml", *CRANK),
    "crank with a limit": ("crank", "crank", "model.yaml", *CRANK, "--u-required", "12"),
    "crank that is not valid": ("crank", "crank", "model.yaml", *CRANK[:-1], "-900"),
    "stop-time": ("stop-time", "stop-time", "model.yaml", *STOP_TIME, "11.45"),
    "stop-time that ends at what is valid": ("stop-time", "stop-time", "model.yaml", *STOP_TIME, "8"),
    "stop-time of 0": ("stop-time", "stop-time", "model.yaml", *STOP_TIME, "12.5"),
    "stop-time without end": ("stop-time", "stop-time", "model.yaml", "--i-load", "0", "--i-cranking", "-200", "--u-required", "8"),
    "charge": ("charge", "charge", "model.yaml", "--u-boost", "13"),
    "charge that is not valid": ("charge", "charge", "model.yaml", "--u-boost", "15"),
    "map of cranks": ("map", "map", "model.yaml", *MAP),
    "map of both": ("map", "map", "model.yaml", *MAP, "--u-required", "11", "--u-boost", "13,15", "--t-sof2", "10"),
    "diagnose": ("diagnose", "diagnose", "drive.csv", "--hypotheses", "current_dependent_resistance,cpe2"),
    "diagnose with a charger": ("diagnose", "diagnose", "charger.csv", "--hypotheses", "fresh_sulphate,cpe2"),
    "diagnose a contact that is worse for a minute": ("diagnose", "diagnose", "for_a_minute.csv", *ONE),
    "diagnose without a verdict": ("diagnose", "diagnose", "again.csv"),
    "diagnose with a reference": ("diagnose-reference", "diagnose", "changed.csv", "--reference", "drive.csv"),
    "diagnose by responses": ("diagnose-reference", "diagnose", "again.csv", "--reference", "drive.csv", "--responses-only"),
    "effects": ("effects", "effects"),
    "one effect": ("effects", "effects", "gassing"),
}


def schema_of(name):
    return read_json(os.path.join(json_page.FOLDER, name + ".schema.json"))


def write_rows(path, rows, head="time_s,current_a,voltage_v"):
    with open(path, "w") as file:
        file.write(head + "\n")
        file.writelines(",".join(map(str, row)) + "\n" for row in rows)


def charger_drive(seconds=1500, seed=3):
    """At one sample a second: stops with a load, a crank, then an alternator that holds a voltage it changes now and then. The more has been
    discharged, the more current the battery takes."""
    dice = random.Random(seed)
    fresh, slow, stop_until, next_stop, held, rows = 150.0, 0.0, 0.0, 20.0, 14.0, []
    for second in range(seconds):
        if second >= next_stop:
            stop_until = second + dice.uniform(8, 20)
            next_stop = stop_until + dice.uniform(25, 50)
        if second % 7 == 0:
            held = dice.uniform(13.4, 14.6)
        if second > stop_until:
            current, voltage = (held - 12.7 - slow) / (0.008 + 0.06 / (1 + fresh / 60)), held
        else:
            current = dice.uniform(-28, -18) if second < stop_until - 1 else dice.uniform(-220, -180)
            voltage = 12.7 + slow + 0.008 * current
        fresh = max(1, fresh - current * (0.7 if current < 0 else 1))
        slow += (0.006 * current - slow) / 12
        rows.append((second, round(current + dice.gauss(0, 0.1), 2), round(voltage + dice.gauss(0, 0.01), 3)))
    return rows


def worse_for_a_minute(recording):
    """The rows with a contact of 10 mOhm in a minute."""
    for line in read_text(recording).splitlines()[1:]:
        t, i, u = map(float, line.split(","))
        yield t, i, round(u + 0.01 * i * (300.0 <= t < 360.0), 4)


def make_recordings(folder):
    path = lambda name: os.path.join(folder, name)
    call([SOF, "demo", path("drive.csv"), "--duration", "400"])
    call([SOF, "demo", path("short.csv"), "--duration", "150"])
    call([SOF, "demo", path("quarter.csv"), "--duration", "900"])
    rows = [line.split(",") for line in read_text(path("drive.csv")).splitlines()[1:]]
    write_rows(path("changed.csv"), ((t, i, round(float(u) + 0.01 * float(i), 4)) for t, i, u in rows))
    write_rows(path("for_a_minute.csv"), worse_for_a_minute(path("quarter.csv")))
    write_rows(path("warm.csv"), ((*row, 21.5) for row in rows[:5000]), "time_s,current_a,voltage_v,temperature_c")
    # the wrong sign, a gap, a value that is missing, a stamp that is there twice
    faulty = [[t, str(-float(i)), u] for t, i, u in rows[::10] if not 100 < float(t) < 130]
    faulty[5][1], faulty[8] = "", faulty[7]
    write_rows(path("faults.csv"), faulty)
    write_rows(path("charger.csv"), charger_drive())


def objects_of(value, path=()):
    """Paths of all objects in a document; of a list's entries the first."""
    if isinstance(value, dict):
        yield path
        for key, each in value.items():
            yield from objects_of(each, (*path, key))
    elif isinstance(value, list) and value:
        yield from objects_of(value[0], (*path, 0))


def at(value, path):
    for step in path:
        value = value[step]
    return value


def part_at(whole, path):
    """What a schema says of an object at a path of a document."""
    part = whole
    for step in path:
        part = part["items"] if step == 0 else part["properties"][step]
        part = json_page.referred(whole, part)[1] or part
    return part


class Schemas(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="some answers ")
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        make_recordings(cls.folder)
        cls.answers = {}
        for name, (_, *command) in ANSWERS.items():
            told = subprocess.run([SOF, *command, "--json", "answer.json"], cwd=cls.folder, capture_output=True, text=True)
            if told.returncode not in (0, 1):
                raise AssertionError(f"{name}: {told.stderr}")
            cls.answers[name] = read_json(os.path.join(cls.folder, "answer.json"))
            os.remove(os.path.join(cls.folder, "answer.json"))
        cls.validators = {name: Draft202012Validator(schema_of(name)) for name in json_page.names()}

    def faults(self, name, answer):
        return [f"{name}: {'/'.join(map(str, fault.path))}: {fault.message[:200]}" for fault in self.validators[ANSWERS[name][0]].iter_errors(answer)]

    def test_are_schemas(self):
        for name in json_page.names():
            Draft202012Validator.check_schema(schema_of(name))

    def test_every_answer_is_as_its_schema_says(self):
        for name, answer in self.answers.items():
            self.assertEqual(self.faults(name, answer), [])

    def test_every_command_that_writes_json_has_answers_here_and_every_schema_too(self):
        writing = {name for name in subcommands(call([SOF, "--help"])) if "--json" in call([SOF, name, "--help"])}
        self.assertEqual(writing, {command for _, command, *_ in ANSWERS.values()})
        self.assertEqual(set(json_page.names()), {schema for schema, *_ in ANSWERS.values()})

    def test_a_key_that_is_added_anywhere_is_refused(self):
        for name, answer in self.answers.items():
            for path in objects_of(answer):
                changed = copy.deepcopy(answer)
                at(changed, path)["added"] = 1
                self.assertTrue(self.faults(name, changed), f"{name}: {path}")

    def test_a_key_that_is_missing_is_refused(self):
        for name, answer in self.answers.items():
            whole = schema_of(ANSWERS[name][0])
            for path in objects_of(answer):
                required = part_at(whole, path)["required"]
                self.assertTrue(required, f"{name}: {path}")
                for key in at(answer, path):
                    if key in required:
                        changed = copy.deepcopy(answer)
                        del at(changed, path)[key]
                        self.assertTrue(self.faults(name, changed), f"{name}: {path}: {key}")

    def test_a_value_of_another_type_is_refused(self):
        for name, answer in self.answers.items():
            for path in objects_of(answer):
                for key in at(answer, path):
                    changed = copy.deepcopy(answer)
                    at(changed, path)[key] = {"a": "value of no key"}
                    self.assertTrue(self.faults(name, changed), f"{name}: {path}: {key}")

    def test_every_object_is_described_by_an_answer(self):
        """What no answer holds has not been compared with anything; an optional key may be missing from all."""
        for schema in json_page.names():
            met = set()
            for name, (of, *_) in ANSWERS.items():
                if of == schema:
                    meet(self.validators[schema].schema, self.validators[schema].schema, self.answers[name], met)
            whole = schema_of(schema)
            optional = {json_page.referred(whole, each.get("items", each))[0] for key, each in whole["properties"].items() if key not in whole["required"]}
            self.assertEqual(set(whole.get("$defs", {})) - met - optional, set(), schema)

    def test_mechanisms_are_those_of_the_catalogue(self):
        known = [one["id"] for one in self.answers["effects"]["mechanisms"]]
        for name in json_page.names():
            for lists in enums(schema_of(name)):
                if "acceptance" in lists:
                    self.assertEqual([one for one in lists if one], known, name)

    def test_every_number_has_its_unit(self):
        for name in json_page.names():
            for path, part in properties(schema_of(name)):
                unit = UNITS.get(path.rpartition("_")[2])
                if unit and "integer" not in part["type"]:
                    self.assertIn(f"[{unit}]", json_page.meaning(schema_of(name), part), f"{name}: {path}")


class Page(unittest.TestCase):
    def test_is_what_the_schemas_say(self):
        page = read_text(json_page.PAGE)
        self.assertEqual(page, json_page.with_reference(page), "docs/json.md is behind: run scripts/update_json_page")


def properties(whole):
    """Path and schema of every property of a file, those of its definitions included."""
    def of(part, path):
        for key, each in part.get("properties", {}).items():
            yield path + key, each
            yield from of(each, path + key + ".")
            yield from of(each.get("items", {}), path + key + "[].")
    yield from of(whole, "")
    for name, each in whole.get("$defs", {}).items():
        yield from of(each, name + ".")


def enums(part):
    if isinstance(part, dict):
        if "enum" in part:
            yield part["enum"]
        for each in part.values():
            yield from enums(each)
    elif isinstance(part, list):
        for each in part:
            yield from enums(each)


def meet(whole, part, value, met):
    """Collects the definitions of a schema that a document uses."""
    for each in (part, *part.get("anyOf", ())):
        if "$ref" in each and value is not None:
            name = each["$ref"].rpartition("/")[2]
            met.add(name)
            meet(whole, whole["$defs"][name], value, met)
    if isinstance(value, dict):
        for key, each in value.items():
            if key in part.get("properties", {}):
                meet(whole, part["properties"][key], each, met)
    elif isinstance(value, list):
        for each in value:
            meet(whole, part.get("items", {}), each, met)


if __name__ == "__main__":
    unittest.main(verbosity=2)

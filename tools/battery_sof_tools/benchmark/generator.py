"""Every call of the program that draws cases, `draw_scenario`: the catalogue's equations, controls, and laws that no catalogue has.

The benchmarks' words for a kind of case are part of their seeds and of plans that are kept, so they stay what they are.
"""

import collections
import contextlib
import hashlib
import os
import tempfile

from ..files import read_json
from ..sof import RECORDING, program, run

PROGRAM = "draw_scenario"
KIND_OF = {"null": "base_control", "structural_null": "structural_control", "porous_null": "porous_control",
           "decoy": "instrument_fault", "unknown": "unlisted_law"}  # of the catalogue's; the others have the same name
LAW_KIND_OF = {"null": "control", "imperfect_null": "control_with_recorder", "other_form": "out_of_catalogue"}
CAUSES = "physical_difference"  # of a porous block, put into measured recordings


def as_planned(label):
    """The label of a law or a control in the benchmarks' words: kind, mechanism, form. Labels in them stay as they are."""
    words = {kind: word for word, kind in LAW_KIND_OF.items()}
    if label["kind"] not in words:
        return label
    return {**label, "kind": words[label["kind"]], "mechanism": label.get("mechanism"), "form": label.get("id")}


def seed_of(*parts):
    """63 bits of its own for every case."""
    digest = hashlib.sha256("/".join(map(str, parts)).encode()).digest()
    return int.from_bytes(digest[:8], "big") >> 1


def options(case, keys):
    """A law's form is an id of `draw_scenario`."""
    return [word for key in keys if case.get(key) is not None for word in ("--" + {"form": "id"}.get(key, key), str(case[key]))]


class Generator:
    """The program of a build, looked for when it is called."""

    def __init__(self, build):
        self.build = build

    def program(self):
        return program(self.build, PROGRAM)

    def listed(self):
        """(kind, mechanism, id) of everything that can be drawn, "-" where there is nothing to choose."""
        return [line.split() for line in run([self.program(), "--list"]).splitlines()]

    def catalogue(self):
        """{mechanism: [id, ...]} of cases with the catalogue's equations and of controls; "-" where there is nothing to choose."""
        ids = collections.defaultdict(list)
        words = {kind: word for word, kind in KIND_OF.items()}
        for kind, _, name in self.listed():
            if kind not in (*LAW_KIND_OF.values(), "deep_cycle", CAUSES):
                ids[words.get(kind, kind)].append(name)
        return dict(ids)

    @contextlib.contextmanager
    def drawn(self, case, quiet=False):
        """A case of catalogue(): its label, and its recording for as long as the block lasts. Scale 1 is the generator's own."""
        word = case["family"] if "family" in case else case["mechanism"]  # plans that were preregistered say family
        kind = KIND_OF.get(word, word)
        command = [self.program(), "--kind", kind] + options(case, ("seed",))
        if case["id"] != "-":
            command += ["--id", case["id"]]
        if any(scale != 1.0 for scale in case.get("scale", ())):
            command += ["--scale", ",".join(f"{scale:.6g}" for scale in case["scale"])]
        if case.get("duration_s"):
            command += ["--duration", f"{case['duration_s']:g}"]
        with tempfile.TemporaryDirectory(prefix="case_") as folder:
            recording, label = (os.path.join(folder, name) for name in (RECORDING, "label.json"))
            run(command + ["--out", recording, "--label", label] + ["--quiet"] * quiet)
            told = read_json(label)
            del told["kind"]
            yield {**told, "family": word, "schema": "battery_sof/case/1"}, recording  # as the preregistered labels have it

    def laws(self):
        """{mechanism: [form, ...]} of laws that no catalogue has."""
        return self.by_mechanism(LAW_KIND_OF["other_form"])

    def causes(self):
        """{mechanism: [cause, ...]} of a porous block."""
        return self.by_mechanism(CAUSES)

    def by_mechanism(self, wanted):
        """{mechanism: [id, ...]} of a kind."""
        ids = collections.defaultdict(list)
        for kind, mechanism, name in self.listed():
            if kind == wanted:
                ids[mechanism].append(name)
        return dict(ids)

    def draw_labelled(self, case, recording, label):
        """Draws a case and writes its label. case: kind and form in the benchmarks' words, or kind and id in those of `draw_scenario`."""
        run([self.program(), "--kind", LAW_KIND_OF.get(case["kind"], case["kind"]), "--out", recording, "--label", label]
            + ["--independent-drive"] * case.get("independent_drive", False)
            + options(case, ("mechanism", "form", "id", "seed", "drive-seed", "rate", "duration")))

    def cause(self, recording, out, strengths, capacity_ah):
        """Writes a recording with the difference of a porous block in it. strengths: {cause: strength}."""
        run([self.program(), "--into", recording, "--capacity-ah", f"{capacity_ah:g}", "--out", out]
            + [word for name, strength in strengths.items() for word in ("--cause", f"{name}={strength!r}")])

    def inject(self, recording, out, case, strength, resistances):
        """Writes a recording with a law in it. case: mechanism, form, seed. resistances: while discharging and charging [Ohm]."""
        discharge, charge = resistances
        run([self.program(), "--into", recording, "--strength", repr(strength), "--r-discharge", repr(discharge), "--r-charge", repr(charge), "--out", out]
            + options(case, ("mechanism", "form", "seed")))

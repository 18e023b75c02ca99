"""Every call of the programs that draw cases: `draw_case` (the catalogue's equations and controls) and `draw_out_of_model` (laws that no catalogue has)."""

import collections
import json
import os
import subprocess

from ..sof import Failure, libraries_beside, program, required

CATALOGUE, LAWS = "draw_case", "draw_out_of_model"


def run(command):
    """What a program printed; Failure with its words."""
    told = subprocess.run(command, capture_output=True, text=True, env=libraries_beside(command[0]))
    if told.returncode:
        raise Failure(f"{os.path.basename(command[0])}: {told.stderr.strip()[:300]}")
    return told.stdout


def options(case, keys):
    return [word for key in keys if case.get(key) is not None for word in ("--" + key, str(case[key]))]


class Generator:
    """The programs of a build, looked for when they are called. laws: another draw_out_of_model than the build's."""

    def __init__(self, build, laws=None):
        self.build, self.laws_program = build, laws

    def of_laws(self):
        return required(os.path.abspath(self.laws_program)) if self.laws_program else program(self.build, LAWS)

    def catalogue(self):
        """{mechanism: [id, ...]} of cases with the catalogue's equations and of controls; "-" where there is nothing to choose."""
        ids = collections.defaultdict(list)
        for line in run([program(self.build, CATALOGUE), "--list"]).splitlines():
            mechanism, name = line.split()
            ids[mechanism].append(name)
        return dict(ids)

    def draw(self, case, recording, quiet=False):
        """Draws a case of catalogue(); its label. Scale 1 is the generator's own."""
        label = recording + ".label"
        command = [program(self.build, CATALOGUE), "--out", recording, "--label", label] + options(case, ("mechanism", "seed"))
        if case["id"] != "-":
            command += ["--id", case["id"]]
        if any(scale != 1.0 for scale in case.get("scale", ())):
            command += ["--scale", ",".join(f"{scale:.6g}" for scale in case["scale"])]
        if case.get("duration_s"):
            command += ["--duration", f"{case['duration_s']:g}"]
        run(command + (["--quiet"] if quiet else []))
        with open(label) as file:
            told = json.load(file)
        os.remove(label)
        return told

    def laws(self):
        """{mechanism: [form, ...]} of laws that no catalogue has."""
        forms = collections.defaultdict(list)
        for line in run([self.of_laws(), "--list"]).splitlines():
            kind, mechanism, form = line.split()
            if kind == "other_form":
                forms[mechanism].append(form)
        return dict(forms)

    def draw_law(self, case, recording, label):
        """Draws a case with a law, or a null of the same batteries, and writes its label."""
        run([self.of_laws(), "--out", recording, "--label", label] + options(case, ("kind", "seed", "mechanism", "form", "rate", "duration")))

    def inject(self, recording, out, case, strength, resistances):
        """Writes a recording with a law in it. case: mechanism, form, seed. resistances: while discharging and charging [Ohm]."""
        discharge, charge = resistances
        run([self.of_laws(), "--beside", recording, "--strength", repr(strength), "--r-discharge", repr(discharge), "--r-charge", repr(charge), "--out", out]
            + options(case, ("mechanism", "form", "seed")))

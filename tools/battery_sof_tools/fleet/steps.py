"""The steps of one recording: `sof` is called, and what it said is kept in a file that appears whole or not at all.

A step's file: {"step", "exit", "reason", "answer", "cost"}. exit is that of `sof` (0, 1 an honest negative outcome, 2 refused), null where the step was not
taken or had no answer; reason is a sentence wherever there is no answer. A step that has its file is not taken again.
"""

import os
import resource
import subprocess
import tempfile
import time

from ..files import read_json, write_json
from ..sof import libraries_beside
from . import listing, plan

NEEDED = {"predict": "identify"}  # a step that needs the model of another


class Recording:
    """One recording on its way through the steps."""

    def __init__(self, folder, entry, setting):
        self.entry, self.setting = entry, setting
        self.results = plan.results(folder, entry["key"])
        self.is_bag = entry["path"].endswith(".bag")

    def file(self, name):
        return os.path.join(self.results, name)

    def columns(self):
        if self.is_bag and os.path.exists(self.file("recording.csv")):
            return []
        return listing.column_options(self.entry)

    def path(self):
        """Of what is read: a bag's copy as CSV where there is one, which every step can read."""
        converted = self.file("recording.csv")
        return converted if self.is_bag and os.path.exists(converted) else self.entry["path"]

    def priors(self):
        if not self.setting.get("priors"):
            return []
        kind = ["--vehicle-type", self.entry["vehicle_type"]] if "vehicle_type" in self.entry else []
        return ["--priors", self.setting["priors"], *kind]

    def command(self, step):
        read = [self.path(), *self.columns()]
        window = listing.window_options(self.entry)
        effects = ["--effects", self.entry["effects"]] if "effects" in self.entry else []
        model = self.file("model.yaml")
        return [self.setting["sof"], *{
            "check": ["check", *read],
            "convert": ["convert", self.entry["path"], self.file("recording.csv"), *listing.column_options(self.entry)],
            "identify": ["identify", *read, *window, "--auto", "--out", model, *effects, *self.priors()],
            "predict": ["predict", model, *read, *window],
            "diagnose": ["diagnose", *read, *window, "--threads", "1", *self.priors(), *([] if self.setting["without_pages"] else ["--report", self.file("page.html")])],
        }[step]]


def spent():
    """Time on the clock, and of the processor by this process and those it called [s]."""
    used = [resource.getrusage(which) for which in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return time.monotonic(), sum(one.ru_utime + one.ru_stime for one in used)


def since(begin):
    now = spent()
    return {"wall_s": now[0] - begin[0], "cpu_s": now[1] - begin[1]}


def asked(command, patience_s):
    """(exit code, answer, reason) of a call of sof."""
    with tempfile.TemporaryDirectory(prefix="sof_fleet_") as folder:
        path = os.path.join(folder, "answer.json")
        try:
            told = subprocess.run([*command, "--json", path], capture_output=True, text=True, errors="replace", timeout=patience_s, env=libraries_beside(command[0]))
        except subprocess.TimeoutExpired:
            return None, None, f"no answer within {patience_s:g} s"
        answer = read_json(path) if os.path.exists(path) else None
    words = [line for line in told.stderr.strip().splitlines() if line and not line.startswith("warning:")]
    if told.returncode < 0:
        return None, None, f"ended by signal {-told.returncode}"
    reason = None if told.returncode == 0 else ((answer or {}).get("message") or (words[-1] if words else f"exit code {told.returncode}"))
    return told.returncode, answer, reason


def converted(recording, patience_s):
    """sof convert tells nothing in JSON."""
    if not recording.is_bag:
        return None, None, "not needed: the recording is CSV"
    told = subprocess.run(recording.command("convert"), capture_output=True, text=True, errors="replace", timeout=patience_s, env=libraries_beside(recording.setting["sof"]))
    return told.returncode, None, told.stderr.strip()[-300:] or None


def scored(recording):
    from . import scoring  # numpy and scipy take their time
    return scoring.answer(recording)


def take(recording, step):
    """One step, and its file."""
    patience_s = recording.setting["patience_s"]
    begin = spent()
    if recording.entry["unreadable"]:
        told = None, None, recording.entry["unreadable"]
    elif step in NEEDED and not os.path.exists(recording.file("model.yaml")):
        told = None, None, f"not taken: {NEEDED[step]} gave no model"
    elif step == "convert":
        told = converted(recording, patience_s)
    elif step == "score":
        told = scored(recording)
    else:
        told = asked(recording.command(step), patience_s)
    write_json(recording.file(step + ".json"), {"step": step, "exit": told[0], "reason": told[2], "answer": told[1], "cost": since(begin)})


def run(folder, entry, setting):
    """All steps that a recording has no file of. A bag is converted again where its copy is needed and gone."""
    recording = Recording(folder, entry, setting)
    todo = plan.missing(folder, entry["key"], setting["steps"])
    if todo and "convert" in setting["steps"] and recording.is_bag and not os.path.exists(recording.file("recording.csv")):
        todo = [step for step in setting["steps"] if step in todo or step == "convert"]
    for step in todo:
        take(recording, step)
    if os.path.exists(recording.file("recording.csv")):
        os.remove(recording.file("recording.csv"))
    return len(todo)

"""One job of the engine, the recordings of a group one after the other: `sof` is called, and what it said is kept in a file that appears whole or not at all.

    python3 -m battery_sof_tools.fleet.steps FOLDER GROUP.json DONE

A step's file: {"step", "exit", "reason", "answer", "cost"}. exit is that of `sof` (0, 1 an honest negative outcome, 2 refused), null where the step was not
taken or had no answer; reason is a sentence wherever there is no answer. A step that has its file is not taken again. Whatever a step comes to is such a file: a
recording that was not foreseen loses no job. Only a `sof` that cannot be started, or a folder that cannot be written, does.
"""

import fcntl
import os
import resource
import subprocess
import sys
import tempfile
import time

from ..files import write_json
from ..sof import completed
from . import listing, plan, stored


class Recording:
    """One recording on its way through the steps."""

    def __init__(self, folder, entry, setting):
        self.entry, self.setting = entry, setting
        self.results = plan.results(folder, entry["key"])
        self.is_bag = entry["path"].endswith(".bag")

    def file(self, name):
        return os.path.join(self.results, name)

    def read(self):
        """Path of what is read and what reports its columns: a bag's copy as CSV where there is one, which every step can read."""
        converted = self.file("recording.csv")
        return [converted] if self.is_bag and os.path.exists(converted) else [self.entry["path"], *listing.column_options(self.entry)]

    def options(self):
        """Of sof identify."""
        return ["--effects", self.entry["effects"]] if "effects" in self.entry else []

    def command(self, step):
        read = self.read()
        window = listing.window_options(self.entry)
        model = self.file("model.yaml")
        return [self.setting["sof"], *{
            "check": ["check", *read],
            "convert": ["convert", self.entry["path"], self.file("recording.csv"), *listing.column_options(self.entry)],
            "identify": ["identify", *read, *window, "--auto", "--out", model, *self.options()],
            "predict": ["predict", model, *read, *window],
            "change": ["diagnose", self.entry["path"], *listing.column_options(self.entry), *window, "--responses-only", "--reference", (self.entry.get("first") or self.entry)["path"]],
            "diagnose": ["diagnose", *read, *window, "--threads", "1", *([] if self.setting["without_pages"] else ["--report", self.file("page.html")])],
        }[step]]


def spent():
    """Time on the clock, and of the processor by this process and those it called [s]."""
    used = [resource.getrusage(which) for which in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return time.monotonic(), sum(one.ru_utime + one.ru_stime for one in used)


def asked(command, name, patience_s):
    """(exit code, answer, reason) of a call of sof."""
    with tempfile.TemporaryDirectory(prefix="sof_fleet_") as folder:
        path = os.path.join(folder, "answer.json")
        told = called([*command, "--json", path], patience_s)
        answer = stored.parsed(stored.content(path), (stored.ANSWERS[name], None)) if os.path.exists(path) else None
    words = [line for line in told.stderr.strip().splitlines() if line and not line.startswith("warning:")]
    reason = None if told.returncode == 0 else ((answer or {}).get("message") or (words[-1] if words else f"exit code {told.returncode}"))
    return told.returncode, answer, reason


def called(command, patience_s):
    told = completed(command, errors="replace", timeout=patience_s)
    if told.returncode < 0:
        raise ValueError(f"ended by signal {-told.returncode}")
    return told


def no_reference(entry):
    """Why a recording is not compared with its battery's first one, or None."""
    if entry.get("first") is None:
        return "not taken: it is its battery's first recording"
    if listing.column_options(entry) != listing.column_options(entry["first"]):
        return "not taken: its battery's first recording has other columns"
    return None


def answered(recording, step, patience_s):
    """(exit code, answer, reason) of a step."""
    reason = recording.entry["unreadable"] or plan.unreadable(recording.entry["path"])
    if reason:
        return None, None, reason
    if step == "predict" and not os.path.exists(recording.file("model.yaml")):
        return None, None, "not taken: identify gave no model"
    if step == "change":
        reason = no_reference(recording.entry)
        if reason:
            return None, None, reason
    if step == "convert" and not recording.is_bag:
        return None, None, "not needed: the recording is CSV"
    if step == "convert":  # tells nothing in JSON
        told = called(recording.command("convert"), patience_s)
        return told.returncode, None, told.stderr.strip()[-300:] or None
    if step == "score":
        from . import scoring  # numpy and scipy take their time
        code, answer, reason = scoring.answer(recording, patience_s)
        return code, stored.require(answer, (stored.ANSWERS["score"], None)), reason
    return asked(recording.command(step), step, patience_s)


def take(recording, step):
    """One step, and its file."""
    patience_s = recording.setting["patience_s"]
    begin = spent()
    try:
        told = answered(recording, step, patience_s)
    except subprocess.TimeoutExpired:
        told = None, None, f"no answer within {patience_s:g} s"
    except ValueError as fault:
        told = None, None, f"no answer: {fault}"
    except OSError:
        raise  # of sof or of the folder of results: the job is lost, the next call takes the step again
    except Exception as fault:
        told = None, None, f"not foreseen: {type(fault).__name__}: {fault}"
    cost = {name: now - then for name, now, then in zip(("wall_s", "cpu_s"), spent(), begin)}
    write_json(recording.file(step + ".json"), {"step": step, "exit": told[0], "reason": told[2], "answer": told[1], "cost": cost})


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


def alone(folder, entry, setting):
    """run() while nobody else takes these steps: another process may outlive the run that it belonged to."""
    where = plan.results(folder, entry["key"])
    os.makedirs(where, exist_ok=True)
    lock = os.open(where, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX)
    try:
        return run(folder, entry, setting)
    finally:
        os.close(lock)


def main(folder, group, done):
    kept, recordings = plan.load(folder)
    setting = plan.setting_of(folder, kept)
    mine = set(stored.read(group, [stored.KEY], "sof-fleet run writes it again"))
    taken = sum(alone(folder, one, setting) for one in plan.with_first(recordings) if one["key"] in mine)
    write_json(done, {"recordings": len(mine), "steps": taken})


if __name__ == "__main__":
    main(*sys.argv[1:])

"""The command `sof`: where it lies, what it answers, and the catalogue of effects as it prints it."""

import concurrent.futures
import csv
import glob
import json
import os
import signal
import subprocess
import tempfile

from .files import digest, read_json
from .progress import followed

ANSWERED = (0, 1)  # exit codes with an answer: done, an honest negative outcome
STOPPED = (signal.SIGTERM, signal.SIGINT)  # not the program's fault
RECORDING, ANSWER = "recording.csv", "answer.json"


class Failure(Exception):
    """A program did not do what it was asked; the text says which and why."""


def program(build, name, other=None):
    """Path of a program of a build, or of the one that is given in its place; SystemExit where it is missing."""
    path = os.path.abspath(other or os.path.join(build, "devel", "lib", "battery_sof", name))
    if not os.access(path, os.X_OK):
        raise SystemExit(f"{path} is missing: build it first (scripts/with_ros cmake --build {build} --target {name})")
    return path


def libraries_beside(path):
    """Environment in which a copy of a program takes the libraries of the folder above its own, as it does where it was built."""
    above = os.path.dirname(os.path.dirname(os.path.abspath(path)))
    return dict(os.environ, LD_LIBRARY_PATH=os.pathsep.join(filter(None, (above, os.environ.get("LD_LIBRARY_PATH")))))


def product_digest(sof):
    """SHA-256 over `sof` and the product's libraries above its folder: answers of two products do not mix."""
    folder = os.path.dirname(os.path.dirname(os.path.abspath(sof)))
    libraries = sorted(one for one in glob.glob(os.path.join(folder, "libbattery_sof*.so")) if "reference" not in os.path.basename(one))
    return digest(sof, *libraries)


def completed(command, **how):
    """A program that has ended, and what it said as text. how: as of subprocess.run()."""
    return subprocess.run(command, capture_output=True, text=True, env=libraries_beside(command[0]), **how)


def call(command, cwd=None, patience_s=None):
    """What a program printed. Failure for another exit code than 0 and 1, or when it takes longer than patience_s."""
    name = os.path.basename(command[0]) + " " + " ".join(command[1:2])
    try:
        told = completed(command, cwd=cwd, timeout=patience_s)
    except subprocess.TimeoutExpired:
        raise Failure(f"{name}: no answer within {patience_s:g} s") from None
    if -told.returncode in STOPPED:
        raise SystemExit(f"{name}: stopped from outside; call again to go on")
    if told.returncode not in ANSWERED:
        raise Failure(f"{name}: exit code {told.returncode}: {told.stderr.strip()[:300]}")
    return told.stdout


def run(command):
    """What a program printed; Failure with its words for any other exit code than 0."""
    told = completed(command)
    if told.returncode:
        # As sealed labels have it.
        raise Failure(f"{os.path.basename(command[0])}: {told.stderr.strip()[:300]}")
    return told.stdout


def number(text):
    """Of a cell: NaN where it is empty, the text where it is none."""
    try:
        return float(text or "nan")
    except ValueError:
        return text


def rows_of(command):
    """Rows of a program that prints CSV, by column."""
    return [{key: number(text) for key, text in row.items()}
            for row in csv.DictReader(run(command).splitlines())]


def side_by_side(work, jobs, what):
    """What work(job) gives of each, in their order, with progress."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(followed(pool.map(work, jobs), what, len(jobs)))


def simulate(sof, jobs):
    """Simulates recordings. jobs: scenario, path to write and seed of each."""
    side_by_side(lambda job: run([sof, "simulate", *job[:2], "--seed", str(job[2])]), jobs,
                 "simulated")


def diagnose(sof, recording, *options, patience_s=None):
    """The answer to a recording, alone in a folder of its own under a name that tells nothing. Failure where there is none."""
    with tempfile.TemporaryDirectory(prefix="sof_") as folder:
        os.symlink(os.path.abspath(recording), os.path.join(folder, RECORDING))
        call([os.path.abspath(sof), "diagnose", RECORDING, "--json", ANSWER, "--threads", "1", *options], folder, patience_s)
        path = os.path.join(folder, ANSWER)
        if not os.path.exists(path):
            raise Failure("sof diagnose: no answer was written")
        return read_json(path)


class Catalogue:
    """Ids of effects and faults by tier (S structure, P physics, I instruments) and by mechanism.

    reported: what `sof effects --json` prints. Faults of the sampling that are no equations belong to tier I.
    """

    def __init__(self, told):
        self.codes = {one["id"]: one["code"] for one in told["effects"]}
        # [s], of the effects that remember: the first time constant at its usual value.
        self.times = {one["id"]: parameter["magnitude"] for one in told["effects"] for parameter in reversed(one.get("parameters", ())) if parameter["unit"] == "s" and parameter["logarithmic"]}
        self.mechanisms = [one["id"] for one in told["mechanisms"]]
        self.mechanism_of = {member: one["id"] for one in told["mechanisms"] for member in one["members"]}
        self.sensors = next(one["id"] for one in told["mechanisms"] if set(one["members"]) - set(self.codes))  # faults of sampling
        self.structure, self.physics, self.instrument = (frozenset(one for one in self.mechanism_of if self.tier(one) == tier) for tier in "SPI")

    def tier(self, name):
        return self.codes.get(name, "I")[0]

    def mechanism(self, name):
        """A mechanism's id, or None for a name that is in no mechanism."""
        return self.mechanism_of.get(name)


def catalogue(sof):
    return Catalogue(json.loads(call([sof, "effects", "--json", "-"])))

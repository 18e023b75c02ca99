"""Stress of the node (docs/reliability.md): stress soak|kill|disk|overload BUILD, soak also --hours H; its answers' times: bench_queries BUILD [SECONDS]"""

import argparse
import os
import subprocess
import sys
import tempfile

from ..sof import program, run
from . import disk, kill, overload, queries, soak

KINDS = {"soak": soak, "kill": kill, "disk": disk, "overload": overload, "queries": queries}


class Programs:
    """What is built, and what it is asked to make."""

    def __init__(self, build):
        self.build = build
        self.node, self.sof = map(self.path, ("battery_sof_node", "sof"))

    def path(self, name):
        return program(self.build, name)

    def drive(self, recording, duration):
        """A simulated drive at 100 Hz as a bag or CSV."""
        with tempfile.TemporaryDirectory() as folder:
            drive = os.path.join(folder, "drive.csv")
            self.call("simulate_city_drive", drive, "--seed", "1", "--duration", str(duration))
            self.call("sof", "convert", drive, recording)

    def identify(self, recording, model):
        self.call("sof", "identify", recording, "--out", model)

    def reads(self, model):
        """Whether a model file is whole."""
        asked = [self.sof, "crank", model, "--i-load", "-20", "--t-stop", "10", "--i-cranking", "-200", "--t-cranking", "1"]
        return subprocess.run(asked, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode in (0, 1)

    def call(self, name, *arguments):
        run([self.path(name), *arguments])


def parsed(arguments):
    parser = argparse.ArgumentParser(description="Stress of the node; prints a table.")
    kinds = parser.add_subparsers(dest="kind", required=True)
    for name in KINDS:
        kinds.add_parser(name).add_argument("build", nargs="?", default="build")
    kinds.choices["soak"].add_argument("--hours", type=float, default=24.0, help="of driving")
    kinds.choices["queries"].add_argument("seconds", nargs="?", type=float, default=20.0, help="of load on each model")
    return parser.parse_args(arguments)


def main():
    options = vars(parsed(sys.argv[1:]))
    kind, programs = KINDS[options.pop("kind")], Programs(options.pop("build"))
    with tempfile.TemporaryDirectory(prefix="battery sof ") as folder:
        print("\n".join(kind.report(kind.measured(programs, folder, **options))))

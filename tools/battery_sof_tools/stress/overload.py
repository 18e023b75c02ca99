"""More than a car asks: many clients, a topic fifty times as fast, other work beside."""

import os

from ..tables import table
from .load import Load, under_load, waited
from .ros import Processes, node_of_this_process

LEARNT = 400.0  # [s] of the drive before the load begins
CLIENTS = 20
QUESTIONS = 200.0  # a second, of all clients
RATE = 5000.0  # [Hz] of the topic
SECONDS = 60.0


def measured(programs, folder):
    recording = os.path.join(folder, "drive.csv")
    programs.drive(recording, LEARNT + SECONDS + 60.0)
    with Processes(folder) as processes:
        processes.start(programs.node)
        load = Load(recording, 0.0, LEARNT, RATE, CLIENTS, 1, QUESTIONS, SECONDS)
        return under_load(node_of_this_process("overload"), load, ("identify", "diagnose"))


def report(seen):
    rows = [("questions answered", len(seen.waits)),
            *((f"of code {code}", count) for code, count in sorted(seen.codes.items())),
            ("answers of code 0 outside 6 to 16 V", seen.outside),
            *((f"{kind} beside", count) for kind, count, _ in seen.runs),
            ("a client in Python waits, median; 99 % [ms]", "{:.1f}; {:.1f}".format(*waited(seen))),
            *((key, f"{seen.values[key]:.2f}") for key in ("query work p99 [ms]", "query work longest [ms]", "sample delay p99 [ms]")),
            ("sample delay longest [ms]", f"{seen.longest:.2f}")]
    return table(("what", "figure"), rows)

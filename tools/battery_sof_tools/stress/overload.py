"""More than a car asks: many clients, a topic fifty times as fast, other work beside."""

import gc
import multiprocessing
import os
import time

from ..tables import table
from .load import Load, under_load, waited
from .ros import Processes, node_of_this_process

LEARNT = 400.0  # [s] of the drive before the load begins
CLIENTS = 20
QUESTIONS = 200.0  # a second, of all clients
RATE = 5000.0  # [Hz] of the topic
SECONDS = 60.0


def wake(end, told):
    """Does nothing but wake every millisecond; puts how late at most [ms].

    That is what the machine makes of any program of usual priority.
    """
    gc.disable()
    latest, begun, turn = 0.0, time.monotonic(), 0
    while not end.is_set():
        turn += 1
        time.sleep(max(0.0, begun + 1e-3 * turn - time.monotonic()))
        late = time.monotonic() - (begun + 1e-3 * turn)
        latest = max(latest, late)
        turn += max(0, int(1e3 * late))
    told.put(1e3 * latest)


def measured(programs, folder):
    """(what was seen, longest delay of a program that only wakes [ms])."""
    recording = os.path.join(folder, "drive.csv")
    programs.drive(recording, LEARNT + SECONDS + 60.0)
    spawn = multiprocessing.get_context("spawn")
    end, woken = spawn.Event(), spawn.Queue()
    with Processes(folder) as processes:
        processes.start(programs.node)
        spawn.Process(target=wake, args=(end, woken), daemon=True).start()
        load = Load(recording, 0.0, LEARNT, RATE, CLIENTS, 1, QUESTIONS, SECONDS)
        seen = under_load(node_of_this_process("overload"), load, ("identify", "diagnose"))
        end.set()
    return seen, woken.get(timeout=120.0)


def report(result):
    seen, late = result
    rows = [("questions answered", len(seen.waits)),
            *((f"of code {code}", count) for code, count in sorted(seen.codes.items())),
            ("answers of code 0 outside 6 to 16 V", seen.outside),
            *((f"{kind} beside", count) for kind, count, _ in seen.runs),
            ("a client in Python waits, median; 99 % [ms]", "{:.1f}; {:.1f}".format(*waited(seen))),
            *((key, f"{seen.values[key]:.2f}") for key in ("query work p99 [ms]", "query work longest [ms]", "sample delay p99 [ms]")),
            ("sample delay longest [ms]", f"{seen.longest:.2f}"),
            ("a program that only wakes every millisecond, latest [ms]", f"{late:.2f}")]
    return table(("what", "figure"), rows)

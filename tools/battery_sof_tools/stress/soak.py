"""Hours of driving, many times as fast, over and over: what the node holds of memory, files and threads.

The bag is played in a loop: at its end the clock jumps back, as it does where a logger is restarted.
"""

import os
import time

import numpy as np

from ..tables import table
from .ros import NODE, Newest, Processes, node_of_this_process, use_of, wait_until

SPEED = 50.0  # times as fast as it was driven
RATE = 100.0  # [Hz] of the drive
HEAD = ("hours of driving", "samples taken", "RSS [MB]", "open files", "threads")


def driven_hours(status):
    return status.accepted / (3600.0 * RATE)


def slope(rows):
    """[MB/h] of memory after the first hour, least squares; NaN with fewer than three rows."""
    late = [(row[0], row[2]) for row in rows if row[0] >= 1.0]
    return float(np.polyfit(*zip(*late), 1)[0]) if len(late) >= 3 else float("nan")


def measured(programs, folder, hours):
    """Rows of (hours, samples, MB, files, threads)."""
    from battery_sof.msg import SofStatus
    bag = os.path.join(folder, "drive.bag")
    programs.drive(bag, 3600.0)
    rows = []
    with Processes(folder) as processes:
        node_of_this_process("soak")
        node = processes.start(programs.node, f"_state_file:={os.path.join(folder, 'state.yaml')}")
        status = Newest(NODE + "/status", SofStatus)
        wait_until(lambda: status.message is not None, 30.0, "a status of the node")
        processes.start("rosbag", "play", "--loop", "--quiet", "--queue", "100000", "--rate", str(SPEED), bag)
        wait_until(lambda: status.message.accepted > 0, 60.0, "a sample")
        while driven_hours(status.message) < hours:
            if node.poll() is not None:
                raise SystemExit(f"the node ended with {node.returncode} after {driven_hours(status.message):.1f} h of driving")
            rows.append((driven_hours(status.message), status.message.accepted, *use_of(node)))
            time.sleep(5.0)
        rows.append((driven_hours(status.message), status.message.accepted, *use_of(node)))
    return rows


def report(rows):
    step = max(1, len(rows) // 12)
    shown = rows[::step] + ([rows[-1]] if (len(rows) - 1) % step else [])
    lines = table(HEAD, [(f"{hours:.1f}", taken, f"{rss:.1f}", files, threads) for hours, taken, rss, files, threads in shown])
    files, threads = ([row[k] for row in rows if row[0] >= 1.0] or [0] for k in (3, 4))
    return lines + ["", f"Memory grows by {slope(rows):.2f} MB an hour of driving after the first; open files {min(files)} to {max(files)}, "
                    f"threads {min(threads)} to {max(threads)}."]

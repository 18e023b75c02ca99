"""The node killed (-9) at random moments of a drive, its writing of the state included, and started again."""

import itertools
import math
import os
import random
import threading
import time

from ..progress import followed
from ..recordings import read_plain
from ..tables import table
from .ros import NODE, Newest, Processes, Samples, node_of_this_process, perform, wait_until

COUNT = 100  # kills
MAX_SAMPLES = 200  # until the saved model must have answered


class PlayedDrive:
    """Samples of a recording, one after the other, over and over, on the node's topic; stamps go on."""

    def __init__(self, path, rospy):
        rows = read_plain(path).T.tolist()
        self.samples = Samples(rospy)
        self.rows = ((1000.0 + lap * (rows[-1][0] + 0.01) + instant, current, voltage) for lap in itertools.count() for instant, current, voltage in rows)

    def publish(self):
        self.samples.send(*next(self.rows))


def samples_until_answered(drive):
    """How many samples the node takes until its saved model answers a crank; None when it does not."""
    import rospy
    from battery_sof.msg import SofStatus
    from battery_sof.srv import PredictCranking, PredictCrankingResponse
    rospy.wait_for_service(NODE + "/predict_cranking", timeout=30.0)
    crank = rospy.ServiceProxy(NODE + "/predict_cranking", PredictCranking)
    status = Newest(NODE + "/status", SofStatus)  # the one that is latched may be of before
    drive.samples.until_connected()
    for taken in range(1, MAX_SAMPLES + 1):
        drive.publish()
        time.sleep(0.02)
        answer = crank(i_load=-20.0, t_stop=10.0, i_cranking=-200.0, t_cranking=0.5, u_required=math.nan)
        if answer.code != PredictCrankingResponse.NO_MODEL:
            wait_until(lambda: status.message and status.message.answer_basis, 30.0, "its status")
            return taken if status.message.answer_basis == "previous_trip" else None
    return None


def one_life(processes, programs, state, drive, chance):
    """(samples until the saved model answered, drafts left beside the state file)."""
    node = processes.start(programs.node, f"_state_file:={state}", "_window_s:=60", "_min_window_quality:=0")
    taken = samples_until_answered(drive)
    for _ in range(8000):
        drive.publish()
        time.sleep(0.0001)
    # At an identification's end the state is written; the node dies before or after.
    threading.Thread(target=perform, args=("identify",), daemon=True).start()
    time.sleep(chance.uniform(0.0, 0.4))
    node.kill()
    node.wait()
    home = os.path.dirname(state)
    return taken, [name for name in os.listdir(home) if name != os.path.basename(state)]


def measured(programs, folder):
    """Rows of (samples until the saved model answered, drafts, whether the state file reads back, whether it was written again)."""
    recording, chance = os.path.join(folder, "drive.csv"), random.Random(1)
    programs.drive(recording, 900.0)
    home = os.path.join(folder, "state")
    os.mkdir(home)
    state = os.path.join(home, "state.yaml")
    programs.identify(recording, state)
    rows = []
    with Processes(folder) as processes:
        drive = PlayedDrive(recording, node_of_this_process("kills"))
        for _ in followed(range(COUNT), "kill"):
            before = os.stat(state).st_mtime_ns
            taken, drafts = one_life(processes, programs, state, drive, chance)
            rows.append((taken, drafts, programs.reads(state), os.stat(state).st_mtime_ns != before))
    return rows


def report(rows):
    taken = [row[0] for row in rows if row[0] is not None]
    return table(("kills", "state written in this life", "state file whole", "saved model answered", "after samples, most", "drafts left"),
                 [(len(rows), sum(row[3] for row in rows), sum(row[2] for row in rows), len(taken), max(taken, default=None),
                   sum(bool(row[1]) for row in rows))])

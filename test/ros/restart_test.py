#!/usr/bin/python3
"""The node is killed and started again under a bag that goes on: it answers from its saved model."""

import math
import os
import subprocess
import sys

import rospy
import rostest
from battery_sof.msg import SofStatus
from battery_sof.srv import PredictCranking

from processes import Folder, NodeTest, program, wait_until, whole_arguments

RATE = 5  # the first second of samples takes 0.2 s
DURATION = 900  # [s]: the bag outlasts the test
PARAMETERS = {"window_s": 60.0, "buffer_s": 90.0, "min_window_quality": 0.0}


class Restart(NodeTest):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.remove)

    def asked(self, refusals):
        """A crank's answer, or none; what was said in place of one is added to the refusals."""
        ask = rospy.ServiceProxy("/killed_node/predict_cranking", PredictCranking)  # at once: rospy waits in steps of 0.3 s
        try:
            answer = ask(i_load=-20.0, t_stop=10.0, i_cranking=-200.0, t_cranking=0.5, u_required=math.nan)
        except rospy.ServiceException:  # the killed node's service
            return None
        if answer.code in (0, 3):
            return answer
        refusals.append(answer.message)
        return None

    def test_node_killed_under_a_running_bag_answers_from_its_saved_model(self):
        csv, bag = self.folder.file("drive.csv"), self.folder.file("drive.bag")
        subprocess.check_call([program("simulate_city_drive"), csv, "--seed", "1", "--duration", str(DURATION)])
        subprocess.check_call([program("sof"), "convert", csv, bag])
        parameters = dict(PARAMETERS, state_file=self.folder.file("model.yaml"))
        node = self.start("killed_node", **parameters)
        status = self.latest("/killed_node/status", SofStatus)
        status.wait(lambda s: s.state == SofStatus.NO_DATA, 20, "a status without data")
        player = self.play(bag, RATE)
        status.wait(lambda s: s.answer_basis == "this_trip", 60, "ready")
        before = wait_until(lambda: self.asked([]), 20, "an answer before the kill")
        wait_until(lambda: os.path.exists(parameters["state_file"]), 20, "the model on the disk")
        node.kill()
        status.close()

        again = self.start("killed_node", **parameters)
        refusals = []
        after = wait_until(lambda: self.asked(refusals), 20, "an answer after the restart")
        self.assertTrue(player.is_alive(), "the bag goes on")
        for said in refusals:
            self.assertIn("the saved model is waiting for the first sample", said)
        self.assertAlmostEqual(after.u_min, before.u_min, delta=0.5)
        ready = self.latest("/killed_node/status", SofStatus).wait(
            lambda s: s.state == SofStatus.READY and "the saved model is in use" in s.reason, 20, "the saved model in use")
        self.assertLess(ready.accepted, 100 * 60, "before a first window is full")
        self.assertTrue(again.is_alive(), again.text())


if __name__ == "__main__":
    rospy.init_node("restart_test")
    rostest.rosrun("battery_sof", "restart", Restart, whole_arguments(sys.argv))

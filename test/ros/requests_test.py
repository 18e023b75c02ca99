#!/usr/bin/python3
"""Requests that were never filled in ask for nothing, and none, however large, keeps others waiting or the node from ending."""

import math
import shutil
import subprocess
import sys
import threading
import time

import rospy
import rostest
from battery_sof.msg import DiagnoseAction, DiagnoseResult, IdentifyAction, SofStatus
from battery_sof.srv import (PredictChargeAcceptance, PredictCranking, PredictMap, PredictStopTime, SetStandingQuery,
                             SimulateProfile)
from sensor_msgs.msg import BatteryState

from processes import Folder, Goal, NodeTest, program, service, wait_until, whole_arguments

INVALID = 1


class Requests(NodeTest):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        csv, cls.model = cls.folder.file("drive.csv"), cls.folder.file("model.yaml")
        subprocess.check_call([program("simulate_city_drive"), csv, "--seed", "1", "--duration", "300"])
        subprocess.check_call([program("sof"), "identify", csv, "--out", cls.model], stdout=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.folder.remove()

    def started(self, name):
        """A node that answers from its saved model."""
        own = self.folder.file(name + ".yaml")  # the node writes it when it ends
        shutil.copyfile(self.model, own)
        node = self.start(name, state_file=own)
        status = self.latest("/" + name + "/status", SofStatus)
        publisher = rospy.Publisher("/battery_state", BatteryState, queue_size=100)
        self.addCleanup(publisher.unregister)
        stamps = iter(range(100000, 200000))

        def is_ready():
            message = BatteryState(current=-5.0, voltage=12.4, temperature=math.nan)
            message.header.stamp = rospy.Time.from_sec(0.01 * next(stamps))
            publisher.publish(message)
            return status.newest() is not None and status.newest().answer_basis in ("previous_trip", "this_trip")

        wait_until(is_ready, 60, "ready")
        return node

    def test_what_was_never_filled_in_asks_for_nothing(self):
        node = self.started("zero")
        crank, stop = service("zero", "predict_cranking", PredictCranking), service("zero", "predict_stop_time", PredictStopTime)
        charge, maps = service("zero", "predict_charge_acceptance", PredictChargeAcceptance), service("zero", "predict_map", PredictMap)
        profile, standing = service("zero", "simulate_profile", SimulateProfile), service("zero", "set_standing_query", SetStandingQuery)
        for ask, says in ((crank, "i_cranking"), (stop, "no limit is given"), (charge, "u_boost"), (maps, "no question is given"), (profile, "empty")):
            answer = ask(ask.request_class())
            self.assertEqual((answer.valid, answer.code), (False, INVALID), answer)
            self.assertIn(says, answer.message)
        answer = crank(i_cranking=-200.0)  # all else as it is when nobody sets it
        self.assertEqual((answer.valid, answer.capable), (True, False), answer)
        self.assertIn("no u_required was given", answer.message)
        self.assertEqual(answer.u_min, crank(i_cranking=-200.0, t_cranking=1.0, u_required=7.2).u_min)
        kept = standing()
        self.assertTrue(kept.success, kept.message)
        self.assertEqual((kept.i_load, kept.t_stop, kept.i_cranking, kept.t_cranking, kept.u_required, kept.t_sof2, kept.i_limit),
                         (0.0, 0.0, -200.0, 1.0, 7.2, 10.0, 5000.0))
        # Nothing is asked of them but to begin, and the first samples are no drive.
        self.assertFalse(Goal("zero", "identify", IdentifyAction).wait().accepted)
        self.assertNotEqual(Goal("zero", "diagnose", DiagnoseAction).wait().code, DiagnoseResult.BUSY)
        self.assertEqual(node.stop(), 0)

    def test_times_too_close_are_refused_and_a_map_is_left_when_the_node_ends(self):
        node = self.started("large")
        profile = service("large", "simulate_profile", SimulateProfile)
        refused = profile(time=[5e-324, 1e-323], current=[-20.0, 20.0])
        self.assertEqual(refused.code, INVALID)
        self.assertIn("time[0] is 4.94066e-324 s after the one before, expected at least", refused.message)
        maps = service("large", "predict_map", PredictMap)
        wide = dict(u_boost=[13.0 + 0.005 * k for k in range(200)], t_sof2=[1.0 + 10.0 * k for k in range(200)])

        def ask():
            try:
                maps(**wide)
            except rospy.ServiceException:
                pass  # it ended

        asking = threading.Thread(target=ask)
        asking.start()
        time.sleep(0.3)
        begun = time.monotonic()
        self.assertFalse(Goal("large", "identify", IdentifyAction).wait().accepted)
        self.assertTrue(asking.is_alive(), "no longer computing")
        self.assertLess(time.monotonic() - begun, 5.0)
        begun = time.monotonic()
        self.assertEqual(node.stop(), 0)
        self.assertLess(time.monotonic() - begun, 2.0)  # a second, and what a busy machine adds
        asking.join()


if __name__ == "__main__":
    rospy.init_node("requests_test")
    rostest.rosrun("battery_sof", "requests", Requests, whole_arguments(sys.argv))

#!/usr/bin/python3
"""A node in whose core something throws, or loses its numbers, goes on and says so (faulty_core.cpp makes it happen); so does one
whose clock jumps."""

import math
import os
import shutil
import subprocess
import sys
import tempfile

import rospy
import rostest
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
from battery_sof.msg import DiagnoseAction, IdentifyAction, IdentifyResult, SofStatus
from battery_sof.srv import PredictCranking, PredictCrankingResponse
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import BatteryState

from processes import Folder, Goal, NodeTest, program, service, wait_until, whole_arguments

IN_PUSH, IN_QUERY, IN_FIT, LOST = -66.6, -77.7, -44.4, -55.5  # [A], as in faulty_core.cpp
LIBRARY = os.path.join(os.path.dirname(os.path.dirname(program("battery_sof_node"))), "libfaulty_core.so")


class Faults(NodeTest):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.preloaded = tempfile.mkdtemp()  # LD_PRELOAD takes a space for the end of a name, and the build's folder may have one
        cls.library = os.path.join(cls.preloaded, os.path.basename(LIBRARY))
        os.symlink(LIBRARY, cls.library)
        csv = cls.folder.file("drive.csv")
        subprocess.check_call([program("simulate_city_drive"), csv, "--seed", "1", "--duration", "300"])
        subprocess.check_call([program("sof"), "identify", csv, "--out", cls.folder.file("good.yaml")], stdout=subprocess.DEVNULL)

    @classmethod
    def tearDownClass(cls):
        cls.folder.remove()
        shutil.rmtree(cls.preloaded)

    def setUp(self):
        self.said, self.name = "", ""
        self.listener = rospy.Subscriber("/diagnostics", DiagnosticArray, self.note, queue_size=100)
        self.addCleanup(self.listener.unregister)
        self.publisher = rospy.Publisher("/battery_state", BatteryState, queue_size=1000)
        self.stamp = 1000.0

    def note(self, array):
        for status in array.status:
            if status.name.startswith(self.name + ":") and status.name.endswith("identification"):
                self.said = status.message

    def publish(self, current=-5.0):
        """A tenth of a second of samples; a current of its own is that of the last."""
        for n in range(10):
            self.stamp += 0.01
            message = BatteryState(current=current if n == 9 else -5.0, voltage=12.4, temperature=float("nan"))
            message.header.stamp = rospy.Time.from_sec(self.stamp)
            self.publisher.publish(message)
        return True

    def started(self, name):
        """A node that answers from its saved model."""
        self.name = name
        self.file = self.folder.file(name + ".yaml")
        with open(self.folder.file("good.yaml")) as good, open(self.file, "w") as file:
            file.write(good.read())
        self.node = self.start(name, environment={"LD_PRELOAD": self.library}, state_file=self.file)
        self.status = self.latest("/" + name + "/status", SofStatus)
        wait_until(lambda: self.publish() and self.is_ready(), 60, "ready")

    def is_ready(self):
        return self.status.newest() is not None and self.status.newest().answer_basis in ("previous_trip", "this_trip")

    def ask(self, current):
        crank = service(self.name, "predict_cranking", PredictCranking)
        return crank(i_load=-20.0, t_stop=10.0, i_cranking=current, t_cranking=0.5, u_required=math.nan)

    def goes_on(self):
        self.assertTrue(self.node.is_alive(), self.node.text())
        accepted = self.status.newest().accepted
        wait_until(lambda: self.publish() and self.status.newest().accepted > accepted + 100, 30, "samples taken again")

    def test_a_query_that_throws_is_answered_without_numbers_and_the_next_one_with_them(self):
        self.started("query_node")
        answer = self.ask(IN_QUERY)
        self.assertEqual(answer.code, PredictCrankingResponse.NO_MODEL)
        self.assertEqual(answer.message, "the crank query failed; /diagnostics says why")
        self.assertTrue(math.isnan(answer.u_min))
        wait_until(lambda: self.said == "the crank query failed: thrown in a query", 20, "the fault in the diagnostics")
        again = self.ask(-200.0)
        self.assertFalse(math.isnan(again.u_min), again.message)
        self.goes_on()

    def test_a_fit_that_throws_is_refused_and_the_model_stays(self):
        self.started("fit_node")
        self.publish(IN_FIT)
        taken = self.status.newest().accepted
        wait_until(lambda: self.status.newest().accepted > taken or self.publish(IN_FIT) and False, 20, "the sample taken")
        goal = Goal(self.name, "identify", IdentifyAction)
        answer = goal.wait()
        self.assertEqual((goal.state(), answer.code), (GoalStatus.ABORTED, IdentifyResult.REFUSED))
        self.assertEqual(answer.message, "the identification failed: thrown in a fit")
        wait_until(lambda: "the identification failed: thrown in a fit" in self.said, 20, "the fault in the diagnostics")
        self.assertFalse(math.isnan(self.ask(-200.0).u_min))
        self.goes_on()

    def test_a_sample_that_throws_begins_the_session_anew_and_sets_the_saved_model_aside(self):
        self.started("push_node")
        self.publish(IN_PUSH)
        wait_until(lambda: self.said == "taking a sample failed: thrown in a push", 20, "the fault in the diagnostics")
        wait_until(lambda: self.publish() and self.status.newest().answer_basis == "population", 20, "a session without a model")
        self.assertTrue(os.path.exists(self.file + ".refused"))
        self.assertFalse(os.path.exists(self.file))
        self.assertFalse(self.ask(-200.0).valid)
        self.goes_on()

    def test_a_model_that_is_not_finite_any_more_is_dropped_and_that_is_said(self):
        self.started("lost_node")
        self.publish(LOST)
        wait_until(lambda: self.publish() and "the model was dropped because its state was not finite" in self.status.newest().reason, 20,
                   "the loss in the status")
        self.assertFalse(self.ask(-200.0).valid)
        self.goes_on()

    def test_cancel_requests_with_stamps_at_the_end_of_time_end_no_node(self):
        node = self.start("late_node")
        for action in ("identify", "diagnose"):
            goal = Goal("late_node", action, {"identify": IdentifyAction, "diagnose": DiagnoseAction}[action])
            self.assertEqual(goal.wait().code, IdentifyResult.NO_DATA)
            cancel = rospy.Publisher("/late_node/{}/cancel".format(action), GoalID, queue_size=1)
            self.addCleanup(cancel.unregister)
            wait_until(lambda: cancel.get_num_connections() > 0, 20, "a connection")
            status = self.latest("/late_node/{}/status".format(action), GoalStatusArray)
            cancel.publish(GoalID(rospy.Time(2**32 - 1, 999999999), "nobody's"))
            status.wait(lambda s: any(one.goal_id.id == "nobody's" for one in s.status_list), 20, "the request was taken")
            known = len(status.messages)
            wait_until(lambda: len(status.messages) > known + 2, 20, "status goes on")
        self.assertTrue(node.is_alive(), node.text())
        self.assertEqual(node.stop(), 0)

    def test_a_goal_that_is_cancelled_before_it_is_begun_says_so_with_a_code_of_its_own(self):
        self.start("recall_node")
        for action, kind in (("identify", IdentifyAction), ("diagnose", DiagnoseAction)):
            server = "/recall_node/" + action
            results = self.latest(server + "/result", type(kind().action_result))
            cancel = rospy.Publisher(server + "/cancel", GoalID, queue_size=10)
            goals = rospy.Publisher(server + "/goal", type(kind().action_goal), queue_size=10)
            for publisher in (cancel, goals):
                self.addCleanup(publisher.unregister)
                wait_until(lambda: publisher.get_num_connections() > 0, 20, "a connection")
            def recalled():
                cancel.publish(GoalID(rospy.Time(100), ""))  # all goals that were sent until then
                goal = type(kind().action_goal)()
                goal.goal_id = GoalID(rospy.Time(50), "sent before {}".format(len(results.messages)))
                goals.publish(goal)
                newest = results.newest()  # the cancel request may come after the first goal
                return newest and newest.status.status == GoalStatus.RECALLED
            wait_until(recalled, 20, "a recalled goal")
            result = results.newest()
            self.assertEqual(result.result.code, result.result.RECALLED)
            self.assertEqual(result.result.message, "the goal was cancelled before work on it began")

    def test_a_clock_that_jumps_by_a_century_stops_no_status(self):
        rospy.set_param("/century/use_sim_time", True)
        self.addCleanup(rospy.delete_param, "/century")
        self.century = self.start("century_node", remappings=["/use_sim_time:=/century/use_sim_time"])
        status = self.latest("/century_node/status", SofStatus)
        clock = rospy.Publisher("/clock", Clock, queue_size=1)
        self.addCleanup(clock.unregister)

        def tick(seconds):
            clock.publish(Clock(rospy.Time(seconds)))
            return status.newest()
        wait_until(lambda: self.publish() and tick(1000) and status.newest().accepted > 0, 20, "samples taken at 1000 s")
        goals = [(IdentifyAction, "identify"), (DiagnoseAction, "diagnose")]
        before = [Goal("century_node", name, kind) for kind, name in goals]
        for goal in before:
            goal.wait()
        wait_until(lambda: "no sample for 3499999000 s" in tick(3500000000).reason, 20, "a status at 3,500,000,000 s")
        for seconds in (3500000000, 5):  # the clock stands still, then jumps back
            tick(seconds)
            for kind, name in goals:
                Goal("century_node", name, kind).wait()
        self.assertTrue(self.century.is_alive(), self.century.text())


if __name__ == "__main__":
    rospy.init_node("faults_test")
    rostest.rosrun("battery_sof", "faults", Faults, whole_arguments(sys.argv))

#!/usr/bin/python3
"""Recorded drives played to the real node with rosbag play --clock."""

import csv
import math
import os
import subprocess
import sys

import rosbag
import rospy
import rostest
import yaml
from actionlib_msgs.msg import GoalStatus
from battery_sof.msg import IdentifiedModel, IdentifyAction, IdentifyResult, SofStatus
from battery_sof.srv import PredictChargeAcceptance, PredictCranking, PredictMap, PredictStopTime, SimulateProfile
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import BatteryState

from processes import Folder, Goal, NodeTest, program, service, start_node, wait_until, whole_arguments

RATE = 30
DURATION = 900  # [s]
YEAR = 365.0 * 86400.0
TRUTH = {"r_discharge": 0.006, "r_charge": 0.0085, "c2": 1100.0, "beta": 22.0, "u_dc": 12.7}  # of simulate_city_drive
TOLERANCE = {"r_discharge": 0.05, "r_charge": 0.1, "c2": 0.2, "beta": 0.2, "u_dc": 0.01}  # relative


def crank_query(proxy, i_load=-20.0, t_stop=10.0, i_cranking=-200.0, t_cranking=0.5, u_required=math.nan):
    return proxy(i_load=i_load, t_stop=t_stop, i_cranking=i_cranking, t_cranking=t_cranking, u_required=u_required)


class Cranks:
    """What the drive's own rows say of its cranks: start, current and lowest voltage."""

    def __init__(self, path):
        with open(path) as rows:
            self.rows = [(float(r["time_s"]), float(r["current_a"]), float(r["voltage_v"])) for r in csv.DictReader(rows)]
        self.cranks = []
        crank = []
        for row in self.rows:
            if row[1] <= -75.0:
                crank.append(row)
            elif crank:
                if min(r[1] for r in crank) <= -150.0:
                    self.cranks.append(self.describe(crank))
                crank = []

    @staticmethod
    def describe(crank):
        lowest = min(crank, key=lambda row: row[2])
        return {"start": crank[0][0], "current": lowest[1], "until_lowest": max(lowest[0] - crank[0][0], 0.01),
                "lowest": lowest[2]}

    def load_before(self, crank):
        before = [i for t, i, _ in self.rows if crank["start"] - 2.0 < t < crank["start"] - 0.02]
        return min(sum(before) / len(before), 0.0)


class AskBeforeCranks:
    """With each status shortly before a crank of the drive, asks for just that crank."""

    def __init__(self, node, drive):
        self.ask = service(node, "predict_cranking", PredictCranking)
        self.drive = drive
        self.answers = {}
        self.subscriber = rospy.Subscriber("/{}/status".format(node), SofStatus, self.on_status)

    def on_status(self, status):
        if status.answer_basis != "this_trip":
            return
        now = status.header.stamp.to_sec()
        for crank in self.drive.cranks:
            ahead = crank["start"] - now
            if 0.5 < ahead < 5.0:
                answer = crank_query(self.ask, self.drive.load_before(crank), ahead, crank["current"],
                                     crank["until_lowest"])
                self.answers[crank["start"]] = (answer, crank)

    def close(self):
        self.subscriber.unregister()


class Playback(NodeTest):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.csv, cls.bag = cls.folder.file("drive.csv"), cls.folder.file("drive.bag")
        cls.state_file = cls.folder.file("model.yaml")
        subprocess.check_call([program("simulate_city_drive"), cls.csv, "--seed", "1", "--duration", str(DURATION)])
        subprocess.check_call([program("sof"), "convert", cls.csv, cls.bag])
        cls.drive = Cranks(cls.csv)
        cls.node = None

    @classmethod
    def tearDownClass(cls):
        if cls.node:
            cls.node.stop()
        cls.folder.remove()

    def assert_model_is_the_drives(self, model):
        self.assertEqual(model.names, list(TRUTH))
        for name, value, std, determined in zip(model.names, model.values, model.std, model.determined):
            self.assertAlmostEqual(value, TRUTH[name], delta=TOLERANCE[name] * TRUTH[name], msg=name)
            self.assertTrue(determined, name)
            self.assertGreater(std, 0.0, name)
        self.assertEqual(model.status, "converged")
        self.assertEqual(yaml.safe_load(model.model_yaml)["schema"], "battery_sof/model/2")

    def assert_refused(self, answer, *words):
        self.assertEqual(answer.code, 1, answer)
        for word in words:
            self.assertIn(word, answer.message)

    def assert_bad_queries_are_refused(self, node):
        ask = service(node, "predict_cranking", PredictCranking)
        self.assert_refused(crank_query(ask, i_load=math.nan), "i_load")
        self.assert_refused(crank_query(ask, i_load=20.0), "i_load")
        self.assert_refused(crank_query(ask, i_cranking=200.0), "i_cranking")
        self.assert_refused(crank_query(ask, i_cranking=math.inf), "i_cranking")
        self.assert_refused(crank_query(ask, t_stop=-1.0), "t_stop")
        self.assert_refused(crank_query(ask, t_stop=YEAR), "t_stop")
        self.assert_refused(crank_query(ask, t_cranking=-1.0), "t_cranking")
        self.assert_refused(crank_query(ask, i_load=math.nan, t_stop=-1.0), "i_load", "t_stop")
        self.assertTrue(math.isnan(crank_query(ask, t_stop=-1.0).u_min))
        profile = service(node, "simulate_profile", SimulateProfile)
        for time, current in (([0.0, 1.0], [0.0]), ([0.0, 2.0, 1.0], [0.0] * 3), ([0.0, 0.0], [0.0] * 2),
                              ([-1.0, 0.0], [0.0] * 2), ([0.0, 1.0], [0.0, math.nan]), ([], [])):
            answer = profile(time, current)
            self.assert_refused(answer)
            self.assertTrue(answer.message)
            self.assertEqual(len(answer.voltage), 0)

    def assert_profile_is_answered(self, node):
        answer = service(node, "simulate_profile", SimulateProfile)([0.0, 10.0, 10.1, 10.6], [-20.0, -20.0, -200.0, -200.0])
        self.assertEqual(answer.code, 0, answer.message)
        self.assertEqual([len(answer.voltage), len(answer.lower), len(answer.upper)], [4, 4, 4])
        self.assertLess(answer.voltage[3], answer.voltage[1] - 0.9)
        for low, middle, high in zip(answer.lower, answer.voltage, answer.upper):
            self.assertTrue(low < middle < high)

    def assert_profiles_of_a_crank_are_answered(self, node):
        """Asked twice in a row, so a few samples apart."""
        ask = service(node, "predict_cranking", PredictCranking)
        held = crank_query(ask)
        profiled = ask(load_time=[0.0, 10.0], load_current=[-20.0, -20.0], cranking_time=[0.0, 0.5],
                       cranking_current=[-200.0, -200.0], u_required=math.nan)
        self.assertEqual(profiled.code, 0, profiled.message)
        self.assertAlmostEqual(profiled.u_min, held.u_min, delta=0.2)
        self.assert_refused(ask(i_cranking=-200.0, t_cranking=1.0, load_time=[0.0, 0.0], load_current=[-1.0, -1.0]),
                            "load time[1]")

    def assert_stop_time_is_answered(self, node):
        ask = service(node, "predict_stop_time", PredictStopTime)
        rarely = ask(i_load=-25.0, i_cranking=-200.0, t_cranking=1.0, u_required=12.6)
        self.assertEqual((rarely.outcome, rarely.t_stop), ("never", 0.0), rarely)
        always = ask(i_load=0.0, i_cranking=-200.0, t_cranking=0.0, u_required=7.2)
        self.assertEqual((always.outcome, always.t_stop, always.code), ("always", math.inf, 0), always)
        self.assert_refused(ask(i_load=1.0, i_cranking=-200.0, u_required=7.2), "i_load")
        refused = ask(i_load=-25.0, i_cranking=-200.0, u_required=math.nan)
        self.assert_refused(refused, "u_required")
        self.assertTrue(math.isnan(refused.t_stop) and refused.outcome == "")

    def assert_charge_is_answered(self, node):
        ask = service(node, "predict_charge_acceptance", PredictChargeAcceptance)
        answer = ask(u_boost=13.2, t_sof2=5.0, i_limit=20.0)
        self.assertIn(answer.code, (0, 3), answer)
        self.assertTrue(answer.lower <= answer.i_boost <= answer.upper <= 20.0, answer)
        self.assertGreater(ask(u_boost=14.2).i_boost, ask(u_boost=13.4).i_boost)
        self.assert_refused(ask(u_boost=-1.0), "u_boost")
        self.assert_refused(ask(u_boost=14.2, t_sof2=-1.0), "t_sof2")

    def assert_maps_are_answered(self, node):
        ask = service(node, "predict_map", PredictMap)
        answer = ask(i_load=[-10.0, -30.0], t_stop=[0.0, 5.0, 10.0], i_cranking=-200.0, u_required=7.2,
                     u_boost=[13.0, 13.4], t_sof2=[1.0])
        self.assertEqual([len(answer.u_min), len(answer.capable), len(answer.u_min_code)], [6, 6, 6], answer)
        self.assertEqual([len(answer.i_boost), len(answer.i_boost_code)], [2, 2], answer)
        self.assertLess(answer.u_min[5], answer.u_min[2])
        self.assert_refused(ask(), "no question is given")
        self.assert_refused(ask(i_load=[-10.0], i_cranking=-200.0), "t_stop has 0 values")

    def assert_standing_answers(self, status):
        self.assertEqual((status.t_sof2, status.i_limit), (10.0, 5000.0))
        self.assertTrue(12.5 < status.u_boost < 13.6, "{} V is not that of past charges".format(status.u_boost))
        self.assertTrue(status.stop_time.outcome and status.stop_time.message and status.charge.message)
        self.assertTrue(status.charge.lower < status.charge.i_boost < status.charge.upper)
        cranks, charges = status.past_cranks, status.past_charges
        self.assertTrue(0.0 <= cranks.coverage <= 1.0)
        self.assertLess(cranks.mean_abs_error, 0.1)
        self.assertGreater(charges.count, 2)
        self.assertLess(charges.mean_abs_error, 5.0)
        self.assertAlmostEqual(charges.expected, charges.measured, delta=8.0)
        self.assertTrue(0.1 <= cranks.interval_factor <= 50.0)

    def assert_identify_on_request_delays_nothing(self, node):
        ask = service(node, "predict_cranking", PredictCranking)
        goals = [Goal(node, "identify", IdentifyAction) for _ in range(3)]  # of clients that do not know of each other
        self.assertIn(crank_query(ask).code, (0, 3))
        for goal in goals:
            result = goal.wait(20.0)
            self.assertEqual((goal.state(), result.accepted, result.code), (GoalStatus.SUCCEEDED, True, IdentifyResult.OK), result.message)
            self.assertEqual(goal.client.get_goal_status_text(), result.message)
            self.assert_model_is_the_drives(result.model)
        feedback = [one for goal in goals for one in goal.feedback]  # what comes after the result is not passed on
        self.assertTrue(feedback and all(math.isnan(one.progress) for one in feedback))
        self.assertLessEqual({one.stage for one in feedback}, {"fitting", "waiting for the running identification"})

    def assert_a_cancelled_identification_is_discarded(self, node):
        for _ in range(30):  # a fit that was quicker has succeeded
            goal = Goal(node, "identify", IdentifyAction)
            wait_until(lambda: goal.feedback or not goal.is_running(), 20, "the goal was taken")
            goal.cancel()
            result = goal.wait(2.0)
            if goal.state() == GoalStatus.PREEMPTED:
                break
        self.assertEqual((goal.state(), result.accepted, result.code), (GoalStatus.PREEMPTED, False, IdentifyResult.REFUSED))
        self.assertEqual(result.message, "cancelled; the running fit continues, but its result is discarded")
        after = Goal(node, "identify", IdentifyAction)  # waits for that fit
        self.assertTrue(after.wait(20.0).accepted)
        self.assertIn("identification refused: the goal was cancelled", self.node.text())

    def test_1_drive_is_learned_and_questions_are_answered_while_it_plays(self):
        cls = type(self)
        cls.node = start_node("sof_node", {"state_file": self.state_file})
        status = self.latest("/sof_node/status", SofStatus)
        models = self.latest("/sof_node/model", IdentifiedModel)
        diagnostics = self.latest("/diagnostics", DiagnosticArray)
        status.wait(lambda s: s.state == SofStatus.NO_DATA and s.reason, 20, "status without data")
        early = crank_query(service("sof_node", "predict_cranking", PredictCranking))
        self.assertEqual(early.code, 2)
        self.assertTrue(math.isnan(early.u_min) and early.message)
        goal = Goal("sof_node", "identify", IdentifyAction)
        self.assertEqual((goal.wait().code, goal.state()), (IdentifyResult.NO_DATA, GoalStatus.REJECTED))
        self.assertEqual(goal.client.get_goal_status_text(), "no samples are buffered yet")

        asker = AskBeforeCranks("sof_node", self.drive)
        self.addCleanup(asker.close)
        player = self.play(self.bag, RATE)
        status.wait(lambda s: s.answer_basis == "population" and "buffered" in s.reason, 20, "answers from the first sample")
        status.wait(lambda s: s.answer_basis == "this_trip", 60, "a window's model")
        self.assert_model_is_the_drives(models.wait(lambda m: True, 10, "a model"))
        self.assert_identify_on_request_delays_nothing("sof_node")
        self.assert_a_cancelled_identification_is_discarded("sof_node")
        self.assert_bad_queries_are_refused("sof_node")
        self.assert_profile_is_answered("sof_node")
        self.assert_profiles_of_a_crank_are_answered("sof_node")
        self.assert_stop_time_is_answered("sof_node")
        self.assert_charge_is_answered("sof_node")
        self.assert_maps_are_answered("sof_node")
        names = {s.name for s in diagnostics.wait(lambda d: len(d.status) == 7, 10, "diagnostics").status}
        self.assertEqual(names, {"sof_node: data rate", "sof_node: rejected samples", "sof_node: battery", "sof_node: identification",
                                 "sof_node: prediction error", "sof_node: response times", "sof_node: diagnosis"})
        self.assertEqual(player.wait(120), 0)

        final = status.wait(lambda s: s.accepted == len(self.drive.rows), 20, "every sample of the bag accepted")
        self.assertEqual(final.rejected, 0)
        self.assertGreater(final.backtest_q_dyn_percent, 90.0)
        self.assertEqual(final.crank.code, 0, final.crank.message)
        self.assertTrue(final.crank.capable and final.crank.lower < final.crank.u_min < final.crank.upper)
        self.assertGreater(final.past_cranks.count, 2)
        self.assertAlmostEqual(final.past_cranks.expected, final.past_cranks.measured, delta=0.1)
        self.assert_standing_answers(final)
        self.assertAlmostEqual(final.expected_time, self.drive.rows[-1][0], delta=0.02)
        self.assertAlmostEqual(final.expected_voltage, self.drive.rows[-1][2], delta=0.05)
        self.assertTrue(math.isnan(final.expected_current))
        asked = list(asker.answers.values())
        self.assertGreaterEqual(len(asked), 2)
        for answer, crank in asked:
            self.assertAlmostEqual(answer.u_min, crank["lowest"], delta=0.2)
        self.assertTrue(self.node.is_alive())

    def test_2_second_playback_jumps_back_and_the_model_stays_with_its_age(self):
        status = self.latest("/sof_node/status", SofStatus)
        before = status.wait(lambda s: s.accepted == len(self.drive.rows), 20, "the first playback's last status")
        self.play(self.bag, RATE, "--duration", 30)
        after = status.wait(lambda s: s.accepted >= before.accepted + 2900, 30, "samples after the jump")
        self.assertLess(after.header.stamp.to_sec(), 40.0)
        self.assertEqual(after.state, SofStatus.READY)
        self.assertGreater(after.model_age, before.model_age + 25.0)
        self.assertEqual(after.rejected, 0)
        self.assertTrue(self.node.is_alive())

    def an_hour_later(self, duration):
        """The drive's first seconds again, as a trip an hour after its end."""
        later = self.folder.file("later.bag")
        with rosbag.Bag(self.bag) as drive, rosbag.Bag(later, "w") as trip:
            for topic, message, stamp in drive.read_messages(end_time=rospy.Time.from_sec(drive.get_start_time() + duration)):
                shift = rospy.Duration.from_sec(DURATION + 3600.0)
                message.header.stamp += shift
                trip.write(topic, message, stamp + shift)
        return later

    def test_3_restarted_node_answers_from_its_state_file(self):
        self.assertEqual(self.node.stop(), 0, self.node.text())
        type(self).node = None
        self.assertEqual([f for f in os.listdir(self.folder.path) if f.startswith("model.yaml")], ["model.yaml"])
        node = self.start("restarted", state_file=self.state_file)
        status = self.latest("/restarted/status", SofStatus)
        self.play(self.an_hour_later(15.0), 10)
        ready = status.wait(lambda s: s.answer_basis == "previous_trip", 20, "ready from the state file")
        self.assertIn("saved model", ready.reason)
        self.assertEqual(crank_query(service("restarted", "predict_cranking", PredictCranking)).code, 0)
        self.assertTrue(node.is_alive())

    def test_4_saved_model_of_another_clock_and_a_damaged_file_are_refused_with_the_reason(self):
        self.start("early", state_file=self.state_file)
        status = self.latest("/early/status", SofStatus)
        self.play(self.bag, RATE, "--duration", 20)
        refused = status.wait(lambda s: s.accepted > 500, 20, "samples")
        self.assertEqual(refused.answer_basis, "population")
        self.assertIn("the saved model was refused", refused.reason)

        damaged = self.folder.file("damaged.yaml")
        with open(self.state_file) as good, open(damaged, "w") as bad:
            bad.write(good.read()[:300])
        node = self.start("damaged", state_file=damaged)
        diagnostics = self.latest("/diagnostics", DiagnosticArray)
        diagnostics.wait(lambda d: any("damaged.yaml" in s.message for s in d.status), 20, "the fault in /diagnostics")
        self.assertTrue(node.is_alive())

    def bad_messages(self):
        """A quiet stretch with every kind of bad message among the good; how many of each is said below."""
        def message(stamp, current=-5.0, voltage=12.5):
            made = BatteryState(voltage=voltage, current=current, temperature=math.nan)
            made.header.stamp = rospy.Time.from_sec(stamp)
            return made
        bag = self.folder.file("bad.bag")
        def overfull(stamp):
            made = message(stamp - 1.0)
            made.header.stamp.nsecs += 10**9
            return made
        with rosbag.Bag(bag, "w") as out:
            for n in range(2000):
                stamp = 100.0 + n * 0.01
                messages = [message(stamp)]
                if n % 100 == 50:
                    messages[0].temperature = 1e9  # its sample is taken all the same
                    messages += [message(stamp + 0.001, current=math.nan), message(stamp + 0.001, voltage=math.inf),
                                 message(stamp + 0.001, voltage=900.0), message(stamp), message(stamp - 1.0),
                                 message(3.0), message(5.0e8), overfull(stamp + 0.001)]
                for each in messages:
                    out.write("/battery_state", each, rospy.Time.from_sec(stamp))
        return bag

    def test_5_bad_messages_are_counted_by_reason_and_the_node_lives(self):
        node = self.start("bad")
        status = self.latest("/bad/status", SofStatus)
        diagnostics = self.latest("/diagnostics", DiagnosticArray)
        self.play(self.bad_messages(), 10)
        status.wait(lambda s: s.accepted == 2000 and s.rejected == 160, 30, "2000 accepted, 160 rejected")

        def counts(array):
            for each in array.status:
                if each.name == "bad: rejected samples":
                    return {v.key: int(v.value) for v in each.values}
            return {}
        expected = {"missing value": 20, "not finite": 20, "out of range": 40, "duplicate stamp": 20,
                    "clock step back": 40, "stamp ahead": 20, "temperature out of range": 20}
        diagnostics.wait(lambda d: counts(d) == expected, 20, "{} in /diagnostics".format(expected))
        self.assertTrue(node.is_alive())
        self.assertEqual(node.stop(), 0)


if __name__ == "__main__":
    rospy.init_node("playback_test")
    rostest.rosrun("battery_sof", "playback", Playback, whole_arguments(sys.argv))

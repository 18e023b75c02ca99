#!/usr/bin/python3
"""A drive is played to battery_sof and to three energy managers; then battery_sof hangs, and is killed."""

import csv
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import roslib.packages
import rospy
import rostest
from battery_sof.msg import SofStatus
from energy_manager.msg import Decision
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool

RATE, DURATION = 12, 900
LIMIT = 7.2  # [V], what energy_manager asks for unless reported otherwise
PARAMETERS = ("_window_s:=120.0", "_buffer_s:=300.0", "_identify_period_s:=120.0")


def program(package, name):
    return roslib.packages.find_node(package, name)[0]


def stops_of(path):
    """Start [s], end [s] and lowest voltage [V] of the crank of every stop of a drive: discharge that ends in a crank."""
    with open(path) as file:
        rows = [(float(r["time_s"]), float(r["current_a"]), float(r["voltage_v"])) for r in csv.DictReader(file)]
    stops, begin, crank = [], None, []
    for t, i, u in rows:
        if i <= -100.0:
            crank.append((t, u))
        elif crank:
            if begin is not None and crank[0][0] - begin > 4.0:
                stops.append((begin, crank[0][0], min(u for _, u in crank)))
            begin, crank = None, []
        elif i > -5.0:
            begin = None
        elif begin is None:
            begin = t
    return stops


class Manager:
    """Every decision of one manager, with whether the engine was off."""

    def __init__(self, name, drive):
        self.decisions, self.drive = [], drive
        rospy.Subscriber(name + "/decision", Decision, self.add)

    def add(self, decision):
        self.decisions.append((decision, self.drive.now, self.drive.off))

    def wait(self, condition, deadline, what):
        end = time.monotonic() + deadline
        while time.monotonic() < end:
            if self.decisions and condition(self.decisions[-1][0]):
                return self.decisions[-1][0]
            time.sleep(0.02)
        raise AssertionError("not within {} s: {}; the last decision is\n{}".format(deadline, what, self.decisions[-1:]))


class PlayedDrive:
    """Reports the managers when the engine of the recorded car was off."""

    def __init__(self, stops):
        self.stops, self.now, self.off = stops, 0.0, False
        self.engine = rospy.Publisher("engine_off", Bool, queue_size=10, latch=True)
        rospy.Subscriber("battery_state", BatteryState, self.on_sample, buff_size=1 << 22)

    def on_sample(self, sample):
        self.now = sample.header.stamp.to_sec()
        off = any(begin < self.now < end for begin, end, _ in self.stops)
        if off != self.off:
            self.engine.publish(off)
        self.off = off


class Decisions(unittest.TestCase):
    def begin(self, *command):
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL)
        self.addCleanup(lambda: (process.send_signal(signal.SIGCONT), process.kill(), process.wait()))
        return process

    def made_drive(self):
        folder = tempfile.TemporaryDirectory(prefix="drive of a car ")
        self.addCleanup(folder.cleanup)
        rows, bag = os.path.join(folder.name, "drive.csv"), os.path.join(folder.name, "drive.bag")
        subprocess.check_call([program("battery_sof", "simulate_city_drive"), rows, "--seed", "3", "--duration", str(DURATION)])
        subprocess.check_call([program("battery_sof", "sof"), "convert", rows, bag])
        return stops_of(rows), bag

    def assert_engine_runs(self, manager, *words):
        found = manager.wait(lambda d: not d.may_stop and any(w in d.reason for w in words), 15, words)
        self.assertEqual(found.longest_stop, 0.0)
        return found

    def assert_stops_were_judged_right(self, stops, since):
        """Every whole stop after the model came was allowed throughout, and its crank held what was promised."""
        judged = 0
        for begin, end, lowest in stops:
            during = [d for d, now, off in self.careful.decisions if off and begin < now < end]
            if begin < since or len(during) < 5:
                continue
            judged += 1
            self.assertTrue(all(d.may_stop and not d.restart for d in during), (begin, during))
            self.assertGreater(during[-1].longest_stop, 3.0)
            self.assertGreater(lowest, LIMIT)
        self.assertGreaterEqual(judged, 3)

    def assert_others_keep_the_engine_running(self, since):
        for manager in (self.demanding, self.unheard_of):
            later = [(d, off) for d, now, off in manager.decisions if now > since]
            self.assertGreater(len(later), 20)
            self.assertFalse([d for d, _ in later if d.may_stop])
            self.assertTrue([d for d, off in later if off and d.restart], "a restart in a stop")
        self.assertTrue([d for d, _, _ in self.demanding.decisions if "might not keep" in d.reason])
        self.assertLess(self.demanding.decisions[-1][0].reserve, 0.2)
        self.assertTrue([d for d, _, _ in self.unheard_of.decisions if "extrapolat" in d.reason or "strongest" in d.reason
                         or "but the window" in d.reason], self.unheard_of.decisions[-1])

    def test_engine_is_off_only_while_an_answer_says_that_it_starts_again(self):
        stops, bag = self.made_drive()
        drive = PlayedDrive(stops)
        self.careful, self.demanding, self.unheard_of = (Manager(n, drive) for n in ("energy_manager", "demanding", "unheard_of"))
        self.assert_engine_runs(self.careful, "no answer")
        node = self.begin(program("battery_sof", "battery_sof_node"), "__name:=battery_sof_node", *PARAMETERS)
        self.assert_engine_runs(self.careful, "no sample", "no data", "the engine runs")
        self.begin(program("rosbag", "play"), "--clock", "--hz", "200", "--quiet", "--wait-for-subscribers", "--rate", str(RATE), bag)

        allowed = self.careful.wait(lambda d: d.may_stop, 60, "a stop allowed")
        since = drive.now
        self.assertGreater(allowed.reserve, 0.2)
        self.assertGreater(allowed.longest_stop, 3.0)
        self.assertGreaterEqual(allowed.planned_charge, 0.0)
        self.careful.wait(lambda d: drive.now > since + 400.0, 90, "some stops")
        self.assert_stops_were_judged_right(stops, since)
        self.assert_others_keep_the_engine_running(since)

        node.send_signal(signal.SIGSTOP)
        self.assert_engine_runs(self.careful, "no answer")
        node.send_signal(signal.SIGCONT)
        self.careful.wait(lambda d: d.may_stop, 30, "allowed again")
        node.kill()
        self.assert_engine_runs(self.careful, "no answer")
        drive.engine.publish(True)
        self.assertTrue(self.careful.wait(lambda d: d.restart, 5, "a restart in a stop").restart)


if __name__ == "__main__":
    rospy.init_node("decisions_test")
    rostest.rosrun("energy_manager", "decisions", Decisions)

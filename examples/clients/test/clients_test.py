#!/usr/bin/python3
"""Both clients ask a node that has no model and one that has; the script reads a bag of CAN frames."""

import csv
import os
import re
import struct
import subprocess
import sys
import tempfile
import time
import unittest

import genpy.dynamic
import rosbag
import roslib.packages
import rospy
import rostest
from battery_sof.msg import SofStatus
from sensor_msgs.msg import BatteryState

FRAME = """std_msgs/Header header
uint32 id
bool is_rtr
bool is_extended
bool is_error
uint8 dlc
uint8[8] data
================================================================================
MSG: std_msgs/Header
uint32 seq
time stamp
string frame_id
"""


def program(package, name):
    return roslib.packages.find_node(package, name)[0]


class Clients(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder, self.node = folder.name, None
        self.addCleanup(self.stop)

    def start(self, *parameters):
        self.stop()
        self.node = subprocess.Popen([program("battery_sof", "battery_sof_node"), *parameters])
        rospy.wait_for_service("/battery_sof_node/predict_cranking", 20.0)

    def stop(self):
        if self.node:
            self.node.terminate()
            self.node.wait(timeout=20)
        self.node = None

    def ask(self):
        """Exit code and output of both clients."""
        found = []
        for client in ("crank_client", "crank_client.py"):
            done = subprocess.run([program("battery_sof_clients", client)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=30)
            found.append((done.returncode, done.stdout))
        return found

    def until_ready(self):
        """Sends samples until the node answers from its saved model, which stands at 300 s."""
        status = []
        subscriber = rospy.Subscriber("/battery_sof_node/status", SofStatus, status.append)
        publisher = rospy.Publisher("/battery_state", BatteryState, queue_size=100)
        end = time.monotonic() + 40.0
        for n in range(100000):
            message = BatteryState(current=-5.0, voltage=12.4, temperature=float("nan"))
            message.header.stamp = rospy.Time.from_sec(400.0 + 0.01 * n)
            publisher.publish(message)
            if status and status[-1].answer_basis in ("previous_trip", "this_trip"):
                break
            self.assertLess(time.monotonic(), end, "not ready")
            time.sleep(0.01)
        subscriber.unregister()
        publisher.unregister()

    def test_without_a_model_there_is_no_valid_answer(self):
        self.start()
        for code, said in self.ask():
            self.assertEqual(code, 1, said)
            self.assertIn("no model has been identified yet", said)

    def test_with_a_model_both_say_the_same(self):
        model, sof = os.path.join(self.folder, "model.yaml"), program("battery_sof", "sof")
        subprocess.check_call([sof, "demo", "drive.csv", "--duration", "300"], cwd=self.folder, stdout=subprocess.DEVNULL)
        subprocess.check_call([sof, "identify", "drive.csv", "--out", model], cwd=self.folder, stdout=subprocess.DEVNULL)
        self.start(f"_state_file:={model}")
        self.until_ready()
        answers = self.ask()
        self.assertEqual([code for code, _ in answers], [0, 0], answers)
        first, second = (re.search(r"holds: lowest voltage .* V; required 7.20 V", said) for _, said in answers)
        self.assertTrue(first and second, answers)
        self.assertEqual(first[0], second[0])

    def test_frames_become_rows(self):
        bag, out = os.path.join(self.folder, "can.bag"), os.path.join(self.folder, "can.csv")
        types = genpy.dynamic.generate_dynamic("can_msgs/Frame", FRAME)
        with rosbag.Bag(bag, "w") as log:
            for n, identifier in enumerate((0x2C0, 0x100, 0x2C0)):
                frame = types["can_msgs/Frame"](id=identifier, dlc=8, data=struct.pack("<hHI", -125 + n, 12345 + n, 0))
                frame.header.stamp = rospy.Time(100 + n)
                log.write("/received_messages", frame, frame.header.stamp)
        subprocess.check_call([program("battery_sof_clients", "can_to_csv.py"), bag, out])
        with open(out, newline="") as file:
            self.assertEqual(list(csv.reader(file)), [["time_s", "current_a", "voltage_v"], ["100.000", "-12.5", "12.345"], ["102.000", "-12.3", "12.347"]])


if __name__ == "__main__":
    rospy.init_node("clients_test")
    rostest.rosrun("battery_sof_clients", "clients", Clients, sys.argv)

#!/usr/bin/python3
"""What BatteryState says of the battery itself: capacity, serial number, whether it is there; and what /diagnostics calls it."""

import sys

import rospy
import rostest
from battery_sof.msg import SofStatus
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import BatteryState

from processes import NodeTest, wait_until, whole_arguments


class OtherBattery(NodeTest):
    def setUp(self):
        self.entries = {}
        listener = rospy.Subscriber("/diagnostics", DiagnosticArray, self.note, queue_size=100)
        self.addCleanup(listener.unregister)
        self.publisher = rospy.Publisher("/battery_state", BatteryState, queue_size=1000)
        self.addCleanup(self.publisher.unregister)
        self.stamp = 1000.0

    def note(self, array):
        for status in array.status:
            node, _, name = status.name.partition(": ")
            if name == "battery":
                self.entries[node] = (status.hardware_id, status.message, {one.key: one.value for one in status.values})

    def publish(self, **fields):
        """A fifth of a second of samples."""
        for _ in range(20):
            self.stamp += 0.01
            message = BatteryState(**{"current": -5.0, "voltage": 12.4, "temperature": float("nan"), **fields})
            message.header.stamp = rospy.Time.from_sec(self.stamp)
            self.publisher.publish(message)

    def until(self, node, fields, condition, what):
        """Publishes until the node's entry of /diagnostics is as expected."""
        def look():
            self.publish(**fields)
            rospy.sleep(0.05)
            return node in self.entries and condition(*self.entries[node])
        try:
            wait_until(look, 20, what)
        except AssertionError as failure:
            raise AssertionError("{}: {}".format(failure, self.entries.get(node)))

    def test_a_new_serial_number_is_another_battery(self):
        node = self.start("unnamed", diagnostic_period=1.0, identify={"status_list_timeout": 5.0})
        status = self.latest("/unnamed/status", SofStatus)
        first = dict(serial_number="A1", design_capacity=70.0, location="left", present=True)
        self.until("unnamed", first, lambda name, _, values: (name, values["capacity [Ah]"], values["location"]) == ("A1", "70", "left"), "A1 of 70 Ah")
        status.wait(lambda s: s.state == SofStatus.READY, 20, "an answer")
        self.until("unnamed", dict(first, present=False), lambda _, said, __: said == "the battery is reported as not present, so its samples are ignored", "not present")
        status.wait(lambda s: s.state == SofStatus.NO_DATA and "not present" in s.reason, 20, "no battery")
        accepted = status.newest().accepted
        self.until("unnamed", dict(first, serial_number="B2", design_capacity=float("nan")),
                   lambda name, said, values: name == "B2" and "another battery is followed" in said and values["capacity [Ah]"] == "50", "B2 of unknown capacity")
        status.wait(lambda s: s.state == SofStatus.READY and s.accepted > accepted and s.answer_basis == "population", 20, "an answer of B2")
        self.assertEqual(node.stop(), 0)

    def test_parameters_come_first(self):
        node = self.start("named", battery_name="starter", capacity_ah=60)
        self.until("named", dict(serial_number="A1", design_capacity=70.0), lambda name, _, values: (name, values["capacity [Ah]"]) == ("starter", "60"), "starter of 60 Ah")
        self.assertEqual(node.stop(), 0)


if __name__ == "__main__":
    rospy.init_node("other_battery_test")
    rostest.rosrun("battery_sof", "other_battery", OtherBattery, whole_arguments(sys.argv))

#!/usr/bin/python3
"""The node starts, and goes on, whatever its state file is; what is refused is set aside and said in /diagnostics."""

import os
import re
import subprocess
import sys

import rospy
import rostest
from battery_sof.msg import SofStatus
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import BatteryState

from processes import Folder, NodeTest, program, wait_until, whole_arguments


def damaged(text):
    """Models with one number that no battery has, by name."""
    replaced = lambda pattern, value: re.sub(pattern, value, text, count=1, flags=re.S)
    return {
        "covariance_nan": replaced(r"(covariance_v2: \[[^,]*, [^,]*, )[^\]]*", r"\g<1>.nan"),
        "noise_huge": replaced(r"(white_std_v: )\S+", r"\g<1>1e200"),
        "level_huge": replaced(r"(u_dc: \{value: )[^,]*", r"\g<1>1e20"),
        "error_negative": replaced(r"(r_discharge: \{value: [^,]*, std_error: )[^,]*", r"\g<1>-1e9"),
        "cut_off": text[: len(text) // 2],
        "list": "a: [1" + ", 1" * 3000000 + "]\n",
    }


class HardStart(NodeTest):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.remove)
        self.said = {}
        self.listener = rospy.Subscriber("/diagnostics", DiagnosticArray, self.note, queue_size=100)
        self.addCleanup(self.listener.unregister)
        self.publisher = rospy.Publisher("/battery_state", BatteryState, queue_size=100)
        self.stamp = 1000.0

    def note(self, array):
        for status in array.status:
            if status.name.endswith("identification"):
                self.said[status.name.split(":")[0]] = status.message

    def publish(self):
        """A fifth of a second of samples behind the model's state."""
        for _ in range(20):
            self.stamp += 0.01
            message = BatteryState(current=-5.0, voltage=12.4, temperature=float("nan"))
            message.header.stamp = rospy.Time.from_sec(self.stamp)
            self.publisher.publish(message)
        return True

    def started(self, name, file):
        node = self.start(name, state_file=file)
        return node, self.latest("/" + name + "/status", SofStatus)

    def test_every_kind_of_state_file(self):
        csv, good = self.folder.file("drive.csv"), self.folder.file("good.yaml")
        subprocess.check_call([program("simulate_city_drive"), csv, "--seed", "1", "--duration", "300"])
        subprocess.check_call([program("sof"), "identify", csv, "--out", good], stdout=subprocess.DEVNULL)
        with open(good) as file:
            text = file.read()
        files = {"good": good}
        for name, content in damaged(text).items():
            self.assertNotEqual(content, text, name)
            files[name] = self.folder.file(name + ".yaml")
            with open(files[name], "w") as file:
                file.write(content)
        refused = set(files) - {"good"}
        os.symlink("loop", self.folder.file("loop"))
        os.mkfifo(self.folder.file("pipe"))
        files.update(loop=self.folder.file("loop"), pipe=self.folder.file("pipe"), device="/dev/zero", long_name=self.folder.file("x" * 300))
        nodes = {name: self.started("hard_" + name, file) for name, file in files.items()}
        for name, (node, status) in nodes.items():
            self.assertTrue(node.is_alive(), name + ":\n" + node.text())
            wait_until(lambda: self.publish() and status.newest() and status.newest().accepted > 100, 60, "samples taken by " + name)
        for name, (node, status) in nodes.items():
            wait_until(lambda: "hard_" + name in self.said, 20, "diagnostics of " + name)
            self.assertTrue(node.is_alive(), name + ":\n" + node.text())
            self.assertEqual(status.newest().answer_basis == "previous_trip", name == "good", name + ": " + status.newest().reason)
            self.assertEqual(os.path.exists(files[name] + ".refused") if len(files[name]) < 250 else False, name in refused, name)
            if name != "good":
                self.assertRegex(self.said["hard_" + name], "set aside as|cannot be used", name)


if __name__ == "__main__":
    rospy.init_node("hard_start_test")
    rostest.rosrun("battery_sof", "hard_start", HardStart, whole_arguments(sys.argv))

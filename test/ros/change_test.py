#!/usr/bin/python3
"""A contact becomes worse while a recorded drive plays: the node says so on ~change, and takes another reference when it is asked to."""

import csv
import json
import os
import subprocess
import sys

import rospy
import rostest
from battery_sof.msg import SofStatus
from std_msgs.msg import String
from std_srvs.srv import Trigger

from processes import Folder, NodeTest, program, wait_until, whole_arguments

DURATION = 900  # [s]
WORSE_FROM = 630.0  # [s]
CONTACT = 0.02  # [Ohm]
RATE = 30
PERIOD = 90.0  # [s] of driving: five make up the reference, one more is sound


class ChangeWhileDriving(NodeTest):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.remove)

    def bag(self):
        """A drive whose voltage is measured behind a contact from WORSE_FROM on."""
        sound, worse, bag = (self.folder.file(name) for name in ("sound.csv", "worse.csv", "drive.bag"))
        subprocess.check_call([program("sof"), "demo", sound, "--duration", str(DURATION)])
        with open(sound) as read, open(worse, "w") as write:
            rows = csv.reader(read)
            print(*next(rows), sep=",", file=write)
            for time, current, voltage in rows:
                added = CONTACT * float(current) if float(time) >= WORSE_FROM else 0.0
                print(time, current, f"{float(voltage) + added:.4f}", sep=",", file=write)
        subprocess.check_call([program("sof"), "convert", worse, bag])
        return bag

    def saved(self, path):
        if not os.path.exists(path):
            return ""
        with open(path) as file:
            return file.read()

    def test_a_contact_that_became_worse_is_named_and_another_reference_is_taken(self):
        bag, state_file = self.bag(), self.folder.file("model.yaml")
        node = self.start("sof_node", change_period_s=PERIOD, state_file=state_file)
        set_reference = rospy.ServiceProxy("/sof_node/set_reference", Trigger)
        set_reference.wait_for_service(20.0)
        early = set_reference()
        self.assertEqual((early.success, early.message), (False, "no samples are buffered yet"))

        change = self.latest("/sof_node/change", String)
        status = self.latest("/sof_node/status", SofStatus)
        self.play(bag, RATE)
        learning = json.loads(change.wait(lambda c: True, 60, "the reference's first drive").data)
        self.assertEqual((learning["schema"], learning["verdict"]), ("battery_sof/change/1", "insufficient_data"))
        self.assertIn("of the 5 drives", learning["summary"])
        said = lambda c: json.loads(c.data)["verdict"]
        change.wait(lambda c: said(c) == "no_change", 60, "a comparison of a sound drive with the reference")
        found = json.loads(change.wait(lambda c: said(c) == "changed", 60, "a change").data)
        self.assertEqual(found["changes"][0]["id"], "contact_resistance", found["summary"])
        self.assertGreater(found["changes"][0]["now"], 0.25 * CONTACT)
        status.wait(lambda s: s.header.stamp.to_sec() > DURATION - 10.0, 60, "the drive's end")

        again = set_reference()
        self.assertTrue(again.success, again.message)
        self.assertIn("are the first of the 5 drives that make up the reference", again.message)
        change.wait(lambda c: said(c) == "insufficient_data", 20, "what was said of the old reference taken back")
        wait_until(lambda: "responses:" in self.saved(state_file), 20, "the reference on the disk")
        node.stop()
        self.assertIn("responses:", self.saved(state_file))
        self.assertNotIn("since:", self.saved(state_file))


if __name__ == "__main__":
    rospy.init_node("change_test")
    rostest.rosrun("battery_sof", "change", ChangeWhileDriving, whole_arguments(sys.argv))

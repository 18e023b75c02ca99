#!/usr/bin/python3
"""Trips too short for an identification: what was learnt on the first one is what the second one begins from."""

import csv
import math
import os
import signal
import subprocess
import sys

import rospy
import rostest
import yaml
from battery_sof.msg import SofStatus

from processes import Folder, NodeTest, program, wait_until, whole_arguments

RATE = 20
DURATION = 150  # [s]; a window of 240 s does not fit


class ShortTrips(NodeTest):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        cls.bags = []
        made = cls.folder.file("drive.csv")
        for trip in range(2):
            subprocess.check_call([program("simulate_city_drive"), made, "--seed", "4", "--duration", str(DURATION)])
            shifted, bag = cls.folder.file("trip_{}.csv".format(trip)), cls.folder.file("trip_{}.bag".format(trip))
            with open(made, newline="") as source, open(shifted, "w", newline="") as target:
                reader = csv.DictReader(source)
                writer = csv.DictWriter(target, reader.fieldnames)
                writer.writeheader()
                for row in reader:
                    writer.writerow(dict(row, time_s="{:.3f}".format(float(row["time_s"]) + 1000.0 + 7200.0 * trip)))
            subprocess.check_call([program("sof"), "convert", shifted, bag])
            cls.bags.append(bag)

    @classmethod
    def tearDownClass(cls):
        cls.folder.remove()

    def driven(self, name, trip, file, *arguments):
        """A node that follows a trip; its statuses."""
        node = self.start(name, state_file=file)
        status = self.latest("/{}/status".format(name), SofStatus)
        status.wait(lambda s: True, 20, "the first status")
        player = self.play(self.bags[trip], RATE, *arguments)
        return node, status, player

    def first_width(self, status):
        """[V], of the first answer's interval; none before it."""
        for message in list(status.messages):
            if not math.isnan(message.crank.u_min):
                return message.crank.upper - message.crank.lower
        return None

    def saved(self, file):
        with open(file) as text:
            return yaml.safe_load(text)

    def test_the_second_trip_begins_from_what_was_learnt_on_the_first(self):
        file = self.folder.file("kept.yaml")
        node, status, player = self.driven("first_trip", 0, file)
        player.wait(60)
        last = status.wait(lambda s: s.header.stamp.to_sec() > 1000.0 + DURATION - 3.0, 20, "the trip's end")
        self.assertEqual(last.answer_basis, "population", "no window was identified")
        self.assertGreater(last.past_cranks.count, 0)
        self.assertEqual(node.stop(), 0, node.text())
        self.assertEqual([name for name in os.listdir(self.folder.path) if "kept" in name], ["kept.yaml"])
        self.assertAlmostEqual(self.saved(file)["errors"]["crank_intervals"]["factor"], last.past_cranks.interval_factor, places=6)
        self.assertEqual(self.saved(file)["errors"]["crank_intervals"]["events"], last.past_cranks.count)
        unknown = self.first_width(status)

        node, status, player = self.driven("second_trip", 1, file, "--duration", "10")
        begun = status.wait(lambda s: s.answer_basis == "previous_trip", 20, "answers from the first trip")
        self.assertIn("the saved model is in use", begun.reason)
        known = wait_until(lambda: self.first_width(status), 20, "an answer")
        self.assertLess(known, 0.8 * unknown, "the first answers' intervals")
        self.assertEqual(node.stop(), 0, node.text())

    def test_a_node_that_is_terminated_saves_what_it_has(self):
        file = self.folder.file("terminated.yaml")
        node, status, player = self.driven("terminated_trip", 0, file)
        player.wait(60)
        last = status.wait(lambda s: s.header.stamp.to_sec() > 1000.0 + DURATION - 3.0, 20, "the trip's end")
        self.assertEqual(node.stop(signal.SIGTERM), 0, node.text())
        self.assertGreater(self.saved(file)["state"]["time_s"], last.header.stamp.to_sec() - 2.0)

    def test_a_node_that_is_killed_has_saved_soon_after_an_event(self):
        file = self.folder.file("killed.yaml")
        node, status, _ = self.driven("killed_trip", 0, file)
        status.wait(lambda s: s.past_cranks.count > 0, 60, "a crank")
        wait_until(lambda: os.path.exists(file), 30, "the state file")
        node.kill()
        self.assertTrue(self.saved(file)["parameters"])
        self.assertEqual([name for name in os.listdir(self.folder.path) if "killed" in name], ["killed.yaml"])


if __name__ == "__main__":
    rospy.init_node("short_trips_test")
    rostest.rosrun("battery_sof", "short_trips", ShortTrips, whole_arguments(sys.argv))

#!/usr/bin/python3
"""launch/two_batteries.launch: two nodes learn two batteries from one bag, and neither takes the other's for its own."""

import csv
import math
import os
import subprocess
import sys

import rosbag
import rospy
import rostest
import yaml
from battery_sof.msg import IdentifiedModel, SofStatus
from battery_sof.srv import PredictCranking
from sensor_msgs.msg import BatteryState

from processes import Folder, NodeTest, Program, program, service, wait_until, whole_arguments

NAMES = ("starter", "supply")
MORE = 0.004  # [Ohm], by which the second battery's resistance is larger
PARAMETERS = {"window_s": 120.0, "buffer_s": 300.0}


class TwoBatteries(NodeTest):
    def made_bag(self):
        rows, bag = self.folder.file("drive.csv"), self.folder.file("drive.bag")
        subprocess.check_call([program("simulate_city_drive"), rows, "--seed", "4", "--duration", "400"])
        with open(rows) as file, rosbag.Bag(bag, "w") as out:
            for row in csv.DictReader(file):
                stamp = rospy.Time.from_sec(float(row["time_s"]) + 1.0)
                for name, more in zip(NAMES, (0.0, MORE)):
                    sample = BatteryState(current=float(row["current_a"]), voltage=float(row["voltage_v"]) + more * float(row["current_a"]), temperature=math.nan)
                    sample.header.stamp = stamp
                    out.write("/{}/battery_state".format(name), sample, stamp)
        return bag

    def launched(self):
        config = self.folder.file("quick.yaml")
        with open(config, "w") as file:
            yaml.safe_dump(PARAMETERS, file)
        launched = Program("roslaunch", "battery_sof", "two_batteries.launch", "state_folder:=" + self.folder.path, "first_config:=" + config,
                           "second_config:=" + config)
        self.addCleanup(launched.stop)
        return launched

    def test_each_node_learns_its_own_battery_and_keeps_it_in_its_own_file(self):
        self.folder = Folder()
        self.addCleanup(self.folder.remove)
        bag = self.made_bag()
        launched = self.launched()
        nodes = ["/{}/battery_sof_node".format(name) for name in NAMES]
        status = [self.latest(node + "/status", SofStatus) for node in nodes]
        models = [self.latest(node + "/model", IdentifiedModel) for node in nodes]
        for one in status:
            one.wait(lambda s: s.state == SofStatus.NO_DATA, 30, "a status")
        self.play(bag, 20)
        found = [model.wait(lambda m: True, 60, "a model") for model in models]
        resistance = [dict(zip(model.names, model.values))["r_discharge"] for model in found]
        self.assertAlmostEqual(resistance[1] - resistance[0], MORE, delta=0.0005)

        answers = [service(node.strip("/"), "predict_cranking", PredictCranking)(i_load=-20.0, t_stop=10.0, i_cranking=-200.0, t_cranking=0.5, u_required=7.2)
                   for node in nodes]
        self.assertAlmostEqual(answers[0].u_min - answers[1].u_min, 200.0 * MORE, delta=0.1)
        files = [self.folder.file("battery_sof_{}.yaml".format(name)) for name in NAMES]
        wait_until(lambda: all(map(os.path.exists, files)), 10, files)
        for file, expected in zip(files, resistance):
            with open(file) as text:
                kept = yaml.safe_load(text)["parameters"]["r_discharge"]
            self.assertAlmostEqual(kept["value"], expected, delta=0.0005)
        self.assertTrue(launched.is_alive(), launched.text())


if __name__ == "__main__":
    rospy.init_node("two_batteries_test")
    rostest.rosrun("battery_sof", "two_batteries", TwoBatteries, whole_arguments(sys.argv))

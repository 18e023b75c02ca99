#!/usr/bin/python3
"""Every shipped parameter and launch file is accepted; every wrong one in fixtures/ is refused with its message."""

import glob
import os
import shlex
import subprocess
import sys

import roslaunch.config
import rosgraph
import rospkg
import rospy
import rostest
import yaml
from battery_sof.msg import SofStatus

from processes import Folder, NodeTest, Program, program, whole_arguments

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGE = rospkg.RosPack().get_path("battery_sof")


def load(name, *arguments):
    """(file, arguments) of one launch file, resolved as roslaunch would; starts nothing."""
    path = os.path.join(PACKAGE, "launch", name)
    return roslaunch.config.load_config_default([(path, list(arguments))], None, verbose=False)


def node_of(config, name):
    return next(node for node in config.nodes if node.name == name)


class Options(NodeTest):
    def test_shipped_parameters_are_accepted(self):
        for path in glob.glob(os.path.join(PACKAGE, "config", "battery_sof*.yaml")):
            with open(path) as shipped:
                node = self.start("shipped", **yaml.safe_load(shipped))
            status = self.latest("/shipped/status", SofStatus)
            status.wait(lambda s: s.state == SofStatus.NO_DATA, 20, "a status")
            self.assertTrue(node.is_alive())
            self.assertEqual(node.stop(), 0)

    def test_each_wrong_parameter_file_is_refused_with_its_message(self):
        paths = sorted(glob.glob(os.path.join(HERE, "fixtures", "*.yaml")))
        self.assertGreater(len(paths), 5)
        for path in paths:
            with open(path) as wrong:
                text = wrong.read()
            node = self.start("wrong", **yaml.safe_load(text))
            self.assertNotEqual(node.wait(20), 0, path)
            expected = [line[len("# expect: "):] for line in text.splitlines() if line.startswith("# expect: ")]
            self.assertTrue(expected, path)
            for words in expected:
                self.assertIn(words, node.text(), path)

    def test_node_launch_file_sets_the_shipped_parameters_and_a_state_file(self):
        config = load("battery_sof.launch")
        self.assertEqual(node_of(config, "battery_sof_node").type, "battery_sof_node")
        values = {name: parameter.value for name, parameter in config.params.items()}
        self.assertEqual(values["/battery_sof_node/buffer_s"], 1800.0)
        self.assertEqual(values["/battery_sof_node/state_file"], os.path.join(
            os.environ.get("ROS_HOME", os.path.expanduser("~/.ros")), "battery_sof_model.yaml"))

    def test_node_launch_file_takes_its_arguments(self):
        config = load("battery_sof.launch", "state_file:=off", "battery_state:=/car/battery", "output:=log")
        node = node_of(config, "battery_sof_node")
        self.assertEqual([list(remap) for remap in node.remap_args], [["battery_state", "/car/battery"]])
        self.assertEqual(config.params["/battery_sof_node/state_file"].value, "")
        self.assertNotIn("/battery_sof_node/battery_name", config.params)
        self.assertEqual(load("battery_sof.launch", "battery_name:=12").params["/battery_sof_node/battery_name"].value, "12")

    def test_node_launch_file_names_the_node(self):
        config = load("battery_sof.launch", "name:=rear_battery")
        self.assertEqual(node_of(config, "rear_battery").type, "battery_sof_node")
        self.assertIn("/rear_battery/state_file", config.params)

    def test_two_batteries_have_names_topics_and_state_files_apart(self):
        config = load("two_batteries.launch", "first:=front", "state_folder:=/a folder")
        self.assertEqual(sorted(node.namespace for node in config.nodes), ["/front/", "/supply/"])
        self.assertEqual([config.params[name + "/battery_sof_node/battery_name"].value for name in ("/front", "/supply")], ["front", "supply"])
        self.assertEqual(config.params["/front/battery_sof_node/state_file"].value, "/a folder/battery_sof_front.yaml")
        self.assertEqual(config.params["/supply/battery_sof_node/state_file"].value, "/a folder/battery_sof_supply.yaml")
        kept_nowhere = load("two_batteries.launch", "state_folder:=off")
        self.assertEqual(kept_nowhere.params["/supply/battery_sof_node/state_file"].value, "")

    def test_live_launch_file_names_page_nodes_and_port(self):
        config = load("live.launch", "port:=0", "nodes:=/a/battery_sof_node,/b/battery_sof_node")
        self.assertEqual(node_of(config, "live_page").type, "live_page")
        self.assertEqual(config.params["/live_page/port"].value, 0)
        self.assertTrue(os.path.exists(os.path.join(config.params["/live_page/page"].value, "index.html")))

    def test_replay_launch_file_plays_a_bag_with_spaces_in_its_path(self):
        config = load("replay.launch", "bag:=/tmp/a drive/of one.bag", "rate:=50")
        self.assertNotIn("/use_sim_time", config.params)
        for name in ("player", "battery_sof_node"):
            (own,) = [to for of, to in node_of(config, name).remap_args if of == "/use_sim_time"]
            self.assertTrue(config.params[own].value, name)
        player = node_of(config, "player")
        arguments = shlex.split(player.args)
        self.assertEqual(arguments[arguments.index("--bags") + 1], "/tmp/a drive/of one.bag")
        self.assertEqual(arguments[arguments.index("--rate") + 1], "50")
        self.assertIn("--clock", arguments)
        self.assertEqual(config.params["/battery_sof_node/state_file"].value, "")

    def test_replay_leaves_no_simulated_time_behind_on_a_roscore_that_goes_on(self):
        folder = Folder()
        self.addCleanup(folder.remove)
        bag = folder.file("drive.bag")
        subprocess.check_call([program("sof"), "simulate", os.path.join(PACKAGE, "config", "scenarios", "city_drive.yaml"), bag,
                               "--duration", "60"], stdout=subprocess.DEVNULL)
        replay = Program("roslaunch", "battery_sof", "replay.launch", "bag:=" + bag, "rate:=50", "output:=log")
        self.addCleanup(replay.stop)
        status = self.latest("/battery_sof_node/status", SofStatus)
        status.wait(lambda s: s.accepted == 6000, 60, "the bag played")
        self.assertLess(status.newest().header.stamp.to_sec(), 61.0)
        self.assertFalse(rospy.has_param("/use_sim_time"))
        subscribers = dict(rosgraph.Master("/options_test").getSystemState()[1])
        self.assertEqual(subscribers["/clock"], ["/battery_sof_node"])
        self.assertEqual(replay.stop(), 0, replay.text())
        self.start("later")
        later = self.latest("/later/status", SofStatus)
        later.wait(lambda s: s.header.stamp.to_sec() > 1e9, 20, "a node of afterwards on today's clock")

    def test_what_is_no_ros_name_is_refused_with_a_sentence(self):
        for argument in ("__ns:=a b", "__name:=a/b", "battery_state:=a b"):
            node = Program(program("battery_sof_node"), argument)
            self.addCleanup(node.stop)
            self.assertEqual(node.wait(20), 2, node.text())
            self.assertIn("not starting, because the command line or ROS_NAMESPACE has an invalid ROS name", node.text())
            self.assertIn(argument.split(":=")[1], node.text())


if __name__ == "__main__":
    rospy.init_node("options_test")
    rostest.rosrun("battery_sof", "options", Options, whole_arguments(sys.argv))

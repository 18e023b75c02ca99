"""Files for other programs: what they name is what the node publishes. Usage (in the devel space's environment): layouts_test.py"""

import ast
import json
import os
import re
import unittest
import xml.etree.ElementTree

import yaml
from battery_sof.msg import SofStatus
from sensor_msgs.msg import BatteryState

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
CONFIG = os.path.join(ROOT, "config")
TOPICS = {"/battery_state/": BatteryState, "/battery_sof_node/status/": SofStatus}


def is_published(path):
    """Whether a topic has such a field; fields of fields are named one after the other."""
    for topic, kind in TOPICS.items():
        if path.startswith(topic):
            value = kind()
            for name in path[len(topic):].split("/"):
                if name not in getattr(value, "__slots__", ()):
                    return False
                value = getattr(value, name)
            return isinstance(value, (bool, int, float))
    return False


class Layouts(unittest.TestCase):
    def check(self, paths, least):
        self.assertGreaterEqual(len(paths), least)
        for path in paths:
            self.assertTrue(is_published(path), path)

    def test_the_one_of_plotjuggler_draws_fields_that_are_published(self):
        root = xml.etree.ElementTree.parse(os.path.join(CONFIG, "plotjuggler_layout.xml")).getroot()
        self.check([curve.get("name") for curve in root.iter("curve")], 6)

    def test_the_one_of_rqt_draws_fields_that_are_published(self):
        with open(os.path.join(CONFIG, "battery_sof.perspective")) as file:
            manager = json.load(file)["groups"]["pluginmanager"]
        running = ast.literal_eval(manager["keys"]["running-plugins"]["repr"])
        plots = [manager["groups"][f"plugin__rqt_plot__Plot__{n}"] for n in running["rqt_plot/Plot"]]
        self.check([path for plot in plots for path in ast.literal_eval(plot["groups"]["plugin"]["keys"]["topics"]["repr"])], 4)

    def test_a_field_that_is_not_published_would_be_seen(self):
        for path in ("/battery_state/volts", "/battery_sof_node/status/header", "/elsewhere/voltage", "/battery_sof_node/status/state/x"):
            self.assertFalse(is_published(path), path)

    def test_the_tree_of_diagnostics_has_every_line_of_the_node_once(self):
        with open(os.path.join(CONFIG, "diagnostic_aggregator.yaml")) as file:
            groups = yaml.safe_load(file)["analyzers"]["battery"]["analyzers"].values()
        with open(os.path.join(ROOT, "src", "ros", "node_diagnostics.cpp")) as file:
            lines = re.findall(r'\badd\("([^"]+)", report', file.read())
        self.assertEqual(sorted(name for group in groups for name in group["contains"]), sorted("battery_sof_node: " + line for line in lines))
        for group in groups:
            self.assertEqual(group["num_items"], len(group["contains"]))


if __name__ == "__main__":
    unittest.main(verbosity=2)

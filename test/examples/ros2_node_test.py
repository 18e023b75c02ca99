"""The example of a node of ROS 2, on stand-ins for what it calls of rclcpp (ros2_stand_ins), because Debian 12 has no rclcpp. Where there is one, in
a folder of AMENT_PREFIX_PATH, the example is compiled against that, too.

Usage: ros2_node_test.py COMPILER PROGRAM; PROGRAM is the example, linked to the stand-ins.
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest

from battery_sof_tools.files import ROOT, read_text
from battery_sof_tools.sof import program

EXAMPLE = os.path.join(ROOT, "examples", "ros2_node")
SOURCE = os.path.join(EXAMPLE, "battery_sof_ros2_node.cpp")
STAND_INS = os.path.join(ROOT, "test", "examples", "ros2_stand_ins")
SOF = program(os.environ["BATTERY_SOF_BUILD"], "sof")
COMPILER = PROGRAM = ""


def folders_of_rclcpp():
    """Folders of headers where rclcpp is installed, each package's its own; none without it."""
    folders = [os.path.join(prefix, "include") for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if prefix]
    found = [one for folder in folders if os.path.isdir(folder) for one in (folder, *(entry.path for entry in os.scandir(folder) if entry.is_dir()))]
    return found if any(os.path.exists(os.path.join(one, "rclcpp", "rclcpp.hpp")) for one in found) else []


def compiled(source, folders):
    """What a compiler says of a text, with warnings as errors; empty where it finds nothing."""
    command = [COMPILER, "-std=c++17", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{os.path.join(ROOT, 'include')}",
               *(part for folder in folders for part in ("-isystem", folder)), "-x", "c++", "-"]
    return subprocess.run(command, input=source, capture_output=True, text=True, check=False).stderr


class Ros2Node(unittest.TestCase):
    def test_compiles_against_stand_ins(self):
        self.assertEqual("", compiled(read_text(SOURCE), [STAND_INS]))

    def test_compiles_against_rclcpp_where_there_is_one(self):
        folders = folders_of_rclcpp()
        print("rclcpp: " + (", ".join(folders) or "none, the example is compiled against stand-ins only"))
        if folders:
            self.assertEqual("", compiled(read_text(SOURCE), folders))

    def test_a_call_that_the_core_or_the_stand_ins_do_not_have_would_be_seen(self):
        for right, wrong in (("session_.push(sample)", "session_.add(sample)"), ("add_node(node)", "addNode(node)")):
            source = read_text(SOURCE)
            self.assertIn(right, source)
            self.assertIn("error: ", compiled(source.replace(right, wrong), [STAND_INS]), wrong)

    def test_says_whether_the_next_crank_holds_once_a_second(self):
        with tempfile.TemporaryDirectory(prefix="a drive ") as folder:
            drive = os.path.join(folder, "drive.csv")
            subprocess.run([SOF, "demo", drive], check=True, capture_output=True)
            said = subprocess.run([PROGRAM, drive], check=True, capture_output=True, text=True).stdout.splitlines()
        answers = [line.split("|") for line in said if line.startswith("/diagnostics|")]
        self.assertEqual(900, len(answers))  # seconds of the drive
        self.assertTrue([line for line in said if line.startswith("info|converged")], said[-1])
        name = "battery_sof: next crank"
        self.assertEqual(["/diagnostics", "1", name], answers[1][:3])
        self.assertRegex(answers[1][3], "^not valid: ")  # no crank yet
        self.assertEqual(["/diagnostics", "0", name], answers[-1][:3])
        self.assertRegex(answers[-1][3], "^holds: lowest voltage 11")
        values = dict(pair.split("=") for pair in answers[-1][4:])
        lower, lowest, upper = (float(values[key]) for key in ("lower bound, 90 % [V]", "lowest voltage [V]", "upper bound, 90 % [V]"))
        self.assertTrue(11.0 < lower < lowest < upper < 12.0, values)
        self.assertRegex(values["model"], "^last identification accepted")

    def test_packages_that_it_includes_are_named_in_its_build_and_its_manifest(self):
        included = set(re.findall(r"#include <(\w+)/", read_text(SOURCE)))
        self.assertEqual({"battery_sof", "diagnostic_msgs", "rclcpp", "sensor_msgs"}, included)
        found = set(re.findall(r"find_package\((\w+)", read_text(os.path.join(EXAMPLE, "CMakeLists.txt"))))
        self.assertEqual(included | {"ament_cmake"}, found)
        depends = set(re.findall(r"<depend>(\w+)</depend>", read_text(os.path.join(EXAMPLE, "package.xml"))))
        self.assertEqual(included - {"battery_sof"}, depends)  # its core is no package of ROS 2


if __name__ == "__main__":
    COMPILER, PROGRAM = sys.argv[1:3]
    del sys.argv[1:3]
    unittest.main(verbosity=2)

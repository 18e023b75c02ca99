#!/usr/bin/python3
"""A 12 V battery and a row of two of them driven alike: the node of the 24 V topic answers with twice the voltage."""

import csv
import subprocess
import sys

import rospy
import rostest
from battery_sof.msg import DiagnoseAction, Diagnosis, IdentifiedModel, SofStatus
from battery_sof.srv import PredictChargeAcceptance, PredictCranking

from processes import Folder, Goal, NodeTest, program, service, start_node, wait_until, whole_arguments

RATE = 30
DURATION = 330  # [s]
QUESTION = dict(i_load=-20.0, t_stop=10.0, i_cranking=-200.0, t_cranking=0.5)


def in_row(csv_file, row_file, blocks):
    """Writes the drive of a series string, each like the one of the first file."""
    with open(csv_file, newline="") as one, open(row_file, "w", newline="") as row:
        reader = csv.DictReader(one)
        writer = csv.DictWriter(row, reader.fieldnames)
        writer.writeheader()
        for sample in reader:
            writer.writerow(dict(sample, voltage_v=repr(blocks * float(sample["voltage_v"]))))


class RowOfBlocks(NodeTest):
    @classmethod
    def setUpClass(cls):
        cls.folder = Folder()
        one, row = cls.folder.file("one.csv"), cls.folder.file("row.csv")
        subprocess.check_call([program("simulate_city_drive"), one, "--seed", "3", "--duration", str(DURATION)])
        in_row(one, row, 2.0)
        cls.bags = [cls.folder.file("one.bag"), cls.folder.file("row.bag")]
        for source, bag, topic in zip((one, row), cls.bags, ("/one_state", "/row_state")):
            subprocess.check_call([program("sof"), "convert", source, bag, "--topic", topic])

    @classmethod
    def tearDownClass(cls):
        cls.folder.remove()

    def start_on(self, topic, name, **parameters):
        node = start_node(name, parameters, remappings=["battery_state:=" + topic])
        self.addCleanup(node.stop)
        return node

    def assert_twice(self, row, one, *names):
        for name in names:
            self.assertAlmostEqual(getattr(row, name), 2.0 * getattr(one, name), places=9, msg=name)

    def assert_the_same(self, row, one, *names):
        for name in names:
            self.assertEqual(getattr(row, name), getattr(one, name), name)

    def test_a_row_of_two_blocks_is_answered_with_twice_the_voltage(self):
        nodes = [self.start_on("/one_state", "one"), self.start_on("/row_state", "row", series_blocks=2)]
        statuses = [self.latest("/{}/status".format(name), SofStatus) for name in ("one", "row")]
        models = [self.latest("/{}/model".format(name), IdentifiedModel) for name in ("one", "row")]
        for status in statuses:
            status.wait(lambda s: True, 20, "the first status")
        self.play(self.bags[0], RATE, self.bags[1]).wait(60)
        for status in statuses:
            status.wait(lambda s: s.state == SofStatus.READY and s.header.stamp.to_sec() > DURATION - 2.0, 20, "READY")
        wait_until(lambda: statuses[0].newest().header.stamp == statuses[1].newest().header.stamp, 10, "the same sample")
        one, row = [status.newest() for status in statuses]
        self.assert_twice(row, one, "u_required", "u_boost", "expected_voltage")
        self.assertEqual(row.u_required, 14.4)
        self.assertTrue(24.0 < row.u_boost < 30.0, "at which the row was charged lately")
        self.assert_twice(row.crank, one.crank, "u_min", "lower", "upper")
        self.assert_the_same(row.crank, one.crank, "capable", "valid", "code")
        self.assert_the_same(row.stop_time, one.stop_time, "t_stop", "lower", "upper", "outcome")
        self.assert_the_same(row.charge, one.charge, "i_boost", "lower", "upper", "code")
        self.assertGreater(one.past_cranks.count, 0)
        self.assert_the_same(row.past_cranks, one.past_cranks, "count", "coverage", "stimulus")
        self.assert_twice(row.past_cranks, one.past_cranks, "measured", "expected", "lower", "upper", "mean_abs_error")
        self.assertIn("series_blocks: 2", models[1].newest().model_yaml)
        self.assert_the_same(models[1].newest(), models[0].newest(), "values", "window_quality")  # of one block

        answers = [service(name, "predict_cranking", PredictCranking)(u_required=required, **QUESTION)
                   for name, required in (("one", 7.2), ("row", 14.4))]
        self.assert_twice(answers[1], answers[0], "u_min", "lower", "upper")
        self.assertTrue(answers[1].capable)
        answers = [service(name, "predict_charge_acceptance", PredictChargeAcceptance)(u_boost=u_boost, t_sof2=10.0, i_limit=120.0)
                   for name, u_boost in (("one", 13.0), ("row", 26.0))]
        self.assert_the_same(answers[1], answers[0], "i_boost", "lower", "upper", "code")

        found = [Goal(name, "diagnose", DiagnoseAction).wait().diagnosis for name in ("one", "row")]
        self.assertNotEqual(found[0].verdict, Diagnosis.INSUFFICIENT_DATA)
        self.assert_the_same(found[1], found[0], "verdict", "summary")
        self.assertIn("2 blocks of 12 V in series", " ".join(found[1].instrument))
        for node in nodes:
            self.assertEqual(node.stop(), 0)

    def test_a_number_that_is_no_row_is_refused(self):
        node = start_node("refused", {"series_blocks": 0.7})
        self.assertNotEqual(node.wait(20), 0)
        self.assertIn("~series_blocks is 0.7, expected 0.5 (6 V), 1 (12 V), 2 (24 V), 4 (48 V)", node.text())


if __name__ == "__main__":
    rospy.init_node("series_blocks_test")
    rostest.rosrun("battery_sof", "series_blocks", RowOfBlocks, whole_arguments(sys.argv))

#!/usr/bin/python3
"""One bag gives the same answers however fast it is played: at 1x, at 50x, and at 50x again."""

import math
import operator
import subprocess
import sys

import rospy
import rostest
from battery_sof.msg import SofStatus
from battery_sof.srv import PredictChargeAcceptance, PredictCranking, PredictMap, PredictStopTime

from processes import Folder, NodeTest, program, service, whole_arguments

DURATION = 100  # [s]: the first model comes after 60, a second identification is due at 80
PARAMETERS = {"window_s": 60.0, "buffer_s": 90.0, "min_window_quality": 0.0, "identify_period_s": 18.0, "retry_period_s": 10.0}
ANSWERS = ("crank.u_min", "crank.lower", "crank.upper", "stop_time.t_stop", "stop_time.lower", "stop_time.upper", "charge.i_boost",
           "charge.lower", "charge.upper", "crank.code", "stop_time.code", "charge.code", "crank.message", "stop_time.message",
           "charge.message", "past_cranks.interval_factor", "past_charges.interval_factor")


def asked(node):
    """What the services answer once the bag has ended."""
    def ask(name, kind, **request):
        return str(service(node, name, kind)(**request))
    return [ask("predict_cranking", PredictCranking, i_load=-25.0, t_stop=20.0, i_cranking=-200.0, t_cranking=0.5,
                u_required=7.2),
            ask("predict_stop_time", PredictStopTime, i_load=-25.0, i_cranking=-200.0, u_required=11.0),
            ask("predict_charge_acceptance", PredictChargeAcceptance, u_boost=13.5),
            ask("predict_map", PredictMap, i_load=[-10.0, -30.0], t_stop=[0.0, 10.0], i_cranking=-200.0,
                u_required=math.nan, u_boost=[13.0, 14.0], t_sof2=[1.0, 5.0])]


class Played:
    """The answers of one playback: by the stamp of each status, and those asked for at its end."""

    def __init__(self, case, bag, rate, samples):
        name = "at_{}".format(rate)
        node = case.start(name, **PARAMETERS)
        status = case.latest("/{}/status".format(name), SofStatus)
        status.wait(lambda s: s.state == SofStatus.NO_DATA, 20, "a status without data")
        player = case.play(bag, rate)
        case.assertEqual(player.wait(DURATION / rate + 40), 0)
        self.final = status.wait(lambda s: s.accepted == samples and s.reason.startswith("last identification"), 20,
                                 "every sample of the bag accepted")
        self.services = asked(name)
        self.statuses = {s.header.stamp: s for s in status.messages if s.answer_basis == "this_trip"}
        case.assertEqual(node.stop(), 0)


def answers(status):
    """As text: NaN equals NaN."""
    return [str(operator.attrgetter(field)(status)) for field in ANSWERS]


class Rates(NodeTest):
    def setUp(self):
        self.folder = Folder()
        self.addCleanup(self.folder.remove)

    def assert_same(self, one, other):
        self.assertEqual(one.services, other.services)
        self.assertEqual(answers(one.final), answers(other.final))
        self.assertEqual((one.final.past_cranks.count, one.final.past_charges.count),
                         (other.final.past_cranks.count, other.final.past_charges.count))
        # An identification that is under way ends at another sample at another rate: just then statuses may differ.
        common = sorted(one.statuses.keys() & other.statuses.keys())
        self.assertGreater(len(common), 20)
        differ = [stamp.to_sec() for stamp in common if answers(one.statuses[stamp]) != answers(other.statuses[stamp])]
        self.assertLessEqual(len(differ), 6, differ)

    def test_same_bag_gives_the_same_answers_at_every_rate(self):
        csv, bag = self.folder.file("drive.csv"), self.folder.file("drive.bag")
        subprocess.check_call([program("simulate_city_drive"), csv, "--seed", "3", "--duration", str(DURATION)])
        subprocess.check_call([program("sof"), "convert", csv, bag])
        with open(csv) as rows:
            samples = sum(1 for _ in rows) - 1
        fast = Played(self, bag, 50, samples)
        self.assert_same(fast, Played(self, bag, 50, samples))
        self.assert_same(fast, Played(self, bag, 1, samples))


if __name__ == "__main__":
    rospy.init_node("rates_test")
    rostest.rosrun("battery_sof", "rates", Rates, whole_arguments(sys.argv))

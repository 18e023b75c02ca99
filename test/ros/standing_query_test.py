#!/usr/bin/python3
"""The standing questions are changed while the node runs: the next status asks the new ones; a wrong one changes nothing."""

import math
import sys

import rospy
import rostest
from battery_sof.msg import SofStatus
from battery_sof.srv import SetStandingQuery, SetStandingQueryResponse

from processes import NodeTest, service, whole_arguments

KEPT = dict.fromkeys(("i_load", "t_stop", "i_cranking", "t_cranking", "u_required", "u_boost", "t_sof2", "i_limit"), math.nan)


class StandingQuery(NodeTest):
    def test_a_changed_question_is_asked_and_a_wrong_one_is_refused(self):
        node = self.start("asked", standing_query={"u_required_v": 8.0})
        status = self.latest("/asked/status", SofStatus)
        status.wait(lambda s: s.u_required == 8.0, 20, "the question of the parameters")
        change = service("asked", "set_standing_query", SetStandingQuery)
        done = change(**dict(KEPT, t_stop=60.0, u_boost=13.5))
        self.assertTrue(done.success, done.message)
        self.assertEqual((done.t_stop, done.u_required, done.u_boost), (60.0, 8.0, 13.5))
        status.wait(lambda s: (s.t_stop, s.u_required, s.u_boost) == (60.0, 8.0, 13.5), 20, "the changed question")
        refused = change(**dict(KEPT, t_stop=10.0, i_cranking=200.0))
        self.assertEqual((refused.success, refused.code), (False, SetStandingQueryResponse.INVALID_QUERY))
        self.assertIn("i_cranking_a is 200, expected -2000 to -1", refused.message)
        self.assertEqual(refused.t_stop, 60.0)
        self.assertEqual(node.stop(), 0)


if __name__ == "__main__":
    rospy.init_node("standing_query_test")
    rostest.rosrun("battery_sof", "standing_query", StandingQuery, whole_arguments(sys.argv))

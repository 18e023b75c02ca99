#!/usr/bin/python3
"""Asks battery_sof_node whether a crank holds 7.2 V after a stop of 30 s. Exit: 0 holds, 1 not assured or not valid, 2 no answer."""

import sys

import rospy
from battery_sof.srv import PredictCranking


def main():
    rospy.init_node("crank_client")
    service = rospy.ServiceProxy("battery_sof_node/predict_cranking", PredictCranking)
    try:
        service.wait_for_service(10.0)  # [s]
        answer = service(i_load=-20.0,  # [A], <= 0: consumers while the engine is off
                         t_stop=30.0,  # [s]
                         i_cranking=-200.0,  # [A], < 0
                         t_cranking=0.8,  # [s]
                         u_required=7.2)  # [V]
    except (rospy.ROSException, rospy.ServiceException) as error:
        rospy.logerr("no answer from battery_sof_node: %s", error)
        return 2
    rospy.loginfo("%s", answer.message)  # has the numbers; begins with holds, not assured or not valid
    return 0 if answer.valid and answer.capable else 1


if __name__ == "__main__":
    sys.exit(main())

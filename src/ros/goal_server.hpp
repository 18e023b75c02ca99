#pragma once

#include <actionlib/server/action_server.h>

namespace battery_sof {

/**
 * @brief actionlib's server, which no stamp can end.
 *
 * It keeps an ended goal in its status list for a timeout after the ROS time of its end, or after
 * the stamp of a cancel request for a goal that it does not know; the sum of a late stamp and the
 * timeout is beyond ros::Time and throws. Here the timeout is 0: the list holds an ended goal once.
 */
template <typename Action>
class GoalServer : public actionlib::ActionServer<Action> {
 public:
  using actionlib::ActionServer<Action>::ActionServer;

  /// Takes goals from now on.
  void begin() {
    this->start();
    this->status_list_timeout_ = ros::Duration(0.0);
  }
};

}  // namespace battery_sof

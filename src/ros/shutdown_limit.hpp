#pragma once

#include <ros/ros.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <thread>

namespace battery_sof {

/**
 * @brief Ends the program when ROS's shutdown and what follows it take longer than a second,
 * whatever is being computed.
 *
 * Maps, profiles and diagnoses break off by themselves; a fit and a single answer have no place to.
 * Nothing is lost: what they would have come to is for nobody any more, and files are written
 * under another name and renamed.
 */
class ShutdownLimit {
 public:
  /// The end was reached in time.
  ~ShutdownLimit() {
    end_.set_value();
    watcher_.join();
  }

 private:
  static constexpr std::chrono::milliseconds kLook{50};
  // roscpp takes up to 0.1 s to see a signal
  static constexpr std::chrono::milliseconds kGrace{700};

  static void watch(const std::future<void>& end) {
    const auto comes_within = [&end](std::chrono::milliseconds time) {
      return end.wait_for(time) == std::future_status::ready;
    };
    while (!ros::isShuttingDown())
      if (comes_within(kLook)) return;
    if (comes_within(kGrace)) return;
    std::fputs("battery_sof_node: ended in the middle of a computation, of which nothing is kept\n",
               stderr);
    std::_Exit(EXIT_SUCCESS);
  }

  std::promise<void> end_;
  std::thread watcher_{watch, end_.get_future()};
};

}  // namespace battery_sof

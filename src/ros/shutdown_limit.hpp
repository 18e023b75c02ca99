#pragma once

#include <ros/ros.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
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
  ShutdownLimit() : watcher_([this] { watch(); }) {}
  /// The end was reached in time.
  ~ShutdownLimit() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      is_over_ = true;
      changed_.notify_all();
    }
    watcher_.join();
  }
  ShutdownLimit(const ShutdownLimit&) = delete;
  ShutdownLimit& operator=(const ShutdownLimit&) = delete;

 private:
  static constexpr std::chrono::milliseconds kLook{50};
  // roscpp takes up to 0.1 s to see a signal
  static constexpr std::chrono::milliseconds kGrace{700};

  void watch() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!ros::isShuttingDown())
      if (changed_.wait_for(lock, kLook, [this] { return is_over_; })) return;
    if (changed_.wait_for(lock, kGrace, [this] { return is_over_; })) return;
    std::fputs("battery_sof_node: ended in the middle of a computation, of which nothing is kept\n",
               stderr);
    std::_Exit(EXIT_SUCCESS);
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_over_ = false;
  std::thread watcher_;
};

}  // namespace battery_sof

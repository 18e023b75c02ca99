#pragma once

#include <condition_variable>
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
  ShutdownLimit();
  /// The end was reached in time.
  ~ShutdownLimit();
  ShutdownLimit(const ShutdownLimit&) = delete;
  ShutdownLimit& operator=(const ShutdownLimit&) = delete;

 private:
  void watch();

  std::mutex mutex_;
  std::condition_variable changed_;
  bool is_over_ = false;
  std::thread watcher_;
};

}  // namespace battery_sof

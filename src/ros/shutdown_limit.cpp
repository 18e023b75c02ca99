#include "ros/shutdown_limit.hpp"

#include <ros/ros.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>

namespace battery_sof {
namespace {

constexpr std::chrono::milliseconds kLook{50};
constexpr std::chrono::milliseconds kGrace{700};  // roscpp takes up to 0.1 s to see a signal

}  // namespace

ShutdownLimit::ShutdownLimit() : watcher_([this] { watch(); }) {}

ShutdownLimit::~ShutdownLimit() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_over_ = true;
    changed_.notify_all();
  }
  watcher_.join();
}

void ShutdownLimit::watch() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!ros::isShuttingDown())
    if (changed_.wait_for(lock, kLook, [this] { return is_over_; })) return;
  if (changed_.wait_for(lock, kGrace, [this] { return is_over_; })) return;
  std::fputs("battery_sof_node: ended in the middle of a computation, of which nothing is kept\n",
             stderr);
  std::_Exit(EXIT_SUCCESS);
}

}  // namespace battery_sof

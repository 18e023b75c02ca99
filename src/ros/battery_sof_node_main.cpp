#include <ros/ros.h>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <thread>

#include "ros/battery_sof_node.hpp"
#include "ros/node_options.hpp"
#include "util/text.hpp"

namespace {

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

int runAndReport() {
  const ros::NodeHandle keeps_ros_running;
  try {
    XmlRpc::XmlRpcValue parameters;
    ros::param::get(ros::this_node::getName(), parameters);
    const battery_sof::NodeOptions options = battery_sof::parseNodeOptions(parameters);
    const ShutdownLimit limit;
    const battery_sof::BatterySofNode node(ros::NodeHandle(), ros::NodeHandle("~"), options);
    ros::spin();
  } catch (const battery_sof::NodeOptionsError& error) {
    ROS_FATAL("refusing to start, the parameters have faults:\n%s", error.what());
    return EXIT_FAILURE;
  } catch (const std::exception& error) {
    ROS_FATAL("%s", error.what());
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int kWrongUsage = 2;
  try {
    ros::init(argc, argv, "battery_sof_node");
  } catch (const ros::Exception& error) {
    ROS_FATAL("refusing to start, the command line or ROS_NAMESPACE has what is no ROS name: %s",
              battery_sof::printable(error.what()).c_str());
    return kWrongUsage;
  }
  return runAndReport();
}

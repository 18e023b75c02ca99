#include <ros/ros.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <future>
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

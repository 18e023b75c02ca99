#include <ros/ros.h>

#include <csignal>
#include <cstdlib>
#include <exception>

#include "ros/battery_sof_node.hpp"
#include "ros/node_options.hpp"
#include "ros/shutdown_limit.hpp"
#include "util/text.hpp"

namespace {

// roscpp ends a node at SIGINT alone; `kill` and systemd send SIGTERM.
void endAtTermination(int) { ros::requestShutdown(); }

int runAndReport() {
  const ros::NodeHandle keeps_ros_running;
  std::signal(SIGTERM, endAtTermination);
  try {
    XmlRpc::XmlRpcValue parameters;
    ros::param::get(ros::this_node::getName(), parameters);
    const battery_sof::NodeOptions options = battery_sof::parseNodeOptions(parameters);
    const battery_sof::ShutdownLimit limit;
    const battery_sof::BatterySofNode node(ros::NodeHandle(), ros::NodeHandle("~"), options);
    ros::spin();
  } catch (const battery_sof::NodeOptionsError& error) {
    ROS_FATAL("not starting, because parameters are wrong:\n%s", error.what());
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
    ROS_FATAL("not starting, because the command line or ROS_NAMESPACE has an invalid ROS name: %s",
              battery_sof::printable(error.what()).c_str());
    return kWrongUsage;
  }
  return runAndReport();
}

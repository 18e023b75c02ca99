// Asks battery_sof_node whether a crank holds 7.2 V after a stop of 30 s. Exit: 0 yes, 1 no, 2 no
// answer.
#include <battery_sof/PredictCranking.h>
#include <ros/ros.h>

int main(int argc, char** argv) {
  ros::init(argc, argv, "crank_client");
  ros::NodeHandle node;
  auto service =
      node.serviceClient<battery_sof::PredictCranking>("battery_sof_node/predict_cranking");
  battery_sof::PredictCranking query;
  query.request.i_load = -20.0;       // [A], <= 0: consumers while the engine is off
  query.request.t_stop = 30.0;        // [s]
  query.request.i_cranking = -200.0;  // [A], < 0
  query.request.t_cranking = 0.8;     // [s]
  query.request.u_required = 7.2;     // [V]
  if (!service.waitForExistence(ros::Duration(10.0)) || !service.call(query)) {
    ROS_ERROR("no answer from battery_sof_node");
    return 2;
  }
  const auto& answer = query.response;
  if (!answer.valid) {  // the message says why: decide as if there were no answer
    ROS_WARN("not valid: %s", answer.message.c_str());
    return 1;
  }
  ROS_INFO("lowest voltage %.2f V, 90 %% between %.2f and %.2f V: %s", answer.u_min, answer.lower,
           answer.upper, answer.capable ? "holds" : "does not hold");
  return answer.capable ? 0 : 1;
}

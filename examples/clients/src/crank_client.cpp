// Asks battery_sof_node whether a crank holds 7.2 V after a stop of 30 s.
// Exit: 0 holds, 1 not assured or not valid, 2 no answer.
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
  // The sentence has the numbers; it begins with holds, not assured or not valid.
  ROS_INFO("%s", answer.message.c_str());
  return answer.valid && answer.capable ? 0 : 1;
}

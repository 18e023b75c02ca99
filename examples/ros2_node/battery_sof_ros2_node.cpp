// Follows one battery in ROS 2: samples come in on `battery`, and once a second the answer on the
// next crank goes out on `/diagnostics`.
#include <battery_sof/session.hpp>
#include <chrono>
#include <cmath>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <memory>
#include <mutex>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/battery_state.hpp>
#include <string>
#include <vector>

using diagnostic_msgs::msg::DiagnosticArray;
using diagnostic_msgs::msg::DiagnosticStatus;
using sensor_msgs::msg::BatteryState;

class BatterySofNode : public rclcpp::Node {
 public:
  BatterySofNode() : rclcpp::Node("battery_sof") {
    battery_sof::SessionSettings settings;
    settings.capacity = declare_parameter("capacity_ah", settings.capacity);
    settings.series_blocks = declare_parameter("series_blocks", settings.series_blocks);
    session_ = battery_sof::Session(settings);
    query_.i_load = declare_parameter("i_load_a", -20.0);
    query_.t_stop = declare_parameter("t_stop_s", 30.0);
    query_.i_cranking = declare_parameter("i_cranking_a", -200.0);
    query_.t_cranking = declare_parameter("t_cranking_s", 1.0);
    query_.u_required = declare_parameter("u_required_v", 7.2 * settings.series_blocks);

    diagnostics_ = create_publisher<DiagnosticArray>("/diagnostics", 10);
    battery_ = create_subscription<BatteryState>(
        "battery", rclcpp::SensorDataQoS().keep_last(1000),
        [this](const BatteryState::ConstSharedPtr message) { keep(*message); });
    // A fit takes seconds. In a group of its own the timer holds up no sample meanwhile.
    group_ = create_callback_group(rclcpp::CallbackGroupType::MutuallyExclusive);
    timer_ = create_wall_timer(
        std::chrono::seconds(1), [this] { follow(); }, group_);
  }

 private:
  void keep(const BatteryState& message) {
    battery_sof::RawSample sample;
    sample.time = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec;
    sample.current = message.current;
    sample.voltage = message.voltage;
    if (std::isfinite(message.temperature)) sample.temperature = message.temperature + 273.15;
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_.push_back(sample);
  }

  // A Session is for one thread at a time: only the timer uses it.
  void follow() {
    std::vector<battery_sof::RawSample> samples;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      samples.swap(waiting_);
    }
    for (const auto& sample : samples) session_.push(sample);
    if (const auto outcome = session_.identifyWhenDue())
      RCLCPP_INFO(get_logger(), "%s", outcome->c_str());
    publish(session_.predictCranking(query_));
  }

  void publish(const battery_sof::CrankingAnswer& answer) {
    const bool holds = assuranceOf(answer) == battery_sof::Assurance::kHolds;
    DiagnosticStatus status;
    status.level = holds ? DiagnosticStatus::OK : DiagnosticStatus::WARN;
    status.name = std::string(get_name()) + ": next crank";
    status.message = answer.message;
    const auto add = [&](const std::string& key, const std::string& value) {
      status.values.emplace_back();
      status.values.back().key = key;
      status.values.back().value = value;
    };
    if (answer.u_min) {
      add("lowest voltage [V]", std::to_string(answer.u_min->value));
      add("lower bound, 90 % [V]", std::to_string(answer.u_min->lower));
      add("upper bound, 90 % [V]", std::to_string(answer.u_min->upper));
    }
    add("model", session_.reason());
    DiagnosticArray array;
    array.header.stamp = now();
    array.status.push_back(status);
    diagnostics_->publish(array);
  }

  battery_sof::Session session_;
  battery_sof::CrankingQuery query_;
  std::mutex mutex_;  // of waiting_
  std::vector<battery_sof::RawSample> waiting_;
  rclcpp::Publisher<DiagnosticArray>::SharedPtr diagnostics_;
  rclcpp::Subscription<BatteryState>::SharedPtr battery_;
  rclcpp::CallbackGroup::SharedPtr group_;
  rclcpp::TimerBase::SharedPtr timer_;
};

int main(int argc, char** argv) {
  rclcpp::init(argc, argv);
  const auto node = std::make_shared<BatterySofNode>();
  rclcpp::executors::MultiThreadedExecutor executor(rclcpp::ExecutorOptions(), 2);
  executor.add_node(node);
  executor.spin();
  rclcpp::shutdown();
}

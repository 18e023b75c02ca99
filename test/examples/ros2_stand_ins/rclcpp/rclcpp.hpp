#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <diagnostic_msgs/msg/diagnostic_array.hpp>
#include <functional>
#include <memory>
#include <sensor_msgs/msg/battery_state.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "battery_sof/csv.hpp"

// Stand-ins for what the example in examples/ros2_node calls of rclcpp, because Debian 12 has no
// rclcpp. They are no ROS 2: an executor plays the CSV file that is the program's first argument to
// the one subscription, calls the one timer at every second of it, and prints what is published.
namespace rclcpp {
using Message = sensor_msgs::msg::BatteryState;

inline std::string& recording() {
  static std::string path;
  return path;
}
inline void init(int argc, char** argv) { recording() = argc > 1 ? argv[1] : ""; }
inline bool shutdown() { return true; }

struct QoS {
  QoS(std::size_t) {}
  QoS& keep_last(std::size_t) { return *this; }
};
struct SensorDataQoS : QoS {
  SensorDataQoS() : QoS(5) {}
};

enum class CallbackGroupType { MutuallyExclusive, Reentrant };
struct CallbackGroup {
  using SharedPtr = std::shared_ptr<CallbackGroup>;
};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
  std::function<void()> call;
  CallbackGroup::SharedPtr group;
};
template <typename Type>
struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
  std::function<void(std::shared_ptr<const Type>)> call;
};
template <typename Type>
struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  std::string topic;
  void publish(const Type& array) {
    for (const auto& status : array.status) {
      std::printf("%s|%d|%s|%s", topic.c_str(), status.level, status.name.c_str(),
                  status.message.c_str());
      for (const auto& pair : status.values)
        std::printf("|%s=%s", pair.key.c_str(), pair.value.c_str());
      std::printf("\n");
    }
  }
};
struct Logger {};

class Node {
 public:
  explicit Node(std::string name) : name_(std::move(name)) {}
  const char* get_name() const { return name_.c_str(); }
  Logger get_logger() const { return {}; }
  builtin_interfaces::msg::Time now() const { return {}; }
  template <typename Value>
  Value declare_parameter(const std::string&, const Value& value) {
    return value;
  }
  template <typename Type>
  typename Publisher<Type>::SharedPtr create_publisher(const std::string& topic, const QoS&) {
    return std::make_shared<Publisher<Type>>(Publisher<Type>{topic});
  }
  template <typename Type, typename Callback>
  typename Subscription<Type>::SharedPtr create_subscription(const std::string&, const QoS&,
                                                             Callback&& callback) {
    auto made = std::make_shared<Subscription<Type>>();
    made->call = std::forward<Callback>(callback);
    subscription = made;
    return made;
  }
  CallbackGroup::SharedPtr create_callback_group(CallbackGroupType) {
    return std::make_shared<CallbackGroup>();
  }
  template <typename Callback>
  TimerBase::SharedPtr create_wall_timer(std::chrono::nanoseconds, Callback callback,
                                         CallbackGroup::SharedPtr group = nullptr) {
    auto made = std::make_shared<TimerBase>(TimerBase{std::move(callback), std::move(group)});
    timer = made;
    return made;
  }

  std::weak_ptr<Subscription<Message>> subscription;  ///< what is not kept ends, as in rclcpp
  std::weak_ptr<TimerBase> timer;

 private:
  std::string name_;
};

struct ExecutorOptions {};
namespace executors {
class MultiThreadedExecutor {
 public:
  explicit MultiThreadedExecutor(const ExecutorOptions&, std::size_t threads) {
    if (threads < 2) throw std::invalid_argument("samples would wait for a fit");
  }
  void add_node(const std::shared_ptr<Node>& node) { node_ = node; }
  void spin() {
    const auto node = std::shared_ptr<Node>(node_);
    const auto battery = std::shared_ptr<Subscription<Message>>(node->subscription);
    const auto timer = std::shared_ptr<TimerBase>(node->timer);
    if (!timer->group) throw std::logic_error("the timer shares the group of the samples");
    const battery_sof::Series series = battery_sof::readCsv(recording()).series;
    for (std::size_t k = 0; k < series.time.size(); ++k) {
      auto message = std::make_shared<Message>();
      const double second = std::floor(series.time[k]);
      message->header.stamp.sec = static_cast<std::int32_t>(second);
      message->header.stamp.nanosec =
          static_cast<std::uint32_t>(std::lround(1e9 * (series.time[k] - second)));
      message->current = static_cast<float>(series.current[k]);
      message->voltage = static_cast<float>(series.voltage[k]);
      message->temperature = 25.0f;
      if (k > 0 && second > std::floor(series.time[k - 1])) timer->call();
      battery->call(message);
    }
    timer->call();
  }

 private:
  std::weak_ptr<Node> node_;
};
}  // namespace executors
}  // namespace rclcpp

#define RCLCPP_INFO(logger, ...) \
  do {                           \
    static_cast<void>(logger);   \
    std::printf("info|");        \
    std::printf(__VA_ARGS__);    \
    std::printf("\n");           \
  } while (false)

#include "bag/bag_storage.hpp"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <algorithm>
#include <memory>
#include <regex>
#include <set>
#include <system_error>
#include <vector>

#include "bag/battery_state_message.hpp"
#include "battery_sof/intake.hpp"
#include "battery_sof/sample_list.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {

namespace {

std::string absoluteTopic(const std::string& topic) {
  return !topic.empty() && topic.front() == '/' ? topic : "/" + topic;
}

void openForReading(rosbag::Bag& bag, const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw RecordingError(
        path.string() +
        (std::filesystem::exists(path, error) ? ": not a regular file" : ": no such file") +
        ", expected a bag");
  requireSoundBag(path);
  try {
    bag.open(path.string(), rosbag::bagmode::Read);
  } catch (const std::exception&) {
    throw RecordingError(path.string() + ": not a readable bag: its index is damaged");
  }
}

/// The connections of a topic, or the reason why there are none that can be used.
std::vector<const rosbag::ConnectionInfo*> connectionsOf(rosbag::View& all,
                                                         const std::string& topic,
                                                         const std::filesystem::path& path) {
  std::vector<const rosbag::ConnectionInfo*> found;
  std::set<std::string> topics;
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    topics.insert(connection->topic + " (" + connection->datatype + ")");
    if (absoluteTopic(connection->topic) == absoluteTopic(topic)) found.push_back(connection);
  }
  if (!found.empty()) return found;
  throw RecordingError(path.string() + ": no topic '" + shortened(topic) + "'; the bag has " +
                       (topics.empty() ? "no topics at all" : someOf(topics)));
}

void requireBatteryState(const std::vector<const rosbag::ConnectionInfo*>& connections,
                         const std::filesystem::path& path) {
  using Traits = ros::message_traits::DataType<sensor_msgs::BatteryState>;
  using Checksum = ros::message_traits::MD5Sum<sensor_msgs::BatteryState>;
  for (const rosbag::ConnectionInfo* connection : connections) {
    const std::string topic =
        path.string() + ": topic '" + shortened(connection->topic) + "' carries ";
    if (connection->datatype != Traits::value())
      throw RecordingError(topic + shortened(connection->datatype) + ", expected " +
                           Traits::value());
    if (connection->md5sum != Checksum::value())
      throw RecordingError(topic + "another version of " + Traits::value() + " (md5 " +
                           shortened(connection->md5sum) + ", expected " + Checksum::value() +
                           "); `rosbag fix` migrates it");
  }
}

void readMessages(Recording& recording, const rosbag::Bag& bag,
                  const std::vector<const rosbag::ConnectionInfo*>& connections) {
  std::vector<std::string> topics;
  for (const rosbag::ConnectionInfo* connection : connections) topics.push_back(connection->topic);
  rosbag::View view(bag, rosbag::TopicQuery(topics));
  Intake intake;
  for (const rosbag::MessageInstance& instance : view) {
    std::vector<std::uint8_t> bytes(instance.size());
    ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    instance.write(stream);
    append(recording, intake, rawSampleOf(batteryStateIn(bytes)));
  }
}

void writeMessages(const std::filesystem::path& path, const Series& series,
                   const std::string& topic) {
  std::vector<sensor_msgs::BatteryState> messages;
  for (const RawSample& sample : rawSamplesOf(series)) messages.push_back(batteryStateOf(sample));
  auto bag = std::make_unique<rosbag::Bag>(path.string(), rosbag::bagmode::Write);
  try {
    // rosbag refuses record times below TIME_MIN; the header stamp, which is the clock, may be 0.
    for (const sensor_msgs::BatteryState& message : messages)
      bag->write(topic, std::max(message.header.stamp, ros::TIME_MIN), message);
    bag->close();
  } catch (...) {
    // its destructor would write once more, throw and so end the program
    static_cast<void>(bag.release());
    throw;
  }
}

}  // namespace

Recording readBag(const std::filesystem::path& path, const std::string& topic) {
  rosbag::Bag bag;
  openForReading(bag, path);
  Recording recording;
  recording.name = printable(path.filename().string());
  try {
    rosbag::View all(bag);
    if (all.size() == 0)
      throw RecordingError(path.string() + ": the bag is empty: no message is in it");
    const auto connections = connectionsOf(all, topic, path);
    requireBatteryState(connections, path);
    readMessages(recording, bag, connections);
  } catch (const RecordingError&) {
    throw;
  } catch (const std::exception&) {
    throw RecordingError(path.string() +
                         ": damaged bag: a chunk or a message in it cannot be read");
  }
  if (recording.series.empty())
    throw RecordingError(path.string() + ": topic '" + topic + "' holds no usable sample (" +
                         std::to_string(recording.rejected.total()) + " rejected)");
  return recording;
}

void writeBag(const std::filesystem::path& path, const Series& series, const std::string& topic) {
  if (!std::regex_match(topic, std::regex("/?[A-Za-z][A-Za-z0-9_]*(/[A-Za-z0-9_]+)*")))
    throw std::invalid_argument("topic '" + shortened(topic) +
                                "' is not a ROS name, expected one like " + kDefaultTopic);
  const auto refuse = [&](const std::string& why) -> RecordingError {
    return RecordingError(path.string() + ": cannot write the bag: " + why);
  };
  try {
    writeFileAtomically(path, [&](const std::filesystem::path& name) {
      writeMessages(name, series, absoluteTopic(topic));
    });
  } catch (const rosbag::BagException&) {
    throw refuse("no permission or no space");
  } catch (const std::exception& error) {
    throw refuse(error.what());
  }
}

}  // namespace battery_sof

#include "bag/bag_storage.hpp"

#include <algorithm>
#include <cstdint>
#include <regex>
#include <set>
#include <system_error>
#include <utility>
#include <vector>

#include "bag/battery_state_sample.hpp"
#include "bag/format/bag_reader.hpp"
#include "bag/format/bag_writer.hpp"
#include "battery_sof/intake.hpp"
#include "battery_sof/sample_list.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof {

namespace {

std::string absoluteTopic(const std::string& topic) {
  return !topic.empty() && topic.front() == '/' ? topic : "/" + topic;
}

void requireRegularFile(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw RecordingError(
        path.string() +
        (std::filesystem::exists(path, error) ? ": not a regular file" : ": no such file") +
        ", expected a bag");
}

/// The connections of a topic, or the reason why there are none that can be used.
std::vector<BagConnection> connectionsOf(const BagReader& bag, const std::string& topic,
                                         const std::filesystem::path& path) {
  std::vector<BagConnection> found;
  std::set<std::string> topics;
  for (const BagConnection& connection : bag.connections()) {
    topics.insert(connection.topic + " (" + connection.type + ")");
    if (absoluteTopic(connection.topic) == absoluteTopic(topic)) found.push_back(connection);
  }
  if (!found.empty()) return found;
  throw RecordingError(path.string() + ": no topic '" + shortened(topic) + "'; the bag has " +
                       someOf(topics));
}

void requireBatteryState(const std::vector<BagConnection>& connections,
                         const std::filesystem::path& path) {
  for (const BagConnection& connection : connections) {
    const std::string topic =
        path.string() + ": topic '" + shortened(connection.topic) + "' carries ";
    if (connection.type != BatteryStateMessage::kType)
      throw RecordingError(topic + shortened(connection.type) + ", expected " +
                           BatteryStateMessage::kType);
    if (connection.md5sum != BatteryStateMessage::kMd5)
      throw RecordingError(topic + "another version of " + BatteryStateMessage::kType + " (md5 " +
                           shortened(connection.md5sum) + ", expected " +
                           BatteryStateMessage::kMd5 + "); `rosbag fix` migrates it");
  }
}

/// The samples in the order in which they were recorded.
std::vector<RawSample> samplesOf(const BagReader& bag,
                                 const std::vector<BagConnection>& connections) {
  std::vector<std::pair<std::uint64_t, RawSample>> recorded;
  for (const BagConnection& connection : connections)
    bag.read(connection, [&](std::uint64_t time, std::string_view message) {
      recorded.emplace_back(time, rawSampleOf(BatteryStateMessage::deserialized(message)));
    });
  std::stable_sort(recorded.begin(), recorded.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<RawSample> samples;
  for (const auto& [time, sample] : recorded) samples.push_back(sample);
  return samples;
}

}  // namespace

Recording readBag(const std::filesystem::path& path, const std::string& topic) {
  requireRegularFile(path);
  const BagReader bag(path);
  if (bag.connections().empty())
    throw RecordingError(path.string() + ": the bag is empty: no message is in it");
  const std::vector<BagConnection> connections = connectionsOf(bag, topic, path);
  requireBatteryState(connections, path);
  Recording recording;
  recording.name = printable(path.filename().string());
  Intake intake;
  try {
    for (const RawSample& sample : samplesOf(bag, connections)) append(recording, intake, sample);
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
  try {
    std::vector<BatteryStateMessage> messages;
    for (const RawSample& sample : rawSamplesOf(series)) messages.push_back(batteryStateOf(sample));
    writeFileAtomically(path, [&](const std::filesystem::path& name) {
      writeBatteryStates(name, absoluteTopic(topic), messages);
    });
  } catch (const std::exception& error) {
    throw RecordingError(path.string() + ": cannot write the bag: " + error.what());
  }
}

}  // namespace battery_sof

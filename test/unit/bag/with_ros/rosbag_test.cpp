#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/BatteryState.h>
#include <std_msgs/Float64.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <regex>

#include "bag/bag_storage.hpp"
#include "bag/battery_state_sample.hpp"
#include "bag/format/bag_reader.hpp"

// Bags as ROS's own library writes and reads them.
namespace battery_sof {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
const std::vector<rosbag::CompressionType> kCompressions = {
    rosbag::compression::Uncompressed, rosbag::compression::BZ2, rosbag::compression::LZ4};

sensor_msgs::BatteryState messageOf(const RawSample& sample) {
  const BatteryStateMessage of = batteryStateOf(sample);
  sensor_msgs::BatteryState message;
  message.header.stamp = {of.stamp.sec, of.stamp.nsec};
  message.current = of.current;
  message.voltage = of.voltage;
  message.temperature = of.temperature;
  return message;
}

class BagOfRosbag : public ::testing::Test {
 protected:
  BagOfRosbag()
      : folder_(std::filesystem::temp_directory_path() /
                ("battery sof rosbag test " + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~BagOfRosbag() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  static std::string refusal(const std::filesystem::path& path) {
    try {
      readBag(path);
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

template <typename Message>
void writeOne(const std::filesystem::path& path, const std::string& topic, const Message& message) {
  rosbag::Bag bag(path.string(), rosbag::bagmode::Write);
  bag.write(topic, ros::Time(10.0), message);
  bag.close();
}

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void writeBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

/// A definition's lines without what its checksum leaves out.
std::string withoutComments(const std::string& definition) {
  std::istringstream lines(definition);
  std::string kept;
  for (std::string line; std::getline(lines, line);) {
    line = std::regex_replace(line.substr(0, line.find('#')), std::regex(" +"), " ");
    line.erase(line.find_last_not_of(' ') + 1);
    if (!line.empty()) kept += line + "\n";
  }
  return kept;
}

/// Messages on two topics, one of which two publishers share, not in the order of their
/// stamps, and in chunks of 20 kB.
TEST_F(BagOfRosbag, IsReadAsRosbagItselfReadsItHoweverItIsCompressed) {
  for (const auto compression : kCompressions) {
    rosbag::Bag written(file("a.bag").string(), rosbag::bagmode::Write);
    written.setCompression(compression);
    written.setChunkThreshold(20000);
    for (const char* name : {"first", "second"}) {
      const auto header = boost::make_shared<ros::M_string>();
      (*header)["callerid"] = name;
      (*header)["topic"] = "/battery_state";
      (*header)["type"] = BatteryStateMessage::kType;
      (*header)["md5sum"] = BatteryStateMessage::kMd5;
      (*header)["message_definition"] = BatteryStateMessage::definition();
      for (int n = 0; n < 1000; ++n) {
        sensor_msgs::BatteryState message = messageOf({0.1 * n, n % 7 - 3.0, 12.5, 300.0});
        message.cell_voltage.assign(n % 7, 2.1f);
        message.serial_number = name;
        const double at =
            1000.0 + 0.1 * n + (name[0] == 's' ? 0.05 : 0.0) - (n % 13 == 5 ? 1.0 : 0.0);
        written.write("/battery_state", ros::Time(at), message, header);
        written.write("/other", ros::Time(at), std_msgs::Float64());
      }
    }
    written.close();
    std::vector<RawSample> expected;
    const rosbag::Bag bag(file("a.bag").string());
    rosbag::View view(bag, rosbag::TopicQuery("/battery_state"));
    for (const auto& instance : view) {
      const auto message = instance.instantiate<sensor_msgs::BatteryState>();
      expected.push_back(
          rawSampleOf(BatteryStateMessage{{message->header.stamp.sec, message->header.stamp.nsec},
                                          message->voltage,
                                          message->temperature,
                                          message->current}));
    }
    Intake intake;
    Recording as_rosbag;
    for (const RawSample& sample : expected) append(as_rosbag, intake, sample);
    const Recording read = readBag(file("a.bag"));
    EXPECT_EQ(read.offered, 2000u);
    EXPECT_GT(read.series.size(), 200u);
    EXPECT_EQ(read.series.time, as_rosbag.series.time);
    EXPECT_EQ(read.series.current, as_rosbag.series.current);
    EXPECT_EQ(read.series.voltage, as_rosbag.series.voltage);
    EXPECT_EQ(read.series.temperature, as_rosbag.series.temperature);
    EXPECT_EQ(toString(read.rejected), toString(as_rosbag.rejected));
  }
}

TEST_F(BagOfRosbag, IsReadByRosbagWhenItIsOurs) {
  Series series;
  for (int n = 0; n < 20000; ++n) series.append({n / 100.0, n % 7 * -0.1, 12.275 + n % 5 * 0.025});
  writeBag(file("a.bag"), series);
  const rosbag::Bag bag(file("a.bag").string());
  rosbag::View view(bag);
  ASSERT_EQ(view.size(), series.size());
  std::size_t n = 0;
  for (const auto& instance : view) {
    const auto message = instance.instantiate<sensor_msgs::BatteryState>();
    ASSERT_NE(message, nullptr);
    EXPECT_EQ(instance.getTopic(), "/battery_state");
    EXPECT_EQ(std::max(message->header.stamp, ros::TIME_MIN), instance.getTime());
    EXPECT_EQ(message->voltage, static_cast<float>(series.voltage[n++]));
    for (float value : {message->temperature, message->charge, message->capacity,
                        message->design_capacity, message->percentage})
      EXPECT_TRUE(std::isnan(value));
    EXPECT_TRUE(message->present);
  }
}

TEST_F(BagOfRosbag, HasTheChecksumAndTheDefinitionThatWeWrite) {
  using Message = sensor_msgs::BatteryState;
  EXPECT_STREQ(ros::message_traits::md5sum<Message>(), BatteryStateMessage::kMd5);
  EXPECT_STREQ(ros::message_traits::datatype<Message>(), BatteryStateMessage::kType);
  EXPECT_EQ(withoutComments(ros::message_traits::definition<Message>()),
            BatteryStateMessage::definition());
}

TEST_F(BagOfRosbag, ASoundBagWithoutAMessageIsEmptyAndNotDamaged) {
  rosbag::Bag none(file("none.bag").string(), rosbag::bagmode::Write);
  none.close();
  EXPECT_THAT(refusal(file("none.bag")), HasSubstr("the bag is empty: no message is in it"));
}

TEST_F(BagOfRosbag, OtherMessageTypeIsRefusedByName) {
  std_msgs::Float64 message;
  writeOne(file("a.bag"), "/battery_state", message);
  EXPECT_THAT(refusal(file("a.bag")), AllOf(HasSubstr("carries std_msgs/Float64"),
                                            HasSubstr("expected sensor_msgs/BatteryState")));
}

TEST_F(BagOfRosbag, ChunkThatClaimsMoreThanItsBytesCanHoldIsRefusedBeforeAnythingIsAllocated) {
  for (const auto compression : {rosbag::compression::Uncompressed, rosbag::compression::BZ2}) {
    rosbag::Bag bag(file("a.bag").string(), rosbag::bagmode::Write);
    bag.setCompression(compression);
    for (int n = 1; n < 100; ++n)
      bag.write("battery_state", ros::Time(n), messageOf({1.0 * n, -5.0, 12.0, {}}));
    bag.close();
    EXPECT_EQ(readBag(file("a.bag")).series.size(), 99u);
    std::string damaged = bytesOf(file("a.bag"));
    const std::size_t chunk = damaged.find("compression=");
    const std::size_t size = damaged.find("size=", chunk);
    ASSERT_NE(size, std::string::npos);
    damaged.replace(size + 5, 4, "\xff\xff\xff\x7f");
    writeBytes(file("damaged.bag"), damaged);
    EXPECT_THAT(refusal(file("damaged.bag")), HasSubstr("a chunk claims to hold 2147483647 bytes"));
  }
}

TEST_F(BagOfRosbag, ListInAMessageThatClaimsMoreThanItsBytesIsRefused) {
  sensor_msgs::BatteryState message = messageOf({1.0, -5.0, 12.0, {}});
  message.serial_number = "SERIALNUMBER";
  writeOne(file("a.bag"), "battery_state", message);
  std::string damaged = bytesOf(file("a.bag"));
  const std::size_t serial = damaged.find("SERIALNUMBER");
  ASSERT_NE(serial, std::string::npos);
  damaged.replace(serial - 16, 4, "\xff\xff\xff\x2f");  // the number of cell voltages
  writeBytes(file("damaged.bag"), damaged);
  EXPECT_THAT(refusal(file("damaged.bag")), HasSubstr("a chunk or a message in it cannot be read"));
}

TEST_F(BagOfRosbag, MissingAndImpossibleValuesAreCountedByReason) {
  rosbag::Bag bag(file("a.bag").string(), rosbag::bagmode::Write);
  const double infinite = std::numeric_limits<double>::infinity();
  const std::vector<sensor_msgs::BatteryState> messages = {
      messageOf({1.0, -5.0, 12.0, 300.0}),  messageOf({2.0, kNan, 12.0, {}}),
      messageOf({3.0, infinite, 12.0, {}}), messageOf({1.0, -5.0, 12.0, {}}),
      messageOf({0.5, -5.0, 12.0, {}}),     messageOf({4.0, -5.0, 900.0, {}}),
      messageOf({5.0, -6.0, 12.0, {}})};
  for (std::size_t n = 0; n < messages.size(); ++n) {
    bag.write("battery_state", ros::Time(100.0 + n), messages[n]);
  }
  bag.close();
  const Recording read = readBag(file("a.bag"));
  EXPECT_EQ(read.series.size(), 2u);
  EXPECT_EQ(read.rejected.missing_value, 1u);
  EXPECT_EQ(read.rejected.not_finite, 1u);
  EXPECT_EQ(read.rejected.duplicate_stamp, 1u);
  EXPECT_EQ(read.rejected.clock_step_back, 1u);
  EXPECT_EQ(read.rejected.out_of_range, 1u);
  EXPECT_NEAR(read.series.temperature.at(0), 300.0, 1e-4);
}

}  // namespace
}  // namespace battery_sof

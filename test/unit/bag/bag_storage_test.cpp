#include "bag/bag_storage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "bag/battery_state_sample.hpp"
#include "bag/format/bag_writer.hpp"
#include "battery_sof/csv.hpp"

namespace battery_sof {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class BagStorage : public ::testing::Test {
 protected:
  BagStorage()
      : folder_(std::filesystem::temp_directory_path() /
                ("battery sof bag test " + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~BagStorage() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path file(const std::string& name) const { return folder_ / name; }

  std::size_t filesInFolder() const {
    const std::filesystem::directory_iterator entries(folder_);
    return std::distance(begin(entries), end(entries));
  }

  static std::string refusal(const std::filesystem::path& path,
                             const std::string& topic = kDefaultTopic) {
    try {
      readBag(path, topic);
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

Series someSeries() {
  Series series;
  for (int n = 0; n < 3000; ++n) {
    series.append({n / 100.0, n % 7 * -0.1, 12.275 + n % 5 * 0.025});
    if (n % 100 == 50) {
      series.temperature_time.push_back(n / 100.0);
      series.temperature.push_back(318.15);
    }
  }
  return series;
}

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void writeBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST_F(BagStorage, RoundTripKeepsEverySampleAsItWas) {
  const Series series = someSeries();
  writeBag(file("a.bag"), series);
  const Recording read = readBag(file("a.bag"));
  EXPECT_EQ(read.name, "a.bag");
  EXPECT_EQ(read.offered, series.size());
  EXPECT_EQ(read.rejected.total(), 0u);
  EXPECT_EQ(read.series.time, series.time);
  ASSERT_EQ(read.series.size(), series.size());
  for (std::size_t n = 0; n < series.size(); ++n) {
    EXPECT_NEAR(read.series.current[n], series.current[n], 1e-12);
    EXPECT_NEAR(read.series.voltage[n], series.voltage[n], 1e-12);
  }
  EXPECT_EQ(read.series.temperature_time, series.temperature_time);
  EXPECT_THAT(read.series.temperature, ::testing::Each(::testing::DoubleNear(318.15, 1e-9)));
}

TEST_F(BagStorage, CsvToBagToCsvKeepsTimesOfAnEpochClockToTheNanosecondADoubleCanHold) {
  Series series;
  for (int n = 0; n < 50; ++n) {
    series.append({1490425206.9 + n * 0.01, -12.5, 12.5});
  }
  writeCsv(file("a.csv"), series);
  writeBag(file("a.bag"), readCsv(file("a.csv")).series);
  writeCsv(file("b.csv"), readBag(file("a.bag")).series);
  EXPECT_EQ(bytesOf(file("a.csv")), bytesOf(file("b.csv")));
}

TEST_F(BagStorage, CsvToBagToCsvIsTheSameFileWhenTheClockStartsAtZero) {
  writeCsv(file("a.csv"),
           readCsv([&] {
             writeBytes(
                 file("in.csv"),
                 "time_s,current_a,voltage_v,temperature_c\n"
                 "0,-15.3,12.275,45\n1.01,-0.1,12.3,\n1.5,,,44.5\n2.123456789,55.2,14.025,\n");
             return file("in.csv");
           }())
               .series);
  writeBag(file("a.bag"), readCsv(file("a.csv")).series);
  writeCsv(file("b.csv"), readBag(file("a.bag")).series);
  EXPECT_EQ(bytesOf(file("a.csv")), bytesOf(file("b.csv")));
}

TEST_F(BagStorage, StampOfZeroIsKeptAlthoughNoRecordTimeMayBeZero) {
  Series series{{0.0, 0.01}, {-1.0, -2.0}, {12.0, 12.1}, {}, {}};
  writeBag(file("a.bag"), series);
  EXPECT_EQ(readBag(file("a.bag")).series.time.front(), 0.0);
}

TEST_F(BagStorage, ABagIsReadWhateverItsChunksAreCompressedBy) {
  const std::filesystem::path corpus =
      std::filesystem::path(BATTERY_SOF_TEST_DIR) / "fuzz" / "corpus" / "bag";
  for (const char* compression : {"none", "bz2", "lz4"}) {
    const Series series = readBag(corpus / compression).series;
    EXPECT_THAT(series.time, ::testing::ElementsAre(1.5, 2.5)) << compression;
    EXPECT_THAT(series.voltage, ::testing::ElementsAre(12.5, 10.5)) << compression;
    EXPECT_THAT(series.temperature, ::testing::ElementsAre()) << compression;
  }
}

TEST_F(BagStorage, DamageInACompressedChunkIsRefusedWithASentence) {
  for (const char* compression : {"bz2", "lz4"}) {
    std::string damaged = bytesOf(std::filesystem::path(BATTERY_SOF_TEST_DIR) / "fuzz" / "corpus" /
                                  "bag" / compression);
    const std::size_t chunk = damaged.find("size=") + 13;
    damaged.replace(chunk + 2, 30, 30, '\x7f');
    writeBytes(file("damaged.bag"), damaged);
    EXPECT_THAT(refusal(file("damaged.bag")),
                HasSubstr("damaged bag: a chunk or a message in it cannot be read"))
        << compression;
  }
}

TEST_F(BagStorage, AnIndexThatLeavesSomethingOutIsRefused) {
  writeBag(file("a.bag"), someSeries());
  for (const char* field : {"chunk_count=", "conn_count=", "ver=", "md5sum="}) {
    std::string damaged = bytesOf(file("a.bag"));
    const std::size_t at = damaged.rfind(field) + std::string(field).size();
    damaged[field == std::string("md5sum=") ? at - 2 : at] ^= '\x08';
    writeBytes(file("damaged.bag"), damaged);
    EXPECT_THAT(refusal(file("damaged.bag")), HasSubstr("its index is damaged")) << field;
  }
}

TEST_F(BagStorage, TopicIsFoundWithAndWithoutALeadingSlash) {
  writeBag(file("a.bag"), someSeries(), "car/battery");
  EXPECT_EQ(readBag(file("a.bag"), "car/battery").series.size(), 3000u);
  EXPECT_EQ(readBag(file("a.bag"), "/car/battery").series.size(), 3000u);
}

TEST_F(BagStorage, ATopicThatIsNoNameOfRosIsRefused) {
  for (const char* topic : {"", "/", "a b!", "/2nd/battery"}) {
    EXPECT_THROW(writeBag(file("a.bag"), someSeries(), topic), std::invalid_argument) << topic;
    EXPECT_FALSE(std::filesystem::exists(file("a.bag"))) << topic;
  }
}

TEST_F(BagStorage, MissingTopicIsRefusedWithTheTopicsThereAre) {
  writeBag(file("a.bag"), someSeries(), "/front/battery");
  EXPECT_THAT(refusal(file("a.bag")),
              AllOf(HasSubstr("a.bag"), HasSubstr("battery_state"),
                    HasSubstr("/front/battery (sensor_msgs/BatteryState)")));
}

TEST_F(BagStorage, EveryTruncationOfAGoodBagIsRefused) {
  writeBag(file("a.bag"), someSeries());
  const std::string whole = bytesOf(file("a.bag"));
  for (double share : {0.0, 0.0001, 0.01, 0.3, 0.5, 0.9, 0.99, 0.9999}) {
    writeBytes(file("cut.bag"), whole.substr(0, static_cast<std::size_t>(share * whole.size())));
    EXPECT_THAT(refusal(file("cut.bag")), HasSubstr("cut.bag")) << "cut at " << share;
  }
}

TEST_F(BagStorage, DamageAnywhereInABagNeverAborts) {
  writeBag(file("a.bag"), someSeries());
  const std::string whole = bytesOf(file("a.bag"));
  for (std::size_t at = 13; at < whole.size(); at += whole.size() / 97) {
    std::string damaged = whole;
    damaged.replace(at, std::min<std::size_t>(60, whole.size() - at), 60, '\x01');
    writeBytes(file("damaged.bag"), damaged);
    EXPECT_NO_FATAL_FAILURE(refusal(file("damaged.bag"))) << "damaged at byte " << at;
  }
}

TEST_F(BagStorage, IndexThatPointsNowhereIsRefusedWithTheByte) {
  writeBag(file("a.bag"), someSeries());
  std::string damaged = bytesOf(file("a.bag"));
  const std::size_t index = damaged.rfind(std::string("op=\x04"));
  ASSERT_NE(index, std::string::npos);
  damaged.replace(damaged.find("ver=", index) + 12 + 8, 4, 4, '\x01');
  writeBytes(file("damaged.bag"), damaged);
  EXPECT_THAT(refusal(file("damaged.bag")),
              AllOf(HasSubstr("damaged bag, at byte"), HasSubstr("an index points to where no")));
}

TEST_F(BagStorage, FilesThatAreNoBagsAreRefused) {
  writeBytes(file("zeros.bag"), std::string(100000, '\0'));
  writeBytes(file("text.bag"), "time_s,current_a,voltage_v\n0,1,12\n");
  writeBytes(file("empty.bag"), "");
  for (const char* name : {"zeros.bag", "text.bag", "empty.bag", "absent.bag"}) {
    EXPECT_THAT(refusal(file(name)), HasSubstr(name));
  }
  EXPECT_THAT(refusal(folder_), HasSubstr("not a regular file, expected a bag"));
}

TEST_F(BagStorage, BagOfUnusableMessagesIsRefusedWithTheirNumber) {
  writeBatteryStates(file("a.bag"), "/battery_state", {batteryStateOf({1.0, kNan, 12.0, {}})});
  EXPECT_THAT(refusal(file("a.bag")), HasSubstr("no usable sample (1 rejected)"));
}

TEST_F(BagStorage, WrittenFileAppearsWholeOrNotAtAll) {
  Series series{{-1.0, 0.0}, {-1.0, -2.0}, {12.0, 12.1}, {}, {}};
  EXPECT_THROW(writeBag(file("a.bag"), series), RecordingError);
  EXPECT_THROW(writeBag(file("no/such/folder/a.bag"), someSeries()), RecordingError);
  series.time = {1.0, 5e9};
  EXPECT_THROW(writeBag(file("a.bag"), series), RecordingError);
  EXPECT_EQ(filesInFolder(), 0u);
}

TEST_F(BagStorage, HeaderThatPointsWhereNoRecordBeginsIsRefused) {
  writeBag(file("a.bag"), someSeries());
  std::string damaged = bytesOf(file("a.bag"));
  const std::size_t at = damaged.find("index_pos=") + 10;
  damaged[at] = static_cast<char>(damaged[at] + 1);
  writeBytes(file("damaged.bag"), damaged);
  EXPECT_THAT(refusal(file("damaged.bag")), HasSubstr("where no record begins"));
  damaged.replace(at, 8, 8, '\0');
  writeBytes(file("damaged.bag"), damaged);
  EXPECT_THAT(refusal(file("damaged.bag")), HasSubstr("the bag has no index"));
}

/// What a connection says of itself stands in its chunk and again in the index.
TEST_F(BagStorage, ConnectionWhoseFieldIsLongerThanItIsRefused) {
  writeBag(file("a.bag"), someSeries());
  const std::string whole = bytesOf(file("a.bag")), field = "type=sensor_msgs/BatteryState";
  ASSERT_NE(whole.find(field), whole.rfind(field));
  for (const std::size_t at : {whole.find(field), whole.rfind(field)}) {
    std::string damaged = whole;
    damaged.replace(at - 4, 4, "\xff\xff\x01\x01");
    writeBytes(file("damaged.bag"), damaged);
    EXPECT_THAT(refusal(file("damaged.bag")), AllOf(HasSubstr("damaged bag, at byte "),
                                                    HasSubstr("a record's header is damaged")));
  }
}

TEST_F(BagStorage, ChunkThatIsListedTwiceIsRefused) {
  writeBag(file("a.bag"), someSeries());
  std::string damaged = bytesOf(file("a.bag"));
  const std::size_t last = damaged.rfind("chunk_pos=");
  const std::size_t first = damaged.find("chunk_pos=");
  ASSERT_NE(first, std::string::npos);
  damaged.replace(last + 10, 8, std::string(8, '\x11'));
  writeBytes(file("damaged.bag"), damaged);
  EXPECT_THAT(refusal(file("damaged.bag")), HasSubstr("a chunk is listed where none is, or twice"));
}

TEST_F(BagStorage, AThousandDamagedBagsAreReadOrRefusedWithASentence) {
  Series series = someSeries();
  for (auto* values : {&series.time, &series.current, &series.voltage}) values->resize(200);
  series.temperature.clear();
  series.temperature_time.clear();
  writeBag(file("a.bag"), series);
  const std::string whole = bytesOf(file("a.bag"));
  std::mt19937 random(5);
  int refused = 0;
  for (int round = 0; round < 1000; ++round) {
    std::string damaged = whole;
    for (std::size_t k = random() % 4 + 1; k > 0; --k)
      damaged[random() % damaged.size()] = static_cast<char>(random());
    writeBytes(file("damaged.bag"), damaged);
    const std::string said = refusal(file("damaged.bag"));
    refused += !said.empty();
    EXPECT_TRUE(said.empty() || said.find("damaged.bag: ") != std::string::npos)
        << round << ": " << said;
  }
  EXPECT_GT(refused, 20);
  EXPECT_LT(refused, 1000);
}

TEST(Stamp, IsExactToTheNanosecondAndRefusesWhatAStampCannotHold) {
  for (double time : {0.0, 1e-9, 0.01, 0.29, 1234.56789, 4194304.123456789}) {
    EXPECT_EQ(secondsOf(stampOf(time)), time);
  }
  EXPECT_EQ(secondsOf(stampOf(1490425206.9)), 1490425206.9);
  EXPECT_EQ(secondsOf(stampOf(0.9999999999)), 1.0);
  constexpr Stamp kLast{4294967295u, 999999999u};
  EXPECT_EQ(secondsOf(stampOf(secondsOf(kLast))), secondsOf(kLast))
      << "each stamp that comes in can go out again";
  for (double time : {-1e-9, 4294967297.0, kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(stampOf(time), std::invalid_argument);
  }
}

TEST(RawSample, OfAStampWithASecondOfNanosecondsIsOutOfRange) {
  BatteryStateMessage message = batteryStateOf({1000.0, -5.0, 12.4, std::nullopt});
  Intake intake;
  for (const std::uint32_t nanoseconds : {1000000000u, 4294967295u}) {
    message.stamp.nsec = nanoseconds;
    EXPECT_EQ(intake.judge(rawSampleOf(message)), SampleFate::kOutOfRange) << nanoseconds;
  }
  message.stamp.nsec = 999999999;
  EXPECT_EQ(intake.judge(rawSampleOf(message)), SampleFate::kAccepted);
}

}  // namespace
}  // namespace battery_sof

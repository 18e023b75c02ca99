#include "battery_sof/csv.hpp"
#include "recording/text_lines.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <thread>

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

class Csv : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(::testing::TempDir()) / (std::string("csv ") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    path_ = folder_ / "drive.csv";
  }
  void TearDown() override { fs::remove_all(folder_); }

  Recording read(const std::string& content, const CsvColumns& columns = {}) {
    std::ofstream(path_, std::ios::binary) << content;
    return readCsv(path_, columns);
  }

  std::string errorOf(const std::string& content, const CsvColumns& columns = {}) {
    std::ofstream(path_, std::ios::binary) << content;
    return errorOfReading(path_, columns);
  }

  static std::string errorOfReading(const fs::path& path, const CsvColumns& columns = {}) {
    try {
      readCsv(path, columns);
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_, path_;
};

::testing::AssertionResult says(const std::string& message, const std::string& part) {
  if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << '"' << message << "\" does not say \"" << part << '"';
}

const char kHeader[] = "time_s,current_a,voltage_v\n";

// ---------------------------------------------------------------------------------------------
// files as a whole

TEST_F(Csv, PlainFileIsReadWithItsName) {
  const Recording recording = read(std::string(kHeader) + "0,-5,12.5\n0.01,-6.25,12.4\n");
  EXPECT_EQ(recording.name, "drive.csv");
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 0.01}));
  EXPECT_EQ(recording.series.current, (std::vector<double>{-5.0, -6.25}));
  EXPECT_EQ(recording.series.voltage, (std::vector<double>{12.5, 12.4}));
  EXPECT_TRUE(recording.series.temperature.empty());
  EXPECT_EQ(recording.offered, 2U);
}

TEST_F(Csv, MissingFileIsNamedWithTheReason) {
  const std::string message = errorOfReading(folder_ / "absent.csv");
  EXPECT_TRUE(says(message, (folder_ / "absent.csv").string()));
  EXPECT_TRUE(says(message, "No such file"));
}

TEST_F(Csv, FolderIsRefused) { EXPECT_TRUE(says(errorOfReading(folder_), "is a directory")); }

TEST_F(Csv, APipeIsReadOnceFromItsBeginning) {
  const std::string content = std::string(kHeader) + "0,-5,12.5\n1,-6,12.4\n";
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(path_, std::ios::binary) << content; });
  std::string seen;
  const Recording recording = readCsv(path_, {}, [&](std::string_view bytes) { seen += bytes; });
  writer.join();
  EXPECT_EQ(recording.series.size(), 2U);
  EXPECT_EQ(seen, content);
}

TEST_F(Csv, DevicesAreRefusedAndSoIsALineWithoutEnd) {
  EXPECT_TRUE(says(errorOfReading("/dev/zero"),
                   "/dev/zero: is a device or a socket, expected a file or a pipe"));
  EXPECT_TRUE(
      says(errorOf(std::string(kHeader) + "0,1,12\n" + std::string(TextLines::kLongest + 1, '1')),
           "line 3 is too long"));
  EXPECT_TRUE(says(errorOf(std::string(TextLines::kLongest + 1, '\0') + "\n"),
                   "line 1 is too long, expected a CSV file"));
  EXPECT_EQ(read(std::string(kHeader) + "0,1,12" + std::string(TextLines::kLongest - 6, ' '))
                .series.size(),
            1U);
}

TEST_F(Csv, LinesAreWholeWhereverTheBlocksOfReadingEnd) {
  std::string content = kHeader;
  for (int k = 0; k < 20000; ++k)
    content += std::to_string(k) + (k % 3 ? ",1,12\n" : ",1,12\r\n\n");
  EXPECT_EQ(read(content).series.size(), 20000U);
}

TEST_F(Csv, ErrorsStayShortWhateverTheFileHolds) {
  std::string names = "time";
  for (int k = 0; k < 50000; ++k) names += ",name " + std::to_string(k);
  const std::string many = errorOf(names + "\n0\n");
  EXPECT_TRUE(says(many, "its columns are: time, name 0, "));
  EXPECT_TRUE(says(many, "name 18 and 49981 more"));
  const std::string cell = errorOf(kHeader + std::string(100000, 'x') + ",1,12\n");
  EXPECT_TRUE(says(cell, "xxx... (100000 bytes)\" is not a number"));
  EXPECT_LT(std::max(many.size(), cell.size()), 1000U);
}

TEST_F(Csv, ABagInAPipeIsToldApart) {
  EXPECT_TRUE(says(errorOf("#ROSBAG V2.0\nE"), "this is a bag, which is read from a file"));
}

TEST_F(Csv, ANameThatIsNoUtf8IsShownByItsCodes) {
  std::ofstream(folder_ / "a\xFF\n.csv") << kHeader << "0,1,12\n";
  EXPECT_EQ(readCsv(folder_ / "a\xFF\n.csv").name, "a\\xff\\n.csv");
}

TEST_F(Csv, EmptyFileIsRefusedWithTheColumnsExpected) {
  const std::string message = errorOf("");
  EXPECT_TRUE(says(message, "is empty"));
  EXPECT_TRUE(says(message, "time_s, current_a, voltage_v"));
  EXPECT_TRUE(says(errorOf("\n \n\r\n"), "is empty"));
}

TEST_F(Csv, HeaderAloneIsRefused) { EXPECT_TRUE(says(errorOf(kHeader), "no sample")); }

TEST_F(Csv, MissingColumnIsNamedWithTheColumnsTheFileHas) {
  const std::string message = errorOf("Clock,I,U\n0,1,12\n");
  EXPECT_TRUE(says(message, "no column \"time_s\""));
  EXPECT_TRUE(says(message, "its columns are: Clock, I, U"));
}

TEST_F(Csv, ColumnsOfCommonNamesAreReadAndSaid) {
  for (const char* header : {"Time(s),Cycle,Current(A),Voltage(V)", "t,n,i,u",
                             "TIMESTAMP,x,amps,Vbat", "t_s,engine_rpm,current_A,voltage_V"}) {
    std::ofstream(path_, std::ios::binary) << header << "\n0,7,-5,12.5\n0.5,7,-6,12.4\n";
    std::vector<std::string> notes;
    const Recording recording = readCsv(path_, {}, {}, &notes);
    EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 0.5})) << header;
    EXPECT_EQ(recording.series.current, (std::vector<double>{-5.0, -6.0})) << header;
    EXPECT_EQ(recording.series.voltage, (std::vector<double>{12.5, 12.4})) << header;
    ASSERT_EQ(notes.size(), 3U) << header;
    EXPECT_TRUE(says(notes[1], "current is read from column"));
  }
}

TEST_F(Csv, OfTwoColumnsThatMayBeMeantNoneIsTaken) {
  const std::string message = errorOf("time_s,current_a,v,Vbat\n0,1,12,12\n");
  EXPECT_TRUE(says(message, "v, Vbat may be the voltage: name one with --voltage-column"));
}

TEST_F(Csv, AColumnThatIsAskedForIsNotReplacedByACommonName) {
  CsvColumns columns;
  columns.current = "shunt";
  EXPECT_TRUE(says(errorOf("time_s,current,voltage_v\n0,1,12\n", columns), "no column \"shunt\""));
}

TEST_F(Csv, TheUnitOfTimeIsReadFromItsColumnsName) {
  const Recording recording = read("time_ms,current,voltage\n1000,1,12\n1500,1,12\n");
  EXPECT_EQ(recording.series.time, (std::vector<double>{1.0, 1.5}));
  const Recording stamps = read("timestamp_ns,i,u\n1000000000,1,12\n1500000000,1,12\n");
  EXPECT_EQ(stamps.series.time, (std::vector<double>{1.0, 1.5}));
  CsvColumns seconds;
  seconds.time_unit = 1.0;
  EXPECT_EQ(read("time_ms,i,u\n1,1,12\n2,1,12\n", seconds).series.time,
            (std::vector<double>{1.0, 2.0}))
      << "a unit that is given is not replaced";
  CsvColumns named;
  named.time = "systems";
  EXPECT_EQ(read("systems,i,u\n1,1,12\n2,1,12\n", named).series.time,
            (std::vector<double>{1.0, 2.0}))
      << "nor is that of a column that is asked for";
}

TEST_F(Csv, TimesThatCountFrom1970AreRecognisedByTheirSizeAndSaid) {
  for (const auto& [first, second, unit] :
       {std::tuple<const char*, const char*, const char*>{"1700000000", "1700000000.5", " seconds"},
        {"1700000000000", "1700000000500", "milliseconds"},
        {"1700000000000000", "1700000000500000", "microseconds"},
        {"1700000000000000000", "1700000000500000000", "nanoseconds"}}) {
    std::ofstream(path_, std::ios::binary) << kHeader << first << ",1,12\n" << second << ",1,12\n";
    std::vector<std::string> notes;
    const Recording recording = readCsv(path_, {}, {}, &notes);
    EXPECT_NEAR(recording.series.time.at(0), 1.7e9, 1e-6) << unit;
    EXPECT_NEAR(recording.series.time.at(1), 1.7e9 + 0.5, 1e-6) << unit;
    ASSERT_EQ(notes.size(), 1U) << unit;
    EXPECT_TRUE(says(notes[0], unit)) << notes[0];
    EXPECT_TRUE(says(notes[0], "2023-11-14 22:13:20 UTC")) << notes[0];
  }
}

TEST_F(Csv, AClockThatDoesNotCountFrom1970StaysAsItIs) {
  EXPECT_EQ(read("time_ms,i,u\n1700000000,1,12\n1700000500,1,12\n").series.time,
            (std::vector<double>{1700000.0, 1700000.5}))
      << "the name says milliseconds, and twenty days of them are a time";
  EXPECT_EQ(read(std::string(kHeader) + "86400,1,12\n86401,1,12\n").series.time.front(), 86400.0);
  CsvColumns given;
  given.time_unit = 1e-3;
  EXPECT_EQ(read("t,i,u\n1700000000,1,12\n1700000001,1,12\n", given).series.time.front(), 1.7e6)
      << "a unit that is given is not replaced";
}

TEST_F(Csv, CommentsTabsAndARowOfUnitsArePassedOver) {
  const Recording recording = read(
      "# made by a logger\ntime\tcurrent\tvoltage\ns\tA\tV\n0\t1\t12\n# a pause\n1\t2\t12.5\n");
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 1.0}));
  EXPECT_EQ(recording.series.current, (std::vector<double>{1.0, 2.0}));
  EXPECT_TRUE(says(errorOf("time_s,current_a,voltage_v\n0,1,12\ns,A,V\n"), "is not a number"));
  EXPECT_EQ(
      read("% made by\n// a logger\ntime_s,current_a,voltage_v\n0,1,12\n  % a pause\n1,2,12\n")
          .series.size(),
      2U);
}

TEST_F(Csv, FileWithAnotherSeparatorIsToldApart) {
  EXPECT_TRUE(says(errorOf("time_s|current_a|voltage_v\n0|1|12\n"), "not look comma-separated"));
}

TEST_F(Csv, SemicolonsAndDecimalCommasAreRead) {
  const Recording recording = read(
      "time_s;current_a;voltage_v;temperature_c\n0;-5,5;12,5;20,5\n0,01;-6.25;\"12,4\";\n0,02;;12,"
      "4;\n");
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 0.01}));
  EXPECT_EQ(recording.series.current, (std::vector<double>{-5.5, -6.25}));
  EXPECT_EQ(recording.series.voltage, (std::vector<double>{12.5, 12.4}));
  ASSERT_EQ(recording.series.temperature.size(), 1U);
  EXPECT_NEAR(recording.series.temperature[0], 293.65, 1e-9);
  EXPECT_EQ(recording.rejected.total(), 1U);
  const Recording dated =
      read("time_s;current_a;voltage_v\n2017-03-25 07:00:00,5;1;12\n2017-03-25 07:00:01,75;1;12\n");
  EXPECT_DOUBLE_EQ(dated.series.time[1] - dated.series.time[0], 1.25);
}

TEST_F(Csv, NumberWithThousandsAndADecimalCommaIsRefusedWithItsPlace) {
  const std::string message = errorOf("time_s;current_a;voltage_v\n0;1;1.012,5\n");
  EXPECT_TRUE(says(message, "line 2, column \"voltage_v\": \"1.012,5\" is not a number"))
      << message;
  EXPECT_TRUE(says(errorOf("time_s;current_a;voltage_v\n0;1;1,012,5\n"), "is not a number"));
}

TEST_F(Csv, SemicolonInAColumnsNameDoesNotSeparate) {
  EXPECT_EQ(read("\"state; engine\",time_s,current_a,voltage_v\n1,0,1,12\n").series.size(), 1U);
  EXPECT_EQ(read("state;engine,time_s,current_a,voltage_v\n1,0,1,12\n").series.size(), 1U);
  EXPECT_TRUE(says(errorOf("time_s,current_a,voltage_v\n0,\"1,5\",12\n"), "is not a number"));
}

TEST_F(Csv, ColumnThatIsThereTwiceIsRefusedOnlyWhenItIsRead) {
  EXPECT_TRUE(says(errorOf("time_s,current_a,voltage_v,voltage_v\n0,1,12,13\n"),
                   "has column \"voltage_v\" more than once"));
  EXPECT_EQ(read("Loop,time_s,current_a,Loop,voltage_v\n1,0,1,1,12\n").series.size(), 1U);
}

TEST_F(Csv, FileThatIsNotSortedIsRefused) {
  std::string text = kHeader;
  for (int k = 0; k < 20; ++k) text += std::to_string((k * 7) % 20) + ",1,12\n";
  EXPECT_TRUE(says(errorOf(text), "not sorted by time"));
}

TEST_F(Csv, FileWithoutAUsableSampleIsRefusedWithTheReasons) {
  const std::string message = errorOf(std::string(kHeader) + "0,,12\n1,nan,12\n2,inf,12\n");
  EXPECT_TRUE(says(message, "no usable sample"));
  EXPECT_TRUE(says(message, "2 lack a value"));
  EXPECT_TRUE(says(message, "1 are not finite"));
}

// ---------------------------------------------------------------------------------------------
// rows and cells

TEST_F(Csv, TextInsteadOfANumberIsNamedWithFileLineColumnAndText) {
  const std::string message = errorOf(std::string(kHeader) + "0,-5,12.5\n\n1,12.5V,12.4\n");
  EXPECT_TRUE(says(message, path_.string()));
  EXPECT_TRUE(says(message, "line 4"));
  EXPECT_TRUE(says(message, "column \"current_a\""));
  EXPECT_TRUE(says(message, "\"12.5V\" is not a number"));
}

TEST_F(Csv, HexadecimalIsNotANumber) {
  EXPECT_TRUE(says(errorOf(std::string(kHeader) + "0,0x10,12\n"), "\"0x10\" is not a number"));
}

TEST_F(Csv, RowWithTooManyOrTooFewCellsIsNamedWithItsLine) {
  const std::string header = kHeader;
  EXPECT_TRUE(
      says(errorOf(header + "0,1,12\n1,1,12,9\n"), "line 3: has 4 cells, the header has 3"));
  EXPECT_TRUE(says(errorOf(header + "0,1\n1,1,12\n"), "line 2: has 2 cells, the header has 3"));
}

TEST_F(Csv, LastLineCutOffWhileWritingIsAMissingValue) {
  const Recording recording = read(std::string(kHeader) + "0,1,12\n1,1,12\n2,1");
  EXPECT_EQ(recording.series.size(), 2U);
  EXPECT_EQ(recording.rejected.missing_value, 1U);
}

TEST_F(Csv, EmptyNotANumberAndInfiniteCellsAreCountedNotUsed) {
  const Recording recording =
      read(std::string(kHeader) +
           "0,-5,12.5\n1,,12.5\n2,-5,NaN\n3,nan,nan\n4,inf,12\n5,-5,-inf\n,1,12\n6,-5,12\n");
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 6.0}));
  EXPECT_EQ(recording.rejected.missing_value, 4U);
  EXPECT_EQ(recording.rejected.not_finite, 2U);
  EXPECT_EQ(recording.offered, 8U);
}

TEST_F(Csv, ValueNoBatterySensorShowsIsCountedNotUsed) {
  const Recording recording = read(std::string(kHeader) + "0,-5,12.5\n1,65535,12.5\n");
  EXPECT_EQ(recording.series.size(), 1U);
  EXPECT_EQ(recording.rejected.out_of_range, 1U);
}

TEST_F(Csv, SmallClockStepBackAndRepeatedStampsAreCountedNotUsed) {
  std::string text = kHeader;
  for (int k = 0; k < 30; ++k) text += std::to_string(k) + ",1,12\n";
  const Recording recording = read(text + "27.5,1,12\n29,1,12\n30,1,12\n");
  EXPECT_EQ(recording.series.size(), 31U);
  EXPECT_EQ(recording.rejected.clock_step_back, 1U);
  EXPECT_EQ(recording.rejected.duplicate_stamp, 1U);
  EXPECT_DOUBLE_EQ(recording.largest_step_back, 1.5);
}

TEST_F(Csv, ByteOrderMarkCarriageReturnsQuotesSpacesBlankLinesAndATrailingCommaAreUnderstood) {
  const Recording recording = read(
      "\xEF\xBB\xBF\"time_s\", current_a ,\"voltage_v\",\"remark\"\r\n"
      "\r\n"
      " 0 ,\"-5\", 12.5 ,\"cold, dark\"\r\n"
      "1,\t-6,\" 12.25 \",,\r\n");
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 1.0}));
  EXPECT_EQ(recording.series.current, (std::vector<double>{-5.0, -6.0}));
  EXPECT_EQ(recording.series.voltage, (std::vector<double>{12.5, 12.25}));
}

TEST_F(Csv, ExponentsSignsAndBareFractionsAreNumbers) {
  const Recording recording = read(std::string(kHeader) + "1e-2,+1.5E1,.125e2\n");
  EXPECT_EQ(recording.series.time.front(), 0.01);
  EXPECT_EQ(recording.series.current.front(), 15.0);
  EXPECT_EQ(recording.series.voltage.front(), 12.5);
}

TEST_F(Csv, LastLineNeedsNoLineBreak) {
  EXPECT_EQ(read(std::string(kHeader) + "0,1,12\n1,1,12").series.size(), 2U);
}

// ---------------------------------------------------------------------------------------------
// other files' columns

TEST_F(Csv, NamedColumnsAreReadAndDischargePositiveIsTurnedRound) {
  CsvColumns columns;
  columns.time = "Time(s)";
  columns.current = "I";
  columns.voltage = "U";
  columns.discharge_positive = true;
  const Recording recording = read("Step,Time(s),U,I\nA,0,12.5,7\nB,1,12.4,-3\n", columns);
  EXPECT_EQ(recording.series.current, (std::vector<double>{-7.0, 3.0}));
  EXPECT_EQ(recording.series.voltage, (std::vector<double>{12.5, 12.4}));
}

TEST_F(Csv, TemperatureIsReadInKelvinWhenTheFileHasIt) {
  const Recording recording =
      read("time_s,current_a,voltage_v,temperature_c\n0,1,12,25\n1,1,12,\n2,1,12,-10\n");
  EXPECT_EQ(recording.series.temperature_time, (std::vector<double>{0.0, 2.0}));
  EXPECT_DOUBLE_EQ(recording.series.temperature[0], 298.15);
  EXPECT_DOUBLE_EQ(recording.series.temperature[1], 263.15);
}

TEST_F(Csv, TemperatureColumnThatWasAskedForMustBeThere) {
  CsvColumns columns;
  columns.temperature = "temp";
  EXPECT_TRUE(says(errorOf(std::string(kHeader) + "0,1,12\n", columns), "no column \"temp\""));
}

TEST_F(Csv, RowsWithATemperatureAloneFillTheTemperatureAndAreNoSamples) {
  const Recording recording =
      read("time_s,current_a,voltage_v,temperature_c\n0,1,12,\n0.5,,,25\n1,1,12,\n1.5,,,26\n");
  EXPECT_EQ(recording.series.time, (std::vector<double>{0.0, 1.0}));
  EXPECT_EQ(recording.series.temperature_time, (std::vector<double>{0.5, 1.5}));
  EXPECT_EQ(recording.offered, 2U);
  EXPECT_EQ(recording.rejected.total(), 0U);
}

TEST_F(Csv, DateTimesBecomeSecondsSince1970) {
  const Recording recording = read(std::string(kHeader) +
                                   "1970-01-02 00:00:01,1,12\n"
                                   "2000-02-29T12:00:00Z,1,12\n"
                                   "2017-03-25 07:00:06.900,1,12\n");
  EXPECT_DOUBLE_EQ(recording.series.time[0], 86401.0);
  // date -u -d '2000-02-29 12:00:00' +%s, and the same for the next
  EXPECT_DOUBLE_EQ(recording.series.time[1], 951825600.0);
  EXPECT_DOUBLE_EQ(recording.series.time[2], 1490425206.9);
}

TEST_F(Csv, WrongDatesAreText) {
  for (const char* time :
       {"2017-13-25 07:00:06", "2017-03-32 07:00:06", "2017-03-25 07:60:06", "2017-03-25 07:00:61",
        "2017-03-25", "25.03.2017 07:00:06", "07:00:06", "2017-03-25 07:00:06 CET",
        "2017-02-29 07:00:06", "1900-02-29 07:00:06", "2017-04-31 07:00:06", "2017-03-25 24:00:01",
        "2017-00-25 07:00:06", "2017-03-00 07:00:06"}) {
    EXPECT_TRUE(
        says(errorOf(std::string(kHeader) + time + ",1,12\n"), "is not a number of seconds"))
        << time;
  }
}

// ---------------------------------------------------------------------------------------------
// writing

TEST_F(Csv, WrittenSeriesReadsBackExactly) {
  Series series;
  series.time = {0.1, 0.30000000000000004, 1490425206.9, 1490425206.9000003};
  series.current = {-1.0 / 3.0, 1e-17, -249.99999999999997, 0.0};
  series.voltage = {12.499999999999998, 12.1, std::nextafter(12.1, 13.0), 14.4};
  series.temperature_time = {0.05, 0.1, 7.0, 2e9};
  series.temperature = {298.15, std::nextafter(298.15, 300.0), 263.0 + 1.0 / 3.0, 273.15};
  writeCsv(path_, series);
  const Series back = readCsv(path_).series;
  EXPECT_EQ(back.time, series.time);
  EXPECT_EQ(back.current, series.current);
  EXPECT_EQ(back.voltage, series.voltage);
  EXPECT_EQ(back.temperature_time, series.temperature_time);
  EXPECT_EQ(back.temperature, series.temperature);
}

TEST_F(Csv, WrittenFileUsesTheFewestDigitsAndOneRowPerTime) {
  Series series;
  series.time = {0.0, 0.1};
  series.current = {-5.5, 0.1};
  series.voltage = {12.6, 12.7};
  series.temperature_time = {0.05, 0.1};
  series.temperature = {25.264 + 273.15, 26.0 + 273.15};
  writeCsv(path_, series);
  std::ifstream file(path_);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(text,
            "time_s,current_a,voltage_v,temperature_c\n"
            "0,-5.5,12.6,\n"
            "0.05,,,25.264\n"
            "0.1,0.1,12.7,26\n");
}

TEST_F(Csv, WritingIntoAMissingFolderIsARecordingErrorAndLeavesNothing) {
  EXPECT_THROW(writeCsv(folder_ / "missing" / "out.csv", {}), RecordingError);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 0);
}

TEST(FormatExactly, TakesFifteenDigitsWhenTheyAreEnoughAndSeventeenWhenNot) {
  EXPECT_EQ(formatExactly(0.1), "0.1");
  EXPECT_EQ(formatExactly(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(formatExactly(-250.0), "-250");
}

// ---------------------------------------------------------------------------------------------
// real recordings

class RealCsv : public ::testing::Test {
 protected:
  static Recording read(const std::string& name, const CsvColumns& columns) {
    return readCsv(fs::path(BATTERY_SOF_SOURCE_DIR "/../shared/data") / name, columns);
  }
  void SetUp() override {
    if (!fs::exists(BATTERY_SOF_SOURCE_DIR "/../shared/data")) {
      GTEST_SKIP() << "no recordings in ../shared/data";
    }
  }
};

TEST_F(RealCsv, StartStopDriveKeepsEverySampleButThoseBehindTheClockSteps) {
  const Recording recording = read("startstop_car/drive_2.csv",
                                   {"t_s", "current_A", "voltage_V", std::string("temp_C"), false});
  EXPECT_EQ(recording.offered, 19098U);
  EXPECT_EQ(recording.rejected.clock_step_back, 2U);
  EXPECT_EQ(recording.rejected.duplicate_stamp, 2U);
  EXPECT_DOUBLE_EQ(recording.largest_step_back, 2.0);
  EXPECT_EQ(recording.series.temperature.size(), recording.series.size());
}

TEST_F(RealCsv, SolarRecordingHasTemperaturesOnRowsOfTheirOwn) {
  const Recording recording = read(
      "solar_vrla/ten_days.csv", {"time", "current", "voltage", std::string("temperature"), true});
  EXPECT_EQ(recording.offered, 12726U);
  EXPECT_DOUBLE_EQ(recording.series.time.front(), 1490425206.9);
  EXPECT_LT(recording.series.current.front(), 0.0);
  EXPECT_GT(recording.series.temperature.size(), 400U);
}

TEST_F(RealCsv, CellTesterFileIsReadThoughOtherHeadersRepeat) {
  const Recording recording =
      read("leaf_cell/hppc_25c.csv", {"Time(s)", "Current(A)", "Voltage(V)", std::nullopt, false});
  EXPECT_EQ(recording.series.size(), 13248U);
  EXPECT_EQ(recording.rejected.total(), 0U);
}

TEST_F(Csv, ATimeColumnMayCountMillisecondsButADateDoesNot) {
  CsvColumns columns;
  columns.time_unit = 1e-3;
  const Recording counted = read(std::string(kHeader) + "1000,1,12\n1500,1,12\n", columns);
  EXPECT_EQ(counted.series.time, (std::vector<double>{1.0, 1.5}));
  const Recording dated =
      read(std::string(kHeader) + "2017-03-25 07:00:06,1,12\n2017-03-25 07:00:07,1,12\n", columns);
  EXPECT_EQ(dated.series.time[1] - dated.series.time[0], 1.0);
}

}  // namespace
}  // namespace battery_sof

#include "recording/csv_units.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "battery_sof/csv.hpp"

namespace battery_sof {
namespace {

namespace fs = std::filesystem;

class CsvUnits : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    path_ = fs::path(::testing::TempDir()) / (std::string("units ") + test->name() + ".csv");
  }
  void TearDown() override { fs::remove(path_); }

  Recording read(const std::string& content, const CsvColumns& columns = {}) {
    std::ofstream(path_, std::ios::binary) << content;
    notes_.clear();
    return readCsv(path_, columns, {}, &notes_);
  }
  std::string errorOf(const std::string& content) {
    try {
      read(content);
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  }
  std::string profileErrorOf(const std::string& content) {
    std::ofstream(path_, std::ios::binary) << content;
    try {
      readProfileCsv(path_, {}, [](double, double, std::size_t) {});
    } catch (const RecordingError& error) {
      return error.what();
    }
    return "";
  }
  bool isNoted(const std::string& part) const {
    for (const std::string& note : notes_)
      if (note.find(part) != std::string::npos) return true;
    return false;
  }

  fs::path path_;
  std::vector<std::string> notes_;
};

::testing::AssertionResult says(const std::string& message, const std::string& part) {
  if (message.find(part) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << '"' << message << "\" does not say \"" << part << '"';
}

/// The second row of a file whose rows are of 0 and 0.5 s, -5 A and 12.5 V.
void expectSecond(const Recording& recording) {
  ASSERT_EQ(recording.series.size(), 2U);
  EXPECT_DOUBLE_EQ(recording.series.time[1], 0.5);
  EXPECT_DOUBLE_EQ(recording.series.current[1], -5.0);
  EXPECT_DOUBLE_EQ(recording.series.voltage[1], 12.5);
}

TEST_F(CsvUnits, ARowOfUnitsBelowTheHeaderIsUsedAndNoted) {
  expectSecond(read("time,current,voltage\nms,mA,mV\n0,0,12600\n500,-5000,12500\n"));
  EXPECT_TRUE(isNoted("time is taken to count ms, by the row of units below the header"));
  EXPECT_TRUE(isNoted("current is taken to count mA, by the row"));
  EXPECT_TRUE(isNoted("voltage is taken to count mV, by the row"));
  expectSecond(read("time,current,voltage\n[\xC2\xB5s],[kA],[V]\n0,0,12.6\n5e5,-0.005,12.5\n"));
  const Recording warm =
      read("time,current,voltage,temp\nmin,A,V,K\n0,0,12.6,290\n0.5,-5,12.5,291\n");
  EXPECT_DOUBLE_EQ(warm.series.time[1], 30.0);
  EXPECT_DOUBLE_EQ(warm.series.temperature[1], 291.0);
  EXPECT_DOUBLE_EQ(read("time,current,voltage,temp\nh,A,V,\xC2\xB0"
                        "C\n0,0,12.6,20\n1,-5,12.5,21\n")
                       .series.temperature[1],
                   294.15);
}

TEST_F(CsvUnits, AnUnknownUnitIsRefusedWithItsColumnAndText) {
  const std::string message = errorOf("time,current,voltage\ns,dA,V\n0,0,12.6\n");
  EXPECT_TRUE(says(message, "line 2, column \"current\": \"dA\" is not a unit of current"));
  EXPECT_TRUE(says(message, "expected one of A, mA, kA"));
  EXPECT_TRUE(says(errorOf("time,current,voltage,temp\ns,A,V,F\n0,0,12.6,70\n"),
                   "\"F\" is not a unit of temperature"));
}

TEST_F(CsvUnits, AUnitThatContradictsTheColumnsNameIsRefused) {
  EXPECT_TRUE(says(errorOf("time,current [A],voltage\ns,mA,V\n0,0,12.6\n"),
                   "\"mA\" is not the unit in the column's name, A"));
}

TEST_F(CsvUnits, UnitsInNamesOfColumnsAreUsedAndNoted) {
  for (const char* header :
       {"time_ms,current_ma,voltage_mv", "Time (ms),Current [mA],Voltage (mV)",
        "millis,I_batt [mA],u_mV", "timestamp.ms,battery current/mA,Vbat mV", "tms,ima,ubatmv"}) {
    expectSecond(read(std::string(header) + "\n0,0,12600\n500,-5000,12500\n"));
    EXPECT_TRUE(isNoted("time is taken to count ms, by its column's name")) << header;
    EXPECT_TRUE(isNoted("current is taken to count mA, by its column's name")) << header;
    EXPECT_TRUE(isNoted("voltage is taken to count mV, by its column's name")) << header;
  }
}

TEST_F(CsvUnits, AColumnThatIsAskedForKeepsTheUnitInItsName) {
  CsvColumns columns{"log_time_ms", "shunt [mA]", "clamp (mV)", std::nullopt, false};
  const std::string content = "log_time_ms,shunt [mA],clamp (mV)\n0,0,12600\n500,-5000,12500\n";
  expectSecond(read(content, columns));
  columns.time_unit = 1e-6;
  EXPECT_DOUBLE_EQ(read(content, columns).series.time[1], 5e-4) << "a unit that is given wins";
  columns.time_unit = 1.0;
  EXPECT_DOUBLE_EQ(
      read("log_time_ms,shunt [mA],clamp (mV)\nms,mA,mV\n0,0,12600\n500,-5000,12500\n", columns)
          .series.time[1],
      500.0);
}

TEST_F(CsvUnits, ATextInBracketsThatIsNoUnitIsNoted) {
  const CsvColumns columns{"time_s", "current (front)", "voltage_v", std::nullopt, false};
  EXPECT_EQ(read("time_s,current (front),voltage_v\n0,-5,12.5\n", columns).series.current[0], -5.0);
  EXPECT_TRUE(
      isNoted("current is taken to count A: \"front\" in its column's name is none of A, mA"));
}

TEST_F(CsvUnits, SecondsThatNothingNamesAreNotedWhereTheRowsAreASecondApartOrMore) {
  read("t,i,u\n0,1,12\n10,1,12\n20,1,12\n");
  EXPECT_TRUE(isNoted("the name of column \"t\" has no unit: rows are 10 s apart"));
  EXPECT_TRUE(isNoted("--time-unit"));
  for (const char* content :
       {"t_s,i,u\n0,1,12\n10,1,12\n", "t,i,u\ns,A,V\n0,1,12\n10,1,12\n",
        "t,i,u\n0,1,12\n0.01,1,12\n", "t,i,u\n1700000000,1,12\n1700000010,1,12\n",
        "t,i,u\n2017-03-25 07:00:06,1,12\n2017-03-25 07:00:16,1,12\n"}) {
    read(content);
    EXPECT_FALSE(isNoted("has no unit")) << content;
  }
}

// ---------------------------------------------------------------------------------------------
// what other programs write

TEST_F(CsvUnits, CommonNamesOfLoggersAreRead) {
  for (const char* header : {"elapsed_time,I_batt [A],U_batt [V]", "Elapsed Time (s),amp,volt",
                             "datetime,amps,volts", "date_time,Amps [A],Battery Voltage"})
    expectSecond(read(std::string(header) + "\n0,0,12.6\n0.5,-5,12.5\n"));
}

TEST_F(CsvUnits, TabsWithDecimalCommasAreRead) {
  expectSecond(read("time_s\tcurrent_a\tvoltage_v\n0\t0\t12,6\n0,5\t-5,0\t12,5\n"));
}

TEST_F(CsvUnits, TheLastCommentAboveNumbersIsTheHeader) {
  for (const char* mark : {"# ", "%", "// ", "#"}) {
    expectSecond(read("# of a logger, made, today\n" + std::string(mark) +
                      "time,current,voltage\n0,0,12.6\n0.5,-5,12.5\n"));
    expectSecond(read(std::string(mark) + "time_ms;current;voltage\n0;0;12,6\n500;-5;12,5\n"));
  }
  expectSecond(read("# not, a, header\ntime_s,current_a,voltage_v\n0,0,12.6\n0.5,-5,12.5\n"));
  EXPECT_TRUE(says(errorOf("# made by a logger\n0,1,12\n"), "has no column \"time_s\""));
}

TEST_F(CsvUnits, DatesMayHaveAnOffsetFromUtc) {
  const auto timeOf = [this](const std::string& date) {
    return read("datetime,current_a,voltage_v\n" + date + ",1,12\n").series.time.at(0);
  };
  const double utc = timeOf("2017-03-25T07:00:06.9Z");
  for (const char* date : {"2017-03-25T08:00:06.9+01:00", "2017-03-25 02:00:06.9-0500",
                           "2017-03-25 12:30:06.9 +05:30", "2017-03-25 08:00:06.9+01"})
    EXPECT_DOUBLE_EQ(timeOf(date), utc) << date;
  for (const char* date : {"2017-03-25 07:00:06+1", "2017-03-25 07:00:06+25:00",
                           "2017-03-25 07:00:06+01:75", "2017-03-25 07:00:06+-1:00"})
    EXPECT_TRUE(says(errorOf(std::string("datetime,current_a,voltage_v\n") + date + ",1,12\n"),
                     "is not a number of seconds or a date"))
        << date;
}

TEST_F(CsvUnits, AProfileIsAdvisedWhatItsCommandsHave) {
  const std::string missing = profileErrorOf("clock,current_a\n0,1\n");
  EXPECT_TRUE(says(missing, "rename that of the time to time_s"));
  EXPECT_FALSE(says(missing, "--time-column"));
  const std::string twice = profileErrorOf("time_s,amps,i\n0,1,1\n");
  EXPECT_TRUE(says(twice, "amps, i may be the current: rename that of the current to current_a"));
}

}  // namespace
}  // namespace battery_sof

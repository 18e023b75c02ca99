#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "simulator/generator/law_injection.hpp"
#include "simulator/generator/law_scenario.hpp"
#include "support/drawn_scenarios.hpp"

namespace battery_sof_simulator {
namespace {

class DrawLaw : public DrawInFolder {
 protected:
  int draw(std::vector<std::string> more) {
    more.insert(more.end(), {"--duration", "240", "--rate", "10"});
    return DrawInFolder::draw(more);
  }
};

TEST_F(DrawLaw, ListsKindsMechanismsAndLaws) {
  EXPECT_EQ(run({"--list"}), 0);
  EXPECT_NE(out_.find("control - -\ncontrol_with_recorder - -\n"), std::string::npos);
  EXPECT_NE(out_.find("out_of_catalogue acid pore_diffusion\n"), std::string::npos);
  EXPECT_NE(out_.find("out_of_catalogue instrument dead_band\n"), std::string::npos);
}

TEST_F(DrawLaw, TheSameOptionsGiveTheSameBytes) {
  const std::vector<std::string> options{"--kind",    "out_of_catalogue", "--mechanism",
                                         "structure", "--seed",           "9"};
  ASSERT_EQ(draw(options), 0) << err_;
  const std::string recording_once = contentOf(recording()), label_once = contentOf(label());
  ASSERT_EQ(draw(options), 0);
  EXPECT_EQ(contentOf(recording()), recording_once);
  EXPECT_EQ(contentOf(label()), label_once);
}

/// The currents of two laws under one seed: without a voltage limit's say they are the same.
TEST_F(DrawLaw, AnIndependentDriveIsTheSameForEveryLaw) {
  const auto driveOf = [](const std::string& mechanism, bool is_independent) {
    Order order;
    order.what = {kOutOfCatalogue, "", mechanism};
    order.seed = 4;
    order.duration = 240.0;
    order.rate = 10.0;
    order.independent_drive = is_independent;
    const LawScenario one = drawLawScenario(order);
    EXPECT_EQ(0, one.attempt) << mechanism;
    std::vector<double> numbers = {one.scenario.voltage_limit, one.scenario.battery.u0_v,
                                   one.scenario.battery.beta_per_v};
    for (const Insert& insert : one.scenario.inserts) {
      numbers.push_back(insert.at);
      for (const Phase& phase : insert.phases) numbers.push_back(phase.begin);
    }
    return numbers;
  };
  EXPECT_EQ(driveOf("structure", true), driveOf("ageing", true));
  EXPECT_NE(driveOf("structure", false), driveOf("ageing", false));
}

TEST_F(DrawLaw, AnIndependentDriveMayLastAMinuteAndItsRateIsTheSeeds) {
  std::set<double> rates;
  for (int seed = 1; seed <= 6; ++seed) {
    ASSERT_EQ(DrawInFolder::draw({"--kind", "control", "--independent-drive", "--duration", "60",
                                  "--seed", std::to_string(seed)}),
              0)
        << err_;
    rates.insert(nlohmann::json::parse(contentOf(label()))["sample_rate_hz"].get<double>());
  }
  EXPECT_GE(rates.size(), 2u);
}

TEST_F(DrawLaw, TheRecordingHasNothingOfTheLabel) {
  ASSERT_EQ(draw({"--kind", "control_with_recorder", "--seed", "2"}), 0) << err_;
  const std::string rows = contentOf(recording());
  EXPECT_EQ(rows.find("time_s,current_a,voltage_v\n0,"), 0u);
  EXPECT_EQ(rows.find_first_not_of("0123456789.,-+e\n", rows.find('\n')), std::string::npos);
}

TEST_F(DrawLaw, TheLabelSaysWhatIsTrue) {
  ASSERT_EQ(draw({"--kind", "out_of_catalogue", "--mechanism", "acid", "--id", "separator_delay",
                  "--seed", "4"}),
            0)
      << err_;
  const auto json = nlohmann::json::parse(contentOf(label()));
  EXPECT_EQ(json["kind"], "out_of_catalogue");
  EXPECT_EQ(json["mechanism"], "acid");
  EXPECT_EQ(json["id"], "separator_delay");
  EXPECT_EQ(json["duration_s"], 240.0);
  EXPECT_GT(json["visible_rms_v"]["training"].get<double>(), 4e-3);
  EXPECT_GT(json["rms_v"]["holdout"].get<double>(), 0.0);
  EXPECT_GT(json["noise"]["voltage_white_v"].get<double>(), 0.0);
  ASSERT_EQ(draw({"--kind", "control", "--seed", "4"}), 0) << err_;
  const auto control = nlohmann::json::parse(contentOf(label()));
  EXPECT_TRUE(control["mechanism"].is_null());
  EXPECT_EQ(control["strength"], 0.0);
  EXPECT_EQ(control["visible_rms_v"]["training"], 0.0);
}

class IntoARecording : public DrawLaw {
 protected:
  IntoARecording() {
    std::ofstream file(measured());
    file << "time_s,current_a,voltage_v\n";
    for (int n = 0; n < 600; ++n)
      file << n << "," << (n / 20 % 3 - 1) * 30 << "," << 12.7 + (n / 20 % 3 - 1) * 0.2 << "\n";
  }
  std::string measured() const { return path("measured.csv"); }
  int put(const std::string& mechanism, const std::string& id, const std::string& strength) {
    return run({"--into", measured(), "--mechanism", mechanism, "--id", id, "--seed", "3",
                "--strength", strength, "--out", recording()});
  }
  std::vector<RecordedSample> after(const std::string& mechanism, const std::string& id,
                                    const std::string& strength) {
    EXPECT_EQ(put(mechanism, id, strength), 0) << err_;
    return readRecording(recording());
  }
};

TEST_F(IntoARecording, StrengthZeroLeavesTheRecordingAsItIs) {
  const auto before = readRecording(measured());
  for (const char* form :
       {"structure conducting_film", "instrument dead_band", "side_reactions impurity_shuttle"}) {
    const std::string both = form;
    const auto at = both.find(' ');
    const auto now = after(both.substr(0, at), both.substr(at + 1), "0");
    ASSERT_EQ(now.size(), before.size());
    for (std::size_t n = 0; n < now.size(); ++n) {
      EXPECT_NEAR(now[n].current, before[n].current, 1e-6) << form;
      EXPECT_NEAR(now[n].voltage, before[n].voltage, 1e-8) << form;
    }
  }
}

TEST_F(IntoARecording, PhysicsAddsToTheVoltageInProportionAndLeavesTheCurrent) {
  const auto before = readRecording(measured());
  const auto once = after("structure", "conducting_film", "1"),
             twice = after("structure", "conducting_film", "2");
  double largest = 0.0;
  for (std::size_t n = 0; n < before.size(); ++n) {
    EXPECT_NEAR(once[n].current, before[n].current, 1e-6);
    EXPECT_NEAR(twice[n].voltage - before[n].voltage, 2.0 * (once[n].voltage - before[n].voltage),
                1e-7);
    largest = std::max(largest, std::abs(once[n].voltage - before[n].voltage));
  }
  EXPECT_GT(largest, 1e-3);
}

TEST_F(IntoARecording, AnInstrumentShowsAnotherCurrent) {
  const auto now = after("instrument", "remanence", "1");
  double largest = 0.0;
  const auto before = readRecording(measured());
  for (std::size_t n = 0; n < now.size(); ++n)
    largest = std::max(largest, std::abs(now[n].current - before[n].current));
  EXPECT_GT(largest, 0.05);
  EXPECT_LE(largest, 0.5 + 1e-6);
}

TEST_F(IntoARecording, WhatIsWrongIsNamed) {
  EXPECT_EQ(put("structure", "no_such_law", "1"), 2);
  EXPECT_NE(err_.find("no law is \"structure no_such_law\""), std::string::npos);
  std::ofstream(measured()) << "time_s,current_a,voltage_v\n0,1,12\n1,x,12\n";
  EXPECT_EQ(put("structure", "conducting_film", "1"), 2);
  EXPECT_NE(err_.find("measured.csv:3: \"1,x,12\""), std::string::npos) << err_;
  std::ofstream(measured()) << "t,i,u\n0,1,12\n";
  EXPECT_EQ(put("structure", "conducting_film", "1"), 2);
  EXPECT_NE(err_.find("expected a header"), std::string::npos);
}

TEST_F(DrawLaw, WrongUsageIsSaidInASentence) {
  EXPECT_EQ(run({"--kind", "friend", "--out", recording(), "--label", label()}), 2);
  EXPECT_NE(err_.find("--list"), std::string::npos);
  EXPECT_EQ(run({"--seed", "1"}), 2);
  EXPECT_EQ(run({"--out", "case.txt", "--label", label()}), 2);
  EXPECT_EQ(run({"--kind", "control", "--rate", "7", "--out", recording(), "--label", label()}), 2);
  EXPECT_FALSE(std::filesystem::exists(recording()));
}

}  // namespace
}  // namespace battery_sof_simulator

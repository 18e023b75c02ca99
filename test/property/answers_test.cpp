#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include "support/answer_laws.hpp"
#include "support/known_model.hpp"

using namespace battery_sof;
using namespace battery_sof::test;

namespace {

// Some seconds. BATTERY_SOF_PROPERTY_MODELS and BATTERY_SOF_PROPERTY_SEED set other ones.
constexpr int kModels = 500;
constexpr int kSeed = 20260517;

int wanted(const char* name, int usual) {
  const char* other = std::getenv(name);
  return other ? std::atoi(other) : usual;
}

bool happens(Random& random, double share) { return random.uniform(0.0, 1.0) < share; }

/// Between two numbers above zero, every order of magnitude alike.
double magnitude(Random& random, double low, double high) {
  return low * std::pow(high / low, random.uniform(0.0, 1.0));
}

/// Inside the bounds, or at one of them.
double drawnParameter(Random& random, const ParameterInfo& info) {
  if (happens(random, 0.1)) return happens(random, 0.5) ? info.lower : info.upper;
  if (info.name == "u_dc") return random.uniform(11.5, 13.2) * (happens(random, 0.2) ? 2.0 : 1.0);
  return info.lower > 0.0 ? magnitude(random, info.lower, info.upper)
                          : random.uniform(info.lower, info.upper);
}

std::vector<std::string> drawnEffects(Random& random) {
  std::vector<std::string> ids;
  const auto& all = effectCatalogue();
  for (int wanted = static_cast<int>(random.uniform(0.0, 5.0)); wanted > 0; --wanted)
    for (const auto& id : withNeeds(
             all[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(all.size())))]
                 .id))
      if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
  return ids;
}

/// Any state that a drive can lead to.
void driveSomewhere(FittedModel& model, Random& random) {
  Simulation simulation = simulationOf(model);
  double current = 0.0;
  for (int n = static_cast<int>(random.uniform(0.0, 5.0)); n > 0; --n) {
    current = happens(random, 0.2) ? random.uniform(-400.0, -150.0) : random.uniform(-80.0, 80.0);
    simulation.hold(current, magnitude(random, 0.01, 600.0));
  }
  takeState(model, simulation, current);
}

FittedModel drawnModel(Random& random) {
  FittedModel model = knownModel(drawnEffects(random));
  const BatteryModel composition = compositionOf(model.fit);
  const double share = happens(random, 0.2) ? 0.0 : magnitude(random, 1e-4, 1.0);
  for (Eigen::Index j = 0; j < composition.parameterCount(); ++j) {
    const ParameterInfo& info = composition.parameters()[static_cast<std::size_t>(j)];
    ParameterEstimate& estimate = model.fit.estimates[static_cast<std::size_t>(j)];
    estimate.value = drawnParameter(random, info);
    estimate.std = j == kRowUDc ? 0.5 * share : share * std::abs(estimate.value);
    model.fit.covariance(j, j) = *estimate.std * *estimate.std;
  }
  takeEstimates(model.fit);
  model.fit.excited.max_voltage = random.uniform(13.0, 16.0);
  if (happens(random, 0.5))
    model.fit.noise = NoiseModel{magnitude(random, 1e-4, 0.1), magnitude(random, 1e-4, 0.1),
                                 magnitude(random, 0.1, 1000.0), magnitude(random, 1e-6, 0.01)};
  driveSomewhere(model, random);
  return model;
}

CrankingQuery drawnCrank(Random& random) {
  CrankingQuery query;
  query.i_load = happens(random, 0.1) ? 0.0 : -magnitude(random, 0.01, 500.0);
  query.t_stop = happens(random, 0.1) ? 0.0 : magnitude(random, 0.1, 86400.0);
  query.i_cranking = -magnitude(random, 1.0, 2000.0);
  query.t_cranking = magnitude(random, 0.01, 60.0);
  if (happens(random, 0.5)) query.u_required = random.uniform(0.0, 16.0);
  return query;
}

StopTimeQuery drawnStop(Random& random) {
  const CrankingQuery crank = drawnCrank(random);
  return {crank.i_load, crank.i_cranking, crank.t_cranking, random.uniform(0.0, 13.0)};
}

ChargeAcceptanceQuery drawnCharge(Random& random) {
  return {random.uniform(10.0, 17.0), magnitude(random, 0.1, 3600.0),
          happens(random, 0.5) ? 5000.0 : magnitude(random, 1.0, 500.0)};
}

/// What the sensor shows of a battery that is left alone [A].
double shownAlone(const Fit& fit) {
  for (const ParameterEstimate& estimate : fit.estimates)
    if (estimate.name == "current_offset") return estimate.value;
  return 0.0;
}

/// The highest voltage of a battery that is left alone for a while [V].
double highestAlone(const FittedModel& model, double duration) {
  Simulation simulation = simulationOf(model);
  const double none = shownAlone(model.fit);
  double highest = -HUGE_VAL, at = 0.0;
  for (double share : {0.0, 1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0}) {
    simulation.hold(none, share * duration - at);
    at = share * duration;
    highest = std::max(highest, simulation.voltage());
  }
  return highest;
}

/// How often a question was asked, how often its answer was valid, and how long the slowest took.
struct Tally {
  int asked = 0, valid = 0, negative = 0;
  double slowest = 0.0, total = 0.0;  // [s] of processor time
  std::string slowest_of;
};

std::string join(const Fit& fit) {
  std::string names;
  for (const auto& id : fit.effects) names += id + " ";
  return names;
}

/// The answer to a question, counted.
template <typename Ask>
auto counted(Tally& tally, const FittedModel& model, Ask ask) {
  const std::clock_t begun = std::clock();
  auto answer = ask();
  const double spent = static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC;
  ++tally.asked;
  tally.valid += answer.valid;
  tally.total += spent;
  if (spent > tally.slowest) {
    tally.slowest = spent;
    tally.slowest_of = "model " + std::to_string(tally.asked - 1) + " of " + join(model.fit);
  }
  return answer;
}

void print(const char* name, const Tally& tally) {
  std::printf("%d %s, %d valid, %d of these below 0; %.2f ms each, the slowest %.2f s (%s)\n",
              tally.asked, name, tally.valid, tally.negative,
              1e3 * tally.total / std::max(1, tally.asked), tally.slowest,
              tally.slowest_of.c_str());
}

}  // namespace

TEST(Answers, OfAnyModelInAnyStateToAnyQuestionKeepTheLawsOfAnswers) {
  Random random(wanted("BATTERY_SOF_PROPERTY_SEED", kSeed));
  Tally cranks, stops, charges;
  const int models = wanted("BATTERY_SOF_PROPERTY_MODELS", kModels);
  int above = 0;  // valid charges at a voltage that the battery alone does not reach
  for (int k = 0; k < models; ++k) {
    const FittedModel model = drawnModel(random);
    const double capacity = magnitude(random, 5.0, 300.0);
    const CrankingQuery crank = drawnCrank(random);
    const CrankingAnswer cranked =
        counted(cranks, model, [&] { return predictCranking(model, crank, capacity); });
    EXPECT_EQ(brokenLaw(cranked, model.fit), "")
        << "model " << k << " " << join(model.fit) << ": " << cranked.message;
    const StopTimeQuery stop = drawnStop(random);
    const StopTimeAnswer stopped =
        counted(stops, model, [&] { return predictStopTime(model, stop, capacity); });
    EXPECT_EQ(brokenLaw(stopped, stop, capacity), "")
        << "model " << k << " " << join(model.fit) << ": " << stopped.message;
    const ChargeAcceptanceQuery charge = drawnCharge(random);
    const ChargeAcceptanceAnswer charged =
        counted(charges, model, [&] { return predictChargeAcceptance(model, charge, capacity); });
    charges.negative += charged.valid && charged.i_boost->value < 0.0;
    if (charged.valid && charge.u_boost > highestAlone(model, charge.t_sof2)) {
      ++above;
      EXPECT_GE(charged.i_boost->value, 0.0)
          << "model " << k << " " << join(model.fit) << ": " << charged.message;
    }
    EXPECT_EQ(brokenLaw(charged, charge, capacity), "")
        << "model " << k << " " << join(model.fit) << ": " << charged.message;
  }
  print("cranks", cranks);
  print("stops", stops);
  print("charges", charges);
  EXPECT_GT(cranks.valid, models / 20);
  EXPECT_GT(stops.valid, models / 20);
  EXPECT_GT(charges.valid, models / 20);
  EXPECT_GT(above, models / 50);
}

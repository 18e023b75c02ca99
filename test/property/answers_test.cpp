#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>

#include "support/answer_laws.hpp"
#include "support/known_model.hpp"

using namespace battery_sof;
using namespace battery_sof::test;

namespace {

constexpr int kModels = 3000;  // some seconds; BATTERY_SOF_PROPERTY_MODELS sets another number

int modelsWanted() {
  const char* wanted = std::getenv("BATTERY_SOF_PROPERTY_MODELS");
  return wanted ? std::atoi(wanted) : kModels;
}

bool happens(Random& random, double share) { return random.uniform(0.0, 1.0) < share; }

/// Between two numbers above zero, every order of magnitude alike.
double magnitude(Random& random, double low, double high) { return low * std::pow(high / low, random.uniform(0.0, 1.0)); }

/// Inside the bounds, or at one of them.
double drawnParameter(Random& random, const ParameterInfo& info) {
  if (happens(random, 0.1)) return happens(random, 0.5) ? info.lower : info.upper;
  if (info.name == "u_dc") return random.uniform(11.5, 13.2) * (happens(random, 0.2) ? 2.0 : 1.0);
  return info.lower > 0.0 ? magnitude(random, info.lower, info.upper) : random.uniform(info.lower, info.upper);
}

std::vector<std::string> drawnEffects(Random& random) {
  std::vector<std::string> ids;
  const auto& all = effectCatalogue();
  for (int wanted = static_cast<int>(random.uniform(0.0, 5.0)); wanted > 0; --wanted)
    for (const auto& id : withNeeds(all[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(all.size())))].id))
      if (std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
  return ids;
}

/// Any state that a drive can lead to.
void driveSomewhere(FittedModel& model, Random& random) {
  Simulation simulation = simulationOf(model);
  double current = 0.0;
  for (int n = static_cast<int>(random.uniform(0.0, 5.0)); n > 0; --n) {
    current = happens(random, 0.2) ? random.uniform(-400.0, -150.0) : random.uniform(-80.0, 80.0);
    hold(simulation, current, magnitude(random, 0.01, 600.0));
  }
  takeState(model, simulation, current);
}

FittedModel drawnModel(Random& random) {
  FittedModel model = knownModel(drawnEffects(random));
  const BatteryModel composition = compositionOf(model);
  const double share = happens(random, 0.2) ? 0.0 : magnitude(random, 1e-4, 1.0);
  for (Eigen::Index j = 0; j < composition.parameterCount(); ++j) {
    const ParameterInfo& info = composition.parameters()[static_cast<std::size_t>(j)];
    ParameterEstimate& estimate = model.estimates[static_cast<std::size_t>(j)];
    estimate.value = drawnParameter(random, info);
    estimate.std = j == kRowUDc ? 0.5 * share : share * std::abs(estimate.value);
    model.covariance(j, j) = *estimate.std * *estimate.std;
  }
  takeEstimates(model);
  model.excited.max_voltage = random.uniform(13.0, 16.0);
  if (happens(random, 0.5)) model.noise = NoiseModel{magnitude(random, 1e-4, 0.1), magnitude(random, 1e-4, 0.1), magnitude(random, 0.1, 1000.0), magnitude(random, 1e-6, 0.01)};
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
  return {random.uniform(10.0, 17.0), magnitude(random, 0.1, 3600.0), happens(random, 0.5) ? 5000.0 : magnitude(random, 1.0, 500.0)};
}

/// How often a question was asked, and how often its answer was valid.
struct Tally {
  int asked = 0, valid = 0, negative = 0;
};

}  // namespace

TEST(Answers, OfAnyModelInAnyStateToAnyQuestionKeepTheLawsOfAnswers) {
  Random random(20260517);
  Tally crank, stop, charge;
  const int models = modelsWanted();
  const auto count = [](Tally& tally, const auto& answer) {
    ++tally.asked;
    tally.valid += answer.valid;
  };
  for (int k = 0; k < models; ++k) {
    const FittedModel model = drawnModel(random);
    const double capacity = magnitude(random, 5.0, 300.0);
    const CrankingQuery of_crank = drawnCrank(random);
    const CrankingAnswer cranked = predictCranking(model, of_crank, capacity);
    count(crank, cranked);
    EXPECT_EQ(brokenLaw(cranked, model), "") << "model " << k << ": " << cranked.message;
    const StopTimeQuery of_stop = drawnStop(random);
    const StopTimeAnswer stopped = predictStopTime(model, of_stop, capacity);
    count(stop, stopped);
    EXPECT_EQ(brokenLaw(stopped, of_stop, capacity), "") << "model " << k << ": " << stopped.message;
    const ChargeAcceptanceQuery of_charge = drawnCharge(random);
    const ChargeAcceptanceAnswer charged = predictChargeAcceptance(model, of_charge, capacity);
    count(charge, charged);
    charge.negative += charged.valid && charged.i_boost->value < 0.0;
    EXPECT_EQ(brokenLaw(charged, of_charge, capacity), "") << "model " << k << ": " << charged.message;
  }
  std::printf("%d models: valid cranks %d, stops %d, charges %d (%d of them below 0 A)\n", models, crank.valid, stop.valid, charge.valid, charge.negative);
  EXPECT_GT(crank.valid, models / 20);
  EXPECT_GT(stop.valid, models / 20);
  EXPECT_GT(charge.valid, models / 20);
}

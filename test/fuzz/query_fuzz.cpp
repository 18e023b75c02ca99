#include "fuzzed.hpp"
#include "fuzzed_model.hpp"

namespace {

using namespace battery_sof;

constexpr int kMaxPoints = 6;  // of a profile

/// [s]: mostly a short one, which shows as much in a hundredth of the time; now and then one of any
/// length that may be asked for.
double durationIn(FuzzedDataProvider& data, double usual, double longest) {
  return fuzz::anyNumber(data, 0.0, data.ConsumeIntegralInRange<int>(0, 31) > 0 ? usual : longest);
}

CurrentProfile profileIn(FuzzedDataProvider& data) {
  CurrentProfile profile;
  double time = 0.0;
  for (int n = data.ConsumeIntegralInRange<int>(0, kMaxPoints); n > 0; --n) {
    profile.time.push_back(time += durationIn(data, 2.0, 100.0));
    profile.current.push_back(fuzz::anyNumber(data, -1000.0, 200.0));
  }
  if (data.ConsumeIntegralInRange<int>(0, 15) == 15) profile.time.push_back(1e9);
  return profile;
}

std::optional<double> perhaps(FuzzedDataProvider& data, double lower, double upper) {
  return data.ConsumeBool() ? std::optional<double>(fuzz::anyNumber(data, lower, upper))
                            : std::nullopt;
}

void askCrank(FuzzedDataProvider& data, const FittedModel& model, double capacity) {
  const CurrentProfile load = data.ConsumeBool() ? profileIn(data) : CurrentProfile(),
                       crank = data.ConsumeBool() ? profileIn(data) : CurrentProfile();
  const CrankingQuery query{fuzz::anyNumber(data, -5000.0, 0.0),
                            durationIn(data, 60.0, 86400.0),
                            fuzz::anyNumber(data, -5000.0, 0.0),
                            durationIn(data, 2.0, 60.0),
                            perhaps(data, 0.0, 100.0),
                            load,
                            crank,
                            perhaps(data, 200.0, 350.0)};
  fuzz::require(test::brokenLaw(predictCranking(model, query, capacity), model.fit));
}

void askStopTime(FuzzedDataProvider& data, const FittedModel& model, double capacity) {
  const StopTimeQuery query{fuzz::anyNumber(data, -5000.0, 0.0),
                            fuzz::anyNumber(data, -5000.0, 0.0),
                            durationIn(data, 2.0, 60.0),
                            fuzz::anyNumber(data, 0.0, 20.0),
                            data.ConsumeBool() ? profileIn(data) : CurrentProfile(),
                            perhaps(data, 200.0, 350.0)};
  fuzz::require(test::brokenLaw(predictStopTime(model, query, capacity), query, capacity));
}

void askCharge(FuzzedDataProvider& data, const FittedModel& model, double capacity) {
  const ChargeAcceptanceQuery query{
      fuzz::anyNumber(data, 0.0, 100.0), durationIn(data, 5.0, 3600.0),
      fuzz::anyNumber(data, 0.0, 5000.0), perhaps(data, 200.0, 350.0)};
  fuzz::require(test::brokenLaw(predictChargeAcceptance(model, query, capacity), query, capacity));
}

void askProfile(FuzzedDataProvider& data, const FittedModel& model) {
  const CurrentProfile profile = profileIn(data);
  fuzz::require(
      test::brokenLaw(simulateProfile(model, profile.time, profile.current), profile.time.size()));
}

}  // namespace

/// Whatever is asked of whatever model, one question an input, the answer keeps the laws of
/// answers.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  FuzzedDataProvider data(bytes, size);
  const FittedModel model = fuzz::modelIn(data);
  const double capacity = data.ConsumeFloatingPointInRange(1.0, 300.0);
  switch (data.ConsumeIntegralInRange<int>(0, 3)) {
    case 0: askCrank(data, model, capacity); break;
    case 1: askStopTime(data, model, capacity); break;
    case 2: askCharge(data, model, capacity); break;
    default: askProfile(data, model);
  }
  return 0;
}

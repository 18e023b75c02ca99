#include "fuzzed.hpp"
#include "fuzzed_model.hpp"
#include "prediction/online_session.hpp"

namespace {

using namespace battery_sof;

/// A drive offered to a session, with clocks, values and calls as the bytes say.
class FuzzedDrive {
 public:
  explicit FuzzedDrive(FuzzedDataProvider& data) : data_(data), session_(options()) {
    if (data.ConsumeBool()) session_.restore(fuzz::modelIn(data, 1));
  }

  void act() {
    switch (data_.ConsumeIntegralInRange<int>(0, 9)) {
      case 0: return jump();
      case 1:
        return offer({fuzz::anyNumber(data_, 0.0, 2e9),
                      fuzz::anyNumber(data_, -6000.0, 6000.0),
                      fuzz::anyNumber(data_, -10.0, 110.0),
                      {}});
      case 2: return identify();
      case 3: return ask();
      case 4: return extend();
      case 5: return session_.beginAnew();
      case 6: return session_.restore(fuzz::modelIn(data_, 1));
      default: return drive();
    }
  }

 private:
  static constexpr std::size_t kQuicker = 10;
  static constexpr int kMaxFits = 1;  // they take most of the time

  static SessionOptions options() {
    SessionOptions options;
    options.buffer = 20.0;
    options.window_length = 6.0;
    options.identify_period = 5.0;
    options.retry_period = 2.0;
    options.min_window_quality = 0.0;
    options.capacity = 1.0;  // ends the search for a longest stop early
    options.identify.max_iterations = 2;
    options.identify.more_starts = 0;
    return options;
  }

  void offer(const RawSample& sample) {
    const std::size_t before = session_.counts().accepted;
    session_.push(sample);
    fuzz::require(session_.counts().accepted >= before, "counts never fall");
  }

  /// A piece of a lively minute, driven in a tenth of it so that a window of 60 samples has all of
  /// it, with what noise the bytes have.
  void drive() {
    const std::size_t count = data_.ConsumeIntegralInRange<std::size_t>(1, 80);
    const double noise = data_.ConsumeFloatingPointInRange(0.0, 0.1);
    for (std::size_t n = 0; n < count; ++n) {
      const std::size_t at = kQuicker * driven_++ % minute_.size();
      time_ += interval_;
      offer({time_, minute_.current[at],
             12.5 + 0.006 * minute_.current[at] + noise * random_.normal(), temperature_});
    }
  }

  void jump() {
    constexpr double kJumps[] = {0.0, 1e-8, 5.0,   30.0,    61.0, 4000.0,
                                 1e9, -0.5, -11.0, -4000.0, -1e9};
    time_ += data_.PickValueInArray(kJumps);
    if (data_.ConsumeBool()) interval_ = data_.ConsumeFloatingPointInRange(1e-3, 10.0);
    if (data_.ConsumeBool()) temperature_ = fuzz::anyNumber(data_, 200.0, 350.0);
  }

  void identify() {
    if (fits_ == kMaxFits) return;
    const auto job = data_.ConsumeBool() ? session_.takeJob() : session_.takeDueJob();
    if (!job) return;
    ++fits_;
    IdentificationResult result = runIdentification(*job);
    if (data_.ConsumeBool()) drive();
    session_.finish(std::move(result));
  }

  void extend() {
    const auto effects = fuzz::effectsIn(data_, 1);
    if (!effects.empty()) session_.fitWith(effects, session_.driving());
  }

  void ask() {
    const Fit fit = session_.live().model().value_or(FittedModel()).fit;
    fuzz::require(
        test::brokenLaw(session_.live().predictCranking({-20.0, 10.0, -200.0, 0.5, 7.2}), fit));
    const double capacity = capacityFor(fit, options().capacity);
    const StopTimeQuery stop{-20.0, -200.0, 0.5, 7.2};
    fuzz::require(test::brokenLaw(session_.live().predictStopTime(stop), stop, capacity));
    const ChargeAcceptanceQuery charge{14.4, 10.0};
    fuzz::require(
        test::brokenLaw(session_.live().predictChargeAcceptance(charge), charge, capacity));
    fuzz::require(!session_.status().reason.empty(), "a status has a reason");
  }

  FuzzedDataProvider& data_;
  OnlineSession session_;
  const Series minute_ = test::livelyMinute(0.1);
  test::Random random_{7};
  double time_ = 1000.0, interval_ = 0.1;  // [s]
  std::size_t driven_ = 0;
  int fits_ = 0;
  std::optional<double> temperature_;
};

}  // namespace

/// Whatever a clock, a sensor and the callers do, no exception leaves the session, and its answers
/// keep the laws of answers.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  FuzzedDataProvider data(bytes, size);
  FuzzedDrive drive(data);
  for (int acts = 0; acts < 20 && data.remaining_bytes() > 0; ++acts) drive.act();
  return 0;
}

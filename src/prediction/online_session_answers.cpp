#include <array>
#include <utility>

#include "prediction/online_session.hpp"
#include "state/posterior.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// A first rest and cranks so far from what is expected are another battery's [standard deviations]:
// by chance in at most one of 700 trips.
constexpr double kSwapped = 3.5;
constexpr double kBeforeFirst = 1e-3;  // [s]

std::string inUseSentence(double age) {
  return format("the saved model is in use, %.0f s old", age);
}

}  // namespace

std::string toString(AnswerBasis basis) {
  constexpr std::array kNames = {"population", "previous_trip", "this_trip"};
  return kNames.at(static_cast<std::size_t>(basis));
}

// ----------------------------------------------------------------------------------------------------
// restored model

void OnlineSession::restore(const FittedModel& model) {
  restored_ = model;
  restored_->fit.series_blocks /= options_.series_blocks;  // 1 when it is of such a row
}

void OnlineSession::judgeRestored(const Sample& first) {
  if (!restored_) return;
  last_outcome_ = refusalOfRestored(first.time);
  const FittedModel model = *std::exchange(restored_, std::nullopt);
  if (!last_outcome_.empty()) {
    refused_ = model;
    return;
  }
  last_outcome_ = inUseSentence(first.time - model.fit.window.to);
  basis_ = AnswerBasis::kPreviousTrip;
  if (model.fit.source) source_ = ChargerShare(*model.fit.source);
  monitor_ = restoredAt(model, first.time);
  followAgain(model.state.time, stream_.maxGap());
  next_look_ = driving_;
}

ModelMonitor OnlineSession::restoredAt(const FittedModel& saved, double time) const {
  ModelMonitor monitor(options_.events, options_.steps);
  monitor.setCalibrations(saved.intervals);
  monitor.learnFrom(parked(saved, time - saved.state.time, temperatureAt(stream_.series(), time)),
                    stream_.maxGap());
  return monitor;
}

void OnlineSession::beginFromPopulation(const Sample& sample) {
  basis_ = AnswerBasis::kPopulation;
  FittedModel model = populationPrior(options_.capacity, knownOf(options_.identify.priors, {}),
                                      sample.time, sample.current, sample.voltage);
  model.fit.crank_current = options_.events.crank_current;
  // The sample itself is taken in as well.
  model.state.time = sample.time - kBeforeFirst;
  monitor_.learnFrom(model, stream_.maxGap());
}

void OnlineSession::watchForSwap(const Sample& sample) {
  if (basis_ != AnswerBasis::kPreviousTrip || !monitor_.learns()) return;
  const double surprise = monitor_.tracker().surprise();
  if (surprise < kSwapped) return;
  loseModel(
      format("the saved model was dropped: the first rest and cranks are %.1f standard deviations "
             "away from what it predicts, so this seems to be another battery",
             surprise));
  beginFromPopulation(sample);
}

void OnlineSession::offerRefusedAgain() {
  if (!refused_ || (monitor_.holdsModel() && basis_ != AnswerBasis::kPopulation)) return;
  restored_ = std::exchange(refused_, std::nullopt);
}

std::string OnlineSession::refusalOfRestored(double first_time) const {
  const double ahead = restored_->state.time - first_time;
  if (ahead > 0.0) {
    return format("the saved model was refused: its state is %.1f s ahead of the first sample",
                  ahead);
  }
  if (restored_->fit.series_blocks != 1.0)
    return format(
        "the saved model was refused: it is of %g blocks of 12 V, but series_blocks is %g",
        restored_->fit.series_blocks * options_.series_blocks, options_.series_blocks);
  return isUsable(restored_->fit) ? "" : "the saved model was refused: its fit is not usable";
}

std::string OnlineSession::whyRestoredWaits() const {
  const Series& first = stream_.waiting();
  if (first.empty()) {
    const std::size_t rejected = counts().rejectedTotal();
    return rejected == 0
               ? "the saved model is waiting for the first sample"
               : "the saved model is waiting for the first usable sample: " + toString(counts());
  }
  return refusalOfRestored(
      first.time[contiguousRanges(first, SampleStream::kClockAhead).back().first]);
}

std::string OnlineSession::whyNoSample() const {
  const std::size_t rejected = counts().rejectedTotal();
  const std::string waits = restored_ ? ": " + whyRestoredWaits() : "";
  if (rejected == 0) return "no sample yet" + waits;
  return "no usable sample yet, " + toString(counts()) + waits;
}

FittedModel OnlineSession::restoredNow() const {
  const Series& first = stream_.waiting();
  ModelMonitor model = restoredAt(*restored_, first.time.front());
  for (std::size_t n = 0; n < first.size(); ++n) model.follow(first[n], stream_.maxGap());
  return model.now();
}

// ----------------------------------------------------------------------------------------------------
// queries

std::optional<std::string> OnlineSession::whyNoModel() const {
  if (restored_) {
    std::string why = whyRestoredWaits();
    return why.empty() ? std::nullopt : std::optional(std::move(why));
  }
  if (monitor_.holdsModel()) return std::nullopt;
  return "no model has been identified yet" + (last_outcome_.empty() ? "" : ": " + last_outcome_);
}

ModelSnapshot OnlineSession::live() const {
  auto reason = whyNoModel();
  if (reason) return ModelSnapshot({}, std::move(reason), options_.capacity);
  FittedModel now = restored_ ? restoredNow() : monitor_.now();
  const Series& series = stream_.series();
  if (!series.temperature.empty()) now.state.temperature = series.temperature.back();
  return ModelSnapshot(ofRow(std::move(now)), std::nullopt, options_.capacity, whyNotValid());
}

std::optional<double> OnlineSession::chargeVoltage() const {
  const auto of_one = restored_ ? usualVoltage(restored_->intervals.event_history.charges)
                                : monitor_.chargeVoltage();
  return of_one ? std::optional<double>(options_.series_blocks * *of_one) : std::nullopt;
}

std::optional<double> OnlineSession::newestTime() const {
  return newest_ ? std::optional<double>(newest_->time) : std::nullopt;
}

std::optional<FittedModel> OnlineSession::model() const {
  if (!monitor_.holdsModel()) return std::nullopt;
  return ofRow(monitor_.now());
}

std::optional<FittedModel> OnlineSession::modelToSave() const {
  const bool was_refused = refused_ && basis_ == AnswerBasis::kPopulation;
  if (restored_ || was_refused || !monitor_.holdsModel() || !whyNotValid().empty())
    return std::nullopt;
  return ofRow(monitor_.now());
}

FittedModel OnlineSession::ofRow(FittedModel model) const {
  model.fit.series_blocks = options_.series_blocks;
  return model;
}

std::optional<ExpectedSample> OnlineSession::expectedSample() const {
  if (!monitor_.holdsModel() || !monitor_.tracker().last()) return std::nullopt;
  const SettledSample& last = *monitor_.tracker().last();
  if (last.voltage_controlled) return ExpectedSample{last.time, std::nullopt, last.current};
  return ExpectedSample{last.time, last.voltage * options_.series_blocks, std::nullopt};
}

SessionStatus OnlineSession::status() const {
  SessionStatus status;
  status.reason = last_outcome_;
  if (monitor_.learns()) {
    status.reason += status.reason.empty() ? "" : "; ";
    status.reason += "answers rest on ";
    const bool has_priors = !knownOf(options_.identify.priors, {}).empty();
    status.reason += basis_ != AnswerBasis::kPopulation ? "the previous trip"
                     : has_priors                       ? "the given priors"
                                                        : "what is known of lead-acid batteries";
    status.reason += " and this trip's samples" + (missing_.empty() ? "" : "; " + missing_);
  }
  status.basis = restored_ ? AnswerBasis::kPreviousTrip : basis_;
  status.newest_time = newestTime();
  if (monitor_.holdsModel()) {
    if (newest_) status.model_age = newest_->time - monitor_.fittedUntil();
    status.window_quality = monitor_.accepted().fit.window_quality;
    status.effects = monitor_.accepted().fit.effects;
    status.voltage_controlled = monitor_.tracker().isVoltageControlled();
  }
  status.backtest = monitor_.backtest();
  status.deep_discharge = deep_discharges_.toString(options_.series_blocks);
  status.charger_present = source_.seen();
  status.charger_share = source_.share();
  status.expected = expectedSample();
  const auto reason = whyNoModel();
  if (restored_ && !reason) {
    status.state = SessionState::kReady;
    status.model_age = stream_.waiting().time.back() - restored_->fit.window.to;
    status.reason = inUseSentence(*status.model_age);
    status.window_quality = restored_->fit.window_quality;
    status.effects = restored_->fit.effects;
  } else if (!newest_) {
    status.state = SessionState::kNoSample;
    status.reason = whyNoSample();
  } else if (!reason) {
    status.state = SessionState::kReady;
  } else {
    status.state = job_ ? SessionState::kIdentifying : SessionState::kCollecting;
    if (status.reason.empty()) status.reason = *reason;
  }
  if (!reason) status.not_valid = whyNotValid();
  if (!status.not_valid.empty())
    status.reason = "no answer is valid, because " + status.not_valid +
                    (status.reason.empty() ? "" : "; " + status.reason);
  return status;
}

}  // namespace battery_sof

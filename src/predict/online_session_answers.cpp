#include <cmath>
#include <utility>

#include "battery_sof/predict/row_of_blocks.hpp"
#include "battery_sof/recording/words.hpp"

namespace battery_sof {
namespace {

std::string inUseSentence(double age) { return sentence("the saved model is in use, %.0f s old", age); }

}  // namespace

// ----------------------------------------------------------------------------------------------------
// restored model

void OnlineSession::restore(const FittedModel& model) {
  restored_ = model;
  restored_->fit.blocks /= options_.blocks;  // 1 when it is of such a row
}

void OnlineSession::judgeRestored(const StreamSample& first) {
  if (!restored_) return;
  const std::string refusal = refusalOfRestored(first.time);
  const FittedModel model = *std::exchange(restored_, std::nullopt);
  last_outcome_ = refusal;
  if (!refusal.empty()) {
    refused_ = model;
    return;
  }
  last_outcome_ = inUseSentence(first.time - model.fit.window.to);
  if (model.fit.source) source_ = SourceShare(*model.fit.source);
  contenders_.base.setScales(model.intervals.crank_scale, model.intervals.charge_scale);
  contenders_.base.install(model, stream_.maxGap());
  followAgain(model.state.time, stream_.maxGap());
  next_look_ = driving_ + options_.identify_period;
}

void OnlineSession::offerRefusedAgain() {
  if (!refused_ || contenders_.base.holdsModel()) return;
  restored_ = std::exchange(refused_, std::nullopt);
}

std::string OnlineSession::refusalOfRestored(double first_time) const {
  const double ahead = restored_->state.time - first_time;
  const double age = first_time - restored_->fit.window.to;
  if (ahead > 0.0) {
    return sentence("the saved model was refused: its state is %.1f s ahead of the first sample", ahead);
  }
  if (age > options_.model_max_age) {
    return sentence("the saved model was refused: it is %.0f s old, allowed are %.0f s", age, options_.model_max_age);
  }
  if (restored_->fit.blocks != 1.0)
    return sentence("the saved model was refused: it is of %g blocks of 12 V, blocks is %g", restored_->fit.blocks * options_.blocks,
                    options_.blocks);
  return isUsable(restored_->fit) ? "" : "the saved model was refused: its fit is not usable";
}

std::string OnlineSession::whyRestoredWaits() const {
  const Series& first = stream_.waiting();
  if (first.empty()) {
    const std::size_t rejected = counts().rejectedTotal();
    return rejected == 0 ? "the saved model waits for the first sample"
                         : "the saved model waits for the first usable sample: " + describe(counts().rejected);
  }
  return refusalOfRestored(first.time[contiguousRanges(first, SampleStream::kClockAhead).back().first]);
}

std::string OnlineSession::whyNoSample() const {
  const std::size_t rejected = counts().rejectedTotal();
  const std::string waits = restored_ ? ": " + whyRestoredWaits() : "";
  if (rejected == 0) return "no sample yet" + waits;
  return "no usable sample yet, " + describe(counts().rejected) + waits;
}

FittedModel OnlineSession::restoredNow() const {
  const Series& first = stream_.waiting();
  TrackedModel model(options_.events);
  model.setScales(restored_->intervals.crank_scale, restored_->intervals.charge_scale);
  model.install(*restored_, stream_.maxGap());
  for (std::size_t n = 0; n < first.size(); ++n) model.follow({first.time[n], first.current[n], first.voltage[n]}, stream_.maxGap());
  return model.now();
}

// ----------------------------------------------------------------------------------------------------
// queries

std::optional<double> OnlineSession::ageOf(const TrackedModel& model) const {
  if (!model.holdsModel() || !newest_) return std::nullopt;
  return newest_->time - model.fittedUntil();
}

bool OnlineSession::isTooOld(const TrackedModel& model) const { return ageOf(model).value_or(0.0) > options_.model_max_age; }

std::optional<std::string> OnlineSession::whyNoModel() const {
  const std::string outcome = restored_ ? whyRestoredWaits() : last_outcome_;
  if (restored_ && outcome.empty()) return std::nullopt;
  if (restored_) return outcome;
  if (!inUse().holdsModel()) {
    return outcome.empty() ? "nothing identified yet" : "nothing identified yet: " + outcome;
  }
  if (!isTooOld(inUse())) return std::nullopt;
  return sentence("the model is %.0f s old, allowed are %.0f s", *ageOf(inUse()), options_.model_max_age);
}

LiveModel OnlineSession::live() const {
  auto reason = whyNoModel();
  if (reason) return LiveModel({}, std::move(reason), options_.capacity);
  FittedModel now = restored_ ? restoredNow() : inUse().now();
  const Series& series = stream_.series();
  if (!series.temperature.empty()) now.state.temperature = series.temperature.back();
  return LiveModel(ofRow(std::move(now)), std::nullopt, options_.capacity, restored_ ? NaiveStandings() : inUse().standings());
}

CrankingAnswer OnlineSession::predictCranking(const CrankingQuery& query) const { return live().predictCranking(query); }

StopTimeAnswer OnlineSession::predictStopTime(const StopTimeQuery& query) const { return live().predictStopTime(query); }

ChargeAcceptanceAnswer OnlineSession::predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
  return live().predictChargeAcceptance(query);
}

ProfileAnswer OnlineSession::simulateProfile(const std::vector<double>& time, const std::vector<double>& current) const {
  return live().simulateProfile(time, current);
}

std::optional<double> OnlineSession::chargeVoltage() const {
  const auto of_one = restored_ ? usualVoltage(restored_->intervals.experience.charges) : inUse().chargeVoltage();
  return of_one ? std::optional<double>(options_.blocks * *of_one) : std::nullopt;
}

std::optional<double> OnlineSession::newestTime() const { return newest_ ? std::optional<double>(newest_->time) : std::nullopt; }

std::optional<FittedModel> OnlineSession::model() const {
  if (!inUse().holdsModel()) return std::nullopt;
  return ofRow(inUse().now());
}

FittedModel OnlineSession::ofRow(FittedModel model) const {
  model.fit.blocks = options_.blocks;
  return model;
}

std::optional<ExpectedSample> OnlineSession::expectedSample() const {
  if (!inUse().isCompared()) return std::nullopt;
  const FollowedSample& last = inUse().last();
  if (last.voltage_drives) return ExpectedSample{inUse().lastTime(), std::nullopt, last.current};
  return ExpectedSample{inUse().lastTime(), last.voltage, std::nullopt};
}

SessionStatus OnlineSession::status() const { return inRow(statusOfBlock(), options_.blocks); }

SessionStatus OnlineSession::statusOfBlock() const {
  SessionStatus status;
  status.reason = last_outcome_;
  status.newest_time = newestTime();
  status.model_age = ageOf(inUse());
  if (inUse().holdsModel()) {
    status.suitability = inUse().accepted().fit.suitability;
    status.effects = inUse().accepted().fit.effects;
  }
  status.backtest = inUse().backtest();
  status.extension = extensionSentence();
  status.source_seen = source_.seen();
  status.source_share = source_.share();
  status.voltage_drives = inUse().voltageDrives();
  status.expected = expectedSample();
  status.crank_contest = inUse().crankContest().score();
  status.charge_contest = inUse().chargeContest().score();
  if (contenders_.extended) status.contest = contenders_.contest.score();
  const auto reason = whyNoModel();
  if (restored_ && !reason) {
    status.state = SessionState::kReady;
    status.model_age = stream_.waiting().time.back() - restored_->fit.window.to;
    status.reason = inUseSentence(*status.model_age);
    status.suitability = restored_->fit.suitability;
    status.effects = restored_->fit.effects;
  } else if (!newest_) {
    status.state = SessionState::kNoSample;
    status.reason = whyNoSample();
  } else if (!reason) {
    status.state = SessionState::kReady;
  } else if (inUse().holdsModel()) {
    status.state = SessionState::kStale;
    status.reason = *reason;
  } else {
    status.state = job_is_out_ ? SessionState::kIdentifying : SessionState::kCollecting;
    if (status.reason.empty()) status.reason = *reason;
  }
  return status;
}

}  // namespace battery_sof

#include "battery_sof/predict/online_session.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "battery_sof/identify/window.hpp"
#include "battery_sof/predict/scores.hpp"

namespace battery_sof {

namespace {

constexpr double kLookInterval = 10.0;   // [s] of driving, a look costs about a millisecond
constexpr double kBacktestSpan = 900.0;  // [s]
constexpr double kToleratedWorsening =
    1.1;  // of the recent RMSE; a tenth is within its own scatter
// Half a step of the coarsest battery sensor known (25 mV): below it neither model is better.
constexpr double kNegligibleRmse = 0.0125;  // [V]

void requirePositive(const char* name, double value) {
  if (value > 0.0 && std::isfinite(value)) return;
  throw std::invalid_argument(sentence("%s is %g, expected above 0 and finite", name, value));
}

const SessionOptions& checked(const SessionOptions& options) {
  requirePositive("buffer", options.buffer);
  requirePositive("identify_period", options.identify_period);
  requirePositive("retry_period", options.retry_period);
  requirePositive("model_max_age", options.model_max_age);
  requirePositive("capacity", options.capacity);
  if (options.window_length) requirePositive("window_length", *options.window_length);
  if (!(options.min_suitability >= 0.0 && options.min_suitability <= 1.0)) {
    throw std::invalid_argument(
        sentence("min_suitability is %g, expected 0 to 1", options.min_suitability));
  }
  return options;
}

bool isRequired(const ParameterEstimate& estimate) {
  return estimate.name == "r_discharge" || estimate.name == "u_dc";
}

bool hasBothSigns(const Series& series, IndexRange range) {
  const auto [lowest, highest] =
      std::minmax_element(series.current.begin() + static_cast<std::ptrdiff_t>(range.first),
                          series.current.begin() + static_cast<std::ptrdiff_t>(range.last));
  return *lowest < 0.0 && *highest > 0.0;
}

}  // namespace

OnlineSession::OnlineSession(SessionOptions options)
    : options_(checked(options)), stream_(options.buffer), judging_(options.events) {}

// ----------------------------------------------------------------------------------------------------
// samples

SessionEvents OnlineSession::push(const RawSample& sample) {
  const SampleStream::Step step = stream_.push(sample);
  if (step.clock_restarted) ++epoch_;
  for (const StreamSample& next : step.samples) {
    if (newest_ && next.time <= newest_->time) restartClock(newest_->time, next);
    advance(next);
  }
  return job_is_out_ ? SessionEvents() : std::exchange(events_, {});
}

void OnlineSession::restartClock(double old_newest, const StreamSample& first) {
  judging_.crank_watch.reset();
  judging_.charge_watch.reset();
  compared_.clear();
  newest_.reset();
  if (!model_) return;
  fitted_until_ += first.time - old_newest;
  FittedModel moved = *model_;
  setStateFromVoltage(moved, first.time, first.current, first.voltage);
  tracker_.emplace(moved, stream_.maxGap());
}

void OnlineSession::advance(const StreamSample& sample) {
  if (newest_ && sample.time - newest_->time <= stream_.maxGap()) {
    driving_ += sample.time - newest_->time;
  }
  newest_ = sample;
  judgeRestored(sample);
  if (!tracker_ || sample.time <= tracker_->state().time) return;
  follow(sample, stream_.maxGap());
}

void OnlineSession::follow(const StreamSample& sample, double max_gap) {
  if (const auto crank = judging_.crank_watch.add(sample, *tracker_, max_gap)) {
    events_.cranks.push_back(*crank);
    observe(judging_.crank_scale, crank->measured_minimum, crank->expected_minimum);
  }
  if (const auto charge = judging_.charge_watch.add(sample, *tracker_, max_gap)) {
    events_.charges.push_back(*charge);
    observe(judging_.charge_scale, charge->measured_current, charge->expected_current);
  }
  tracker_->setScales(judging_.crank_scale, judging_.charge_scale);
  tracker_->advance(sample.time, sample.current);
  tracker_->observe(sample.voltage);
  compare(sample);
}

void OnlineSession::compare(const StreamSample& sample) {
  compared_.push_back({sample.time, sample.voltage, tracker_->expectedVoltage()});
  while (compared_.front().time < sample.time - kBacktestSpan) compared_.pop_front();
}

BacktestScore OnlineSession::backtest() const {
  BacktestScore score;
  if (compared_.size() < 2) return score;
  std::vector<double> measured, expected;
  measured.reserve(compared_.size());
  expected.reserve(compared_.size());
  for (const Compared& instant : compared_) {
    measured.push_back(instant.measured);
    expected.push_back(instant.expected);
  }
  score.q_dyn_percent = qDyn(measured, expected);
  score.duration = compared_.back().time - compared_.front().time;
  return score;
}

// ----------------------------------------------------------------------------------------------------
// identification

std::optional<IdentificationJob> OnlineSession::takeDueJob() {
  if (job_is_out_ || driving_ < next_look_ || !isDue()) return std::nullopt;
  return makeJob();
}

std::optional<IdentificationJob> OnlineSession::takeJob() {
  if (job_is_out_ || stream_.series().empty()) return std::nullopt;
  return makeJob();
}

bool OnlineSession::isDue() {
  if (!whyNoModel()) return true;
  next_look_ = driving_ + kLookInterval;
  const std::string missing = missingForFirst();
  if (!missing.empty()) last_outcome_ = missing;
  return missing.empty();
}

std::string OnlineSession::missingForFirst() const {
  const Series& series = stream_.series();
  if (series.size() < 2) return "waiting for samples";
  const double length = options_.window_length.value_or(defaultWindowLength(series));
  if (length > options_.buffer) {
    return sentence("a window of %.0f s does not fit into the buffer of %.0f s", length,
                    options_.buffer);
  }
  const IndexRange range = recentWindow(series, length);
  const double covered = series.time[range.last - 1] - series.time[range.first];
  if (covered < length - 2.0 * medianInterval(series)) {
    return sentence("%.0f of %.0f s without a gap are buffered", covered, length);
  }
  if (!hasBothSigns(series, range)) return "the last window holds no charge or no discharge";
  const double suitability = windowExcitation(series, range);
  if (suitability >= options_.min_suitability) return {};
  return sentence("the last window's suitability is %.2f, below %.2f", suitability,
                  options_.min_suitability);
}

IdentificationJob OnlineSession::makeJob() {
  job_is_out_ = true;
  job_driving_ = driving_;
  judging_at_job_ = judging_;
  IdentificationJob job;
  job.epoch = epoch_;
  job.series = stream_.series();
  job.window_length = options_.window_length;
  job.min_suitability = options_.min_suitability;
  job.options = options_.identify;
  job.incumbent = model_;
  return job;
}

IdentificationOutcome OnlineSession::finish(IdentificationResult result) {
  job_is_out_ = false;
  IdentificationOutcome outcome;
  const std::string refusal = refusalOf(result);
  outcome.accepted = refusal.empty();
  outcome.message = outcome.accepted ? result.message : refusal;
  if (outcome.accepted) {
    judging_ = judging_at_job_;
    events_ = {};
    install(*result.model, result.max_gap);
    outcome.model = model();
  } else {
    outcome.model = std::move(result.model);
  }
  last_outcome_ =
      (outcome.accepted ? "last identification accepted: " : "last identification refused: ") +
      outcome.message;
  next_look_ = job_driving_ + (whyNoModel() ? options_.retry_period : options_.identify_period);
  return outcome;
}

std::string OnlineSession::refusalOf(const IdentificationResult& result) const {
  if (result.epoch != epoch_) return "the clock jumped back while the identification ran";
  if (!result.model) return result.message;
  const FittedModel& model = *result.model;
  if (!isUsable(model)) return describe(model.status) + ": " + model.message;
  for (const ParameterEstimate& estimate : model.estimates) {
    if (isRequired(estimate) && !estimate.determined) {
      return "the window does not determine " + estimate.name;
    }
  }
  if (model.state.time < stream_.series().time.front()) {
    return "the identification took longer than the buffer reaches back";
  }
  const bool compete = result.incumbent_rmse && !isTooOld();
  const double allowed =
      compete ? std::max(kToleratedWorsening * *result.incumbent_rmse, kNegligibleRmse) : 0.0;
  if (!compete || result.recent_rmse <= allowed) return {};
  return sentence("on the most recent window the new model's RMSE is %.4f V, the old one's %.4f V",
                  result.recent_rmse, *result.incumbent_rmse);
}

void OnlineSession::install(const FittedModel& model, double max_gap) {
  model_ = model;
  fitted_until_ = model.window.to;
  compared_.clear();
  tracker_.emplace(model, max_gap);
  tracker_->setScales(judging_.crank_scale, judging_.charge_scale);
  const Series& series = stream_.series();
  const auto later = std::upper_bound(series.time.begin(), series.time.end(), model.state.time);
  for (auto n = static_cast<std::size_t>(later - series.time.begin()); n < series.size(); ++n)
    follow({series.time[n], series.current[n], series.voltage[n]}, max_gap);
}

// ----------------------------------------------------------------------------------------------------
// restored model

void OnlineSession::restore(const FittedModel& model) { restored_ = model; }

void OnlineSession::judgeRestored(const StreamSample& first) {
  if (!restored_) return;
  const FittedModel model = *restored_;
  restored_.reset();
  const double ahead = model.state.time - first.time;
  const double age = first.time - model.window.to;
  if (ahead > 0.0) {
    last_outcome_ = sentence(
        "the saved model was refused: its state is %.1f s ahead of the first sample", ahead);
  } else if (age > options_.model_max_age) {
    last_outcome_ = sentence("the saved model was refused: it is %.0f s old, allowed are %.0f s",
                             age, options_.model_max_age);
  } else if (!isUsable(model)) {
    last_outcome_ = "the saved model was refused: its fit is not usable";
  } else {
    last_outcome_ = sentence("the saved model is in use, %.0f s old", age);
    judging_.crank_scale = model.crank_scale;
    judging_.charge_scale = model.charge_scale;
    install(model, stream_.maxGap());
    next_look_ = driving_ + options_.identify_period;
  }
}

// ----------------------------------------------------------------------------------------------------
// queries

std::optional<double> OnlineSession::modelAge() const {
  if (!model_ || !newest_) return std::nullopt;
  return newest_->time - fitted_until_;
}

bool OnlineSession::isTooOld() const { return modelAge().value_or(0.0) > options_.model_max_age; }

std::optional<std::string> OnlineSession::whyNoModel() const {
  if (!model_) {
    return last_outcome_.empty() ? "nothing identified yet"
                                 : "nothing identified yet: " + last_outcome_;
  }
  if (!isTooOld()) return std::nullopt;
  return sentence("the model is %.0f s old, allowed are %.0f s", *modelAge(),
                  options_.model_max_age);
}

LiveModel OnlineSession::live() const {
  auto reason = whyNoModel();
  if (reason) return LiveModel({}, std::move(reason), options_.capacity);
  FittedModel now = tracker_->modelNow();
  const Series& series = stream_.series();
  if (!series.temperature.empty()) now.state.temperature = series.temperature.back();
  return LiveModel(std::move(now), std::nullopt, options_.capacity);
}

CrankingAnswer OnlineSession::predictCranking(const CrankingQuery& query) const {
  return live().predictCranking(query);
}

StopTimeAnswer OnlineSession::predictStopTime(const StopTimeQuery& query) const {
  return live().predictStopTime(query);
}

ChargeAcceptanceAnswer OnlineSession::predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
  return live().predictChargeAcceptance(query);
}

ProfileAnswer OnlineSession::simulateProfile(const std::vector<double>& time,
                                             const std::vector<double>& current) const {
  return live().simulateProfile(time, current);
}

std::optional<double> OnlineSession::newestTime() const {
  return newest_ ? std::optional<double>(newest_->time) : std::nullopt;
}

std::optional<FittedModel> OnlineSession::model() const {
  if (!tracker_) return std::nullopt;
  return tracker_->modelNow();
}

SessionStatus OnlineSession::status() const {
  SessionStatus status;
  status.reason = last_outcome_;
  status.newest_time = newestTime();
  status.model_age = modelAge();
  if (model_) status.suitability = model_->suitability;
  status.backtest = backtest();
  const auto reason = whyNoModel();
  if (!newest_) {
    status.state = SessionState::kNoSample;
    status.reason = "no sample yet";
  } else if (!reason) {
    status.state = SessionState::kReady;
  } else if (model_) {
    status.state = SessionState::kStale;
    status.reason = *reason;
  } else {
    status.state = job_is_out_ ? SessionState::kIdentifying : SessionState::kCollecting;
  }
  return status;
}

}  // namespace battery_sof

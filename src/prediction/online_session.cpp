#include "prediction/online_session.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "estimation/window.hpp"
#include "recording/series_blocks.hpp"
#include "state/posterior.hpp"

namespace battery_sof {

namespace {

constexpr double kLookInterval = 10.0;  // [s] of driving, a look costs about a millisecond
// of the recent RMSE; a tenth is within its own scatter
constexpr double kToleratedWorsening = 1.1;

void requirePositive(const char* name, double value) {
  requireThat(value > 0.0, name, value, "above 0 and finite");
}

const SessionOptions& checked(const SessionOptions& options) {
  requirePositive("buffer", options.buffer);
  requirePositive("identify_period", options.identify_period);
  requirePositive("retry_period", options.retry_period);
  requirePositive("capacity", options.capacity);
  if (options.window_length) requirePositive("window_length", *options.window_length);
  requireThat(options.min_window_quality >= 0.0 && options.min_window_quality <= 1.0,
              "min_window_quality", options.min_window_quality, "0 to 1");
  requireThat(areSeriesBlocks(options.series_blocks), "series_blocks", options.series_blocks,
              kAllowedSeriesBlocks);
  return options;
}

SessionEvents ofSeries(SessionEvents of_one, double series_blocks) {
  for (auto* events : {&of_one.cranks, &of_one.charges, &of_one.stops})
    for (EventComparison& event : *events) event = battery_sof::ofSeries(event, series_blocks);
  return of_one;
}

bool hasBothSigns(const Series& series, IndexRange range) {
  const auto [lowest, highest] = std::minmax_element(series.current.begin() + range.first,
                                                     series.current.begin() + range.last);
  return *lowest < 0.0 && *highest > 0.0;
}

}  // namespace

OnlineSession::OnlineSession(const SessionOptions& options)
    : options_(checked(options)),
      stream_(options.buffer, {options.capacity, options.series_blocks}),
      monitor_(options.events, options.steps) {}

// ----------------------------------------------------------------------------------------------------
// samples

void OnlineSession::setCapacity(double capacity) {
  requirePositive("capacity", capacity);
  options_.capacity = capacity;
  stream_.setCapacity(capacity);
}

SessionEvents OnlineSession::push(const RawSample& sample) {
  RawSample of_one = sample;
  of_one.voltage /= options_.series_blocks;
  return ofSeries(take(of_one), options_.series_blocks);
}

SessionEvents OnlineSession::take(const RawSample& sample) {
  watchForJumps(sample);
  const SampleStream::Step step = stream_.push(sample);
  if (step.clock_restarted) ++epoch_;
  for (const Sample& next : step.samples) {
    if (newest_ && next.time <= newest_->time) restartClock(newest_->time, next);
    advance(next);
  }
  return std::exchange(events_, {});
}

void OnlineSession::watchForJumps(const RawSample& sample) {
  const std::optional<RawSample> first = stream_.jumpConfirmedBy(sample);
  const std::optional<double> newest = stream_.newestStamp();
  if (before_jump_ && newest && std::abs(*newest - jumped_to_) > SampleStream::kClockAhead)
    before_jump_.reset();
  if (!first) return;
  if (before_jump_) {
    const double since = first->time - *before_jump_->stream_.newestStamp();
    const double spent = std::abs(*newest - jumped_to_);
    if (since > 0.0 && since <= SampleStream::kClockAhead + spent) {
      goBackTo(*std::exchange(before_jump_, nullptr));
      events_ = take(*first);
      return;
    }
  }
  before_jump_.reset();
  before_jump_ = std::make_shared<const OnlineSession>(*this);
  jumped_to_ = first->time;
}

void OnlineSession::goBackTo(const OnlineSession& before) {
  OnlineSession then = before;
  then.stream_ = stream_;
  then.stream_.goOnFrom(before.stream_);
  then.epoch_ = epoch_ + 1;
  if (!job_) then.job_.reset();
  if (job_ && !then.job_) then.job_ = JobOut{then.monitor_, then.driving_};
  then.events_ = std::move(events_);
  then.composition_ = std::move(composition_);
  then.next_composition_ = std::move(next_composition_);
  *this = std::move(then);
}

void OnlineSession::beginAnew() {
  goBackTo(OnlineSession(options_));
  events_ = {};
  composition_.reset();
  next_composition_.reset();
}

void OnlineSession::restartClock(double old_newest, const Sample& first) {
  newest_.reset();
  const double moved = first.time - old_newest;
  monitor_.moveTo(first, moved, stream_.maxGap());
  source_.forgetPast();
  deep_discharges_.forgetClock();
  offerRefusedAgain();
}

void OnlineSession::advance(const Sample& sample) {
  const double passed = newest_ ? sample.time - newest_->time : 0.0;
  if (passed > SampleStream::kClockAhead) offerRefusedAgain();
  if (passed <= stream_.maxGap()) driving_ += passed;
  newest_ = sample;
  deep_discharges_.add(sample, stream_.maxGap());
  source_.add(sample);
  source_.forgetBefore(stream_.series().time.front());
  judgeRestored(sample);
  if (!monitor_.holdsModel()) beginFromPopulation(sample);
  follow(sample, stream_.maxGap());
  watchForSwap(sample);
  watchForDenial();
}

void OnlineSession::watchForDenial() {
  const bool is_denied = monitor_.holdsModel() && monitor_.isDenied();
  if (is_denied && !is_denied_) next_look_ = driving_;
  if (is_denied) stream_.doubt();
  is_denied_ = is_denied;
}

void OnlineSession::follow(const Sample& sample, double max_gap) {
  if (!monitor_.holdsModel()) return;
  const SessionEvents ended = followed(sample, max_gap);
  for (const auto kind : {&SessionEvents::cranks, &SessionEvents::charges, &SessionEvents::stops})
    (events_.*kind).insert((events_.*kind).end(), (ended.*kind).begin(), (ended.*kind).end());
}

SessionEvents OnlineSession::followed(const Sample& sample, double max_gap) {
  const SessionEvents ended = monitor_.follow(sample, max_gap);
  if (std::isfinite(monitor_.tracker().error())) return ended;
  loseModel("the model was dropped because its state was not finite");
  return {};
}

void OnlineSession::loseModel(const std::string& why) {
  monitor_ = ModelMonitor(options_.events, options_.steps);
  composition_.reset();
  last_outcome_ = why;
  next_look_ = driving_ + kLookInterval;
}

void OnlineSession::followAgain(double after, double max_gap) {
  const Series& series = stream_.series();
  for (std::size_t n = firstAfter(series, after); n < series.size(); ++n)
    followed(series[n], max_gap);
}

// ----------------------------------------------------------------------------------------------------
// identification

std::optional<IdentificationJob> OnlineSession::takeDueJob() {
  if (job_) return std::nullopt;
  beginDueComposition();
  if (driving_ < next_look_ || !isDue()) return std::nullopt;
  return makeJob();
}

std::optional<IdentificationJob> OnlineSession::takeJob() {
  if (job_ || stream_.series().empty()) return std::nullopt;
  beginDueComposition();
  return makeJob();
}

bool OnlineSession::isDue() {
  if (restored_) return false;
  if (monitor_.holdsModel() && !monitor_.learns()) return true;
  next_look_ = driving_ + kLookInterval;
  const std::string missing = missingForFirst();
  if (!missing.empty()) missing_ = missing;
  return missing.empty();
}

std::string OnlineSession::missingForFirst() const {
  const Series& series = stream_.series();
  if (series.size() < 2) return "waiting for samples";
  const double length = options_.window_length.value_or(defaultWindowLength(series));
  if (length > options_.buffer) {
    return format("a window of %.0f s does not fit into the buffer of %.0f s", length,
                  options_.buffer);
  }
  const IndexRange range = recentWindow(series, length);
  const double covered = series.time[range.last - 1] - series.time[range.first];
  if (covered < length - 2.0 * medianInterval(series)) {
    return format("only %.0f of %.0f s without a gap are buffered", covered, length);
  }
  if (!hasBothSigns(series, range)) return "the last window contains no charge or no discharge";
  const double window_quality = windowExcitation(series, range);
  if (window_quality >= options_.min_window_quality) return {};
  return format("the quality of the last window is %.2f, below the required %.2f", window_quality,
                options_.min_window_quality);
}

IdentificationJob OnlineSession::makeJob() {
  job_ = JobOut{monitor_, driving_};
  IdentificationJob job{options_, epoch_, stream_.series(), {}};
  job.identify.capacity = options_.capacity;
  if (monitor_.holdsModel()) job.incumbent = monitor_.accepted();
  if (!composition_) return job;
  job.identify.effects = composition_->effects;
  job.identify.discrepancy = composition_->discrepancy;
  return job;
}

IdentificationOutcome OnlineSession::finish(IdentificationResult result) {
  JobOut job = std::exchange(job_, std::nullopt).value_or(JobOut{monitor_, driving_});
  if (result.epoch == epoch_) takeSource(result.source);
  IdentificationOutcome outcome;
  const bool is_of_run = result.epoch == epoch_;
  const bool may_compare = !monitor_.learns() && (!composition_ || composition_->is_in_use);
  const std::string refusal = is_of_run ? refusalOf(result, may_compare)
                                        : "the clock jumped back while the identification ran";
  outcome.accepted = refusal.empty();
  outcome.message = outcome.accepted ? result.message : refusal;
  if (outcome.accepted) {
    const ModelMonitor answered = std::exchange(monitor_, std::move(job.monitor));
    install(result);
    monitor_.setCalibrations(answered.calibrations());
    basis_ = AnswerBasis::kThisTrip;
    if (composition_) composition_->is_in_use = true;
  }
  if (outcome.accepted && !monitor_.holdsModel()) {
    outcome.accepted = false;
    outcome.message = last_outcome_;
  }
  outcome.model = outcome.accepted ? monitor_.now() : std::move(result.model);
  if (outcome.model) outcome.model->fit.series_blocks = options_.series_blocks;
  is_denied_ = monitor_.holdsModel() && monitor_.isDenied();
  last_outcome_ =
      (outcome.accepted ? "last identification accepted: " : "last identification refused: ") +
      outcome.message;
  const bool is_given_up = !outcome.accepted && composition_ && is_of_run;
  if (is_given_up) composition_.reset();
  next_look_ =
      job.driving + (monitor_.learns() || is_denied_ || is_given_up ? options_.retry_period
                                                                    : options_.identify_period);
  return outcome;
}

void OnlineSession::takeSource(const ChargerShare& source) {
  if (!source.until()) return;
  source_ = source;
  const Series& series = stream_.series();
  for (std::size_t n = firstAfter(series, *source.until()); n < series.size(); ++n)
    source_.add(series[n]);
}

std::string OnlineSession::refusalOf(const IdentificationTrial& trial, bool may_compare) const {
  if (!trial.model) return trial.message;
  const FittedModel& model = *trial.model;
  if (!isUsable(model.fit)) return toString(model.fit.status) + ": " + model.fit.message;
  for (const ParameterEstimate& estimate : model.fit.estimates) {
    const bool is_required = estimate.name == "r_discharge" || estimate.name == "u_dc";
    if (is_required && !estimate.determined)
      return "the window does not determine " + estimate.name;
  }
  if (model.state.time < stream_.series().time.front()) {
    return "the identification took longer than the length of the buffer";
  }
  if (!trial.incumbent_rmse || !may_compare) return {};
  if (trial.worsening <= kToleratedWorsening) return {};
  std::string why = format(
      "on the most recent window the new model's error is %.2f times the old one's, RMSE %.4f V "
      "instead of %.4f V",
      trial.worsening, options_.series_blocks * trial.recent_rmse,
      options_.series_blocks * *trial.incumbent_rmse);
  if (trial.incumbent_current_rmse > 0.0)
    why += format(" and %.2f A instead of %.2f A", trial.recent_current_rmse,
                  trial.incumbent_current_rmse);
  return why;
}

void OnlineSession::install(const IdentificationResult& result) {
  FittedModel model = *result.model;
  if (monitor_.holdsModel()) carryCranks(model.fit, monitor_.now().fit);
  monitor_.goOnAs(*result.followed, model);
  followAgain(result.model->state.time, result.max_gap);
}

void OnlineSession::fitWith(const std::vector<std::string>& effects, double from_driving,
                            std::shared_ptr<const DiscrepancyModel> discrepancy) {
  if (effects.empty()) throw std::invalid_argument("fitWith: no effects are given");
  if (options_.identify.start == FitStart::kPaper)
    throw std::invalid_argument("fitWith: effects need the robust start");
  static_cast<void>(BatteryModel(effects, discrepancy));  // throws for what cannot be composed
  const std::optional<Composition>& last = next_composition_ ? next_composition_ : composition_;
  if (last && last->discrepancy == discrepancy &&
      std::is_permutation(last->effects.begin(), last->effects.end(), effects.begin(),
                          effects.end()))
    return;
  next_composition_ = Composition{effects, std::move(discrepancy), from_driving, false};
}

void OnlineSession::beginDueComposition() {
  if (!next_composition_ || driving_ < next_composition_->from_driving || whyNoModel()) return;
  composition_ = std::exchange(next_composition_, std::nullopt);
  next_look_ = driving_;
}

}  // namespace battery_sof

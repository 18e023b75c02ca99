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
      contenders_{ModelMonitor(options.events, options.steps), std::nullopt, {}} {}

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
  if (job_ && !then.job_) then.job_ = JobOut{then.contenders_, then.driving_};
  then.events_ = std::move(events_);
  then.extension_ = std::move(extension_);
  then.next_extension_ = std::move(next_extension_);
  *this = std::move(then);
}

void OnlineSession::beginAnew() {
  goBackTo(OnlineSession(options_));
  events_ = {};
  extension_.reset();
  next_extension_.reset();
}

void OnlineSession::restartClock(double old_newest, const Sample& first) {
  newest_.reset();
  const double moved = first.time - old_newest;
  contenders_.base.moveTo(first, moved, stream_.maxGap());
  if (contenders_.extended) contenders_.extended->moveTo(first, moved, stream_.maxGap());
  contenders_.selector.forgetPast();
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
  if (!contenders_.base.holdsModel()) beginFromPopulation(sample);
  follow(sample, stream_.maxGap());
  watchForSwap(sample);
  watchForDenial();
}

void OnlineSession::watchForDenial() {
  const bool is_denied = inUse().holdsModel() && inUse().isDenied();
  if (is_denied && !is_denied_) next_look_ = driving_;
  is_denied_ = is_denied;
}

void OnlineSession::follow(const Sample& sample, double max_gap) {
  if (!contenders_.base.holdsModel()) return;
  const SessionEvents ended = followBoth(sample, max_gap);
  for (const auto kind : {&SessionEvents::cranks, &SessionEvents::charges, &SessionEvents::stops})
    (events_.*kind).insert((events_.*kind).end(), (ended.*kind).begin(), (ended.*kind).end());
}

SessionEvents OnlineSession::followBoth(const Sample& sample, double max_gap) {
  auto& [base, extended, selector] = contenders_;
  const bool extended_answers = doesExtendedAnswer();
  const bool is_new = sample.time > base.tracker().state().time &&
                      (!extended || sample.time > extended->tracker().state().time);
  const SessionEvents of_base = base.follow(sample, max_gap);
  if (!std::isfinite(base.tracker().error())) {
    loseModel("the model was lost: its state was not finite");
    return {};
  }
  if (!extended) return of_base;
  const SessionEvents of_extended = extended->follow(sample, max_gap);
  if (!std::isfinite(extended->tracker().error())) {
    extended.reset();
    selector = {};
    extension_->outcome = "lost: its state was not finite";
    return of_base;
  }
  if (is_new) selector.add(sample, base, of_base, *extended, of_extended);
  return extended_answers ? of_extended : of_base;
}

void OnlineSession::loseModel(const std::string& why) {
  contenders_ = {ModelMonitor(options_.events, options_.steps), std::nullopt, {}};
  last_outcome_ = why;
  next_look_ = driving_ + kLookInterval;
}

void OnlineSession::followAgain(double after, double max_gap) {
  const Series& series = stream_.series();
  for (std::size_t n = firstAfter(series, after); n < series.size(); ++n)
    followBoth(series[n], max_gap);
}

// ----------------------------------------------------------------------------------------------------
// identification

std::optional<IdentificationJob> OnlineSession::takeDueJob() {
  if (job_) return std::nullopt;
  beginDueExtension();
  if (driving_ < next_look_ || !isDue()) return std::nullopt;
  return makeJob();
}

std::optional<IdentificationJob> OnlineSession::takeJob() {
  if (job_ || stream_.series().empty()) return std::nullopt;
  beginDueExtension();
  return makeJob();
}

bool OnlineSession::isDue() {
  if (restored_) return false;
  if (contenders_.base.holdsModel() && !contenders_.base.learns()) return true;
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
    return format("%.0f of %.0f s without a gap are buffered", covered, length);
  }
  if (!hasBothSigns(series, range)) return "the last window holds no charge or no discharge";
  const double window_quality = windowExcitation(series, range);
  if (window_quality >= options_.min_window_quality) return {};
  return format("the last window's window quality is %.2f, below %.2f", window_quality,
                options_.min_window_quality);
}

IdentificationJob OnlineSession::makeJob() {
  job_ = JobOut{contenders_, driving_};
  IdentificationJob job{options_, epoch_, stream_.series(), {}, {}, {}};
  const auto& [base, extended, selector] = contenders_;
  if (base.holdsModel()) job.incumbent = base.accepted();
  if (!extension_) return job;
  job.extended_options = options_.identify;
  job.extended_options->effects = extension_->effects;
  job.extended_options->discrepancy = extension_->discrepancy;
  if (extended) job.extended_incumbent = extended->accepted();
  return job;
}

IdentificationOutcome OnlineSession::finish(IdentificationResult result) {
  JobOut job = std::exchange(job_, std::nullopt).value_or(JobOut{contenders_, driving_});
  if (result.epoch == epoch_) takeSource(result.source);
  IdentificationOutcome outcome;
  const std::string refusal = result.epoch == epoch_
                                  ? refusalOf(result, !contenders_.base.learns())
                                  : "the clock jumped back while the identification ran";
  outcome.accepted = refusal.empty();
  outcome.message = outcome.accepted ? result.message : refusal;
  const bool extends = acceptsExtended(result, outcome.accepted);
  if (outcome.accepted || extends) {
    const Contenders answered = std::exchange(contenders_, std::move(job.contenders));
    install(result, outcome.accepted, extends);
    contenders_.base.setCalibrations(answered.base.calibrations());
    if (contenders_.extended && answered.extended)
      contenders_.extended->setCalibrations(answered.extended->calibrations());
  }
  if (outcome.accepted) basis_ = AnswerBasis::kThisTrip;
  if (outcome.accepted && !contenders_.base.holdsModel()) {
    outcome.accepted = false;
    outcome.message = last_outcome_;
  }
  outcome.model = outcome.accepted ? contenders_.base.now() : std::move(result.model);
  if (outcome.model) outcome.model->fit.series_blocks = options_.series_blocks;
  if (doesExtendedAnswer()) outcome.extended = ofRow(inUse().now());
  is_denied_ = inUse().holdsModel() && inUse().isDenied();
  last_outcome_ =
      (outcome.accepted ? "last identification accepted: " : "last identification refused: ") +
      outcome.message;
  next_look_ = job.driving + (contenders_.base.learns() || is_denied_ ? options_.retry_period
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
    return "the identification took longer than the buffer reaches back";
  }
  if (!trial.incumbent_rmse || !may_compare) return {};
  if (trial.worsening <= kToleratedWorsening) return {};
  return format(
      "on the most recent window the new model's error is %.2f times the old one's, RMSE %.4f V "
      "after %.4f V",
      trial.worsening, options_.series_blocks * trial.recent_rmse,
      options_.series_blocks * *trial.incumbent_rmse);
}

bool OnlineSession::acceptsExtended(const IdentificationResult& result, bool base_accepted) {
  if (!result.extended || !extension_ || result.epoch != epoch_) return false;
  const auto& [base, extended, selector] = contenders_;
  const std::string refusal = refusalOf(*result.extended, extended.has_value());
  extension_->outcome = refusal.empty() ? result.extended->message : "refused: " + refusal;
  return refusal.empty() && (base_accepted || base.holdsModel());
}

void OnlineSession::install(const IdentificationResult& result, bool base, bool extended) {
  if (base) install(contenders_.base, result);
  if (extended) {
    if (!contenders_.extended) {
      contenders_.extended.emplace(options_.events, options_.steps);
      contenders_.extended->setCalibrations(contenders_.base.calibrations());
    }
    install(*contenders_.extended, *result.extended);
  }
  followAgain((base ? result : *result.extended).model->state.time, result.max_gap);
}

void OnlineSession::install(ModelMonitor& monitor, const IdentificationTrial& trial) {
  FittedModel model = *trial.model;
  if (monitor.holdsModel()) carryCranks(model.fit, monitor.now().fit);
  monitor.goOnAs(*trial.followed, model);
}

// ----------------------------------------------------------------------------------------------------
// extended composition

void OnlineSession::extendWith(const std::vector<std::string>& effects, double from_driving,
                               std::shared_ptr<const DiscrepancyModel> discrepancy) {
  if (effects.empty()) throw std::invalid_argument("extendWith: no effects are given");
  if (options_.identify.start == FitStart::kPaper)
    throw std::invalid_argument("extendWith: effects need the robust start");
  static_cast<void>(BatteryModel(effects, discrepancy));  // throws for what cannot be composed
  const std::optional<Extension>& last = next_extension_ ? next_extension_ : extension_;
  if (last && last->discrepancy == discrepancy &&
      std::is_permutation(last->effects.begin(), last->effects.end(), effects.begin(),
                          effects.end()))
    return;
  next_extension_ = Extension{effects, std::move(discrepancy), from_driving, {}};
}

void OnlineSession::beginDueExtension() {
  if (!next_extension_ || driving_ < next_extension_->from_driving || whyNoModel()) return;
  extension_ = std::exchange(next_extension_, std::nullopt);
  next_look_ = driving_;
}

std::string OnlineSession::extensionSentence() const {
  const std::optional<Extension>& newest = next_extension_ ? next_extension_ : extension_;
  if (!newest) return {};
  const std::vector<std::string> running = contenders_.extended
                                               ? contenders_.extended->accepted().fit.effects
                                               : std::vector<std::string>();
  std::string text = running.empty() ? "the base model answers" : selectorSentence();
  if (running == newest->effects) return text;
  const std::string names = join(newest->effects);
  if (newest->outcome.empty()) return text + "; " + names + " is to be fitted in addition";
  return text + "; the fit with " + names + " was " + newest->outcome;
}

std::string OnlineSession::selectorSentence() const {
  const ModelSelectorScore score = contenders_.selector.score();
  const std::string names = join(contenders_.extended->accepted().fit.effects);
  const std::string who = doesExtendedAnswer() ? "the model with " + names : "the base model";
  return who + format(" answers: over %.0f s it missed %.1f mV with %s, %.1f mV without",
                      score.duration, 1e3 * options_.series_blocks * score.extended_rmse,
                      names.c_str(), 1e3 * options_.series_blocks * score.base_rmse);
}

const ModelMonitor& OnlineSession::inUse() const {
  const auto& [base, extended, selector] = contenders_;
  return extended && selector.doesExtendedAnswer() ? *extended : base;
}

}  // namespace battery_sof

#include "prediction/online_session.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "estimation/window.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/series_blocks.hpp"
#include "state/posterior.hpp"

namespace battery_sof {

namespace {

constexpr double kLookInterval = 10.0;  // [s] of driving, a look costs about a millisecond
// of the recent RMSE; a tenth is within its own scatter
constexpr double kToleratedWorsening = 1.1;
// A first rest and cranks so far from what is expected are another battery's [standard deviations]:
// by chance in at most one of 700 trips.
constexpr double kSwapped = 3.5;
constexpr double kBeforeFirst = 1e-3;     // [s]
constexpr std::size_t kChargesKept = 20;  // whose voltage is kept
constexpr const char* kLostNumbers = "the model was dropped because its state was not finite";

void requirePositive(const char* name, double value) {
  requireThat(value > 0.0, name, value, "above 0 and finite");
}

const SessionOptions& checked(const SessionOptions& options) {
  requirePositive("buffer", options.buffer);
  requirePositive("identify_period", options.identify_period);
  requirePositive("retry_period", options.retry_period);
  if (options.capacity) requirePositive("capacity", *options.capacity);
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
      history_({SampleStream(options.buffer, {capacity(), options.series_blocks}),
                ModelMonitor(options.events, options.steps)}) {}

// ----------------------------------------------------------------------------------------------------
// samples

void OnlineSession::setCapacity(std::optional<double> nominal) {
  if (nominal) requirePositive("capacity", *nominal);
  options_.capacity = nominal;
  now().stream.setCapacity(capacity());
}

SessionEvents OnlineSession::push(const RawSample& sample) {
  RawSample of_one = sample;
  of_one.voltage /= options_.series_blocks;
  return ofSeries(accept(of_one), options_.series_blocks);
}

SessionEvents OnlineSession::accept(const RawSample& sample) {
  watchForJumps(sample);
  for (const Sample& next : now().stream.push(sample)) {
    if (now().newest && next.time <= now().newest->time) restartClock(next);
    advance(next);
  }
  if (!now().newest) tryWaiting();
  return std::exchange(events_, {});
}

void OnlineSession::watchForJumps(const RawSample& sample) {
  const std::optional<double> newest = now().stream.newestStamp();
  const double spent = newest ? std::abs(*newest - jumped_to_) : 0.0;
  if (spent > SampleStream::kClockAhead) history_.remove(Mark::kBeforeClockJump);
  const std::optional<RawSample> first = now().stream.jumpConfirmedBy(sample);
  if (!first) return;
  if (history_.has(Mark::kBeforeClockJump)) {
    const double since = first->time - *history_.at(Mark::kBeforeClockJump).stream.newestStamp();
    if (since > 0.0 && since <= SampleStream::kClockAhead + spent) {
      history_.rewindTo(Mark::kBeforeClockJump);
      events_ = accept(*first);
      return;
    }
  }
  history_.mark(Mark::kBeforeClockJump);
  jumped_to_ = first->time;
  if (!now().newest) now().monitor.drop();  // what tryWaiting() began
}

void OnlineSession::beginAnew() {
  history_.rewindTo(Mark::kBeginning);
  events_ = {};
  composition_.reset();
  next_composition_.reset();
}

void OnlineSession::restartClock(const Sample& first) {
  now().monitor.restartClock(first, first.time - now().newest->time, now().stream.maxGap());
  now().newest = first;
  now().source.forgetPast();
  now().deep_discharges.forgetClock();
  offerRefusedAgain();
}

void OnlineSession::advance(const Sample& sample) {
  Standing& here = now();
  const double passed = here.newest ? sample.time - here.newest->time : 0.0;
  if (!here.newest) here.monitor.drop();  // what tryWaiting() began
  if (!here.newest || passed > SampleStream::kClockAhead) offerRefusedAgain();
  if (passed <= here.stream.maxGap()) here.driving += passed;
  here.newest = sample;
  here.deep_discharges.add(sample, here.stream.maxGap());
  here.source.add(sample);
  here.source.forgetBefore(here.stream.series().time.front());
  if (here.saved && !here.saved->refusal && startSaved(sample)) here.saved.reset();
  if (!here.monitor.holdsModel()) beginFromPopulation(sample);
  follow(sample);
  watchForSwap(sample);
  watchForDenial();
}

void OnlineSession::watchForDenial() {
  const bool is_denied = now().monitor.isDenied();
  if (is_denied && !now().is_denied) now().next_look = now().driving;
  if (is_denied) now().stream.doubt();
  now().is_denied = is_denied;
}

void OnlineSession::follow(const Sample& sample) {
  const SessionEvents ended = now().monitor.follow(sample, now().stream.maxGap());
  if (!now().monitor.isFinite()) return loseModel(kLostNumbers);
  for (const auto kind : {&SessionEvents::cranks, &SessionEvents::charges, &SessionEvents::stops})
    (events_.*kind).insert((events_.*kind).end(), (ended.*kind).begin(), (ended.*kind).end());
  for (const EventComparison& charge : ended.charges)
    now().charge_voltages.push_back(charge.voltage);
  while (now().charge_voltages.size() > kChargesKept) now().charge_voltages.pop_front();
}

void OnlineSession::watchForSwap(const Sample& sample) {
  if (now().basis != AnswerBasis::kPreviousTrip || !now().monitor.learns()) return;
  const double surprise = now().monitor.tracker().surprise();
  if (surprise < kSwapped) return;
  loseModel(
      format("the saved model was dropped: the first rest and cranks are %.1f standard deviations "
             "away from what it predicts, so this seems to be another battery",
             surprise));
  beginFromPopulation(sample);
}

void OnlineSession::beginFromPopulation(const Sample& sample) {
  now().basis = AnswerBasis::kPopulation;
  FittedModel model = populationPrior(capacity(), knownOf(options_.identify.priors, {}),
                                      sample.time, sample.current, sample.voltage);
  model.fit.crank_current = options_.events.crank_current;
  model.fit.nominal_capacity = options_.capacity;
  // The sample itself is taken in as well.
  model.state.time = sample.time - kBeforeFirst;
  now().monitor.learnFrom(model, now().stream.maxGap());
}

void OnlineSession::loseModel(const std::string& why) {
  now().monitor.drop();
  composition_.reset();
  now().last_outcome = why;
  now().next_look = now().driving + kLookInterval;
}

// ----------------------------------------------------------------------------------------------------
// saved model

void OnlineSession::restore(const FittedModel& model) {
  now().saved = SavedModel{model};
  now().saved->model.fit.series_blocks /= options_.series_blocks;  // 1 when it is of such a row
}

bool OnlineSession::startSaved(const Sample& first) {
  Standing& here = now();
  const FittedModel& model = here.saved->model;
  const double since = first.time - model.state.time, blocks = model.fit.series_blocks;
  std::optional<std::string> refusal;
  if (since < 0.0)
    refusal = format("its state is %.1f s ahead of the first sample", -since);
  else if (blocks != 1.0)
    refusal = format("it is of %g blocks of 12 V, but series_blocks is %g",
                     blocks * options_.series_blocks, options_.series_blocks);
  else if (!isUsable(model.fit))
    refusal = "its fit is not usable";
  if (refusal) {
    here.last_outcome = "the saved model was refused: " + *refusal;
    here.saved->refusal = here.last_outcome;
    return false;
  }
  here.last_outcome =
      format("the saved model is in use, %.0f s old", first.time - model.fit.window.to);
  here.basis = AnswerBasis::kPreviousTrip;
  here.next_look = here.driving;
  here.missing_for_first.reset();
  if (model.fit.source) here.source = ChargerShare(*model.fit.source);
  ModelMonitor monitor(options_.events, options_.steps);
  monitor.learnFrom(parked(model, since, temperatureAt(here.stream.series(), first.time)),
                    here.stream.maxGap());
  if (!history_.replay(std::move(monitor))) loseModel(kLostNumbers);
  return true;
}

void OnlineSession::tryWaiting() {
  Standing& here = now();
  const Series& waiting = here.stream.waiting();
  if (!here.saved || waiting.empty()) return;
  const Sample last = waiting[waiting.size() - 1];
  if (!here.monitor.holdsModel() && !startSaved(last)) return;
  here.monitor.follow(last, here.stream.maxGap());
  if (!here.monitor.isFinite()) loseModel(kLostNumbers);
}

void OnlineSession::offerRefusedAgain() {
  if (now().saved && now().basis == AnswerBasis::kPopulation) now().saved->refusal.reset();
}

// ----------------------------------------------------------------------------------------------------
// identification

std::optional<IdentificationJob> OnlineSession::takeDueJob() {
  if (isJobOut()) return std::nullopt;
  beginDueComposition();
  if (now().driving < now().next_look || !isDue()) return std::nullopt;
  return makeJob();
}

std::optional<IdentificationJob> OnlineSession::takeJob() {
  if (isJobOut() || series().empty()) return std::nullopt;
  beginDueComposition();
  return makeJob();
}

bool OnlineSession::isDue() {
  if (now().monitor.holdsModel() && !now().monitor.learns()) return true;
  now().next_look = now().driving + kLookInterval;
  const std::optional<std::string> missing = missingForFirst();
  if (missing) now().missing_for_first = missing;
  return !missing;
}

std::optional<std::string> OnlineSession::missingForFirst() const {
  const Series& series = now().stream.series();
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
  if (window_quality >= options_.min_window_quality) return std::nullopt;
  return format("the quality of the last window is %.2f, below the required %.2f", window_quality,
                options_.min_window_quality);
}

IdentificationJob OnlineSession::makeJob() {
  history_.mark(Mark::kJobTaken);
  IdentificationJob job{options_, series(), {}};
  job.identify.capacity = options_.capacity;
  if (now().monitor.holdsModel()) job.incumbent = now().monitor.accepted();
  if (!composition_) return job;
  job.identify.effects = composition_->effects;
  job.identify.discrepancy = composition_->discrepancy;
  return job;
}

IdentificationOutcome OnlineSession::finish(IdentificationResult result) {
  if (!isJobOut()) throw std::invalid_argument("finish: no job is out");
  const std::shared_ptr<const Standing> taken = history_.take(Mark::kJobTaken);
  const bool is_of_run = history_.continuesFrom(*taken);
  Standing& here = now();
  if (is_of_run && result.source.until()) {
    here.source = result.source;
    for (std::size_t n = firstAfter(series(), *result.source.until()); n < series().size(); ++n)
      here.source.add(series()[n]);
  }
  std::optional<std::string> refusal =
      is_of_run ? refusalOf(result) : "the clock jumped back while the identification ran";
  if (!refusal) refusal = install(result, *taken);
  IdentificationOutcome outcome;
  outcome.accepted = !refusal;
  outcome.message = refusal.value_or(result.message);
  outcome.model = outcome.accepted ? here.monitor.now() : std::move(result.model);
  if (outcome.model) outcome.model->fit.series_blocks = options_.series_blocks;
  here.is_denied = here.monitor.isDenied();
  here.last_outcome =
      (outcome.accepted ? "last identification accepted: " : "last identification refused: ") +
      outcome.message;
  const bool is_given_up = !outcome.accepted && composition_ && is_of_run;
  if (is_given_up) composition_.reset();
  here.next_look = taken->driving + (here.monitor.learns() || here.is_denied || is_given_up
                                         ? options_.retry_period
                                         : options_.identify_period);
  return outcome;
}

std::optional<std::string> OnlineSession::refusalOf(const IdentificationResult& result) const {
  if (!result.model) return result.message;
  const FittedModel& model = *result.model;
  if (!isUsable(model.fit)) return toString(model.fit.status) + ": " + model.fit.message;
  for (const ParameterEstimate& estimate : model.fit.estimates) {
    const bool is_required = estimate.name == "r_discharge" || estimate.name == "u_dc";
    if (is_required && !estimate.determined)
      return "the window does not determine " + estimate.name;
  }
  if (model.state.time < series().time.front())
    return "the identification took longer than the length of the buffer";
  const bool may_compare = !now().monitor.learns() && (!composition_ || composition_->is_in_use);
  if (!result.incumbent_rmse || !may_compare) return std::nullopt;
  if (result.worsening <= kToleratedWorsening) return std::nullopt;
  std::string why = format(
      "on the most recent window the new model's error is %.2f times the old one's, RMSE %.4f V "
      "instead of %.4f V",
      result.worsening, options_.series_blocks * result.recent_rmse,
      options_.series_blocks * *result.incumbent_rmse);
  if (result.incumbent_current_rmse > 0.0)
    why += format(" and %.2f A instead of %.2f A", result.recent_current_rmse,
                  result.incumbent_current_rmse);
  return why;
}

std::optional<std::string> OnlineSession::install(const IdentificationResult& result,
                                                  const Standing& taken) {
  FittedModel model = *result.model;
  if (taken.monitor.holdsModel()) carryCranks(model.fit, taken.monitor.now().fit);
  ModelMonitor accepted = *result.followed;
  accepted.accept(model, taken.monitor.calibrations());
  const IntervalCalibrations answered = now().monitor.calibrations();
  now().basis = AnswerBasis::kThisTrip;
  if (!history_.replay(std::move(accepted))) {
    loseModel(kLostNumbers);
    return kLostNumbers;
  }
  now().monitor.setCalibrations(answered);
  if (composition_) composition_->is_in_use = true;
  return std::nullopt;
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
  if (!next_composition_ || now().driving < next_composition_->from_driving || whyNoModel()) return;
  composition_ = std::exchange(next_composition_, std::nullopt);
  now().next_look = now().driving;
}

// ----------------------------------------------------------------------------------------------------
// queries

std::optional<std::string> OnlineSession::whyNoModel() const {
  if (now().monitor.holdsModel()) return std::nullopt;
  if (now().saved && !now().newest) {
    if (now().saved->refusal) return now().saved->refusal;
    return counts().rejectedTotal() == 0
               ? "the saved model is waiting for the first sample"
               : "the saved model is waiting for the first usable sample: " + toString(counts());
  }
  return "no model has been identified yet" +
         (now().last_outcome.empty() ? "" : ": " + now().last_outcome);
}

ModelSnapshot OnlineSession::live() const {
  std::optional<FittedModel> live = model();
  if (live && !series().temperature.empty()) live->state.temperature = series().temperature.back();
  return ModelSnapshot(std::move(live), whyNoModel(), capacity(), whyNotValid());
}

std::optional<double> OnlineSession::chargeVoltage() const {
  std::optional<double> of_one;
  if (now().monitor.holdsModel())
    of_one = usualVoltage(now().monitor.tracker().intervals().event_history.charges);
  else if (now().saved)
    of_one = usualVoltage(now().saved->model.intervals.event_history.charges);
  const std::deque<double>& passed = now().charge_voltages;
  if (!of_one && !passed.empty()) of_one = medianOf({passed.begin(), passed.end()});
  if (of_one) *of_one *= options_.series_blocks;
  return of_one;
}

std::optional<double> OnlineSession::newestTime() const {
  return now().newest ? std::optional<double>(now().newest->time) : std::nullopt;
}

std::optional<FittedModel> OnlineSession::model() const {
  if (!now().monitor.holdsModel()) return std::nullopt;
  FittedModel model = now().monitor.now();
  model.fit.series_blocks = options_.series_blocks;
  return model;
}

std::optional<FittedModel> OnlineSession::modelToSave() const {
  const bool saved_is_better = now().saved && now().basis != AnswerBasis::kThisTrip;
  if (saved_is_better || whyNotValid()) return std::nullopt;
  return model();
}

SessionStatus OnlineSession::status() const {
  const Standing& here = now();
  const ModelMonitor& monitor = here.monitor;
  const bool saved_waits = here.saved && !here.saved->refusal;
  SessionStatus status;
  status.reason = here.last_outcome;
  if (monitor.learns()) {
    status.reason += status.reason.empty() ? "" : "; ";
    status.reason += "answers rest on ";
    const bool has_priors = !knownOf(options_.identify.priors, {}).empty();
    status.reason += here.basis != AnswerBasis::kPopulation ? "the previous trip"
                     : has_priors                           ? "the given priors"
                                  : "what is known of lead-acid batteries";
    status.reason +=
        " and this trip's samples" + (here.missing_for_first ? "; " + *here.missing_for_first : "");
  }
  status.basis = saved_waits ? AnswerBasis::kPreviousTrip : here.basis;
  status.newest_time = newestTime();
  if (monitor.holdsModel()) {
    status.model_age = monitor.age();
    status.window_quality = monitor.accepted().fit.window_quality;
    status.effects = monitor.accepted().fit.effects;
    status.voltage_controlled = monitor.tracker().isVoltageControlled();
    if (const auto& last = monitor.tracker().last()) {
      status.expected = ExpectedSample{last->time, std::nullopt, std::nullopt};
      if (last->voltage_controlled)
        status.expected->current = last->current;
      else
        status.expected->voltage = last->voltage * options_.series_blocks;
    }
  }
  status.backtest = monitor.backtest();
  status.deep_discharge = here.deep_discharges.toString(options_.series_blocks);
  status.charger_present = here.source.seen();
  status.charger_share = here.source.share();
  if (const auto reason = whyNoModel()) {
    status.state = !here.newest ? SessionState::kNoSample
                   : isJobOut() ? SessionState::kIdentifying
                                : SessionState::kCollecting;
    if (status.reason.empty()) status.reason = *reason;
    if (!here.newest)
      status.reason =
          (counts().rejectedTotal() == 0 ? "no sample yet"
                                         : "no usable sample yet, " + toString(counts())) +
          (here.saved ? ": " + *reason : "");
  } else {
    status.state = SessionState::kReady;
    status.not_valid = whyNotValid().value_or("");
  }
  if (!status.not_valid.empty())
    status.reason = "no answer is valid, because " + status.not_valid +
                    (status.reason.empty() ? "" : "; " + status.reason);
  return status;
}

}  // namespace battery_sof

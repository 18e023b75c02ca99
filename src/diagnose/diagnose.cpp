#include "battery_sof/diagnose/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "battery_sof/diagnose/absorption.hpp"
#include "battery_sof/diagnose/comparison.hpp"
#include "battery_sof/diagnose/detectable.hpp"
#include "battery_sof/diagnose/locate.hpp"
#include "battery_sof/diagnose/naming.hpp"
#include "battery_sof/diagnose/profile_interval.hpp"
#include "battery_sof/diagnose/regimes.hpp"
#include "battery_sof/diagnose/residual_force.hpp"
#include "battery_sof/diagnose/slow_tone.hpp"
#include "battery_sof/diagnose/verdict.hpp"
#include "battery_sof/identify/composition_identification.hpp"
#include "battery_sof/identify/error_tracker.hpp"
#include "battery_sof/naive/naive_predictor.hpp"
#include "battery_sof/naive/ridge.hpp"
#include "battery_sof/predict/both_ways.hpp"
#include "battery_sof/recording/checks.hpp"
#include "battery_sof/recording/clipped_current.hpp"
#include "battery_sof/recording/current_flicker.hpp"
#include "battery_sof/recording/fit_mask.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kLeastForRidge = 60;  // samples, as ridgeVoltage() asks for

constexpr std::size_t kLeastSamples = 120;   // of the training part: ten for every unknown of base model and noise
constexpr double kLeastDuration = 120.0;     // [s], two time constants of the double layer at rest
constexpr double kLeastCharge = 20.0;        // [As] that must flow in either direction
constexpr std::size_t kCompressFrom = 4000;  // samples
constexpr double kSlowLength = 10.0;         // sampling intervals that may be averaged where the current is held
constexpr double kSlow = 0.15;               // [s]; sampled more slowly, edges cannot be set aside
constexpr double kEdge = 5.0;                // [A]
constexpr double kBeforeEdge = 0.1, kAfterEdge = 0.15;  // [s], PHYSICS 2.1's edge grid; before it as much as a channel may be late
constexpr double kShortSteps = 6000.0;        // [s] of a slow recording beyond which short steps would take minutes
constexpr double kLostShare = 0.005;         // of the samples; a second in three minutes
constexpr std::size_t kFewestFreezes = 3;
constexpr double kCoarseVoltage = 0.0099;    // [V], 10 mV but for printed digits; most effects leave less than 20 mV (PHYSICS 1.1, 1.2)
constexpr double kCoarseCurrent = 0.495;     // [A], 0.5 A: PHYSICS 1.3's offset
constexpr double kStillShare = 0.25;         // of the samples repeat the one before: noise of less than a step
constexpr double kCoarse = 3.0;              // rounding to more than this many deviations of the noise

bool contains(const std::vector<std::string>& list, const std::string& id) {
  return std::find(list.begin(), list.end(), id) != list.end();
}

void requireValid(const DiagnoseOptions& options) {
  if (!(options.holdout_share > 0.0) || !(options.holdout_share <= 0.5))
    throw std::invalid_argument("holdout_share is " + std::to_string(options.holdout_share) +
                                ", expected above 0 and at most 0.5");
  if (options.threads < 0)
    throw std::invalid_argument("threads is " + std::to_string(options.threads) + ", expected at least 0");
  for (const std::vector<std::string>* list : {&options.hypotheses, &options.given, &options.confirm})
    for (const std::string& id : *list) effectInfo(id);
}

/// @return why a training part cannot be diagnosed; empty when it can.
std::string lackOf(const Series& train) {
  if (train.size() < kLeastSamples)
    return "the training part has " + std::to_string(train.size()) + " samples, at least " +
           std::to_string(kLeastSamples) + " are needed";
  const double duration = train.time.back() - train.time.front();
  if (duration < kLeastDuration)
    return "the training part lasts " + std::to_string(static_cast<int>(duration)) + " s, at least " +
           std::to_string(static_cast<int>(kLeastDuration)) + " s are needed";
  double charge = 0.0, discharge = 0.0;
  const double gap = gapThreshold(train);
  for (std::size_t k = 1; k < train.size(); ++k) {
    const double dt = train.time[k] - train.time[k - 1];
    if (dt > gap) continue;
    charge += std::max(0.0, train.current[k]) * dt;
    discharge += std::max(0.0, -train.current[k]) * dt;
  }
  if (discharge < kLeastCharge) return "the training part hardly discharges the battery";
  if (charge + discharge < 2.0 * kLeastCharge) return "the training part hardly moves any charge";
  return "";
}

/// Whether a step is large in itself and the channel's noise is less, so that rounding is most of the error.
bool isCoarse(const Finding& quantisation, const Series& series) {
  const bool is_voltage = quantisation.unit == "V";
  if (*quantisation.value < (is_voltage ? kCoarseVoltage : kCoarseCurrent)) return false;
  const std::vector<double>& values = is_voltage ? series.voltage : series.current;
  std::size_t repeats = 0;
  for (std::size_t k = 1; k < values.size(); ++k)
    if (values[k] == values[k - 1]) ++repeats;
  return medianInterval(series) <= kSlow && static_cast<double>(repeats) > kStillShare * static_cast<double>(values.size());
}

/// The catalogue's id of a finding of the checks; empty for what is not a fault of an instrument that spoils a diagnosis.
/// One sleep of the car is not a bus that drops messages, and a gap is no fault.
std::string faultOf(const Finding& finding, const Series& series) {
  if (finding.id == "quantisation") return isCoarse(finding, series) ? finding.id : "";
  if (finding.severity == Severity::kNote) return "";
  if (finding.id == "clipping" || finding.id == "aliasing") return finding.id;
  const bool is_lost = finding.id == "stuck" || finding.id == "missing";
  const bool is_single = finding.id == "stuck" && finding.at.size() < kFewestFreezes;
  return is_lost && !is_single && static_cast<double>(finding.samples) >= kLostShare * static_cast<double>(series.size()) ? "dropouts" : "";
}

class Diagnoser {
 public:
  Diagnoser(const Recording& recording, const DiagnoseOptions& options)
      : recording_(recording), series_(recording.series), options_(options) {
    const auto held = static_cast<std::size_t>(std::ceil(options.holdout_share * static_cast<double>(series_.size())));
    train_ = {0, series_.size() - std::min(series_.size(), held)};
    holdout_ = {train_.last, series_.size()};
  }

  Diagnosis run() {
    quiet_current_ = slice(series_, train_);
    const std::string lack = lackOf(quiet_current_);
    if (!lack.empty()) return insufficient(lack);
    tell("checking the instruments");
    screenInstruments();
    tell("fitting the base model");
    fitBase();
    exchangeHalves();
    tell("locating where model and measurement part");
    locate();
    options_.given.empty() ? nameAll() : takeGiven();
    tell("describing what remains");
    weighRemainder();
    found_.verdict = judge(naming_, instruments_, remainder_, options_.thresholds);
    takeEffects();
    tell("opening the part that was held out");
    compare();
    found_.summary = summaryOf(found_);
    found_.next_experiment = nextExperiment(found_);
    return std::move(found_);
  }

 private:
  void tell(const std::string& stage) const {
    if (options_.progress) options_.progress(stage);
  }

  Diagnosis insufficient(const std::string& lack) {
    found_.verdict = Verdict::kInsufficientData;
    found_.summary = "The recording cannot answer: " + lack + ".";
    found_.next_experiment = nextExperiment(found_);
    found_.outside = outsideWhatSignalsShow();
    return std::move(found_);
  }

  void screenInstruments() {
    Recording part = recording_;
    part.series = quiet_current_;
    limits_ = instrumentLimits(part.series);
    maskBehindUnknownCharge(part.series, limits_);
    quiet_current_ = withEstimatedCurrent(part.series, limits_);
    const CurrentFlicker flicker = currentFlicker(quiet_current_);
    flicker_share_ = flicker.share;
    quiet_current_ = withoutSensorNoise(quiet_current_, flicker);
    slow_ = medianInterval(quiet_current_) > kSlow;
    for (const Finding& finding : checkRecording(part).findings) {
      const std::string fault = faultOf(finding, part.series);
      if (finding.severity == Severity::kNote && fault.empty()) continue;
      instruments_.sentences.push_back(finding.what + ": " + finding.meaning);
      if (!fault.empty()) instruments_.faults.push_back(fault);
      if (finding.id == "skew" && finding.value) alignWholeSamples(*finding.value);
    }
    std::sort(instruments_.faults.begin(), instruments_.faults.end());
    instruments_.faults.erase(std::unique(instruments_.faults.begin(), instruments_.faults.end()), instruments_.faults.end());
    found_.instrument = instruments_.sentences;
    found_.outside = outsideWhatSignalsShow();
  }

  /// A channel that is whole samples late cannot be told from physics by a fit: the current is moved to where the voltage
  /// answers to it. @param lag [s], > 0 when the voltage comes later.
  void alignWholeSamples(double lag) {
    const auto by = std::lround(lag / medianInterval(quiet_current_));
    if (!slow_ || by == 0) return;
    late_samples_ = by;
    quiet_current_.current = moved(quiet_current_.current, by);
    instruments_.faults.push_back("time_skew");
    instruments_.sentences.push_back("the current was moved by " + std::to_string(by) + " samples to meet the voltage");
  }

  /// @return values shifted to `by` samples later; what comes in at an end is its neighbour.
  static std::vector<double> moved(const std::vector<double>& values, std::ptrdiff_t by) {
    const auto last = static_cast<std::ptrdiff_t>(values.size()) - 1;
    std::vector<double> shifted(values.size());
    for (std::ptrdiff_t n = 0; n <= last; ++n)
      shifted[static_cast<std::size_t>(n)] = values[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(n - by, 0, last))];
    return shifted;
  }

  void fitBase() {
    Compression compression;
    compression.max_length = std::max(compression.max_length, kSlowLength * medianInterval(quiet_current_));
    drive_ = train_.size() > kCompressFrom ? compressedDrive(quiet_current_, train_, compression, limits_.masked)
                                           : fullDrive(quiet_current_, train_, limits_.masked);
    if (!slow_) drive_ = withoutEdges(drive_, std::numeric_limits<double>::infinity(), 0.0, kAfterEdge);
    quiet_ = slow_ ? drive_ : withoutEdges(drive_, kEdge, kBeforeEdge, kAfterEdge);
    search_.least_white = std::max(1e-5, limits_.voltage_lsb_std);
    const BatteryModel model;
    base_ = fitWhitened(model, quiet_, {typicalStart(model, quiet_)}, std::nullopt, search_);
    if (limits_.voltage_lsb_std > kCoarse * 0.001 && limits_.voltage_lsb_std > 0.5 * base_.noise.white_std &&
        !contains(instruments_.faults, "quantisation"))
      instruments_.faults.push_back("quantisation");
  }

  /// Exchange test on the halves of the training part: a half that fits better with the other's parameters than with its own
  /// tells that a search stopped early, not of physics. The base model is then searched from more starts.
  void exchangeHalves() {
    const std::size_t middle = quiet_.samples.size() / 2;
    const Drive first = partOf(quiet_, 0, middle), second = partOf(quiet_, middle, quiet_.samples.size());
    const BatteryModel model;
    WhitenedSearch once = search_;
    once.rounds = 1;
    const auto fitOf = [&](const Drive& part) { return fitWhitened(model, part, {base_.point, typicalStart(model, part)}, base_.noise, once); };
    const WhitenedFit one = fitOf(first), other = fitOf(second);
    if (!optimiserFailed(exchangeOf({&first, &second}, {&one, &other}))) return;
    found_.instrument.push_back("the base model's search stopped early in a half of the recording and was begun anew from more starts");
    WhitenedSearch wider = search_;
    wider.more_starts = 6;
    const WhitenedFit again = fitWhitened(model, quiet_, {base_.point, one.point, other.point}, base_.noise, wider);
    if (again.deviance < base_.deviance) base_ = again;
  }

  static Drive partOf(const Drive& drive, std::size_t begin, std::size_t end) {
    Drive part = drive;
    part.samples.assign(drive.samples.begin() + static_cast<std::ptrdiff_t>(begin),
                        drive.samples.begin() + static_cast<std::ptrdiff_t>(end));
    part.samples.front().step.duration = 0.0;
    part.first_time = part.samples.front().step.time;
    return part;
  }

  void locate() {
    regimes_ = regimesOf(quiet_);
    found_.regimes = regimeFindings(base_, quiet_, regimes_);
    found_.absorption = absorptionMap(base_, quiet_, regimes_);
  }

  void nameAll() {
    NamingOptions options;
    options.thresholds = options_.thresholds;
    options.threads = options_.threads;
    options.least_white = search_.least_white;
    options.interval = medianInterval(quiet_current_);
    options.progress = options_.progress;
    options.hypotheses = slowHypotheses();
    naming_ = nameEffects(quiet_, base_, options);
    const std::size_t slow_ones = naming_.accepted.size();
    if (!slow_) nameFast(options);
    if (naming_.accepted.size() != slow_ones) {
      // What the edges had bent may now be named or withdrawn.
      const WhitenedFit start = fitWhitened(naming_.extended.model, quiet_, {naming_.extended.point}, std::nullopt, search_);
      const std::vector<std::string> before = naming_.extended.model.effects();
      naming_ = nameEffects(quiet_, start, options, naming_);
      // And what had been named at the edges, without what came in now.
      if (naming_.extended.model.effects() != before) nameFast(options);
    }
    final_ = fitWhitened(naming_.extended.model, quiet_, {naming_.extended.point}, std::nullopt, search_);
    if (!slow_ && !naming_.accepted.empty())
      naming_.extended = fitWhitened(naming_.extended.model, drive_, {naming_.extended.point}, std::nullopt, search_);
    for (Accepted& accepted : naming_.accepted)
      for (const std::string& id : effectInfo(accepted.id).same_as)
        if (!contains(accepted.tied, id) && !isAccepted(id)) accepted.tied.push_back(id);
    tieSmallSkew();
    std::stable_sort(naming_.accepted.begin(), naming_.accepted.end(),
                     [](const Accepted& one, const Accepted& other) { return one.evidence > other.evidence; });
  }

  /// What is weighed on the quiet grid: what was asked for, or all that can be weighed in time.
  std::vector<std::string> slowHypotheses() {
    const bool all = options_.hypotheses.empty();
    const bool too_long = all && slow_ && quiet_current_.time.back() - quiet_current_.time.front() > kShortSteps;
    std::vector<std::string> ids;
    std::string left_out;
    for (const EffectInfo& info : effectCatalogue()) {
      if (all ? info.on_request : !contains(options_.hypotheses, info.id)) continue;
      if (!slow_ && info.acts_at_edges) continue;
      if (too_long && info.takes_short_steps)
        left_out += (left_out.empty() ? "" : ", ") + info.id;
      else
        ids.push_back(info.id);
    }
    if (too_long)
      found_.instrument.push_back("long and slowly sampled: " + left_out +
                                  " are not weighed; give a part of the recording, or name them as hypotheses");
    return ids;
  }

  /// The extended model is what was given, fitted as it would be had it been found.
  void takeGiven() {
    naming_ = withEffects(quiet_, base_, idsOf(options_.given, false), search_);
    final_ = naming_.extended;
    if (slow_) return;
    const WhitenedFit start = fitWhitened(final_.model, drive_, {final_.point}, std::nullopt, search_);
    naming_ = withEffects(drive_, start, idsOf(options_.given, true), search_, std::move(naming_));
    final_ = fitWhitened(naming_.extended.model, quiet_, {naming_.extended.point}, std::nullopt, search_);
  }

  /// @return those of the ids that act at edges alone, where there are edges; or the others.
  std::vector<std::string> idsOf(const std::vector<std::string>& ids, bool at_edges) const {
    std::vector<std::string> some;
    for (const std::string& id : ids)
      if ((!slow_ && effectInfo(id).acts_at_edges) == at_edges) some.push_back(id);
    return some;
  }

  /// A skew so small that an inductance within its bounds would show the same.
  void tieSmallSkew() {
    const auto row = naming_.extended.model.parameterRow("channel_skew");
    if (!row) return;
    const double alike = std::abs(naming_.extended.point.parameters[*row]) * naming_.extended.point.parameters[kRowRDischarge];
    for (Accepted& accepted : naming_.accepted)
      if (accepted.id == "time_skew" && alike <= effectInfo("inductance").parameters.front().upper &&
          !contains(accepted.tied, "inductance") && !isAccepted("inductance"))
        accepted.tied.push_back("inductance");
  }

  bool isAccepted(const std::string& id) const {
    return std::any_of(naming_.accepted.begin(), naming_.accepted.end(),
                       [&](const Accepted& accepted) { return accepted.id == id; });
  }

  /// What acts at edges alone, once slower physics is in: with every sample.
  void nameFast(NamingOptions options) {
    options.hypotheses.clear();
    for (const EffectInfo& info : effectCatalogue())
      if (info.acts_at_edges && (options_.hypotheses.empty() || contains(options_.hypotheses, info.id)))
        options.hypotheses.push_back(info.id);
    if (options.hypotheses.empty()) return;
    options.thresholds = fastThresholds();
    const WhitenedFit start = fitWhitened(naming_.extended.model, drive_, {naming_.extended.point}, std::nullopt, search_);
    const std::vector<Signature> screened = naming_.last_screen;
    naming_ = nameEffects(drive_, start, options, naming_);
    for (const Signature& signature : screened)
      if (!effectInfo(signature.id).acts_at_edges) naming_.last_screen.push_back(signature);
  }

  void weighRemainder() {
    // The noise of the best model there is: beside the base model it is inflated by what is looked for.
    found_.mismatch = mismatchSegments(base_, quiet_, regimes_, final_.noise);
    remainder_.base_omnibus = omnibusZ(base_, quiet_);
    remainder_.extended_omnibus = omnibusZ(final_, quiet_);
    const std::optional<SlowTone> tone = slowTone(final_, quiet_);
    remainder_.has_tone = tone.has_value();
    // A line of power P takes 2 P from the deviance.
    remainder_.left = leftUnexplained(final_, quiet_) + (tone ? 2.0 * tone->power : 0.0);
    remainder_.gained = std::max(0.0, base_.deviance - final_.deviance);
    remainder_.explained = remainder_.gained > 0.0 ? remainder_.gained / (remainder_.gained + remainder_.left) : 0.0;
    found_.omnibus_base = remainder_.base_omnibus;
    found_.omnibus_extended = remainder_.extended_omnibus;
    found_.explained = remainder_.explained;
    if (remainder_.extended_omnibus > options_.thresholds.omnibus || naming_.unnamed || tone) describeForce(tone);
    if (options_.lists_detectable) detect();
  }

  /// Everything that was weighed and is not in the model, screened beside the model as it is in the end.
  void detect() {
    std::vector<std::string> weighed, slow_ones, fast_ones;
    for (const Signature& signature : naming_.last_screen) weighed.push_back(signature.id);
    if (weighed.empty()) return;
    for (const std::string& id : addable(final_.model, weighed))
      (!slow_ && effectInfo(id).acts_at_edges ? fast_ones : slow_ones).push_back(id);
    const int threads = options_.threads;
    NameRule rule{options_.thresholds, naming_.accepted, leastGainToExplain(remainder_, options_.thresholds), search_};
    rule.confirm = options_.confirm;
    if (!rule.confirm.empty()) {
      tell("diagnosing with what could hide put in");
      rule.is_named = namedIn(final_);
    }
    found_.detectable = detectableBeside(final_, quiet_, screen(final_, quiet_, slow_ones, threads), rule, threads);
    if (fast_ones.empty()) return;
    const WhitenedFit& at_edges = naming_.extended;
    const std::vector<Signature> screened = screen(at_edges, drive_, fast_ones, threads);
    rule.thresholds = fastThresholds();
    if (!rule.confirm.empty()) rule.is_named = namedIn(at_edges);
    for (const Detectable& one : detectableBeside(at_edges, drive_, screened, rule, threads)) found_.detectable.push_back(one);
  }

  /// @return whether this diagnosis names an effect once the training part's voltage holds what it adds beside the fit.
  std::function<bool(const BatteryModel&, const CompositionPoint&, const std::string&)> namedIn(const WhitenedFit& fit) const {
    const Drive every = fullDrive(quiet_current_, train_, limits_.masked);
    const Eigen::VectorXd modelled = simulatedVoltage(fit.model, fit.point, every);
    return [this, every, modelled](const BatteryModel& larger, const CompositionPoint& point, const std::string& id) {
      const Eigen::VectorXd added = simulatedVoltage(larger, point, every) - modelled;
      if (!added.allFinite()) return false;
      Recording changed = recording_;
      for (Eigen::Index n = 0; n < added.size(); ++n) changed.series.voltage[train_.first + static_cast<std::size_t>(n)] += added[n];
      DiagnoseOptions options = options_;
      options.lists_detectable = false;
      options.threads = 1;
      options.progress = nullptr;
      const Diagnosis found = diagnose(changed, options);
      return std::any_of(found.effects.begin(), found.effects.end(), [&](const NamedEffect& effect) {
        return effect.id == id || contains(effect.tied_with, id);
      });
    };
  }

  /// Those of a search on all samples: what acts at edges alone changes little of the whole.
  DiagnosisThresholds fastThresholds() const {
    DiagnosisThresholds thresholds = options_.thresholds;
    thresholds.least_share = thresholds.least_structure_share = thresholds.least_fast_share;
    thresholds.structure_evidence = thresholds.name_evidence;
    return thresholds;
  }

  void describeForce(const std::optional<SlowTone>& tone) {
    found_.force = describeResidual(final_, quiet_);
    if (tone) {
      char text[96];
      std::snprintf(text, sizeof text, "a tone of %.1f mV with a period of %.3g s", 1e3 * tone->amplitude, tone->period);
      found_.force->terms = {text};
      found_.force->description = std::string("The residual holds ") + text + ", which follows no current. " + found_.force->description;
    }
    for (const Signature& signature : naming_.last_screen) {
      const double cosine = std::sqrt(signature.score) / std::max(1e-9, final_.innovation.norm());
      if (cosine <= found_.force->cosine) continue;
      found_.force->cosine = cosine;
      found_.force->nearest = signature.id;
    }
  }

  void takeEffects() {
    found_.candidates = naming_.candidates;
    const auto completed = [&](const WhitenedFit& fit) {
      IdentifyOptions options;
      options.effects = fit.model.effects();
      options.masked = limits_.masked;
      options.voltage_lsb_std = limits_.voltage_lsb_std;
      FittedModel model = completedModel(quiet_current_, train_, options, fit.point, fit.noise);
      fitErrors(model, quiet_current_, train_);
      model.recording = recording_.name;
      return model;
    };
    found_.base = completed(base_);
    const bool named = found_.verdict != Verdict::kUnknown && !naming_.accepted.empty();
    is_extended_ = named || !options_.given.empty();
    found_.extended = is_extended_ ? completed(naming_.extended) : found_.base;
    if (named)
      for (const Accepted& accepted : naming_.accepted) takeEffect(accepted);
    if (found_.verdict == Verdict::kSensorFault)
      for (const std::string& id : instruments_.faults) found_.effects.push_back({id, 0.95, {}, {}, 0.0, 0.0, {}});
  }

  void takeEffect(const Accepted& accepted) {
    NamedEffect effect{accepted.id, accepted.confidence, absorbedInto(), {}, accepted.evidence, accepted.rms, accepted.tied};
    for (const ParameterInfo& info : effectInfo(accepted.id).parameters)
      for (const ParameterEstimate& estimate : found_.extended.estimates)
        if (estimate.name == info.name && !estimate.held)
          effect.parameters.push_back(profiled(estimate, info, !slow_ && effectInfo(accepted.id).acts_at_edges));
    found_.effects.push_back(effect);
    for (const std::string& id : accepted.tied) {
      NamedEffect rival{id, std::max(0.0, 1.0 - accepted.confidence) / static_cast<double>(accepted.tied.size()), {}, {},
                        accepted.evidence, accepted.rms, {accepted.id}};
      for (const std::string& other : accepted.tied)
        if (other != id) rival.tied_with.push_back(other);
      found_.effects.push_back(rival);
    }
  }

  /// Interval by profile likelihood on the final fit to the quiet grid; what acts at edges alone on all samples.
  DiagnosedParameter profiled(const ParameterEstimate& estimate, const ParameterInfo& info, bool at_edges) const {
    DiagnosedParameter parameter{estimate.name, estimate.unit, estimate.value, estimate.std, std::nullopt, std::nullopt,
                                 estimate.at_bound};
    const double first = estimate.std ? 1.96 * *estimate.std : 0.2 * std::abs(estimate.value);
    if (!(first > 0.0)) return parameter;
    const ProfileInterval interval =
        at_edges ? profileInterval(naming_.extended, drive_, estimate.name, first)
                 : profileInterval(final_, quiet_, estimate.name, first);
    // Ends are carried over as distances: the other grid's optimum differs by a share of a standard error.
    const double center = (at_edges ? naming_.extended : final_).point.parameters[*final_.model.parameterRow(info.name)];
    if (interval.lower) parameter.lower = std::max(info.lower, estimate.value - (center - *interval.lower));
    if (interval.upper) parameter.upper = std::min(info.upper, estimate.value + (*interval.upper - center));
    return parameter;
  }

  /// Base parameters that moved by more than a tenth, or two standard errors, once the effects were in.
  std::vector<std::string> absorbedInto() const {
    std::vector<std::pair<double, std::string>> moved;
    for (std::size_t j = 0; j < static_cast<std::size_t>(kRowUDc); ++j) {
      const ParameterEstimate& before = found_.base.estimates[j];
      const ParameterEstimate& after = found_.extended.estimates[j];
      const double by = std::abs(before.value - after.value);
      const double noise = std::hypot(before.std.value_or(0.0), after.std.value_or(0.0));
      if (by > 0.1 * std::abs(before.value) && by > 2.0 * noise) moved.push_back({by / std::abs(before.value), before.name});
    }
    std::stable_sort(moved.begin(), moved.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    std::vector<std::string> names;
    for (const auto& one : moved) names.push_back(one.second);
    return names;
  }

  /// The whole recording: the training part as it was fitted, then what was held out, its current treated as training
  /// taught and not by what its own voltage says. Where the current is cut off it stays so.
  void openHoldOut() {
    CurrentFlicker flicker = currentFlicker(series_);
    flicker.share = flicker_share_;
    Series whole = withoutSensorNoise(series_, flicker);
    whole.current = moved(whole.current, late_samples_);
    std::copy(quiet_current_.current.begin(), quiet_current_.current.end(), whole.current.begin());
    quiet_current_ = std::move(whole);
    InstrumentLimits limits = instrumentLimits(series_);
    maskBehindUnknownCharge(series_, limits);
    std::copy(limits_.masked.begin(), limits_.masked.end(), limits.masked.begin());
    const auto begin = limits.masked.begin() + static_cast<std::ptrdiff_t>(holdout_.first);
    if (std::all_of(begin, limits.masked.end(), [](char fault) { return fault != 0; })) {
      std::fill(begin, limits.masked.end(), 0);
      found_.instrument.push_back("no sample of the part that was held out is a measurement beyond doubt; it is compared as it stands");
    }
    limits_ = std::move(limits);
  }

  void compare() {
    openHoldOut();
    found_.base_voltage = voltageOf(found_.base);
    found_.extended_voltage = is_extended_ ? voltageOf(found_.extended) : found_.base_voltage;
    Comparison& fit = found_.fit;
    fit.train = windowOf(train_);
    fit.holdout = windowOf(holdout_);
    fit.base_train = metrics(train_, found_.base_voltage, found_.base);
    fit.base_holdout = metrics(holdout_, found_.base_voltage, found_.base);
    fit.extended_train = metrics(train_, found_.extended_voltage, found_.extended);
    fit.extended_holdout = metrics(holdout_, found_.extended_voltage, found_.extended);
    compareBothWays();
    fit.regimes = compareRegimes(quiet_current_, holdout_, found_.base_voltage, found_.extended_voltage, limits_.masked);
  }

  /// The hold-out in the direction that is imposed, and beside what needs no physics.
  void compareBothWays() {
    const Source source = findSource(series_);
    found_.source_share = source.share;
    const std::optional<DrivingSource> driving = drivingSource(series_);
    const std::vector<char> drives = driving ? driving->imposes_voltage : std::vector<char>(series_.size(), 0);
    Comparison& fit = found_.fit;
    const NaivePredictor naive = fitNaive(series_, train_, drives);
    if (naive.voltage_from_current) {
      fit.naive_line = errorMetrics(series_, holdout_, predictNaive(naive, series_, {0, series_.size()}, drives).voltage,
                                    std::nullopt, limits_.masked);
      if (driving)
        takeShares(scoreNaive(naive, series_, holdout_, {drives.begin() + static_cast<std::ptrdiff_t>(holdout_.first), drives.end()}).mixed,
                   *fit.naive_line);
    }
    if (train_.size() >= kLeastForRidge) {
      std::vector<double> voltage = series_.voltage;
      const RidgePrediction ridge = ridgeVoltage(quiet_current_, train_, holdout_);
      std::copy(ridge.voltage.begin(), ridge.voltage.end(), voltage.begin() + static_cast<std::ptrdiff_t>(holdout_.first));
      fit.naive_ridge = errorMetrics(series_, holdout_, voltage, std::nullopt, limits_.masked);
    }
    if (!driving) return;
    takeShares(sharesOf(found_.base, *driving), fit.base_holdout);
    takeShares(sharesOf(found_.extended, *driving), fit.extended_holdout);
  }

  MixedScores sharesOf(FittedModel model, const DrivingSource& driving) const {
    model.source = driving.rule;
    model.voltage_lag = driving.repair.lag;
    const FollowedPrediction predicted = predictMixed(model, series_, holdout_);
    return scoreBothWays(model, series_, holdout_, predicted).mixed;
  }

  static void takeShares(const MixedScores& scores, ErrorMetrics& metrics) {
    metrics.share_percent = scores.share_percent;
    metrics.current_share_percent = scores.current_share_percent;
    metrics.voltage_share_percent = scores.voltage_share_percent;
  }

  FitWindow windowOf(IndexRange range) const {
    return {series_.time[range.first], series_.time[range.last - 1], range.size()};
  }

  ErrorMetrics metrics(IndexRange range, const std::vector<double>& voltage, const FittedModel& model) const {
    return errorMetrics(quiet_current_, range, voltage, chargeCurrentError(model, quiet_current_, range, limits_.masked), limits_.masked);
  }

  /// The whole recording from the training part's first state on.
  std::vector<double> voltageOf(const FittedModel& model) const {
    const Drive whole = fullDrive(quiet_current_, {0, series_.size()});
    CompositionPoint point{pointOf(model).parameters, Eigen::VectorXd()};
    point.state = Eigen::Map<const Eigen::VectorXd>(model.first_state.data(), static_cast<Eigen::Index>(model.first_state.size()));
    const Eigen::VectorXd voltage = simulatedVoltage(compositionOf(model), point, whole);
    return {voltage.data(), voltage.data() + voltage.size()};
  }

  const Recording& recording_;
  const Series& series_;
  const DiagnoseOptions& options_;
  Series quiet_current_;  // what the battery saw of the measured current; of the training part until the hold-out is opened
  double flicker_share_ = 1.0;
  std::ptrdiff_t late_samples_ = 0;  // that the current was moved by
  IndexRange train_, holdout_;
  std::vector<Regime> regimes_;
  InstrumentLimits limits_;
  InstrumentScreen instruments_;
  Remainder remainder_;
  bool slow_ = false, is_extended_ = false;
  Drive drive_, quiet_;
  WhitenedSearch search_;
  WhitenedFit base_, final_;
  Naming naming_;
  Diagnosis found_;
};

}  // namespace

Diagnosis diagnose(const Recording& recording, const DiagnoseOptions& options) {
  requireValid(options);
  return Diagnoser(recording, options).run();
}

}  // namespace battery_sof

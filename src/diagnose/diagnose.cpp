#include "battery_sof/diagnose/diagnose.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "battery_sof/diagnose/absorption.hpp"
#include "battery_sof/diagnose/comparison.hpp"
#include "battery_sof/diagnose/explanation.hpp"
#include "battery_sof/diagnose/hypotheses.hpp"
#include "battery_sof/diagnose/locate.hpp"
#include "battery_sof/diagnose/profile_interval.hpp"
#include "battery_sof/diagnose/regimes.hpp"
#include "battery_sof/diagnose/screening.hpp"
#include "battery_sof/diagnose/slow_tone.hpp"
#include "battery_sof/diagnose/unseen_current.hpp"
#include "battery_sof/diagnose/verdict.hpp"
#include "battery_sof/identify/composition_identification.hpp"
#include "battery_sof/identify/error_tracker.hpp"
#include "battery_sof/identify/identification.hpp"
#include "battery_sof/naive/naive_predictor.hpp"
#include "battery_sof/naive/ridge.hpp"
#include "battery_sof/predict/both_ways.hpp"
#include "battery_sof/recording/clipped_current.hpp"
#include "battery_sof/recording/fit_mask.hpp"
#include "battery_sof/recording/number_text.hpp"

namespace battery_sof {
namespace {

constexpr std::size_t kLeastForRidge = 60;  // samples, as ridgeVoltage() asks for

constexpr std::size_t kCompressFrom = 4000;  // samples
constexpr double kSlowLength = 10.0;         // sampling intervals that may be averaged where the current is held
constexpr double kEdge = 5.0;                // [A]
constexpr double kBeforeEdge = 0.1, kAfterEdge = 0.15;  // [s], docs/physics.md#noise-of-a-residual; a channel may be late
constexpr double kShortSteps = 6000.0;       // [s] of a slow recording beyond which short steps would take minutes
constexpr double kCoarse = 3.0;              // rounding to more than this many deviations of the noise
constexpr int kLeftOutBlocks = 4;
constexpr double kToldRight = 0.7;           // [1], of the families told of batteries of unknown law: docs/diagnosis.md
constexpr double kPlausible = 0.02;          // [V], what instruments may leave of a vehicle's recording
constexpr double kLowestVoltage = 10.5, kHighestVoltage = 15.5;  // [V] a block of lead-acid cells
constexpr std::size_t kTermsTold = 4;
constexpr int kConfirmations = 6;

bool contains(const std::vector<std::string>& list, const std::string& id) {
  return std::find(list.begin(), list.end(), id) != list.end();
}

void requireValid(const DiagnoseOptions& options) {
  if (!(options.holdout_share > 0.0) || !(options.holdout_share <= 0.5))
    throw std::invalid_argument("holdout_share is " + std::to_string(options.holdout_share) +
                                ", expected above 0 and at most 0.5");
  if (options.threads < 0)
    throw std::invalid_argument("threads is " + std::to_string(options.threads) + ", expected at least 0");
  const Relevance& relevance = options.relevance;
  for (const auto& [name, value] : {std::pair<const char*, double>{"rmse", relevance.rmse}, {"crank", relevance.crank}, {"charge_share", relevance.charge_share}})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw std::invalid_argument("relevance." + std::string(name) + " is " + std::to_string(value) + ", expected finite and at least 0");
  for (const std::vector<std::string>* list : {&options.hypotheses, &options.given, &options.confirm})
    for (const std::string& id : *list) effectInfo(id);
}

/// Whether a voltage is that of blocks of six lead-acid cells, one or more in a row.
bool isLeadAcid(const Series& series) {
  std::vector<double> voltage = series.voltage;
  const auto middle = voltage.begin() + static_cast<std::ptrdiff_t>(voltage.size() / 2);
  std::nth_element(voltage.begin(), middle, voltage.end());
  const double blocks = std::round(*middle / 12.8);
  return blocks >= 1.0 && *middle >= blocks * kLowestVoltage && *middle <= blocks * kHighestVoltage;
}

CompositionPoint pointOfFirst(const FittedModel& model) {
  CompositionPoint point{pointOf(model).parameters, Eigen::VectorXd()};
  point.state = Eigen::Map<const Eigen::VectorXd>(model.first_state.data(), static_cast<Eigen::Index>(model.first_state.size()));
  return point;
}

ModelPoint beginning(const CompositionPoint& point, const Drive& drive) {
  return {point.parameters, point.state, drive.first_time, drive.first_time};
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
    const Series train = slice(series_, train_);
    found_.outside = outsideWhatSignalsShow();
    const std::string lack = lackOf(train);
    if (!lack.empty()) return insufficient(lack);
    tell("checking the instruments");
    screened_ = screenInstruments(recording_, train);
    found_.instrument = screened_.sentences;
    tell("fitting the base model");
    fitBase();
    exchangeHalves();
    tell("locating where model and measurement part");
    locate();
    explainErrors();
    tell("learning what no equation stands for");
    fitFinal();
    learn();
    judgeIt();
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
    tellSource();
    found_.next_experiment = nextExperiment(found_);
    return std::move(found_);
  }

  void tellSource() {
    found_.source = overviewOf(findSource(series_), series_);
    found_.source_share = found_.source.share;
  }

  void fitBase() {
    const Series& series = screened_.series;
    Compression compression;
    compression.max_length = std::max(compression.max_length, kSlowLength * medianInterval(series));
    drive_ = train_.size() > kCompressFrom ? compressedDrive(series, train_, compression, screened_.limits.masked)
                                           : fullDrive(series, train_, screened_.limits.masked);
    if (!screened_.slow) drive_ = withoutEdges(drive_, std::numeric_limits<double>::infinity(), 0.0, kAfterEdge);
    quiet_ = screened_.slow ? drive_ : withoutEdges(drive_, kEdge, kBeforeEdge, kAfterEdge);
    const double lsb = screened_.limits.voltage_lsb_std;
    search_.least_white = std::max(1e-5, lsb);
    const BatteryModel model;
    base_ = fitWhitened(model, quiet_, {typicalStart(model, quiet_)}, std::nullopt, search_);
    if (lsb > kCoarse * 0.001 && lsb > 0.5 * base_.noise.white_std && !contains(screened_.faults, "quantisation"))
      screened_.faults.push_back("quantisation");
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

  /// Families and effects, in the direction that is imposed. Who imposes what is told from samples of one instant: where a slow
  /// recording's channels turn out to be shifted, a step that one of them shows late looked like a source, and the current drives.
  void explainErrors() {
    driving_ = drivingSource(screened_.series);
    const std::vector<std::string> ids = hypotheses();
    explainErrors(ids);
    if (!driving_ || !screened_.slow || !contains(explained_.model.effects(), "time_skew")) return;
    const Explanation behind_source = std::exchange(explained_, Explanation());
    const std::optional<DrivingSource> source = std::exchange(driving_, std::nullopt);
    explainErrors(ids);
    // Behind a source that is there the current alone never tells the voltage to what instruments leave, whatever the shift.
    if (contains(explained_.model.effects(), "time_skew") && explained_.noise < kPlausible) return;
    explained_ = behind_source;
    driving_ = source;
  }

  void explainErrors(const std::vector<std::string>& ids) {
    const Series& series = screened_.series;
    std::vector<char> masked = screened_.limits.masked;
    Series sound = series;
    if (driving_) {
      sound = repaired(series, driving_->repair);
      for (std::size_t n = 0; n < masked.size(); ++n) masked[n] = masked[n] || driving_->repair.dropped[n];
    }
    const Drive imposed = fullDrive(sound, train_, masked, driving_ ? driving_->imposes_voltage : std::vector<char>());
    const BatteryModel circuit;
    const BaseResponse response = baseResponse(circuit, beginning(base_.point, imposed), imposed, imposed.samples.size());
    const ForceTable table = forceTable(imposed, response, base_.point.parameters[kRowBeta]);
    ExplanationRules rules;
    rules.relevance = options_.relevance;
    explained_ = explain(imposed, imposed.samples.size(), table, base_.point, ids, options_.given, rules, options_.progress);
  }

  std::vector<std::string> hypotheses() {
    if (options_.hypotheses.empty() && !isLeadAcid(screened_.series)) {
      found_.instrument.push_back("the voltage is not that of lead-acid blocks: what is missing is learnt and gets no lead-acid name");
      return {};
    }
    std::vector<std::string> ids = hypothesesOf(options_.hypotheses, driving_.has_value());
    const double span = screened_.series.time.back() - screened_.series.time.front();
    if (!options_.hypotheses.empty() || !screened_.slow || span <= kShortSteps) return ids;
    std::string left_out;
    for (const std::string& id : ids)
      if (effectInfo(id).takes_short_steps) left_out += (left_out.empty() ? "" : ", ") + id;
    ids.erase(std::remove_if(ids.begin(), ids.end(), [](const std::string& id) { return effectInfo(id).takes_short_steps; }), ids.end());
    found_.instrument.push_back("long and slowly sampled: " + left_out +
                                " are not weighed; give a part of the recording, or name them as hypotheses");
    return ids;
  }

  /// The composition under a noise model, for intervals and for the model that is handed on.
  void fitFinal() {
    const auto& ids = explained_.model.effects();
    at_edges_ = !screened_.slow && std::any_of(ids.begin(), ids.end(), [](const std::string& id) { return effectInfo(id).acts_at_edges; });
    if (screened_.slow) quiet_ = withUnseen(quiet_, explained_.model, explained_.point, explained_.noise);
    final_ = ids.empty() ? base_ : fitWhitened(explained_.model, finalDrive(), {explained_.point}, std::nullopt, search_);
    found_.mismatch = mismatchSegments(base_, quiet_, regimes_, at_edges_ ? base_.noise : final_.noise);
  }

  const Drive& finalDrive() const { return at_edges_ ? drive_ : quiet_; }

  /// What currents and their memory say of the voltage beside the model, by blocks that are left out.
  void learn() {
    const Drive full = fullDrive(screened_.series, train_, screened_.limits.masked);
    const WhitenedFit& beside = driving_ ? base_ : final_;
    BaseResponse response = baseResponse(beside.model, beginning(beside.point, full), full, full.samples.size());
    takeForceDirections(response, beside.model, beginning(beside.point, full), full);
    const ForceTable table = forceTable(full, response, beside.point.parameters[kRowBeta]);
    LearnedFinding learned;
    learned.left_out = leftOutErrors(response, table, kLeftOutBlocks, isTimeless);
    ForceFit fit = learnForce(response, table, isTimeless);
    learned.force = std::move(fit.force);
    learned.families = std::move(fit.families);
    learned.rms = fit.rms;
    const double limit = std::max(options_.relevance.rmse, 0.5 * fit.noise);
    const bool matters = learned.rms >= limit;
    found_.left = {explained_.left_rms, explained_.left_crank, explained_.left_charge_share, options_.relevance};
    found_.left.limits.rmse = explained_.relevant;
    // Where nothing else came in, it alone would be the alarm: it takes as much evidence as any other component.
    const bool is_evident = !explained_.components.empty() || fit.gain >= ExplanationRules().least_gain;
    learned.is_used = matters && is_evident && learned.left_out.force < learned.left_out.base;
    if (!learned.is_used && learned.left_out.base <= kPlausible) return;
    describeLearned(learned);
    if (learned.is_used) withForce_ = composedWith(beside, std::make_shared<const LearnedForce>(learned.force));
    const std::vector<double>& current = screened_.series.current;
    const auto [least, most] = std::minmax_element(current.begin(), current.begin() + static_cast<std::ptrdiff_t>(train_.last));
    learned.curve = curveOf(learned.force, *least, *most);
    found_.learned = std::move(learned);
  }

  /// A fit with a force beside it, as it was learnt.
  static WhitenedFit composedWith(const WhitenedFit& beside, std::shared_ptr<const LearnedForce> force) {
    WhitenedFit fit = beside;
    fit.model = withForce(beside.model, std::move(force));
    fit.point.parameters = withFactors(fit.model, beside.point.parameters);
    return fit;
  }

  static void describeLearned(LearnedFinding& learned) {
    learned.answers = answersOf(learned.force, learned.answer_current);
    std::vector<std::pair<double, std::string>> terms;
    for (Eigen::Index k = 0; k < learned.force.weight.size(); ++k)
      terms.push_back({std::abs(learned.force.weight[k]), describe(learned.force.columns[static_cast<std::size_t>(k)])});
    std::stable_sort(terms.begin(), terms.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& term : terms)
      if (learned.terms.size() < kTermsTold && !contains(learned.terms, term.second)) learned.terms.push_back(term.second);
    char text[200];
    printClassic(text, sizeof text, "What the currents and their memory say beside the equations moves the voltage by %.1f mV RMS and takes "
                  "the error on left-out blocks from %.1f to %.1f mV.", 1e3 * learned.rms, 1e3 * learned.left_out.base,
                  1e3 * learned.left_out.force);
    learned.description = text;
  }

  void judgeIt() {
    Unexplained rest;
    rest.is_tone = slowTone(final_, finalDrive()).has_value();
    rest.is_learned = found_.learned && found_.learned->is_used;
    rest.rmse = found_.learned ? found_.learned->left_out.base : 0.0;
    rest.plausible = kPlausible;
    found_.verdict = judge(explained_, {screened_.faults, screened_.sentences}, rest);
    found_.evidence_base = explained_.base_evidence;
    found_.evidence_extended = explained_.evidence;
    found_.temper = explained_.temper;
    // The evidence weighs families against each other and does not know that a battery's law may be none of them.
    for (Component& one : explained_.components) one.probability *= kToldRight;
    if (!explained_.components.empty()) {
      found_.family = explained_.components.front().family;
      found_.probability = explained_.components.front().probability;
    } else if (found_.verdict == Verdict::kUnknown && rest.is_learned && !found_.learned->families.empty()) {
      found_.family = found_.learned->families.front().family;
    }
    takeCandidates();
    if (options_.lists_detectable) takeDetectable();
  }

  const Component* componentOf(const std::string& id) const {
    for (const Component& one : explained_.components)
      if (one.member == id) return &one;
    return nullptr;
  }

  /// Every effect that was fitted once, with its best gain and why it was not taken.
  void takeCandidates() {
    ExplanationRules rules;
    double best = 0.0;
    for (const WeighedMember& one : explained_.weighed) best = std::max(best, one.gain);
    for (const WeighedMember& one : explained_.weighed) {
      const auto known = std::find_if(found_.candidates.begin(), found_.candidates.end(), [&](const Candidate& c) { return c.id == one.id; });
      if (known == found_.candidates.end())
        found_.candidates.push_back({one.id, one.gain, 0.0, "", familyId(familyOf(one.id))});
      else
        known->evidence = std::max(known->evidence, one.gain);
    }
    for (Candidate& candidate : found_.candidates) {
      if (const Component* accepted = componentOf(candidate.id)) {
        candidate.evidence = accepted->gain;
        candidate.confidence = accepted->probability;
      } else {
        candidate.rejected_because = rejection(candidate, rules);
      }
    }
    std::stable_sort(found_.candidates.begin(), found_.candidates.end(), [](const Candidate& a, const Candidate& b) {
      return std::make_pair(a.rejected_because.empty(), a.evidence) > std::make_pair(b.rejected_because.empty(), b.evidence);
    });
  }

  std::string rejection(const Candidate& candidate, const ExplanationRules& rules) const {
    for (const Component& one : explained_.components)
      if (contains(one.tied, candidate.id)) return "does as well as " + one.member + ", which stands in the model";
    if (candidate.evidence < rules.least_gain) return "the recording hardly speaks for it";
    return explained_.components.empty() ? "what it adds is too small to matter" : "what was taken instead explains more of the error";
  }

  void takeDetectable() {
    for (const LeastStrength& least : explained_.least) {
      if (least.parameter.empty()) continue;
      Detectable one{least.id, least.parameter, least.unit, least.strength, least.typical, false};
      if (contains(options_.confirm, one.id)) confirm(one);
      one.visible = one.strength && std::abs(*one.strength) <= std::abs(one.typical);
      found_.detectable.push_back(one);
    }
  }

  /// Raises a strength until a diagnosis of the recording with the effect put in names it; none where that fails.
  void confirm(Detectable& one) const {
    tell("diagnosing with " + one.id + " put in");
    const BatteryModel larger = enlarged(final_.model, one.id);
    const ParameterInfo& info = larger.parameters()[static_cast<std::size_t>(*larger.parameterRow(one.parameter))];
    for (int round = 0; round < kConfirmations && one.strength; ++round) {
      CompositionPoint point = embedded(final_.model, final_.point, larger);
      for (const ParameterInfo& other : larger.parameters())
        if (!final_.model.parameterRow(other.name)) point.parameters[*larger.parameterRow(other.name)] = other.magnitude;
      point.parameters[*larger.parameterRow(one.parameter)] = *one.strength;
      if (isNamedWith(larger, point, one.id)) return;
      const double gone = info.vanishes_at.value_or(0.0);
      const double next = gone + 2.0 * (*one.strength - gone);
      one.strength = next >= info.lower && next <= info.upper ? std::optional<double>(next) : std::nullopt;
    }
    one.strength.reset();
  }

  bool isNamedWith(const BatteryModel& larger, const CompositionPoint& point, const std::string& id) const {
    const Drive every = fullDrive(screened_.series, train_, screened_.limits.masked);
    const Eigen::VectorXd added = simulatedVoltage(larger, point, every) - simulatedVoltage(final_.model, final_.point, every);
    if (!added.allFinite()) return false;
    Recording changed = recording_;
    for (Eigen::Index n = 0; n < added.size(); ++n) changed.series.voltage[train_.first + static_cast<std::size_t>(n)] += added[n];
    DiagnoseOptions options = options_;
    options.lists_detectable = false;
    options.confirm.clear();
    options.progress = nullptr;
    const Diagnosis found = diagnose(changed, options);
    return std::any_of(found.effects.begin(), found.effects.end(),
                       [&](const NamedEffect& effect) { return effect.id == id || contains(effect.tied_with, id); });
  }

  FittedModel completed(const WhitenedFit& fit) const {
    IdentifyOptions options;
    options.effects = fit.model.effects();
    options.force = fit.model.force();
    options.masked = screened_.limits.masked;
    options.voltage_lsb_std = screened_.limits.voltage_lsb_std;
    FittedModel model = completedModel(screened_.series, train_, options, fit.point, fit.noise);
    fitErrors(model, screened_.series, train_);
    model.recording = recording_.name;
    return model;
  }

  void takeEffects() {
    found_.base = completed(base_);
    has_effects_ = !explained_.model.effects().empty();
    found_.extended = driving_ ? found_.base : withForce_ ? completed(*withForce_) : has_effects_ ? completed(final_) : found_.base;
    if (driving_) takeBothWays();
    if (found_.verdict == Verdict::kUnknown || found_.verdict == Verdict::kNoMismatch) return;
    for (const Component& one : explained_.components)
      if (!one.member.empty()) takeEffect(one);
    if (found_.verdict == Verdict::kSensorFault)
      for (const std::string& id : screened_.faults)
        found_.effects.push_back({id, 0.95, {}, {}, 0.0, 0.0, {}, familyId(Family::kInstrument), 0.95});
  }

  /// Where a source drives, both models are fitted in the direction that is imposed; the extended one with what its window teaches.
  void takeBothWays() {
    IdentifyOptions options;
    options.masked = screened_.limits.masked;
    options.source = driving_;
    base_both_ways_ = identify(screened_.series, train_, options);
    options.effects = explained_.model.effects();
    options.chooses_effects = !has_effects_;
    found_.extended = has_effects_ || !explained_.components.empty() ? identify(screened_.series, train_, options) : base_both_ways_;
    found_.extended.recording = recording_.name;
    base_both_ways_.learned = LearnedResidual();
    base_both_ways_.experience = Experience();
  }

  void takeEffect(const Component& one) {
    NamedEffect effect{one.member, one.probability, absorbedInto(), {}, one.gain, one.rms, one.tied, familyId(one.family), one.probability};
    for (const ParameterInfo& info : effectInfo(one.member).parameters)
      for (const ParameterEstimate& estimate : found_.extended.estimates)
        if (estimate.name == info.name && !estimate.held) effect.parameters.push_back(profiled(estimate, info));
    const double each = one.probability / static_cast<double>(1 + one.tied.size());
    if (!one.tied.empty()) effect.confidence = each;
    found_.effects.push_back(effect);
    for (const std::string& id : one.tied) {
      NamedEffect rival{id, each, {}, {}, one.gain, one.rms, {one.member}, familyId(familyOf(id)), one.probability};
      for (const std::string& other : one.tied)
        if (other != id) rival.tied_with.push_back(other);
      found_.effects.push_back(rival);
    }
  }

  /// Interval by profile likelihood.
  DiagnosedParameter profiled(const ParameterEstimate& estimate, const ParameterInfo& info) const {
    DiagnosedParameter parameter{estimate.name, estimate.unit, estimate.value, estimate.std, std::nullopt, std::nullopt,
                                 estimate.at_bound};
    const double first = estimate.std ? 1.96 * *estimate.std : 0.2 * std::abs(estimate.value);
    if (!(first > 0.0)) return parameter;
    const ProfileInterval interval = profileInterval(final_, finalDrive(), estimate.name, first);
    // Ends are carried over as distances: the other grid's optimum differs by a share of a standard error.
    const double center = final_.point.parameters[*final_.model.parameterRow(info.name)];
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
    whole_ = treatedAsScreened(series_, screened_);
    InstrumentLimits limits = instrumentLimits(series_);
    maskBehindUnknownCharge(series_, limits);
    std::copy(screened_.limits.masked.begin(), screened_.limits.masked.end(), limits.masked.begin());
    const auto begin = limits.masked.begin() + static_cast<std::ptrdiff_t>(holdout_.first);
    if (std::all_of(begin, limits.masked.end(), [](char fault) { return fault != 0; })) {
      std::fill(begin, limits.masked.end(), 0);
      found_.instrument.push_back("no sample of the part that was held out is a measurement beyond doubt; it is compared as it stands");
    }
    masked_ = std::move(limits.masked);
  }

  void compare() {
    openHoldOut();
    found_.base_voltage = voltageOf(found_.base);
    found_.extended_voltage = extendedVoltage();
    Comparison& fit = found_.fit;
    fit.train = windowOf(train_);
    fit.holdout = windowOf(holdout_);
    fit.base_train = metrics(train_, found_.base_voltage, found_.base);
    fit.base_holdout = metrics(holdout_, found_.base_voltage, found_.base);
    fit.extended_train = metrics(train_, found_.extended_voltage, found_.extended);
    fit.extended_holdout = metrics(holdout_, found_.extended_voltage, found_.extended);
    compareBothWays();
    fit.regimes = compareRegimes(whole_, holdout_, found_.base_voltage, found_.extended_voltage, masked_);
    for (Candidate& candidate : found_.candidates)
      if (candidate.rejected_because.empty() && fit.base_holdout.rmse > 0.0)
        candidate.holdout_gain_percent = 100.0 * (1.0 - fit.extended_holdout.rmse / fit.base_holdout.rmse);
    if (fit.extended_holdout.rmse > fit.base_holdout.rmse) withhold();
  }

  /// What predicts the hold-out worse than the base model is told and not given. Where a source drives, the model that is handed on
  /// answers in the other direction and stays.
  void withhold() {
    Comparison& fit = found_.fit;
    found_.withheld_rmse = fit.extended_holdout.rmse;
    found_.extended_voltage = found_.base_voltage;
    if (found_.learned) found_.learned->is_used = false;
    if (driving_) {
      takeErrorsOfBase(fit.base_train, fit.extended_train);
      takeErrorsOfBase(fit.base_holdout, fit.extended_holdout);
    } else {
      found_.extended = found_.base;
      fit.extended_train = fit.base_train;
      fit.extended_holdout = fit.base_holdout;
    }
    fit.regimes = compareRegimes(whole_, holdout_, found_.base_voltage, found_.extended_voltage, masked_);
  }

  static void takeErrorsOfBase(const ErrorMetrics& base, ErrorMetrics& extended) {
    const ErrorMetrics shares = std::exchange(extended, base);
    extended.share_percent = shares.share_percent;
    extended.current_share_percent = shares.current_share_percent;
    extended.voltage_share_percent = shares.voltage_share_percent;
  }

  /// Where a source drives, what was learnt of the voltage from the current; the model that is handed on answers in the other direction.
  std::vector<double> extendedVoltage() const {
    if (!driving_) return voltageOf(found_.extended);
    return withForce_ ? voltageOf(withForce_->model, withForce_->point) : found_.base_voltage;
  }

  /// The hold-out in the direction that is imposed, and beside what needs no physics.
  void compareBothWays() {
    tellSource();
    const std::optional<DrivingSource> driving = drivingSource(series_);
    const std::vector<char> drives = driving ? driving->imposes_voltage : std::vector<char>(series_.size(), 0);
    Comparison& fit = found_.fit;
    const NaivePredictor naive = fitNaive(series_, train_, drives);
    if (naive.voltage_from_current) {
      fit.naive_line = errorMetrics(series_, holdout_, predictNaive(naive, series_, {0, series_.size()}, drives).voltage,
                                    std::nullopt, masked_);
      if (driving)
        takeShares(scoreNaive(naive, series_, holdout_, {drives.begin() + static_cast<std::ptrdiff_t>(holdout_.first), drives.end()}).mixed,
                   *fit.naive_line);
    }
    if (train_.size() >= kLeastForRidge) {
      std::vector<double> voltage = series_.voltage;
      const RidgePrediction ridge = ridgeVoltage(whole_, train_, holdout_);
      std::copy(ridge.voltage.begin(), ridge.voltage.end(), voltage.begin() + static_cast<std::ptrdiff_t>(holdout_.first));
      fit.naive_ridge = errorMetrics(series_, holdout_, voltage, std::nullopt, masked_);
    }
    if (!driving) return;
    takeShares(sharesOf(driving_ ? base_both_ways_ : found_.base, *driving), fit.base_holdout);
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
    return errorMetrics(whole_, range, voltage, chargeCurrentError(model, whole_, range, masked_), masked_);
  }

  /// The whole recording from the training part's first state on.
  std::vector<double> voltageOf(const FittedModel& model) const { return voltageOf(compositionOf(model), pointOfFirst(model)); }
  std::vector<double> voltageOf(const BatteryModel& model, const CompositionPoint& point) const {
    const Eigen::VectorXd voltage = simulatedVoltage(model, point, fullDrive(whole_, {0, series_.size()}));
    return {voltage.data(), voltage.data() + voltage.size()};
  }

  const Recording& recording_;
  const Series& series_;
  const DiagnoseOptions& options_;
  IndexRange train_, holdout_;
  Screening screened_;
  Series whole_;             // the whole recording, its current treated as training taught; from openHoldOut() on
  std::vector<char> masked_;
  std::vector<Regime> regimes_;
  bool at_edges_ = false, has_effects_ = false;
  Drive drive_, quiet_;
  WhitenedSearch search_;
  WhitenedFit base_, final_;
  std::optional<WhitenedFit> withForce_;  // where what was learnt is used
  std::optional<DrivingSource> driving_;
  FittedModel base_both_ways_;
  Explanation explained_;
  Diagnosis found_;
};

}  // namespace

Diagnosis diagnose(const Recording& recording, const DiagnoseOptions& options) {
  requireValid(options);
  return Diagnoser(recording, options).run();
}

}  // namespace battery_sof

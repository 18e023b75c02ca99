#include "diagnosis/change.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "estimation/identification.hpp"
#include "model/mechanism.hpp"
#include "prediction/scores.hpp"
#include "recording/checks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

// Spread between sound trips of one battery: standard deviation of the difference of two.
// `scripts/change_study --spread` prints what pairs of real recordings show (docs/changes.md).
constexpr double kResistancesTogether = 0.08;  // [1], of all resistances: temperature
constexpr double kResistanceApart = 0.04;      // [1], of each
constexpr double kResistanceLeast = 3e-4;      // [Ohm], of each
constexpr double kBlockedSpread = 0.2;         // [A]
constexpr double kTapSpread[kTaps] = {0.03, 0.04, 0.07, 0.11, 0.06, 0.04, 0.03, 0.03, 0.03};
// of each where rows are less than kFastRow apart: loggers whose channels are not sampled together
constexpr double kFastTapSpread = 0.12, kFastRow = 0.25;  // [1], [s]

constexpr double kLeastGain = 8.0;  // of D; see docs/decisions/0021-changes-against-a-reference.md
constexpr double kAlike = 4.0;      // of D: two standard errors
constexpr double kNinety = 2.71;    // of D, the 90 % interval of one strength
constexpr double kPower = 1.28;     // standard errors above a limit in nine of ten cases
constexpr double kAnotherBattery = 1.0;  // mean of ln ratios of errors
// of D, what a shift of the channels may leave where they look as if the sign were wrong
constexpr double kExplained = 0.2;
constexpr std::size_t kFewestRows = 300;
constexpr std::size_t kFewestFeatures = 8;

enum class Kind { kContact, kGain, kOffset, kSkew, kLag };

struct Family {
  Kind kind;
  const char* id;
  const char* unit;
  std::vector<double> grid;  // ascending; strengths in unit, of kSkew and kLag in rows
  bool continuous = true;
};

const std::vector<Family>& families() {
  static const std::vector<Family> all = {
      {Kind::kContact,
       "contact_resistance",
       "ohm",
       {-0.004, -0.002, -0.001, -0.0005, 0.0005, 0.001, 0.002, 0.003, 0.004, 0.006, 0.009, 0.014,
        0.02}},
      {Kind::kGain,
       "current_gain",
       "1",
       {-0.3, -0.2, -0.14, -0.1, -0.06, -0.03, 0.03, 0.06, 0.1, 0.14, 0.2, 0.3}},
      {Kind::kOffset,
       "current_offset",
       "A",
       {-5.0, -3.0, -2.0, -1.2, -0.8, -0.4, 0.4, 0.8, 1.2, 2.0, 3.0, 5.0}},
      {Kind::kSkew, "time_skew", "s", {-3, -2, -1, 1, 2, 3}, false},
      // > 0: the voltage lags; < 0: the current
      {Kind::kLag, "sensor_lag", "s", {-5, -3, -2, -1.3, -0.7, 0.7, 1.3, 2, 3, 5}},
  };
  return all;
}

void lag(std::vector<double>& values, const std::vector<double>& time, double constant) {
  for (std::size_t n = 1; n < values.size(); ++n) {
    const double kept = std::exp(-(time[n] - time[n - 1]) / constant);
    values[n] = kept * values[n - 1] + (1.0 - kept) * values[n];
  }
}

/// What the recording would be had its instruments been changed so. @param strength as in the grid.
ResponseRows withChange(ResponseRows rows, Kind kind, double strength) {
  switch (kind) {
    case Kind::kContact:
      for (std::size_t n = 0; n < rows.size(); ++n) rows.voltage[n] += strength * rows.current[n];
      break;
    case Kind::kGain:
      for (double& current : rows.current) current *= 1.0 + strength;
      break;
    case Kind::kOffset:
      for (double& current : rows.current) current += strength;
      break;
    case Kind::kSkew:  // d > 0: the voltage comes late, the current early
      return withCurrentMoved(std::move(rows), -static_cast<int>(std::lround(strength)));
    case Kind::kLag:
      lag(strength > 0.0 ? rows.voltage : rows.current, rows.time,
          std::abs(strength) * rows.interval);
      break;
  }
  return rows;
}

/// Variance between two sound trips. @param interval [s], between rows. @param trips half of 1/number
/// of the one + 1/number of the other.
Eigen::MatrixXd betweenTrips(const Eigen::VectorXd& then, double interval, double trips) {
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(kResponseFeatures, kResponseFeatures);
  Eigen::VectorXd together = Eigen::VectorXd::Zero(kResponseFeatures);
  for (const int k : {kEdgeResistance, kSlowEdgeResistance}) {
    together[k] = kResistancesTogether * then[k];
    spread(k, k) = std::pow(kResistanceApart * then[k], 2) + std::pow(kResistanceLeast, 2);
  }
  spread(kBlockedCurrent, kBlockedCurrent) = std::pow(kBlockedSpread, 2);
  for (int tap = 0; tap < kTaps; ++tap)
    spread(kFirstTap + tap, kFirstTap + tap) =
        std::pow(interval < kFastRow ? kFastTapSpread : kTapSpread[tap], 2);
  return trips * (spread + together * together.transpose());
}

/// NOW's features against those of the reference with a change put in.
class Comparison {
 public:
  Comparison(const std::vector<Series>& now, const std::vector<Series>& then) {
    for (const Series& one : then) then_.push_back(responseRows(one));
    scale_ = responseScale(then_.front());
    std::vector<ResponseFeatures> features;
    for (const Series& one : now) features.push_back(responseFeatures(responseRows(one), scale_));
    now_ = meanOf(features);
    reference_ = featuresWith(Kind::kOffset, 0.0);
    trips_ = 0.5 * (1.0 / static_cast<double>(now.size()) + 1.0 / static_cast<double>(then.size()));
    for (int k = 0; k < kResponseFeatures; ++k)
      if (now_.known[k] && reference_.known[k]) compared_.push_back(k);
    ResponseFeatures alike = now_;
    alike.value = reference_.value;
    level_ = distance(reference_, alike);
  }

  const std::vector<int>& compared() const { return compared_; }
  const ResponseFeatures& now() const { return now_; }
  const ResponseFeatures& reference() const { return reference_; }
  double interval() const { return then_.front().interval; }
  double spreadOf(int k) const {
    return std::sqrt(betweenTrips(reference_.value, interval(), trips_)(k, k));
  }
  double currentScale() const { return scale_.current; }
  /// ln determinant of V with nothing changed: D counts from there.
  double level() const { return level_; }

  ResponseFeatures featuresWith(Kind kind, double strength) const {
    std::vector<ResponseFeatures> features;
    for (const ResponseRows& rows : then_)
      features.push_back(
          responseFeatures(strength == 0.0 ? rows : withChange(rows, kind, strength), scale_));
    return meanOf(features);
  }

  /// -2 ln likelihood, but for a constant that is the same for every change.
  double distance(const ResponseFeatures& expected, const ResponseFeatures& seen) const {
    const auto size = static_cast<Eigen::Index>(compared_.size());
    const Eigen::MatrixXd spread = betweenTrips(expected.value, interval(), trips_);
    Eigen::VectorXd difference(size);
    Eigen::MatrixXd variance(size, size);
    for (Eigen::Index k = 0; k < size; ++k) {
      const int row = compared_[k];
      if (!expected.known[row]) return HUGE_VAL;
      difference[k] = seen.value[row] - expected.value[row];
      for (Eigen::Index m = 0; m < size; ++m)
        variance(k, m) = seen.covariance(row, compared_[m]) +
                         expected.covariance(row, compared_[m]) + spread(row, compared_[m]);
    }
    const Eigen::LDLT<Eigen::MatrixXd> factors(variance);
    const double log_determinant = factors.vectorD().array().max(1e-30).log().sum();
    return difference.dot(factors.solve(difference)) + log_determinant;
  }
  double nothing() const { return distance(reference_, now_) - level(); }
  double withChangeOf(Kind kind, double strength) const {
    return distance(featuresWith(kind, strength), now_) - level();
  }
  /// By how much D would fall if a change of this strength were all that has changed.
  double visible(Kind kind, double strength) const {
    const ResponseFeatures changed = featuresWith(kind, strength);
    return distance(reference_, changed) - distance(changed, changed);
  }

 private:
  std::vector<ResponseRows> then_;
  ResponseScale scale_;
  ResponseFeatures now_, reference_;
  double trips_ = 1.0, level_ = 0.0;
  std::vector<int> compared_;
};

/// A family's best strength.
struct Weighed {
  const Family* family = nullptr;
  double strength = 0.0, distance = HUGE_VAL;
  double lower = 0.0, upper = 0.0;
};

double refined(const Comparison& comparison, Weighed& best, double low, double high) {
  constexpr double kGolden = 0.618033988749895;
  double a = low, b = high;
  double c = b - kGolden * (b - a), d = a + kGolden * (b - a);
  double at_c = comparison.withChangeOf(best.family->kind, c);
  double at_d = comparison.withChangeOf(best.family->kind, d);
  for (int step = 0; step < 9; ++step) {
    if (at_c < at_d) {
      b = d, d = c, at_d = at_c;
      c = b - kGolden * (b - a);
      at_c = comparison.withChangeOf(best.family->kind, c);
    } else {
      a = c, c = d, at_c = at_d;
      d = a + kGolden * (b - a);
      at_d = comparison.withChangeOf(best.family->kind, d);
    }
  }
  if (std::min(at_c, at_d) < best.distance) {
    best.strength = at_c < at_d ? c : d;
    best.distance = std::min(at_c, at_d);
  }
  return best.distance;
}

Weighed weigh(const Comparison& comparison, const Family& family) {
  Weighed best{&family};
  std::size_t at = 0;
  const double scale = family.kind == Kind::kOffset ? comparison.currentScale() : 1.0;
  std::vector<double> grid = family.grid;
  for (double& strength : grid) strength *= scale;
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double distance = comparison.withChangeOf(family.kind, grid[k]);
    if (distance >= best.distance) continue;
    best.distance = distance;
    best.strength = grid[k];
    at = k;
  }
  if (!family.continuous || !std::isfinite(best.distance)) return best;
  const auto neighbour = [&](std::size_t k, bool above) {
    if (above) return k + 1 < grid.size() ? grid[k + 1] : grid[k];
    return k > 0 ? grid[k - 1] : grid[k];
  };
  double low = neighbour(at, false), high = neighbour(at, true);
  // A lag of one channel does not go over into one of the other.
  if (family.kind == Kind::kLag && low * best.strength <= 0.0)
    low = best.strength > 0.0 ? 0.3 : low;
  if (family.kind == Kind::kLag && high * best.strength <= 0.0)
    high = best.strength < 0.0 ? -0.3 : high;
  refined(comparison, best, low, high);
  return best;
}

/// Where D rises by kNinety on one side.
double bound(const Comparison& comparison, const Weighed& of, bool above) {
  const Family& family = *of.family;
  const double limit = of.distance + kNinety;
  const auto isBeyond = [&](double strength) {
    return comparison.withChangeOf(family.kind, strength) > limit;
  };
  double inside = of.strength, step = std::max(0.25 * std::abs(of.strength), 1e-4);
  double outside = inside;
  for (int k = 0; k < 6; ++k, step *= 2.0) {
    outside = of.strength + (above ? step : -step);
    if (family.kind == Kind::kLag && outside * of.strength <= 0.0)
      return of.strength > 0.0 ? 0.0 : -0.0;
    if (isBeyond(outside)) break;
    inside = outside;
  }
  for (int k = 0; k < 6; ++k) {
    const double middle = 0.5 * (inside + outside);
    (isBeyond(middle) ? outside : inside) = middle;
  }
  return inside;
}

void addInterval(const Comparison& comparison, Weighed& of) {
  if (!of.family->continuous) {
    of.lower = of.strength - 0.5;
    of.upper = of.strength + 0.5;
    return;
  }
  of.lower = bound(comparison, of, false);
  of.upper = bound(comparison, of, true);
}

bool isInRows(Kind kind) { return kind == Kind::kSkew || kind == Kind::kLag; }

/// What no current and voltage can tell from a change, whatever is recorded.
std::vector<std::string> alwaysAlike(Kind kind, double strength) {
  if (kind == Kind::kContact) return {"r_discharge", "r_charge"};
  if (kind == Kind::kOffset && strength > 0.0) return {"parasitic_load", "gassing"};
  return {};
}

std::vector<Change> changesOf(const Comparison& comparison, std::vector<Weighed> weighed) {
  const double nothing = comparison.nothing();
  const Weighed best = weighed.front();
  double all = std::exp(-0.5 * (nothing - kLeastGain - best.distance)), alike = 0.0;
  Change change;
  for (const Weighed& one : weighed) {
    const double weight = std::exp(-0.5 * (one.distance - best.distance));
    all += weight;
    if (one.distance > best.distance + kAlike) continue;
    alike += weight;
    if (one.family != best.family) change.indistinguishable.push_back(one.family->id);
    for (const std::string& id : alwaysAlike(one.family->kind, one.strength))
      change.indistinguishable.push_back(id);
  }
  const double unit = isInRows(best.family->kind) ? comparison.interval() : 1.0;
  change.id = best.family->id;
  change.mechanism = mechanismId(mechanismOf(change.id));
  change.now = unit * best.strength;
  change.unit = best.family->unit;
  change.lower = unit * best.lower;
  change.upper = unit * best.upper;
  change.probability = alike / all;
  return {change};
}

std::vector<ChangeLimit> limitsOf(const Comparison& comparison) {
  const double wanted = std::pow(std::sqrt(kLeastGain) + kPower, 2);
  std::vector<ChangeLimit> limits;
  for (const Family& family : families()) {
    const double scale = family.kind == Kind::kOffset ? comparison.currentScale() : 1.0;
    double hidden = 0.0, seen = HUGE_VAL;
    for (const double in_grid : family.grid) {
      if (in_grid <= 0.0) continue;
      const double strength = scale * in_grid;
      if (comparison.visible(family.kind, strength) >= wanted) {
        seen = strength;
        break;
      }
      hidden = strength;
    }
    if (!std::isfinite(seen)) continue;  // more than is ever looked for
    for (int k = 0; k < 6 && family.continuous; ++k) {
      const double middle = 0.5 * (hidden + seen);
      (comparison.visible(family.kind, middle) >= wanted ? seen : hidden) = middle;
    }
    limits.push_back(
        {family.id, family.unit, seen * (isInRows(family.kind) ? comparison.interval() : 1.0)});
  }
  return limits;
}

// ---------------------------------------------------------------------------------------------
// models

struct Modelled {
  Series series;
  FittedModel model;
};

/// The longest of the recordings, fitted as a whole; none where it cannot be.
std::optional<Modelled> fitted(const std::vector<Series>& all) {
  const Series& longest = *std::max_element(
      all.begin(), all.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  FitRequest request;
  request.from = longest.time.front();
  request.to = longest.time.back();
  request.anyway = true;  // what must not be compared has been refused
  request.options.chooses_effects = true;
  FittedModel model = fitPlanned(longest, planFit(longest, request));
  if (!isUsable(model.fit)) return std::nullopt;
  return Modelled{longest, std::move(model)};
}

ModelShare shareOf(const FittedModel& model, const Series& series, IndexRange range) {
  const PredictionReport report = predictRange(model, series, range).report;
  if (!report.both_ways)
    return {report.from_current.q_dyn_percent, std::nullopt, report.from_current.q_dyn_percent};
  const MixedScores& mixed = report.both_ways->mixed;
  return {mixed.share_percent, mixed.current_share_percent, mixed.voltage_share_percent};
}

ModelShare shareOf(const FittedModel& model, const Series& series) {
  return shareOf(model, series, {0, series.size()});
}

ModelShare lastQuarter(const FittedModel& model, const Series& series) {
  return shareOf(model, series, {series.size() - series.size() / 4, series.size()});
}

/// ln of the error of another model over that of the own one, where a source is seen of the current.
std::optional<double> lossOf(const ModelShare& other, const ModelShare& own) {
  const bool of_current = other.current_share_percent && own.current_share_percent;
  const auto& theirs = of_current ? other.current_share_percent : other.voltage_share_percent;
  const auto& ours = of_current ? own.current_share_percent : own.voltage_share_percent;
  if (!theirs || !ours) return std::nullopt;
  constexpr double kLeast = 0.01;
  return std::log(std::max(kLeast, 1.0 - 0.01 * *theirs) / std::max(kLeast, 1.0 - 0.01 * *ours));
}

std::optional<double> modelDistance(const Modelled& now, const Modelled& then) {
  const auto one = lossOf(shareOf(then.model, now.series), shareOf(now.model, now.series));
  const auto other = lossOf(shareOf(now.model, then.series), shareOf(then.model, then.series));
  if (!one || !other) return std::nullopt;
  return 0.5 * (*one + *other);
}

std::vector<Series> changed(std::vector<Series> all, const Weighed& by) {
  for (Series& series : all) {
    ResponseRows rows{series.time, series.current, series.voltage, {}, medianInterval(series)};
    rows.excluded.assign(rows.size(), 0);
    rows = withChange(std::move(rows), by.family->kind, by.strength);
    series.current = rows.current;
    series.voltage = rows.voltage;
  }
  return all;
}

/// Fits both, the reference with the change in it too, and runs them on each other's recording.
void runModels(ChangeDiagnosis& diagnosis, const std::vector<Series>& now,
               const std::vector<Series>& then, const Weighed* change,
               const ChangeOptions& options) {
  const auto stage = [&](const char* what) {
    if (options.progress) options.progress(what);
  };
  stage("fitting the reference");
  const auto reference = fitted(then);
  stage("fitting the recording");
  const auto present = fitted(now);
  std::optional<Modelled> with_change = reference;
  if (change) {
    stage("fitting the reference with the change");
    with_change = fitted(changed(then, *change));
  }
  if (!present) return;
  stage("running the models on each other's recording");
  diagnosis.own_model = lastQuarter(present->model, present->series);
  if (reference) diagnosis.reference_model = lastQuarter(reference->model, present->series);
  if (!with_change) return;
  diagnosis.changed_model = lastQuarter(with_change->model, present->series);
  diagnosis.model_distance = modelDistance(*present, *with_change);
}

// ---------------------------------------------------------------------------------------------
// words

std::string strengthText(double value, const std::string& unit) {
  if (unit == "ohm") return format("%.2g mOhm", 1e3 * value);
  if (unit == "1") return format("%.2g %%", 1e2 * value);
  return format("%.2g ", value) + unit;
}

std::string clauseOf(const Change& change) {
  const std::string by = strengthText(std::abs(change.now), change.unit);
  const bool is_more = change.now > 0.0;
  if (change.id == "contact_resistance")
    return "the ohmic resistance between the points of measurement is " + by +
           (is_more ? " higher" : " lower");
  if (change.id == "current_gain")
    return "the current reads " + by + (is_more ? " more" : " less") + " than it did";
  if (change.id == "current_offset")
    return "the current's zero has moved by " + std::string(is_more ? "+" : "-") + by;
  if (change.id == "time_skew")
    return std::string(is_more ? "the voltage" : "the current") + " comes " + by +
           " later against the other channel";
  return std::string(is_more ? "the voltage" : "the current") + " follows with a lag of " + by;
}

void conclude(ChangeDiagnosis& diagnosis, ChangeVerdict verdict, std::string summary) {
  diagnosis.verdict = verdict;
  diagnosis.summary = std::move(summary);
}

/// The problems of a recording, that of the sign apart: channels that are shifted against each other
/// can look like a wrong sign.
struct Problems {
  std::vector<Finding> sign, others;
};
Problems problemsOf(const std::vector<Series>& all) {
  Problems problems;
  for (const Series& series : all)
    for (Finding& finding : findProblems(series))
      (finding.id == "sign" ? problems.sign : problems.others).push_back(std::move(finding));
  return problems;
}

std::string tooShort(const std::vector<Series>& all, const char* which) {
  for (const Series& series : all)
    if (series.size() < kFewestRows)
      return format("%s has %zu samples, a comparison needs %zu", which, series.size(),
                    kFewestRows);
  return "";
}

std::string problemText(const std::vector<Finding>& problems, const char* which) {
  return problems.empty() ? "" : std::string(which) + " has a problem: " + format(problems);
}

void requireBoth(const std::vector<Series>& now, bool has_reference) {
  if (now.empty()) throw std::invalid_argument("diagnoseChange: no recording of now");
  if (!has_reference) throw std::invalid_argument("diagnoseChange: no reference");
}

std::string nothingText(const ChangeDiagnosis& diagnosis) {
  std::vector<std::string> limits;
  for (const ChangeLimit& limit : diagnosis.detection_limits)
    limits.push_back(limit.id + " of " + strengthText(limit.strength, limit.unit));
  const std::string seen = limits.empty() ? "" : " It would have shown " + join(limits) + ".";
  return "Nothing has changed but what sound trips of one battery differ by." + seen;
}

std::string changedText(const Change& change) {
  std::string text =
      "Since the reference, " + clauseOf(change) + format(" (%.0f %%)", 100.0 * change.probability);
  if (!change.indistinguishable.empty())
    text += "; these recordings cannot tell it from " + join(change.indistinguishable);
  return text + ".";
}

}  // namespace

std::string toString(ChangeVerdict verdict) {
  switch (verdict) {
    case ChangeVerdict::kNoChange: return "no_change";
    case ChangeVerdict::kChanged: return "changed";
    case ChangeVerdict::kAnotherBattery: return "another_battery";
    case ChangeVerdict::kInsufficientData: break;
  }
  return "insufficient_data";
}

ChangeDiagnosis diagnoseChange(const std::vector<Series>& now, const std::vector<Series>& then,
                               const ChangeOptions& options) {
  requireBoth(now, !then.empty());
  const auto stage = [&](const char* what) {
    if (options.progress) options.progress(what);
  };
  ChangeDiagnosis diagnosis;
  constexpr const char* kNow = "the recording";
  constexpr const char* kThen = "the reference";
  const auto refuse = [&](const std::string& why) {
    conclude(diagnosis, ChangeVerdict::kInsufficientData, "No comparison: " + why + ".");
    return diagnosis;
  };
  for (const std::string& why : {tooShort(now, kNow), tooShort(then, kThen)})
    if (!why.empty()) return refuse(why);
  const Problems problems = options.anyway ? Problems() : problemsOf(now);
  const Problems before = options.anyway ? Problems() : problemsOf(then);
  for (const std::string& why :
       {problemText(problems.others, kNow), problemText(before.others, kThen),
        problemText(before.sign, kThen)})
    if (!why.empty()) return refuse(why);
  stage("comparing responses");
  const Comparison comparison(now, then);
  for (const int k : comparison.compared())
    diagnosis.compared.push_back(
        {featureId(k), featureUnit(k), comparison.reference().value[k], comparison.now().value[k],
         std::sqrt(comparison.now().covariance(k, k) + comparison.reference().covariance(k, k)),
         comparison.spreadOf(k)});
  if (comparison.compared().size() < kFewestFeatures) {
    conclude(diagnosis, ChangeVerdict::kInsufficientData,
             "No comparison: too few changes of current of 8 A and more are in both recordings.");
    return diagnosis;
  }
  diagnosis.distance = comparison.nothing();
  stage("weighing changes");
  std::vector<Weighed> weighed;
  for (const Family& family : families()) weighed.push_back(weigh(comparison, family));
  std::sort(weighed.begin(), weighed.end(),
            [](const Weighed& a, const Weighed& b) { return a.distance < b.distance; });
  Weighed& best = weighed.front();
  diagnosis.gain = diagnosis.distance - best.distance;
  const bool has_changed = diagnosis.gain > kLeastGain;
  if (!problems.sign.empty() &&
      !(isInRows(best.family->kind) && best.distance < kExplained * diagnosis.distance))
    return refuse(problemText(problems.sign, kNow));
  diagnosis.detection_limits = limitsOf(comparison);

  if (options.runs_models) runModels(diagnosis, now, then, has_changed ? &best : nullptr, options);
  if (diagnosis.model_distance && *diagnosis.model_distance > kAnotherBattery) {
    conclude(diagnosis, ChangeVerdict::kAnotherBattery,
             format("This is another battery, or another vehicle: each one's model misses the "
                    "other's recording by %.1f times what the own one does.",
                    std::exp(*diagnosis.model_distance)));
    return diagnosis;
  }
  if (!has_changed) {
    conclude(diagnosis, ChangeVerdict::kNoChange, nothingText(diagnosis));
    return diagnosis;
  }
  addInterval(comparison, best);
  diagnosis.changes = changesOf(comparison, weighed);
  conclude(diagnosis, ChangeVerdict::kChanged, changedText(diagnosis.changes.front()));
  return diagnosis;
}

}  // namespace battery_sof

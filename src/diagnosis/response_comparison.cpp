#include "diagnosis/response_comparison.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

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

// of a row, by which the instants differ at which a logger samples its channels: uniform over one
constexpr double kSamplingShift = 0.2887;  // [1]

constexpr double kMostSpread = 3.0;  // [1], of the usual: drives that differ by more have changed

constexpr double kNinety = 2.71;  // of D, the 90 % interval of one strength
constexpr double kPower = 1.28;   // standard errors above a limit in nine of ten cases

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
  Eigen::VectorXd later = Eigen::VectorXd::Zero(kResponseFeatures);
  for (int tap = 0; tap < kTaps; ++tap) {
    const int row = kFirstTap + tap;
    spread(row, row) = std::pow(interval < kFastRow ? kFastTapSpread : kTapSpread[tap], 2);
    later[row] = kSamplingShift * ((tap > 0 ? then[row - 1] : 0.0) - then[row]);
  }
  return trips * (spread + together * together.transpose() + later * later.transpose());
}

/// Features of references are averaged: they must be taken in the same way.
void requireSameScale(const ResponseScale& one, const ResponseScale& other) {
  constexpr double kSameCurrent = 0.1;  // [1], of the thresholds: features hardly depend on them
  if (one.moved == other.moved && std::abs(one.current / other.current - 1.0) < kSameCurrent)
    return;
  throw std::invalid_argument(
      "the references cannot be averaged: their ranges of current or the delays between their "
      "channels differ");
}

double gridScale(const ResponseComparison& comparison, const CandidateChange& candidate) {
  return candidate.kind == ChangeKind::kOffset ? comparison.scale().current : 1.0;
}

/// Golden section between two strengths.
void refine(const ResponseComparison& comparison, WeighedChange& best, double low, double high) {
  constexpr double kGolden = 0.618033988749895;
  double a = low, b = high;
  double c = b - kGolden * (b - a), d = a + kGolden * (b - a);
  double at_c = comparison.withChangeOf(*best.candidate, c);
  double at_d = comparison.withChangeOf(*best.candidate, d);
  for (int step = 0; step < 9; ++step) {
    if (at_c < at_d) {
      b = d, d = c, at_d = at_c;
      c = b - kGolden * (b - a);
      at_c = comparison.withChangeOf(*best.candidate, c);
    } else {
      a = c, c = d, at_c = at_d;
      d = a + kGolden * (b - a);
      at_d = comparison.withChangeOf(*best.candidate, d);
    }
  }
  if (std::min(at_c, at_d) < best.distance) {
    best.strength = at_c < at_d ? c : d;
    best.distance = std::min(at_c, at_d);
  }
}

WeighedChange weigh(const ResponseComparison& comparison, const CandidateChange& candidate) {
  WeighedChange best{&candidate, 0.0, HUGE_VAL};
  best.moved = comparison.scale().moved;
  std::size_t at = 0;
  std::vector<double> grid = candidate.grid;
  for (double& strength : grid) strength *= gridScale(comparison, candidate);
  for (std::size_t k = 0; k < grid.size(); ++k) {
    const double distance = comparison.withChangeOf(candidate, grid[k]);
    if (distance >= best.distance) continue;
    best.distance = distance;
    best.strength = grid[k];
    at = k;
  }
  if (!candidate.continuous || !std::isfinite(best.distance)) return best;
  const auto neighbour = [&](std::size_t k, bool above) {
    if (above) return k + 1 < grid.size() ? grid[k + 1] : grid[k];
    return k > 0 ? grid[k - 1] : grid[k];
  };
  double low = neighbour(at, false), high = neighbour(at, true);
  // A lag of one channel does not go over into one of the other.
  if (candidate.kind == ChangeKind::kLag && low * best.strength <= 0.0)
    low = best.strength > 0.0 ? 0.3 : low;
  if (candidate.kind == ChangeKind::kLag && high * best.strength <= 0.0)
    high = best.strength < 0.0 ? -0.3 : high;
  refine(comparison, best, low, high);
  return best;
}

/// Where D rises by kNinety on one side.
double bound(const ResponseComparison& comparison, const WeighedChange& of, bool above) {
  const CandidateChange& candidate = *of.candidate;
  // What is left beyond chance widens it (Birge 1932).
  const double per_feature = of.distance / static_cast<double>(comparison.compared().size());
  const double limit = of.distance + kNinety * std::max(1.0, per_feature);
  const auto isBeyond = [&](double strength) {
    return comparison.withChangeOf(candidate, strength) > limit;
  };
  double inside = of.strength, step = std::max(0.25 * std::abs(of.strength), 1e-4);
  double outside = inside;
  for (int k = 0; k < 6; ++k, step *= 2.0) {
    outside = of.strength + (above ? step : -step);
    if (candidate.kind == ChangeKind::kLag && outside * of.strength <= 0.0)
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

}  // namespace

ResponseComparison::ResponseComparison(const std::vector<Series>& now,
                                       const ResponseReference& then)
    : tables_(then.tables) {
  for (const Series& one : then.recordings) then_.push_back(responseRows(one));
  scale_ = tables_.empty() ? responseScale(then_.front()) : tables_.front()->scale;
  interval_ = tables_.empty() ? then_.front().interval : tables_.front()->interval;
  for (const auto& table : tables_) requireSameScale(table->scale, scale_);
  for (ResponseRows& rows : then_) rows.moved = scale_.moved;
  std::vector<ResponseFeatures> features;
  for (const Series& one : now) features.push_back(responseFeatures(responseRows(one), scale_));
  now_ = meanOf(features);
  trips_ = 0.5 * (1.0 / static_cast<double>(now.size()) + 1.0 / static_cast<double>(then.size()));
  begin();
}

ResponseComparison::ResponseComparison(const std::shared_ptr<const ResponseTable>& reference)
    : tables_{reference},
      interval_(reference->interval),
      scale_(reference->scale),
      now_(reference->since.value().mean) {
  const RecentResponses &now = *reference->since, &sound = reference->sound.value_or(now);
  scatter_ = sound.scatter;
  // Drives one after the other share a temperature and a charge, so their mean is no nearer.
  if (!reference->sound) trips_ = 0.5 * (now.squares + 1.0);
  begin();
}

void ResponseComparison::begin() {
  reference_ = featuresWith(ChangeKind::kOffset, 0.0);
  for (int k = 0; k < kResponseFeatures; ++k)
    if (now_.known[k] && reference_.known[k]) compared_.push_back(k);
  ResponseFeatures alike = now_;
  alike.value = reference_.value;
  level_ = distance(reference_, alike);
}

double ResponseComparison::spreadOf(int feature) const {
  return std::sqrt(spread(reference_.value)(feature, feature));
}

Eigen::MatrixXd ResponseComparison::spread(const Eigen::VectorXd& then) const {
  Eigen::MatrixXd between = betweenTrips(then, interval(), trips_);
  // a difference of two has twice the variance of one, as betweenTrips()
  const Eigen::VectorXd seen = 2.0 * trips_ * scatter_, usual = between.diagonal();
  between.diagonal() = seen.cwiseMin(kMostSpread * kMostSpread * usual).cwiseMax(usual);
  return between;
}

double ResponseComparison::nothing() const { return distance(reference_, now_) - level_; }

double ResponseComparison::withChangeOf(const CandidateChange& candidate, double strength) const {
  return distance(featuresWith(candidate.kind, strength), now_) - level_ +
         std::pow(strength / candidate.typical, 2);
}

double ResponseComparison::visible(ChangeKind kind, double strength) const {
  const ResponseFeatures changed = featuresWith(kind, strength);
  ResponseFeatures seen = now_;
  seen.value = changed.value;
  return distance(reference_, seen) - distance(changed, seen);
}

ResponseFeatures ResponseComparison::featuresWith(ChangeKind kind, double strength) const {
  std::vector<ResponseFeatures> features;
  for (const ResponseRows& rows : then_)
    features.push_back(
        responseFeatures(strength == 0.0 ? rows : withChange(rows, kind, strength), scale_));
  for (const auto& table : tables_)
    features.push_back(battery_sof::featuresWith(*table, kind, strength));
  return meanOf(features);
}

double ResponseComparison::distance(const ResponseFeatures& expected,
                                    const ResponseFeatures& seen) const {
  const auto size = static_cast<Eigen::Index>(compared_.size());
  const Eigen::MatrixXd between = spread(expected.value);
  Eigen::VectorXd difference(size);
  Eigen::MatrixXd variance(size, size);
  for (Eigen::Index k = 0; k < size; ++k) {
    const int row = compared_[k];
    if (!expected.known[row]) return HUGE_VAL;
    difference[k] = seen.value[row] - expected.value[row];
    for (Eigen::Index m = 0; m < size; ++m)
      variance(k, m) = seen.covariance(row, compared_[m]) + expected.covariance(row, compared_[m]) +
                       between(row, compared_[m]);
  }
  const Eigen::LDLT<Eigen::MatrixXd> factors(variance);
  const double log_determinant = factors.vectorD().array().max(1e-30).log().sum();
  return difference.dot(factors.solve(difference)) + log_determinant;
}

std::vector<WeighedChange> weighChanges(const ResponseComparison& comparison) {
  std::vector<WeighedChange> weighed;
  for (const CandidateChange& candidate : candidateChanges())
    weighed.push_back(weigh(comparison, candidate));
  std::sort(weighed.begin(), weighed.end(),
            [](const WeighedChange& a, const WeighedChange& b) { return a.distance < b.distance; });
  return weighed;
}

void addInterval(const ResponseComparison& comparison, WeighedChange& of) {
  if (!of.candidate->continuous) {
    of.lower = of.strength - 0.5;
    of.upper = of.strength + 0.5;
    return;
  }
  of.lower = bound(comparison, of, false);
  of.upper = bound(comparison, of, true);
}

double visibleStrength(const ResponseComparison& comparison, const CandidateChange& candidate,
                       double least) {
  const double wanted = std::pow(std::sqrt(least) + kPower, 2);
  double hidden = 0.0, seen = HUGE_VAL;
  for (const double in_grid : candidate.grid) {
    const double strength = gridScale(comparison, candidate) * in_grid;
    if (strength <= 0.0) continue;
    if (comparison.visible(candidate.kind, strength) >= wanted) {
      seen = strength;
      break;
    }
    hidden = strength;
  }
  for (int k = 0; k < 6 && candidate.continuous && std::isfinite(seen); ++k) {
    const double middle = 0.5 * (hidden + seen);
    (comparison.visible(candidate.kind, middle) >= wanted ? seen : hidden) = middle;
  }
  return seen;
}

}  // namespace battery_sof

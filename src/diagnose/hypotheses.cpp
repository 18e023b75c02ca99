#include "battery_sof/diagnose/hypotheses.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "battery_sof/diagnose/signatures.hpp"
#include "battery_sof/identify/parallel.hpp"

namespace battery_sof {
namespace {

constexpr double kGridStep = 1.5;  // prior standard deviations between grid points of a time constant
constexpr int kInstants = 9;       // instants tried over a recording
constexpr int kZooms = 4;          // times that the best instant is looked at three times closer

struct Parts {
  std::vector<Eigen::Index> strengths, shapes, instants;  // rows of the larger composition that are new and free
};

Parts newParts(const BatteryModel& nested, const BatteryModel& larger) {
  Parts parts;
  for (Eigen::Index j = 0; j < larger.parameterCount(); ++j) {
    const ParameterInfo& info = larger.parameters()[static_cast<std::size_t>(j)];
    if (info.held || nested.parameterRow(info.name)) continue;
    if (info.instant)
      parts.instants.push_back(j);
    else if (info.vanishes_at)
      parts.strengths.push_back(j);
    else
      parts.shapes.push_back(j);
  }
  return parts;
}

const ParameterInfo& infoOf(const BatteryModel& model, Eigen::Index row) {
  return model.parameters()[static_cast<std::size_t>(row)];
}

/// The nested optimum, the new effect's strengths gone and its first states tied to the double layer's where they are a part of it.
CompositionPoint withoutStrength(const WhitenedFit& fit, const BatteryModel& larger, const Parts& parts) {
  CompositionPoint point = embedded(fit.model, fit.point, larger);
  for (const Eigen::Index j : parts.strengths) point.parameters[j] = *infoOf(larger, j).vanishes_at;
  for (Eigen::Index k = 0; k < larger.stateCount(); ++k)
    if (larger.states()[static_cast<std::size_t>(k)].begins_as_u_c2) point.state[k] = point.state[0];
  return point;
}

/// Where a strength is tried: its magnitude, or beside its vanishing value when that is its magnitude.
double triedStrength(const ParameterInfo& info) {
  const double gone = *info.vanishes_at;
  if (std::abs(info.magnitude - gone) > 1e-9 * (std::abs(info.upper) + std::abs(gone))) return info.magnitude;
  if (info.logarithmic) return std::min(info.upper, 2.0 * gone);
  return gone + 0.25 * (info.upper - gone);
}

std::vector<CompositionPoint> grid(const BatteryModel& larger, const CompositionPoint& from, const Parts& parts,
                                   double length) {
  std::vector<CompositionPoint> points = {from};
  for (const Eigen::Index j : parts.shapes) {
    const ParameterInfo& info = infoOf(larger, j);
    const double spread = info.prior_std.value_or(0.7);
    for (const double steps : {-2.0, -1.0, 1.0, 2.0}) {
      CompositionPoint point = from;
      const double by = steps * kGridStep * spread;
      point.parameters[j] = std::clamp(info.logarithmic ? from.parameters[j] * std::exp(by) : from.parameters[j] + by,
                                       info.lower, info.upper);
      points.push_back(point);
    }
  }
  if (parts.instants.empty()) return points;
  std::vector<CompositionPoint> timed;
  for (const CompositionPoint& point : points)
    for (int k = 0; k < kInstants; ++k) {
      timed.push_back(point);
      for (const Eigen::Index j : parts.instants) timed.back().parameters[j] = length * (k + 0.5) / kInstants;
    }
  return timed;
}

/// The same with its instants up to two steps earlier or later.
std::vector<CompositionPoint> around(const CompositionPoint& from, const Parts& parts, double step) {
  std::vector<CompositionPoint> points;
  for (const double by : {-2.0, -1.0, 1.0, 2.0}) {
    points.push_back(from);
    for (const Eigen::Index j : parts.instants) points.back().parameters[j] = std::max(0.0, from.parameters[j] + by * step);
  }
  return points;
}

/// Coefficients of columns on v, those of one-sided strengths kept at or above zero by dropping the worst offender.
Eigen::VectorXd boundedCoefficients(const Eigen::MatrixXd& columns, const Eigen::VectorXd& v,
                                    const std::vector<bool>& one_sided) {
  std::vector<Eigen::Index> used;
  for (Eigen::Index k = 0; k < columns.cols(); ++k)
    if (columns.col(k).norm() > 1e-9) used.push_back(k);
  Eigen::VectorXd all = Eigen::VectorXd::Zero(columns.cols());
  while (!used.empty()) {
    const Eigen::MatrixXd some = columns(Eigen::all, used);
    const Eigen::VectorXd c = some.colPivHouseholderQr().solve(v);
    std::size_t worst = used.size();
    double most = 0.0;
    for (std::size_t k = 0; k < used.size(); ++k) {
      const double by = -c[static_cast<Eigen::Index>(k)] * some.col(static_cast<Eigen::Index>(k)).norm();
      if (one_sided[static_cast<std::size_t>(used[k])] && by > most) {
        most = by;
        worst = k;
      }
    }
    if (worst == used.size()) {
      for (std::size_t k = 0; k < used.size(); ++k) all[used[k]] = c[static_cast<Eigen::Index>(k)];
      break;
    }
    used.erase(used.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return all;
}

Signature signatureOf(const WhitenedFit& fit, const Drive& drive, const std::string& id,
                      const Eigen::VectorXd& modelled) {
  const BatteryModel larger = enlarged(fit.model, id);
  const Parts parts = newParts(fit.model, larger);
  const CompositionPoint nested = withoutStrength(fit, larger, parts);
  const double length = drive.samples.back().step.time - drive.first_time;
  std::vector<bool> one_sided;
  for (const Eigen::Index j : parts.strengths) {
    const ParameterInfo& info = infoOf(larger, j);
    one_sided.push_back(info.lower >= *info.vanishes_at);
  }
  Signature best{id, -1.0, 0.0, nested};
  const auto weigh = [&](const CompositionPoint& at) {
    Eigen::MatrixXd columns(fit.innovation.size(), static_cast<Eigen::Index>(parts.strengths.size()));
    for (std::size_t k = 0; k < parts.strengths.size(); ++k) {
      CompositionPoint tried = at;
      tried.parameters[parts.strengths[k]] = triedStrength(infoOf(larger, parts.strengths[k]));
      const Eigen::VectorXd added = simulatedVoltage(larger, tried, drive) - modelled;
      columns.col(static_cast<Eigen::Index>(k)) = added.allFinite() ? added : Eigen::VectorXd::Zero(added.size());
    }
    columns = signaturesOf(fit, drive, std::move(columns)).columns;
    const Eigen::VectorXd c = boundedCoefficients(columns, fit.innovation, one_sided);
    const Eigen::VectorXd explained = columns * c;
    const double score = std::max(0.0, explained.squaredNorm() - static_cast<double>(columns.cols() - 1));
    const double sensitivity = columns.rowwise().sum().norm();
    if (score <= best.score) return;
    best.score = score;
    best.sensitivity = sensitivity;
    best.start = at;
    for (std::size_t k = 0; k < parts.strengths.size(); ++k) {
      const ParameterInfo& info = infoOf(larger, parts.strengths[k]);
      const double gone = *info.vanishes_at;
      const double by = c[static_cast<Eigen::Index>(k)] * (triedStrength(info) - gone);
      best.start.parameters[parts.strengths[k]] = std::clamp(gone + by, info.lower, info.upper);
    }
  };
  for (const CompositionPoint& at : grid(larger, nested, parts, length)) weigh(at);
  double step = length / kInstants;
  for (int zoom = 0; zoom < kZooms && !parts.instants.empty(); ++zoom) {
    step /= 3.0;
    for (const CompositionPoint& at : around(best.start, parts, step)) weigh(at);
  }
  return best;
}

}  // namespace

BatteryModel enlarged(const BatteryModel& model, const std::string& id) {
  std::vector<std::string> effects = model.effects();
  const auto add = [&](const std::string& one) {
    if (std::find(effects.begin(), effects.end(), one) == effects.end()) effects.push_back(one);
  };
  for (const std::string& needed : effectInfo(id).needs) add(needed);
  add(id);
  return BatteryModel(effects);
}

std::vector<std::string> addable(const BatteryModel& model, const std::vector<std::string>& hypotheses) {
  std::vector<std::string> ids;
  for (const EffectInfo& info : effectCatalogue()) {
    const bool wanted = (hypotheses.empty() && !info.on_request) ||
                        std::find(hypotheses.begin(), hypotheses.end(), info.id) != hypotheses.end();
    const auto& there = model.effects();
    if (wanted && std::find(there.begin(), there.end(), info.id) == there.end()) ids.push_back(info.id);
  }
  return ids;
}

std::vector<Signature> screen(const WhitenedFit& fit, const Drive& drive, const std::vector<std::string>& ids,
                              int threads) {
  const Eigen::VectorXd modelled = simulatedVoltage(fit.model, fit.point, drive);
  std::vector<Signature> signatures(ids.size());
  parallelFor(ids.size(), threads,
              [&](std::size_t k) { signatures[k] = signatureOf(fit, drive, ids[k], modelled); });
  return signatures;
}

WhitenedFit refit(const WhitenedFit& nested, const Drive& drive, const Signature& signature,
                  const WhitenedSearch& search) {
  const BatteryModel larger = enlarged(nested.model, signature.id);
  const CompositionPoint vanished = withoutStrength(nested, larger, newParts(nested.model, larger));
  CompositionPoint typical = vanished;
  for (const Eigen::Index j : newParts(nested.model, larger).strengths) typical.parameters[j] = triedStrength(infoOf(larger, j));
  return fitWhitened(larger, drive, {vanished, signature.start, typical}, nested.noise, search);
}

}  // namespace battery_sof

#include "diagnosis/response_table.hpp"

#include <algorithm>
#include <cmath>

#include "estimation/identification.hpp"
#include "recording/checks.hpp"

namespace battery_sof {
namespace {

constexpr double kDigits = 1e5;  // a table's numbers have six: errors are above a thousandth

/// Rounded, so that a file has few digits and reads back to the same number.
double sixDigits(double value) {
  if (value == 0.0 || !std::isfinite(value)) return 0.0;
  const double scale = kDigits / std::pow(10.0, std::floor(std::log10(std::abs(value))));
  return std::round(value * scale) / scale;
}

Eigen::VectorXd standardErrors(const ResponseFeatures& features) {
  return features.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
}

Eigen::MatrixXd correlationOf(const ResponseFeatures& features) {
  const Eigen::VectorXd error = standardErrors(features);
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(kResponseFeatures, kResponseFeatures);
  for (Eigen::Index k = 0; k < kResponseFeatures; ++k)
    for (Eigen::Index m = 0; m < kResponseFeatures; ++m)
      if (k != m && error[k] > 0.0 && error[m] > 0.0)
        correlation(k, m) = features.covariance(k, m) / (error[k] * error[m]);
  return correlation;
}

/// The change at those of its strengths at which all is known that is known of the recording as it
/// is.
TabulatedChange tabulated(const ResponseRows& rows, const ResponseTable& of,
                          const CandidateChange& candidate) {
  TabulatedChange change{candidate.kind, {}, {}, {}};
  std::vector<ResponseFeatures> all;
  const double scale = candidate.kind == ChangeKind::kOffset ? of.scale.current : 1.0;
  for (const double in_grid : candidate.grid) {
    const double strength = sixDigits(scale * in_grid);
    ResponseFeatures features =
        responseFeatures(withChange(rows, candidate.kind, strength), of.scale);
    bool knows_all = true;
    for (int k = 0; k < kResponseFeatures; ++k)
      knows_all = knows_all && (features.known[k] || !of.unchanged.known[k]);
    if (!knows_all) continue;
    change.strength.push_back(strength);
    all.push_back(std::move(features));
  }
  change.value.setZero(kResponseFeatures, static_cast<Eigen::Index>(all.size()));
  change.std_error = change.value;
  for (std::size_t j = 0; j < all.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    change.value.col(column) = all[j].value.unaryExpr(&sixDigits);
    change.std_error.col(column) = standardErrors(all[j]).unaryExpr(&sixDigits);
  }
  return change;
}

}  // namespace

void RecentResponses::add(const ResponseFeatures& drive) {
  const double newest = std::max(1.0 / static_cast<double>(++drives), 1.0 / kMostDrives);
  squares = drives == 1 ? 1.0 : std::pow(1.0 - newest, 2) * squares + std::pow(newest, 2);
  Eigen::VectorXd old_weight = Eigen::VectorXd::Zero(kResponseFeatures);
  for (Eigen::Index k = 0; k < kResponseFeatures; ++k)
    if (mean.known[k] && drive.known[k])
      scatter[k] =
          (1.0 - newest) * (scatter[k] + newest * std::pow(drive.value[k] - mean.value[k], 2));
  for (std::size_t k = 0; k < kResponseFeatures; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (mean.known[k]) old_weight[row] = drive.known[k] ? 1.0 - newest : 1.0;
    mean.known[k] = mean.known[k] || drive.known[k];
  }
  const Eigen::VectorXd new_weight = Eigen::VectorXd::Ones(kResponseFeatures) - old_weight;
  mean.value = old_weight.cwiseProduct(mean.value) + new_weight.cwiseProduct(drive.value);
  mean.covariance = old_weight.asDiagonal() * mean.covariance * old_weight.asDiagonal();
  mean.covariance += new_weight.asDiagonal() * drive.covariance * new_weight.asDiagonal();
}

std::shared_ptr<const ResponseTable> responseTable(const Series& series, bool anyway) {
  if (series.size() < kFewestRows || (!anyway && !findProblems(series).empty())) return nullptr;
  ResponseRows rows = responseRows(series);
  auto table = std::make_shared<ResponseTable>();
  table->from = series.time.front();
  table->to = series.time.back();
  table->samples = series.size();
  table->interval = rows.interval;
  table->scale = responseScale(rows);
  table->scale.current = sixDigits(table->scale.current);
  rows.moved = table->scale.moved;
  ResponseFeatures& unchanged = table->unchanged;
  unchanged = responseFeatures(rows, table->scale);
  if (unchanged.count() < kFewestFeatures) return nullptr;
  const Eigen::VectorXd error = standardErrors(unchanged).unaryExpr(&sixDigits);
  const Eigen::MatrixXd correlation = correlationOf(unchanged);
  unchanged.value = unchanged.value.unaryExpr(&sixDigits).eval();
  unchanged.covariance = error.asDiagonal() * correlation * error.asDiagonal();
  for (const CandidateChange& candidate : candidateChanges())
    table->changes.push_back(tabulated(rows, *table, candidate));
  return table;
}

std::shared_ptr<const ResponseTable> responseTable(const Series& series,
                                                   const FitRequest& request) {
  return responseTable(slice(series, samplesBetween(series, request.from, request.to)),
                       request.anyway);
}

std::shared_ptr<const ResponseTable> withDrive(
    const std::shared_ptr<const ResponseTable>& reference, const Series& drive) {
  if (!reference) {
    const auto first = responseTable(drive);
    if (!first) return nullptr;
    auto table = std::make_shared<ResponseTable>(*first);
    table->sound.emplace();
    table->sound->add(table->unchanged);
    return table;
  }
  if (drive.size() < kFewestRows || !findProblems(drive).empty()) return nullptr;
  const ResponseFeatures features = responseFeatures(responseRows(drive), reference->scale);
  if (features.count() < kFewestFeatures) return nullptr;
  auto added = std::make_shared<ResponseTable>(*reference);
  const bool learns = added->sound && added->sound->drives < kSoundDrives;
  if (!learns && !added->since) added->since.emplace();
  (learns ? added->sound : added->since)->add(features);
  return added;
}

namespace {

ResponseFeatures featuresOfFirst(const ResponseTable& table, ChangeKind kind, double strength) {
  if (strength == 0.0) return table.unchanged;
  const auto of = std::find_if(table.changes.begin(), table.changes.end(),
                               [&](const TabulatedChange& one) { return one.kind == kind; });
  ResponseFeatures features;
  if (of == table.changes.end() || of->strength.empty()) return features;
  const ResponseFeatures& unchanged = table.unchanged;
  const Eigen::Index last = of->value.cols();
  std::vector<double> knots = of->strength;  // with 0: the recording as it is
  const auto zero = knots.insert(std::lower_bound(knots.begin(), knots.end(), 0.0), 0.0);
  const Eigen::Index at_zero = zero - knots.begin();
  const Eigen::Index high = std::clamp<Eigen::Index>(
      std::upper_bound(knots.begin(), knots.end(), strength) - knots.begin(), 1, last);
  const double left = knots[static_cast<std::size_t>(high - 1)];
  const double share = (strength - left) / (knots[static_cast<std::size_t>(high)] - left);
  const auto between = [&](const Eigen::MatrixXd& columns, const Eigen::VectorXd& without) {
    const auto at = [&](Eigen::Index knot) -> Eigen::VectorXd {
      if (knot == at_zero) return without;
      return columns.col(knot < at_zero ? knot : knot - 1);
    };
    return Eigen::VectorXd(at(high - 1) + share * (at(high) - at(high - 1)));
  };
  features.known = unchanged.known;
  features.value = between(of->value, unchanged.value);
  const Eigen::VectorXd error = between(of->std_error, standardErrors(unchanged)).cwiseMax(0.0);
  features.covariance = error.asDiagonal() * correlationOf(unchanged) * error.asDiagonal();
  return features;
}

}  // namespace

ResponseFeatures featuresWith(const ResponseTable& table, ChangeKind kind, double strength) {
  ResponseFeatures features = featuresOfFirst(table, kind, strength);
  if (!table.sound) return features;
  const ResponseFeatures& mean = table.sound->mean;
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(kResponseFeatures);
  for (Eigen::Index k = 0; k < kResponseFeatures; ++k) {
    if (!table.unchanged.known[k]) continue;
    features.value[k] += mean.value[k] - table.unchanged.value[k];
    if (table.unchanged.covariance(k, k) > 0.0)
      scale[k] = std::sqrt(mean.covariance(k, k) / table.unchanged.covariance(k, k));
  }
  features.covariance = scale.asDiagonal() * features.covariance * scale.asDiagonal();
  return features;
}

}  // namespace battery_sof

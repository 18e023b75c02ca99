#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <tuple>
#include <vector>

#include "diagnosis/response_table.hpp"
#include "util/eigen_decomposition.hpp"
#include "util/text.hpp"
#include "yaml_fields.hpp"

// The section responses of MODEL.yaml, described for both directions (yaml_fields.hpp), and the
// correlations that it shares with the parameters.

namespace battery_sof {

// Of a range, or in a state's unit: far above what an undetermined parameter shows.
inline constexpr double kMaxStd = 1e9;
inline constexpr double kMinEigenvalue = -1e-6;

/// Rounded to twelve digits, so that writing, reading and writing again gives the same text.
inline Eigen::MatrixXd correlationOf(const Eigen::MatrixXd& covariance) {
  Eigen::MatrixXd correlation = covariance;
  for (Eigen::Index j = 0; j < covariance.rows(); ++j)
    for (Eigen::Index k = 0; k < covariance.cols(); ++k) {
      const double scale = std::sqrt(covariance(j, j) * covariance(k, k));
      correlation(j, k) = j == k        ? 1.0
                          : scale > 0.0 ? std::round(1e12 * covariance(j, k) / scale) / 1e12
                                        : 0.0;
    }
  return correlation;
}

inline void requireCorrelation(const FieldReader& root, const Eigen::MatrixXd& correlation) {
  root.require(((correlation.diagonal().array() - 1.0).abs() <= kSame).all(), "correlation",
               "must have ones on its diagonal");
  root.require(((correlation - correlation.transpose()).array().abs() <= kSame).all(),
               "correlation", "must be symmetric");
  const double least = eigenDecomposition(correlation).eigenvalues().minCoeff();
  root.require(least >= kMinEigenvalue, "correlation",
               format("has the eigenvalue %g, expected none below 0", least));
}

/// Numbers of a feature at every strength of a change, a row of a matrix.
template <typename File, typename Matrix>
void describeFeatureRow(File& file, std::size_t feature, Matrix& matrix, Range range) {
  const auto row = static_cast<Eigen::Index>(feature);
  Eigen::VectorXd numbers = matrix.row(row);
  file.numbers(featureId(feature).c_str(), numbers, static_cast<std::size_t>(numbers.size()),
               range);
  if constexpr (File::kReads) matrix.row(row) = numbers;
}

template <typename File, typename Change>
void describeTabulated(File& file, Change& change, const ResponseFeatures& unchanged) {
  file.numbers("strength", change.strength);
  const auto& strengths = change.strength;
  file.require(std::is_sorted(strengths.begin(), strengths.end(), std::less_equal<>()) &&
                   !contains(strengths, 0.0),
               "strength", "must rise, without 0");
  if constexpr (File::kReads) {
    change.value.setZero(kResponseFeatures, static_cast<Eigen::Index>(strengths.size()));
    change.std_error = change.value;
  }
  for (const auto& [key, matrix, range] : {std::tuple{"value", &change.value, kNumbers},
                                           {"std_error", &change.std_error, Range{0.0, kMaxStd}}})
    file.map(key, [&, matrix = matrix, range = range](auto& rows) {
      for (std::size_t k = 0; k < kResponseFeatures; ++k)
        if (unchanged.known[k]) describeFeatureRow(rows, k, *matrix, range);
    });
}

inline std::vector<std::string> knownIds(const ResponseFeatures& features) {
  std::vector<std::string> ids;
  for (std::size_t k = 0; k < kResponseFeatures; ++k)
    if (features.known[k]) ids.push_back(featureId(k));
  return ids;
}

/// A column for each feature that is known, 1 in its row.
inline Eigen::MatrixXd knownColumns(const ResponseFeatures& features) {
  const auto size = static_cast<Eigen::Index>(features.count());
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(kResponseFeatures, size);
  Eigen::Index column = 0;
  for (Eigen::Index k = 0; k < kResponseFeatures; ++k)
    if (features.known[static_cast<std::size_t>(k)]) columns(k, column++) = 1.0;
  return columns;
}

/// Values with their standard errors and correlation, of those that are known.
template <typename File, typename Features>
void describeFeatures(File& file, Features& features) {
  auto ids = knownIds(features);
  file.texts("features", ids, "a list of ids");
  if constexpr (File::kReads) {
    for (std::size_t k = 0; k < kResponseFeatures; ++k)
      features.known[k] = contains(ids, featureId(k));
    file.require(knownIds(features) == ids && !ids.empty(), "features",
                 "must be ids of features in their order");
  }
  const Eigen::MatrixXd known = knownColumns(features);
  const Eigen::MatrixXd covariance = known.transpose() * features.covariance * known;
  Eigen::VectorXd value = known.transpose() * features.value;
  Eigen::VectorXd error = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd correlation = correlationOf(covariance);
  file.numbers("value", value, ids.size());
  file.numbers("std_error", error, ids.size(), Range{0.0, kMaxStd});
  file.matrix("correlation", correlation);
  if constexpr (File::kReads) {
    requireCorrelation(file, correlation);
    const Eigen::MatrixXd scaled = known * error.asDiagonal();
    features.value = known * value;
    features.covariance = scaled * correlation * scaled.transpose();
  }
}

template <typename File, typename Drives>
void describeDrives(File& file, const char* name, Drives& drives) {
  if constexpr (File::kReads)
    if (file.has(name)) drives.emplace();
  if (!drives) return;
  file.map(name, [&](auto& of) {
    of.count("drives", drives->drives);
    of.number("squares", drives->squares, {1e-3, 1.0});
    of.numbers("scatter", drives->scatter, kResponseFeatures);
    describeFeatures(of, drives->mean);
  });
}

template <typename File, typename Table>
void describeResponses(File& file, Table& table) {
  int version = kResponseVersion;
  file.count("version", version);
  file.require(version == kResponseVersion, "version",
               format("is %d, expected %d: identify again", version, kResponseVersion));
  file.number("from_s", table.from, kTimes);
  file.number("to_s", table.to, kTimes);
  file.require(table.to >= table.from, "to_s", "is before from_s");
  file.count("samples", table.samples);
  file.number("interval_s", table.interval, {1e-6, kTimes.most});
  file.number("current_scale", table.scale.current, {1e-3, 1.0});
  double moved = table.scale.moved;
  file.number("moved_rows", moved, {-kTaps, kTaps});
  if constexpr (File::kReads) table.scale.moved = static_cast<int>(std::lround(moved));
  describeFeatures(file, table.unchanged);
  if constexpr (File::kReads)
    for (const CandidateChange& candidate : candidateChanges())
      table.changes.push_back({candidate.kind, {}, {}, {}});
  describeDrives(file, "sound", table.sound);
  describeDrives(file, "since", table.since);
  file.map("changes", [&](auto& changes) {
    for (std::size_t k = 0; k < table.changes.size(); ++k)
      changes.map(candidateChanges()[k].id, [&](auto& change) {
        describeTabulated(change, table.changes[k], table.unchanged);
      });
  });
}

}  // namespace battery_sof

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/response_changes.hpp"

namespace battery_sof {

struct FitRequest;  // estimation/identification.hpp

/// Version of what features are taken by: of the thresholds in response_features.cpp and the changes
/// in response_changes.cpp. A table of another version is not comparable.
inline constexpr int kResponseVersion = 3;

/// Features of a recording with one change of several strengths put in, a column a strength.
struct TabulatedChange {
  ChangeKind kind = ChangeKind::kContact;
  std::vector<double> strength;  ///< as of ChangeKind, ascending, without 0
  Eigen::MatrixXd value, std_error;
};

/// Mean of the responses of a battery's drives since a reference; the older one is, the less it
/// weighs: w of the newest, 1 - w of all before.
struct RecentResponses {
  static constexpr double kMostDrives = 5.0;  ///< 1 / least w

  ResponseFeatures mean;
  std::size_t drives = 0;
  double squares = 1.0;  ///< [1], sum of squared weights: of a mean of n equal ones 1/n
  /// variance of the drives about their mean, with the same weights: their own errors are a part
  Eigen::VectorXd scatter = Eigen::VectorXd::Zero(kResponseFeatures);

  /// w = 1/n of drive n, at least 1 / kMostDrives. A feature that the drive does not know stays.
  void add(const ResponseFeatures& drive);
};

/**
 * @brief What a recording has to say as the reference of a comparison, without its samples: what
 * MODEL.yaml keeps of it.
 *
 * Features between two strengths are interpolated. Their covariance has the standard errors of the
 * strength and the correlations of the recording as it is.
 */
struct ResponseTable {
  double from = 0.0, to = 0.0;  ///< [s]
  std::size_t samples = 0;
  double interval = 1.0;  ///< [s], between rows
  ResponseScale scale;
  ResponseFeatures unchanged;
  std::vector<TabulatedChange> changes;  ///< in the order of candidateChanges()
  /// of the node: what the drives showed that the reference is the mean of, and those since
  std::optional<RecentResponses> sound, since;
};

/**
 * @return the table of a recording; none where it is too short for a comparison, knows fewer than
 * kFewestFeatures, or has a problem (findProblems()).
 * @param anyway a recording with a problem has one all the same.
 */
std::shared_ptr<const ResponseTable> responseTable(const Series& series, bool anyway = false);

/// @return the table of what a model was identified from, between the request's from and to.
std::shared_ptr<const ResponseTable> responseTable(const Series& series, const FitRequest& request);

/// Drives that a reference is the mean of which withDrive() begins.
inline constexpr std::size_t kSoundDrives = 5;

/// @return a reference with a further drive. The first kSoundDrives make up the reference, those
/// that follow are the drives since. None where the drive cannot serve: as of responseTable().
/// @param reference none: the drive begins one.
std::shared_ptr<const ResponseTable> withDrive(
    const std::shared_ptr<const ResponseTable>& reference, const Series& drive);

/// @return the features with a change put in; nothing known beyond a strength that left some
/// unknown.
ResponseFeatures featuresWith(const ResponseTable& table, ChangeKind kind, double strength);

/// What a comparison needs.
inline constexpr std::size_t kFewestRows = 300, kFewestFeatures = 8;

}  // namespace battery_sof

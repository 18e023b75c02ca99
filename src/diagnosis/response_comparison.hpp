#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/response_changes.hpp"
#include "diagnosis/response_table.hpp"

namespace battery_sof {

/// What a comparison is with: recordings, and what model files keep of recordings.
struct ResponseReference {
  std::vector<Series> recordings;
  std::vector<std::shared_ptr<const ResponseTable>> tables;
  std::size_t size() const { return recordings.size() + tables.size(); }
};

/**
 * @brief NOW's features against those of the reference with a change put in.
 *
 *     D(c, s) = (f_now - f_then(c, s))' V^-1 (f_now - f_then(c, s)) + ln det V - ln det V(nothing)
 *     V = V_now + V_then(c, s) + V_between
 *
 * V_between is the spread between sound trips, smaller for the mean of several trips. Where a battery's
 * own drives have shown how they differ among themselves it is that, if it is larger, up to three
 * times as much: of those that made up the reference, else of those since.
 */
class ResponseComparison {
 public:
  /// @param now at least one recording. @param then at least one recording or table.
  /// @throws std::invalid_argument for tables of different scales.
  ResponseComparison(const std::vector<Series>& now, const ResponseReference& then);
  /// The drives since a reference, which has such (ResponseTable::since), against it.
  explicit ResponseComparison(const std::shared_ptr<const ResponseTable>& reference);

  const std::vector<int>& compared() const { return compared_; }  ///< features known in both
  const ResponseFeatures& now() const { return now_; }
  const ResponseFeatures& reference() const { return reference_; }
  double interval() const { return interval_; }          ///< [s], between rows of the reference
  const ResponseScale& scale() const { return scale_; }  ///< of the reference
  double spreadOf(int feature) const;                    ///< between sound trips

  double nothing() const;  ///< D of no change
  /// D(c, s) and the strength's prior, (s / typical)^2
  double withChangeOf(const CandidateChange& candidate, double strength) const;
  /// The reference's features with a change put in.
  ResponseFeatures featuresWith(ChangeKind kind, double strength) const;
  /// By how much D would fall if a change of this strength were all that has changed.
  double visible(ChangeKind kind, double strength) const;

 private:
  void begin();  ///< with now_, trips_ and what the reference is made of
  double distance(const ResponseFeatures& expected, const ResponseFeatures& seen) const;
  Eigen::MatrixXd spread(const Eigen::VectorXd& then) const;

  std::vector<ResponseRows> then_;
  std::vector<std::shared_ptr<const ResponseTable>> tables_;
  double interval_ = 1.0;
  ResponseScale scale_;
  ResponseFeatures now_, reference_;
  double trips_ = 1.0, level_ = 0.0;
  Eigen::VectorXd scatter_ = Eigen::VectorXd::Zero(kResponseFeatures);  // of drives
  std::vector<int> compared_;
};

/// A candidate's best strength.
struct WeighedChange {
  const CandidateChange* candidate = nullptr;
  double strength = 0.0, distance = 0.0;  ///< D there; infinite where nothing can be said
  double lower = 0.0, upper = 0.0;        ///< 90 % interval of the strength; see addInterval()
  int moved = 0;                          ///< ResponseRows::moved, of what it is put into
};

/// @return every candidate at its best strength, least D first.
std::vector<WeighedChange> weighChanges(const ResponseComparison& comparison);

/// Finds where D rises by 2.71 on either side of the best strength, by more where the best change
/// leaves D larger than the number of features.
void addInterval(const ResponseComparison& comparison, WeighedChange& of);

/// @return the strength at which a candidate would lower D by `least` in nine cases of ten, as of
/// ChangeKind; infinite beyond the strengths that are tried.
double visibleStrength(const ResponseComparison& comparison, const CandidateChange& candidate,
                       double least);

}  // namespace battery_sof

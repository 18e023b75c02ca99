#pragma once

#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "diagnosis/response_features.hpp"

namespace battery_sof {

/// What may have changed between two recordings, as far as it can be put into one exactly.
enum class ChangeKind {
  kContact,  ///< [Ohm], v + R i
  kGain,     ///< [1], (1 + g) i
  kOffset,   ///< [A], i + i_o
  kSkew,     ///< [rows], > 0: the voltage comes late, < 0: the current
  kLag,  ///< [rows], time constant of a first-order lag; > 0: of the voltage, < 0: of the current
};

/// A kind of change with the strengths that are tried.
struct CandidateChange {
  ChangeKind kind;
  const char* id;            ///< of the effect
  const char* unit;          ///< of the effect's strength
  double typical;            ///< standard deviation of its prior, as of ChangeKind; infinite: flat
  std::vector<double> grid;  ///< ascending, as of ChangeKind
  bool continuous = true;    ///< whether strengths between those of the grid are meant

  /// Whether strengths count in rows of the recording; else in `unit`.
  bool isInRows() const { return kind == ChangeKind::kSkew || kind == ChangeKind::kLag; }
};

/// @return all of them.
const std::vector<CandidateChange>& candidateChanges();

/// @return what the recording would be had its instruments been changed so. @param strength as of
/// ChangeKind.
ResponseRows withChange(ResponseRows rows, ChangeKind kind, double strength);

/**
 * @brief NOW's features against those of the reference with a change put in.
 *
 *     D(c, s) = (f_now - f_then(c, s))' V^-1 (f_now - f_then(c, s)) + ln det V - ln det V(nothing)
 *     V = V_now + V_then(c, s) + V_between
 *
 * V_between is the spread between sound trips, smaller for the mean of several trips.
 */
class ResponseComparison {
 public:
  /// @param now, then at least one recording each.
  ResponseComparison(const std::vector<Series>& now, const std::vector<Series>& then);

  const std::vector<int>& compared() const { return compared_; }  ///< features known in both
  const ResponseFeatures& now() const { return now_; }
  const ResponseFeatures& reference() const { return reference_; }
  double interval() const { return then_.front().interval; }  ///< [s], between rows
  double currentScale() const { return scale_.current; }      ///< ResponseScale::current
  double spreadOf(int feature) const;                         ///< between sound trips

  double nothing() const;  ///< D of no change
  /// D(c, s) and the strength's prior, (s / typical)^2
  double withChangeOf(const CandidateChange& candidate, double strength) const;
  /// By how much D would fall if a change of this strength were all that has changed.
  double visible(ChangeKind kind, double strength) const;

 private:
  ResponseFeatures featuresWith(ChangeKind kind, double strength) const;
  double distance(const ResponseFeatures& expected, const ResponseFeatures& seen) const;

  std::vector<ResponseRows> then_;
  ResponseScale scale_;
  ResponseFeatures now_, reference_;
  double trips_ = 1.0, level_ = 0.0;
  std::vector<int> compared_;
};

/// A candidate's best strength.
struct WeighedChange {
  const CandidateChange* candidate = nullptr;
  double strength = 0.0, distance = 0.0;  ///< D there; infinite where nothing can be said
  double lower = 0.0, upper = 0.0;        ///< 90 % interval of the strength; see addInterval()
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

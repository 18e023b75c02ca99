#pragma once

#include <vector>

#include "diagnosis/response_features.hpp"

namespace battery_sof {

/// What may have changed between two recordings, as far as it can be put into one exactly.
enum class ChangeKind {
  kContact,  ///< [Ohm], v + R i, with i as late as the voltage is (ResponseRows::moved)
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

/// @param rows with how late their voltage is.
/// @return what the recording would be had its instruments been changed so. @param strength as of
/// ChangeKind.
ResponseRows withChange(ResponseRows rows, ChangeKind kind, double strength);

}  // namespace battery_sof

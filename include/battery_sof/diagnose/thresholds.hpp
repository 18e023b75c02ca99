#pragma once

namespace battery_sof {

/// Where a diagnosis draws its lines (PHYSICS 2.3); docs/diagnosis.md has the sets they were drawn on.
struct DiagnosisThresholds {
  double score = 12.0;             ///< T1: z^2 of the best hypothesis above it is a mismatch
  double omnibus = 4.0;            ///< z_O above it: the library finds what the model lacks
  double structure_evidence = 6.0; ///< gain of the criterion that a name of tier S needs
  double name_evidence = 20.0;     ///< T2: the same of tier P or I, and of tier S at edges, where the current's own noise has some evidence
  double least_share = 0.10;       ///< [1], of the held-out RMS error that an effect of tier P or I must take out
  double least_structure_share = 0.05;  ///< [1], the same of tier S
  double least_fast_share = 0.03;  ///< [1], the same of what acts at edges alone, on all samples
  double tie_evidence = 6.0;       ///< hypotheses closer than this in the criterion are tied
};

}  // namespace battery_sof

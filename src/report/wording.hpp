#pragma once

#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.hpp"

/// Words and numbers that several reports share.
namespace battery_sof {

constexpr std::size_t kTextWidth = 100;  ///< columns of a text report
constexpr double kNotableZ = 4.0;        ///< of a parameter's bias: 1 in 16,000 by chance alone

/// Text in lines of at most kTextWidth columns, the first behind lead, the others indented as far.
std::string wrapped(const std::string& lead, const std::string& text);

/// @return the sentence behind a summary: what the verdict says of the battery itself.
std::string meaningOf(Verdict verdict);

/// @return three significant digits.
std::string threeDigits(double value);

/// @return a voltage given in [V] as millivolts without unit: a tenth below 100 mV, whole ones
/// above; "-" for none.
std::string millivolts(const std::optional<double>& volts);

/// @return why no strength of an effect is promised, where the residual is not noise alone; without
/// a full stop.
std::string whyNothingIsPromised(const UnexplainedPart& left);

/// @return "-12 %", or of u_dc "3.4 mV": the change that a regime needs; "beyond its bound" where
/// the value stands at its bound and cannot go further.
std::string biasText(const ParameterBias& bias);

/// @return "97 %"; never 100 %, as no confidence counts what is in no catalogue.
std::string confidenceText(double confidence);

/// @return "acid 0.62, structure 0.30": the likely mechanisms with their probabilities.
std::string likelyMechanismsText(const std::vector<MechanismProbability>& mechanisms);

/// @return a sentence where something is missing and no stretch stands out; empty elsewhere.
std::string noStretchText(const Diagnosis& diagnosis);

/// @return a code name as words: "long_charge" reads "long charge".
std::string plainName(std::string name);

/// A number of ErrorMetrics for tables, in the unit of its title: "RMS error [mV]".
struct MetricRow {
  std::string title;
  bool more_is_better;  ///< else what is nearer to 0 is
  std::optional<double> base_train, extended_train, base_holdout, extended_holdout;
};

/// @return the rows of the table before and after; those that no stretch has are left out.
std::vector<MetricRow> metricRows(const Comparison& fit);

/// @return how many cranks the two parts hold, "cranks: 2 in the hold-out, 6 in the training part";
/// empty without any.
std::string crankCounts(const Comparison& fit);

/// @return sentences on what baselines without physics reach on the hold-out, and on the source;
/// empty when neither is known.
std::string baselineSentence(const Diagnosis& diagnosis);

/// @return how a regime's error changed, judged by the interval of the change: "better", "worse" or
/// "not decided".
std::string changeOf(const RegimeComparison& regime);

}  // namespace battery_sof

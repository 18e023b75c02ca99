#pragma once

#include <string>
#include <vector>

#include "battery_sof/diagnose/diagnosis.hpp"
#include "battery_sof/diagnose/naming.hpp"

namespace battery_sof {

/// What the instrument screen found, in the words of the catalogue.
struct InstrumentScreen {
  std::vector<std::string> faults;     ///< ids of tier I: clipping, dropouts, quantisation, aliasing
  std::vector<std::string> sentences;  ///< all findings worth telling
};

/// What speaks for something beyond the catalogue.
struct Remainder {
  double base_omnibus = 0.0;      ///< z_O beside the base model
  double extended_omnibus = 0.0;  ///< z_O beside the extended one
  double explained = 1.0;         ///< gained / (gained + left): share of the mismatch that the extended model explains [0, 1]
  bool has_tone = false;          ///< slowTone() beside the extended model
  double gained = 0.0;            ///< of -2 ln likelihood, by the extended model
  double left = 0.0;              ///< of the same, by what the extended model leaves to the library and a tone
};

/// @return verdict by PHYSICS 2.3's table.
Verdict judge(const Naming& naming, const InstrumentScreen& instruments, const Remainder& remainder,
              const DiagnosisThresholds& thresholds);

/// @return gain of -2 ln likelihood that one effect more would have to bring for a name to be the verdict; 0 where nothing unknown is left.
double leastGainToExplain(const Remainder& remainder, const DiagnosisThresholds& thresholds);

/// @return what no current and voltage can show (PHYSICS 0.7).
std::vector<std::string> outsideWhatSignalsShow();

/// @return what to record next, in one or two sentences.
std::string nextExperiment(const Diagnosis& diagnosis);

/// @return the verdict in one plain sentence with numbers.
std::string summaryOf(const Diagnosis& diagnosis);

}  // namespace battery_sof

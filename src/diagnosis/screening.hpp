#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "battery_sof/series.hpp"
#include "model/input_sequence.hpp"
#include "recording/current_flicker.hpp"
#include "recording/fit_mask.hpp"

namespace battery_sof {

/// What the instruments did to a training part, and the part as it can be fitted.
struct Screening {
  Series series;  ///< of the training part: its current as the battery saw it
  InstrumentLimits limits;
  /// ids of tier I: clipping, dropouts, quantisation, aliasing, time_skew
  std::vector<std::string> faults;
  std::vector<std::string> sentences;  ///< all findings worth telling, and on the first fit
  std::optional<double> skew;          ///< [s], by which the checks found the voltage to come later
  double flicker_share = 1.0;          ///< of the current sensor's flicker that is the battery's
  std::ptrdiff_t late_samples = 0;     ///< that the current was moved by to meet the voltage
  bool slow = false;  ///< sampled too slowly, or too little left, to set edges aside
};

/// @param holdout_share of the recording, which is not in its training part.
/// @param anyway problems (findProblems()) are none.
/// @return why a training part cannot be diagnosed, and how long a recording must be or what is to
/// be corrected; none when it can.
std::optional<std::string> lackOf(const Series& train, double holdout_share, bool anyway = false);

/// @param inputs of a training part, as a fit takes them.
/// @return why they cannot be fitted: too few are measurements; none when they can.
std::optional<std::string> lackOfMeasurements(const InputSequence& inputs);

/// @return whether either half has enough measurements to be fitted by itself.
bool hasTwoHalves(const InputSequence& inputs);

/// @param train the recording's training part.
/// @param keeps_edges edges are not to be set aside, however fast the sampling: Screening::slow.
Screening screenInstruments(const Recording& recording, const Series& train,
                            bool keeps_edges = false);

/// @return the whole recording's current as the training part taught to treat it; the training
/// part's own as screened.
Series treatedAsScreened(const Series& whole, const Screening& screening);

}  // namespace battery_sof

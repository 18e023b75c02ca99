#include "diagnosis/response_changes.hpp"

#include <cmath>
#include <utility>

#include "recording/fit_mask.hpp"

namespace battery_sof {
namespace {

void lag(std::vector<double>& values, const std::vector<double>& time, double constant) {
  for (std::size_t n = 1; n < values.size(); ++n) {
    const double kept = std::exp(-(time[n] - time[n - 1]) / constant);
    values[n] = kept * values[n - 1] + (1.0 - kept) * values[n];
  }
}

}  // namespace

const std::vector<CandidateChange>& candidateChanges() {
  static const std::vector<CandidateChange> all = {
      {ChangeKind::kContact,
       "contact_resistance",
       "ohm",
       0.005,
       {-0.004, -0.002, -0.001, -0.0005, 0.0005, 0.001, 0.002, 0.003, 0.004, 0.006, 0.009, 0.014,
        0.02}},
      {ChangeKind::kGain,
       "current_gain",
       "1",
       0.1,
       {-0.3, -0.2, -0.14, -0.1, -0.06, -0.03, 0.03, 0.06, 0.1, 0.14, 0.2, 0.3}},
      {ChangeKind::kOffset,
       "current_offset",
       "A",
       2.0,
       {-5.0, -3.0, -2.0, -1.2, -0.8, -0.4, 0.4, 0.8, 1.2, 2.0, 3.0, 5.0}},
      {ChangeKind::kSkew, "time_skew", "s", HUGE_VAL, {-3, -2, -1, 1, 2, 3}, false},
      // > 0: the voltage lags; < 0: the current
      {ChangeKind::kLag, "sensor_lag", "s", HUGE_VAL, {-5, -3, -2, -1.3, -0.7, 0.7, 1.3, 2, 3, 5}},
  };
  return all;
}

ResponseRows withChange(ResponseRows rows, ChangeKind kind, double strength) {
  switch (kind) {
    case ChangeKind::kContact: {
      const ResponseRows met = withCurrentMoved(rows, rows.moved);
      for (std::size_t n = 0; n < rows.size(); ++n) rows.voltage[n] += strength * met.current[n];
      break;
    }
    case ChangeKind::kGain:
      for (double& current : rows.current) current *= 1.0 + strength;
      break;
    case ChangeKind::kOffset:
      for (double& current : rows.current) current += strength;
      break;
    case ChangeKind::kSkew:  // d > 0: the voltage comes late, the current early
      return withCurrentMoved(std::move(rows), -static_cast<int>(std::lround(strength)));
    case ChangeKind::kLag:
      lag(strength > 0.0 ? rows.voltage : rows.current, rows.time,
          std::abs(strength) * rows.interval);
      // A current that lags does not reach the end of the sensor's range.
      for (char& excluded : rows.excluded)
        if (strength < 0.0 && excluded == static_cast<char>(SampleFault::kClipped)) excluded = 0;
      break;
  }
  return rows;
}

}  // namespace battery_sof

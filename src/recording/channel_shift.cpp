#include "recording/channel_shift.hpp"

#include <algorithm>

#include "recording/channel_statistics.hpp"
#include "util/text.hpp"

namespace battery_sof {

Series withShiftedCurrent(const Series& series, double shift) {
  requireThat(true, "shift of the current [s]", shift, "finite");
  Series shifted;
  shifted.temperature_time = series.temperature_time;
  shifted.temperature = series.temperature;
  const double gap = gapThreshold(series);
  std::size_t after = 0;
  for (std::size_t n = 0; n < series.size(); ++n) {
    const double time = series.time[n] - shift;
    while (after < series.size() && series.time[after] < time) ++after;
    if (after == series.size()) break;
    if (series.time[after] == time) {
      shifted.append({series.time[n], series.current[after], series.voltage[n]});
      continue;
    }
    if (after == 0 || series.time[after] - series.time[after - 1] > gap) continue;
    const double from = series.time[after - 1], share = (time - from) / (series.time[after] - from);
    const double current =
        series.current[after - 1] + share * (series.current[after] - series.current[after - 1]);
    shifted.append({series.time[n], current, series.voltage[n]});
  }
  return shifted;
}

}  // namespace battery_sof

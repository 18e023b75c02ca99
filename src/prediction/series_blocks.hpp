#pragma once

#include "prediction/online_session.hpp"
#include "prediction/range_prediction.hpp"

/// What was computed of one block, with the voltages of a row of them
/// (recording/series_blocks.hpp).
namespace battery_sof {

RangePrediction ofSeries(RangePrediction of_one, double series_blocks);
SessionEvents ofSeries(SessionEvents of_one, double series_blocks);
SessionStatus ofSeries(SessionStatus of_one, double series_blocks);

}  // namespace battery_sof

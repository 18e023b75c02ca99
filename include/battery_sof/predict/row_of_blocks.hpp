#pragma once

#include "battery_sof/predict/online_session.hpp"
#include "battery_sof/predict/range_prediction.hpp"

/// What was computed of one block, with the voltages of a row of them (recording/blocks.hpp).
namespace battery_sof {

RangePrediction inRow(RangePrediction of_one, double blocks);
SessionEvents inRow(SessionEvents of_one, double blocks);
SessionStatus inRow(SessionStatus of_one, double blocks);

}  // namespace battery_sof

#pragma once

#include <battery_sof/SetStandingQuery.h>

#include "ros/node_options.hpp"

namespace battery_sof {

/**
 * @brief The standing questions with what a request changes. NaN keeps what there is, and so does 0
 * where zero has no meaning (askedFor()): of all but i_load and t_stop.
 * @throws NodeOptionsError for values outside the ranges of the parameters standing_query/..., one
 * line each.
 */
StandingQueries changedBy(const SetStandingQuery::Request& request, const StandingQueries& present);

/// A response of OK with the standing questions. u_required is NaN when it is not asked. @param
/// lately see StandingQueries::chargeAt().
SetStandingQuery::Response responseOf(const StandingQueries& standing,
                                      const std::optional<double>& lately = std::nullopt);

/// A response of INVALID_QUERY with the questions that stay.
SetStandingQuery::Response refusalOf(const NodeOptionsError& error, const StandingQueries& present,
                                     const std::optional<double>& lately = std::nullopt);

}  // namespace battery_sof

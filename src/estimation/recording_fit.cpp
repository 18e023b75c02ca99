#include "estimation/recording_fit.hpp"

#include <cmath>
#include <stdexcept>

#include "recording/fit_mask.hpp"
#include "state/residual_filter.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

WindowChoice windowOf(const Series& series, const FitRequest& request) {
  const IndexRange searched = samplesBetween(series, request.from, request.to);
  if (request.from && request.to && !request.chooses_window) return {searched, 0.0, ""};
  WindowSearch search;
  search.from = series.time[searched.first];
  search.to = series.time[searched.last - 1];
  return chooseWindow(series, search);
}

}  // namespace

FitPlan planFit(const Series& series, const FitRequest& request) {
  FitPlan plan{windowOf(series, request), request.options};
  if (!plan.window.range) return plan;
  const InstrumentLimits limits = instrumentLimits(series);
  plan.options.masked = limits.withoutClipped();
  plan.options.voltage_lsb_std = limits.voltage_lsb_std;
  if (plan.options.start != FitStart::kPaper)
    plan.options.source = chargerControl(series, plan.window.range->last);
  return plan;
}

FittedModel fitPlanned(const Series& series, const FitPlan& plan) {
  FittedModel model;
  if (!plan.window.range) {
    model.fit.status = FitStatus::kNotExcited;
    model.fit.message = plan.window.message;
    return model;
  }
  model = identify(series, *plan.window.range, plan.options);
  if (isUsable(model.fit)) fitErrors(model, series, *plan.window.range);
  return model;
}

void carryToEnd(FittedModel& model, const Series& series, const FitRequest& request) {
  carryState(model, series, samplesBetween(series, std::nullopt, request.to).last - 1);
}

IndexRange samplesBetween(const Series& series, std::optional<double> from,
                          std::optional<double> to) {
  if (series.empty())
    throw std::invalid_argument("the recording has no samples, expected at least one");
  const double first = from.value_or(series.time.front()), last = to.value_or(series.time.back());
  if (!std::isfinite(first) || !std::isfinite(last))
    throw std::invalid_argument(
        format("the range is %g to %g s, expected finite times", first, last));
  const IndexRange range = indexRange(series, first, last);
  if (!range.empty()) return range;
  throw std::invalid_argument(
      format("no sample from %.3f to %.3f s; the recording holds %.3f to %.3f s", first, last,
             series.time.front(), series.time.back()));
}

}  // namespace battery_sof

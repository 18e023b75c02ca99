// Preloaded into a node it stands before the core: where a test asks for it by a current that
// nothing else uses, a function of the core throws or loses its numbers. All else goes on to the
// core.
#include <dlfcn.h>

#include <limits>
#include <stdexcept>

#include "estimation/window.hpp"
#include "prediction/online_session.hpp"

namespace battery_sof {
namespace {

// [A]
constexpr double kThrowsInPush = -66.6, kThrowsInQuery = -77.7, kThrowsInFit = -44.4,
                 kLosesNumbers = -55.5;

/// A function of the core by its linker's name. `this` is the first argument of a member.
template <typename Function>
Function* inCore(const char* name) {
  auto* function = reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
  if (!function) throw std::logic_error(std::string("the core has no ") + name);
  return function;
}

}  // namespace

SessionEvents OnlineSession::push(const RawSample& sample) {
  static auto* const in_core = inCore<SessionEvents(OnlineSession*, const RawSample&)>(
      "_ZN11battery_sof13OnlineSession4pushERKNS_9RawSampleE");
  if (sample.current == kThrowsInPush) throw std::runtime_error("thrown in a push");
  return in_core(this, sample);
}

FollowedSample StateEstimator::predict(InputSample sample) {
  static auto* const in_core = inCore<FollowedSample(StateEstimator*, InputSample)>(
      "_ZN11battery_sof14StateEstimator7predictENS_11InputSampleE");
  FollowedSample followed = in_core(this, sample);
  if (sample.step.current == kLosesNumbers)
    followed.voltage = std::numeric_limits<double>::quiet_NaN();
  return followed;
}

CrankingAnswer predictCranking(const FittedModel& model, const CrankingQuery& query,
                               double capacity) {
  static auto* const in_core =
      inCore<CrankingAnswer(const FittedModel&, const CrankingQuery&, double)>(
          "_ZN11battery_sof15predictCrankingERKNS_11FittedModelERKNS_13CrankingQueryEd");
  if (query.i_cranking == kThrowsInQuery) throw std::runtime_error("thrown in a query");
  return in_core(model, query, capacity);
}

WindowChoice chooseWindow(const Series& series, IndexRange searched, std::optional<double> length) {
  static auto* const in_core =
      inCore<WindowChoice(const Series&, IndexRange, std::optional<double>)>(
          "_ZN11battery_sof12chooseWindowERKNS_6SeriesENS_10IndexRangeESt8optionalIdE");
  if (series.current.back() == kThrowsInFit) throw std::runtime_error("thrown in a fit");
  return in_core(series, searched, length);
}

}  // namespace battery_sof

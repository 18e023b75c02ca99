#include "prediction/stop_time.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kFirst = 0.5;  // [s]
// from stop to stop: five of them within the decade a relaxation takes
constexpr double kGrowth = 1.5;
constexpr double kResolution = 0.1;  // [s]
constexpr double kRelative = 0.01;   // of the stop time
constexpr double kRise = 1e-4;       // [V] a block, below it a rise is rounding
constexpr double kEver = std::numeric_limits<double>::infinity();

CrankingQuery crankOf(const StopTimeQuery& query) {
  CrankingQuery crank;
  crank.i_load = query.i_load;
  crank.i_cranking = query.i_cranking;
  crank.t_cranking = query.t_cranking;
  crank.u_required = query.u_required;
  crank.crank = query.crank;
  crank.temperature = query.temperature;
  return crank;
}

double of(const Interval& u, int bound) {
  return bound == 0 ? u.lower : bound == 1 ? u.value : u.upper;
}

/// Where one of the bounds stops to hold: somewhere between two stops, or never.
struct Crossing {
  bool failed = false;
  double holds_at = 0.0, fails_at = 0.0;  // [s]
  double spare = 0.0, lack = 0.0;         // [V], above and below what is required at these
  std::optional<Simulation> standing;     // at holds_at
};

/// The stop that draws a charge [Ah], at most a day [s].
double stopThatDraws(double charge, double i_load) {
  return i_load < 0.0 ? std::min(kLongestQuery, kSecondsPerHour * charge / -i_load) : kLongestQuery;
}

/// Follows the stop phase and predicts cranks along it.
class StopScan {
 public:
  /// @param longest [s], where the stop phase ends.
  StopScan(const FittedModel& model, const CrankingQuery& crank, double longest, double capacity)
      : model_(model),
        crank_(crank),
        longest_(longest),
        capacity_(capacity),
        here_(uncertainSimulationOf(model)) {}

  void scan() {
    look(0.0);
    for (double t = kFirst; open() && has_numbers_ && at_ < longest_; t *= kGrowth)
      look(std::min(t, longest_));
  }

  /// The longest stop of the lower bound, the value and the upper bound, to kResolution or
  /// kRelative.
  double crossing(int bound) const {
    const Crossing& found = crossings_[bound];
    if (!found.failed) return kEver;
    return found.fails_at == 0.0 ? 0.0 : refined(found, bound);
  }
  bool monotone() const { return monotone_; }
  std::optional<double> holdsAgainAt() const { return holds_again_; }
  /// The crank's lowest voltage without a stop [V].
  const std::optional<Interval>& atOnce() const { return at_once_; }
  /// False when a crank along the stop phase had no finite voltage.
  bool hasNumbers() const { return has_numbers_; }

 private:
  /// Whether a crossing is still to be found.
  bool open() const { return !crossings_[2].failed; }

  double spareOf(const Interval& u, int bound) const { return of(u, bound) - *crank_.u_required; }

  Interval crankAfter(const Simulation& standing, double t) const {
    return lowestOfCrank(
        standing, model_, crank_, t,
        openCircuitFall(model_.fit, -crank_.i_load * t / kSecondsPerHour, capacity_));
  }

  void look(double t) {
    const Simulation before = here_;
    hold(here_, crank_.i_load, t - at_);
    const Interval u = crankAfter(here_, t);
    has_numbers_ = has_numbers_ && areNumbers(u);
    if (!at_once_) at_once_ = u;
    if (before_ && u.value > *before_ + kRise * model_.fit.series_blocks) monotone_ = false;
    before_ = u.value;
    for (int bound = 0; bound < 3; ++bound) note(crossings_[bound], t, spareOf(u, bound), before);
    if (crossings_[1].failed && spareOf(u, 1) >= 0.0 && !holds_again_) holds_again_ = t;
    at_ = t;
  }

  static void note(Crossing& crossing, double t, double spare, const Simulation& before) {
    if (crossing.failed) return;
    if (spare >= 0.0) {
      crossing.holds_at = t;
      crossing.spare = spare;
      return;
    }
    crossing.failed = true;
    crossing.fails_at = t;
    crossing.lack = -spare;
    crossing.standing.emplace(before);
  }

  /// Regula falsi (Illinois) between the two stops.
  double refined(const Crossing& found, int bound) const {
    double low = found.holds_at, high = found.fails_at, spare = found.spare, lack = found.lack;
    double t = low;
    for (int k = 0, side = 0; k < 50; ++k) {
      const double enough = std::max(kResolution, kRelative * low);
      if (high - low <= enough) return low;
      const double slope = (spare + lack) / (high - low);
      t = low + spare / slope;
      Simulation there = *found.standing;
      hold(there, crank_.i_load, t - found.holds_at);
      const double now = spareOf(crankAfter(there, t), bound);
      if (std::abs(now) <= 0.25 * enough * slope) return t;
      if (now >= 0.0) {
        low = t;
        spare = now;
        if (side > 0) lack *= 0.5;
        side = 1;
      } else {
        high = t;
        lack = -now;
        if (side < 0) spare *= 0.5;
        side = -1;
      }
    }
    return t;
  }

  const FittedModel& model_;
  const CrankingQuery& crank_;
  double longest_, capacity_;
  Simulation here_;
  double at_ = 0.0;
  Crossing crossings_[3];
  std::optional<Interval> at_once_;
  std::optional<double> before_, holds_again_;
  bool monotone_ = true, has_numbers_ = true;
};

/// By how much a discrepancy model is held at its range's end in a crank after a stop [V].
double beyondIdentifiedAfter(const FittedModel& model, const CrankingQuery& crank, double t_stop) {
  Simulation simulation = simulationOf(model);
  hold(simulation, crank.i_load, t_stop);
  double beyond = simulation.beyondIdentified();
  lowestOfCrank(std::move(simulation), model, crank, t_stop, {}, &beyond);
  return beyond;
}

std::string shown(double t_stop) {
  return std::isinf(t_stop) ? "no end" : format("%.1f s", t_stop);
}

/// What lies beyond the longest stop that is supported.
std::string beyond(double crossing) {
  if (crossing == kEver) return "; longer ones are not supported";
  return format("; the model puts the end at %.1f s, which is not supported", crossing);
}

std::string messageOf(const StopTimeAnswer& answer, const StopTimeQuery& query,
                      const StopScan& scan) {
  std::string text;
  if (answer.outcome == StopTimeOutcome::kAtLeast)
    text =
        format("the crank holds %.2f V after stops up to at least %.1f s, its lower bound up to %s",
               query.u_required, answer.t_stop->value, shown(answer.t_stop->lower).c_str()) +
        beyond(scan.crossing(1));
  else if (answer.outcome == StopTimeOutcome::kAlways)
    text = format("the crank holds %.2f V after every stop up to a day", query.u_required);
  else if (answer.outcome == StopTimeOutcome::kNever)
    text = format("the crank does not hold %.2f V even at once", query.u_required);
  else
    text = format("the crank holds %.2f V after stops up to %.1f s, 90 %% between %s and %s",
                  query.u_required, answer.t_stop->value, shown(answer.t_stop->lower).c_str(),
                  shown(answer.t_stop->upper).c_str());
  if (scan.holdsAgainAt())
    text += format("; it would hold again after %.1f s", *scan.holdsAgainAt());
  return text;
}

}  // namespace

StopTimeQuery asked(StopTimeQuery request) {
  request.t_cranking = askedFor(request.t_cranking).value_or(StopTimeQuery().t_cranking);
  return request;
}

std::string toString(StopTimeOutcome outcome) {
  switch (outcome) {
    case StopTimeOutcome::kFinite: return "finite";
    case StopTimeOutcome::kAtLeast: return "at_least";
    case StopTimeOutcome::kAlways: return "always";
    case StopTimeOutcome::kNever: return "never";
  }
  return "never";
}

namespace {

/// @param value [s], of the stop.  @param supported [Ah], supportedCharge().
QueryRange rangeOf(const FittedModel& model, const StopTimeQuery& query, const CrankingQuery& crank,
                   double value, double supported) {
  QueryRange range;
  range.min_current = query.i_cranking;
  if (!query.crank.empty())
    range.min_current = *std::min_element(query.crank.current.begin(), query.crank.current.end());
  range.charge_moved =
      std::min(-query.i_load * std::min(value, kLongestQuery) / kSecondsPerHour, supported);
  range.temperature = query.temperature;
  if (model.fit.discrepancy)
    range.beyond_identified = beyondIdentifiedAfter(model, crank, std::min(value, kLongestQuery));
  return range;
}

}  // namespace

StopTimeAnswer predictStopTime(const FittedModel& model, const StopTimeQuery& query,
                               double capacity) {
  const CrankingQuery crank = crankOf(query);
  std::string faults = faultsOf(crank);
  if (!askedFor(query.u_required)) faults = "no limit is given for a crank to hold: " + faults;
  return answered<StopTimeAnswer>(
      model, faults, capacity, [&](StopTimeAnswer& answer) -> std::optional<QueryRange> {
        const bool draws = query.i_load < 0.0;
        const double supported = supportedCharge(model.fit, capacity);
        const double longest = stopThatDraws(capacity, query.i_load);
        const double longest_held = draws ? stopThatDraws(supported, query.i_load) : kEver;
        StopScan scan(model, crank, longest, capacity);
        scan.scan();
        if (!scan.hasNumbers()) return std::nullopt;
        const double crossing = scan.crossing(1), value = std::min(crossing, longest_held);
        const double upper = std::min(scan.crossing(2), draws ? longest : kEver);
        answer.t_stop = Interval{value, std::min(scan.crossing(0), value), std::max(upper, value)};
        answer.outcome = value == 0.0       ? StopTimeOutcome::kNever
                         : value == kEver   ? StopTimeOutcome::kAlways
                         : value < crossing ? StopTimeOutcome::kAtLeast
                                            : StopTimeOutcome::kFinite;
        answer.monotone = scan.monotone();
        answer.message = messageOf(answer, query, scan);

        QueryRange range = rangeOf(model, query, crank, value, supported);
        range.answered_voltage = scan.atOnce();
        // Ends closer than the search resolves are the same.
        range.says_nothing = widthSaysNothing(
            {value, answer.t_stop->lower, std::min(answer.t_stop->upper, longest)},
            longest - kResolution, "s", draws ? "the stop that draws all of the battery" : "a day");
        return range;
      });
}

}  // namespace battery_sof

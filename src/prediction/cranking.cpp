#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "battery_sof/intake.hpp"
#include "prediction/questions.hpp"
#include "util/constants.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kLongestCrank = 60.0;                   // [s], no starter survives more
constexpr std::size_t kMaxPoints = 100000;               // of a load or crank
constexpr double kLooks[] = {0.0, 0.05, 0.2, 0.5, 1.0};  // of a crank's time

double lowestOf(const CurrentProfile& profile) {
  return profile.empty() ? 0.0 : *std::min_element(profile.current.begin(), profile.current.end());
}
double highestOf(const CurrentProfile& profile) {
  return profile.empty() ? 0.0 : *std::max_element(profile.current.begin(), profile.current.end());
}

double lowestCurrent(const CrankingQuery& query) {
  return query.crank.empty() ? query.i_cranking : lowestOf(query.crank);
}

/// Charge out of the battery while it stands [Ah].
double drawnInStop(const CrankingQuery& query) {
  if (query.load.empty()) return -query.i_load * query.t_stop / kSecondsPerHour;
  double charge = -query.load.current.front() * query.load.time.front();
  for (std::size_t n = 1; n < query.load.time.size(); ++n)
    charge -= 0.5 * (query.load.current[n] + query.load.current[n - 1]) *
              (query.load.time[n] - query.load.time[n - 1]);
  return charge / kSecondsPerHour;
}

/// Runs a profile from where the simulation stands; look(simulation, seconds since the beginning)
/// at every point.
template <typename Look>
void run(Simulation& simulation, const CurrentProfile& profile, Look&& look) {
  double time_before = 0.0, current_before = profile.current.front();
  for (std::size_t n = 0; n < profile.time.size(); ++n) {
    InputStep step = inputStep(time_before, current_before, profile.time[n], profile.current[n],
                               std::numeric_limits<double>::infinity());
    step.time = simulation.time() + step.duration;
    simulation.advance(step);
    look(simulation, profile.time[n]);
    time_before = profile.time[n];
    current_before = profile.current[n];
  }
}

/// What an answer's message says: the interval and what is required.
std::string sentenceOf(const CrankingAnswer& answer, const std::optional<double>& u_required) {
  const std::string text = format("lowest voltage %.2f V, 90 %% between %.2f and %.2f V",
                                  answer.u_min->value, answer.u_min->lower, answer.u_min->upper);
  if (!u_required) return text + "; no u_required was given, so no limit was checked";
  return text + format("; required %.2f V", *u_required);
}

QueryRange rangeOf(const CrankingQuery& query) {
  QueryRange range;
  range.min_current = std::min(lowestCurrent(query), lowestOf(query.load));
  range.max_current = highestOf(query.load);
  range.charge_moved = std::abs(drawnInStop(query));
  range.temperature = query.temperature;
  return range;
}

/// Lowest voltage of a crank [V], of one block, that begins where a simulation stands, `ahead` [s]
/// after the model's state. @param fall openCircuitFall() until then.
/// @param beyond_identified raised to Simulation::beyondIdentified() [V]; nullptr: not needed.
Interval lowestOfCrank(Simulation simulation, const FittedModel& model, const CrankingQuery& query,
                       double ahead, const ErrorForecast& fall,
                       double* beyond_identified = nullptr) {
  const ResidualFilter errors(model);
  const double own = crankError(model.fit, lowestCurrent(query));
  std::optional<LowestVoltage> lowest;
  const auto look = [&](const Simulation& now, double since) {
    const Interval u = voltageAnswer(now, errors.forecastThrough(ahead + since), own,
                                     model.intervals.calibrations.cranks);
    if (!lowest || u.value <= lowest->by_model.value) lowest = {u, now.voltage(), ahead + since};
    if (beyond_identified)
      *beyond_identified = std::max(*beyond_identified, now.beyondIdentified());
  };
  if (!query.crank.empty()) {
    run(simulation, query.crank, look);
    return crankAnswer(model, lowestCurrent(query), *lowest, fall);
  }
  double since = 0.0;
  for (const double share : kLooks) {
    if (model.fit.effects.empty() && share > 0.0 && share < 1.0) continue;
    simulation.hold(query.i_cranking, share * query.t_cranking - since);
    since = share * query.t_cranking;
    look(simulation, since);
  }
  return crankAnswer(model, lowestCurrent(query), *lowest, fall);
}

}  // namespace

CrankingQuery asked(CrankingQuery request) {
  request.t_cranking = askedFor(request.t_cranking).value_or(CrankingQuery().t_cranking);
  request.u_required = askedFor(request.u_required);
  return request;
}

Faults faultsOf(const CrankingQuery& q) {
  Faults faults;
  if (q.load.empty()) {
    requireOf(faults, q.i_load <= 0.0 && q.i_load >= -kMaxCurrent, "i_load [A]", q.i_load,
              "-5000 to 0 (negative: out of the battery)");
    requireOf(faults, q.t_stop >= 0.0 && q.t_stop <= kLongestQuery, "t_stop [s]", q.t_stop,
              "0 to 86400");
  }
  if (q.crank.empty()) {
    requireOf(faults, q.i_cranking < 0.0 && q.i_cranking >= -kMaxCurrent, "i_cranking [A]",
              q.i_cranking, "-5000 to below 0 (negative: out of the battery)");
    requireOf(faults, q.t_cranking > 0.0 && q.t_cranking <= kLongestCrank, "t_cranking [s]",
              q.t_cranking, "above 0, up to 60");
  }
  for (const auto& fault : {faultOf(q.load.time, q.load.current, "load", kMaxPoints),
                            faultOf(q.crank.time, q.crank.current, "crank", kMaxPoints)})
    if (fault) faults.push_back(*fault);
  requireOf(faults, q.crank.duration() <= kLongestCrank, "last crank time [s]", q.crank.duration(),
            "up to 60");
  if (faults.empty() && !q.crank.empty())
    requireOf(faults, lowestCurrent(q) < 0.0, "lowest crank current [A]", lowestCurrent(q),
              "below 0");
  if (q.u_required)
    requireOf(faults, *q.u_required > 0.0 && *q.u_required <= 100.0, "u_required [V]",
              *q.u_required, "above 0, up to 100");
  return faults;
}

double crankError(const Fit& fit, double current) {
  // Without a crank in the window the scores hold the error of normal driving: it grows with the
  // current.
  if (fit.scores.cranks > 0) return fit.scores.crank_error_std;
  const double seen = std::max({-fit.excited.min_current, fit.excited.max_current, 1.0});
  return fit.scores.rmse * std::max(1.0, std::abs(current) / seen);
}

CrankingAnswer predictCranking(const FittedModel& model, const CrankingQuery& query,
                               double capacity) {
  return answered<CrankingAnswer>(
      model, faultsOf(query), capacity, [&](CrankingAnswer& answer) -> std::optional<QueryRange> {
        Simulation simulation = uncertainSimulationOf(model);
        if (query.load.empty())
          simulation.hold(query.i_load, query.t_stop);
        else
          run(simulation, query.load, [](const Simulation&, double) {});
        const double t_stop = query.load.empty() ? query.t_stop : query.load.duration();
        QueryRange range = rangeOf(query);
        range.answered_voltage = lowestOfCrank(
            std::move(simulation), model, query, t_stop,
            openCircuitFall(model.fit, drawnInStop(query), capacity), &range.beyond_identified);
        if (!areNumbers(*range.answered_voltage)) return std::nullopt;
        answer.u_min = ofSeries(*range.answered_voltage, model.fit.series_blocks);
        if (query.u_required) answer.capable = answer.u_min->lower >= *query.u_required;
        answer.message = sentenceOf(answer, query.u_required);
        return range;
      });
}

// ---------------------------------------------------------------------------------------------
// the longest stop before a crank

namespace {

constexpr double kFirst = 0.5;  // [s]
// from stop to stop: five of them within the decade a relaxation takes
constexpr double kNextStop = 1.5;
constexpr double kResolution = 0.1;  // [s]
constexpr double kRelative = 0.01;   // of the stop time
constexpr double kRise = 1e-4;       // [V] a block, below it a rise is rounding
constexpr double kEver = std::numeric_limits<double>::infinity();

/// @param series_blocks of the voltage that is required; the crank's is of one block.
CrankingQuery crankOf(const StopTimeQuery& query, double series_blocks) {
  const double u_required = query.u_required / series_blocks;
  return {query.i_load, 0.0, query.i_cranking, query.t_cranking,
          u_required,   {},  query.crank,      query.temperature};
}

constexpr double Interval::*kBounds[] = {&Interval::lower, &Interval::value, &Interval::upper};

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
  /// @param crank with what is required of one block.  @param longest [s], where the stop phase ends.
  StopScan(const FittedModel& model, const CrankingQuery& crank, double longest, double capacity)
      : model_(model),
        crank_(crank),
        longest_(longest),
        capacity_(capacity),
        here_(uncertainSimulationOf(model)) {}

  void scan() {
    look(0.0);
    for (double t = kFirst; open() && has_numbers_ && at_ < longest_; t *= kNextStop)
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

  double spareOf(const Interval& u, int bound) const {
    return u.*kBounds[bound] - *crank_.u_required;
  }

  Interval crankAfter(const Simulation& standing, double t) const {
    return lowestOfCrank(
        standing, model_, crank_, t,
        openCircuitFall(model_.fit, -crank_.i_load * t / kSecondsPerHour, capacity_));
  }

  void look(double t) {
    const Simulation before = here_;
    here_.hold(crank_.i_load, t - at_);
    const Interval u = crankAfter(here_, t);
    has_numbers_ = has_numbers_ && areNumbers(u);
    if (!at_once_) at_once_ = u;
    if (before_ && u.value > *before_ + kRise) monotone_ = false;
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
      there.hold(crank_.i_load, t - found.holds_at);
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

/// The model with one parameter a number of standard errors away, and with it what goes along.
FittedModel displaced(FittedModel model, Eigen::Index parameter, double errors) {
  const Eigen::VectorXd along = model.fit.covariance.col(parameter);
  if (!(along[parameter] > 0.0)) return model;
  const Eigen::VectorXd moved = errors / std::sqrt(along[parameter]) * along;
  Eigen::VectorXd values = pointOf(model).parameters;
  values += moved.head(values.size());
  const BatteryModel composition = compositionOf(model.fit);
  for (Eigen::Index j = 0; j < values.size(); ++j) {
    const ParameterInfo& info = composition.parameters()[static_cast<std::size_t>(j)];
    values[j] = std::clamp(values[j], info.lower, info.upper);
    model.fit.estimates[static_cast<std::size_t>(j)].value = values[j];
  }
  model.fit.parameters = baseParameters(values);
  model.state.states += moved.tail(model.state.states.size());
  return model;
}

/// The longest stop if the acid is used up elsewhere than expected: the voltage falls so steeply
/// there that its derivatives along one curve say little of the next.
void widenAtUsedUp(Interval& t_stop, const FittedModel& model, const CrankingQuery& crank,
                   double longest, double capacity) {
  if (!std::isfinite(t_stop.value)) return;
  const BatteryModel composition = compositionOf(model.fit);
  double earlier = 0.0, later = 0.0;
  for (const char* name : {"exhaustion_voltage", "exhaustion_width"}) {
    const auto row = composition.parameterRow(name);
    if (!row) return;
    double least = t_stop.value, most = t_stop.value;
    for (const double errors : {kNinetyPercent, -kNinetyPercent}) {
      const FittedModel other = displaced(model, *row, errors);
      StopScan scan(other, crank, longest, capacity);
      scan.scan();
      const double crossing = std::min(scan.crossing(1), longest);
      least = std::min(least, crossing);
      most = std::max(most, crossing);
    }
    earlier = std::hypot(earlier, t_stop.value - least);
    later = std::hypot(later, most - t_stop.value);
  }
  t_stop.lower = std::clamp(t_stop.value - earlier, 0.0, t_stop.lower);
  t_stop.upper = std::clamp(t_stop.value + later, t_stop.upper, std::max(t_stop.upper, longest));
}

/// By how much a discrepancy model is held at its range's end in a crank after a stop [V].
double beyondIdentifiedAfter(const FittedModel& model, const CrankingQuery& crank, double t_stop) {
  Simulation simulation = simulationOf(model);
  simulation.hold(crank.i_load, t_stop);
  double beyond = simulation.beyondIdentified();
  lowestOfCrank(std::move(simulation), model, crank, t_stop, {}, &beyond);
  return beyond;
}

std::string shown(double t_stop) {
  return std::isinf(t_stop) ? "no end" : format("%.1f s", t_stop);
}

/// What lies beyond the longest stop that is supported.
std::string beyond(double crossing) {
  if (crossing == kEver) return "; answers for longer stops are not valid";
  return format("; the model puts the end at %.1f s, but that is not valid", crossing);
}

std::string messageOf(const StopTimeAnswer& answer, const StopTimeQuery& query,
                      const StopScan& scan) {
  std::string text;
  if (answer.outcome == StopTimeOutcome::kAtLeast)
    text =
        format("a crank keeps %.2f V after stops up to at least %.1f s, its lower bound up to %s",
               query.u_required, answer.t_stop->value, shown(answer.t_stop->lower).c_str()) +
        beyond(scan.crossing(1));
  else if (answer.outcome == StopTimeOutcome::kAlways)
    text = format("a crank keeps %.2f V after every stop up to a day", query.u_required);
  else if (answer.outcome == StopTimeOutcome::kNever)
    text = format("a crank falls below %.2f V even without a stop", query.u_required);
  else
    text = format("a crank keeps %.2f V after stops up to %.1f s, 90 %% between %s and %s",
                  query.u_required, answer.t_stop->value, shown(answer.t_stop->lower).c_str(),
                  shown(answer.t_stop->upper).c_str());
  if (scan.holdsAgainAt())
    text += format("; after stops of %.1f s and more it would keep it again", *scan.holdsAgainAt());
  return text;
}

}  // namespace

StopTimeQuery asked(StopTimeQuery request) {
  request.t_cranking = askedFor(request.t_cranking).value_or(StopTimeQuery().t_cranking);
  return request;
}

std::string toString(StopTimeOutcome outcome) {
  constexpr std::array kNames = {"finite", "at_least", "always", "never"};
  return kNames.at(static_cast<std::size_t>(outcome));
}

Faults faultsOf(const StopTimeQuery& query) {
  Faults faults = faultsOf(crankOf(query, 1.0));
  if (!askedFor(query.u_required))
    faults.insert(faults.begin(), "no limit is given that the crank has to keep");
  return faults;
}

StopTimeAnswer predictStopTime(const FittedModel& model, const StopTimeQuery& query,
                               double capacity) {
  const CrankingQuery crank = crankOf(query, model.fit.series_blocks);
  return answered<StopTimeAnswer>(
      model, faultsOf(query), capacity, [&](StopTimeAnswer& answer) -> std::optional<QueryRange> {
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
        widenAtUsedUp(*answer.t_stop, model, crank, longest, capacity);
        answer.outcome = value == 0.0       ? StopTimeOutcome::kNever
                         : value == kEver   ? StopTimeOutcome::kAlways
                         : value < crossing ? StopTimeOutcome::kAtLeast
                                            : StopTimeOutcome::kFinite;
        answer.monotone = scan.monotone();
        answer.message = messageOf(answer, query, scan);

        QueryRange range = rangeOf(crank);
        const double t_stop = std::min(value, kLongestQuery);
        range.charge_moved = std::min(-query.i_load * t_stop / kSecondsPerHour, supported);
        if (model.fit.discrepancy)
          range.beyond_identified = beyondIdentifiedAfter(model, crank, t_stop);
        range.answered_voltage = scan.atOnce();
        // Ends closer than the search resolves are the same.
        range.says_nothing = widthSaysNothing(
            ReasonKind::kWideStop,
            {value, answer.t_stop->lower, std::min(answer.t_stop->upper, longest)},
            longest - kResolution, draws ? "the stop that discharges the whole battery" : "a day");
        return range;
      });
}

}  // namespace battery_sof

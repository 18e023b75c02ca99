#include "prediction/cranking.hpp"

#include <algorithm>
#include <cmath>

#include "battery_sof/intake.hpp"
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
    const double duration = profile.time[n] - time_before;
    InputStep step;
    step.duration = duration;
    step.time = simulation.time() + duration;
    step.held = 0.5 * (current_before + profile.current[n]);
    step.current = profile.current[n];
    simulation.advance(step);
    look(simulation, profile.time[n]);
    time_before = profile.time[n];
    current_before = profile.current[n];
  }
}

/// What an answer's message says: the interval, and whether it holds what is required.
std::string sentenceOf(const CrankingAnswer& answer, const std::optional<double>& u_required) {
  const std::string text = format("lowest voltage %.2f V, 90 %% between %.2f and %.2f V",
                                  answer.u_min->value, answer.u_min->lower, answer.u_min->upper);
  if (!u_required) return text + "; no u_required was given to hold it against";
  return text + format(": %s %.2f V", answer.capable.value_or(false) ? "holds" : "may not hold",
                       *u_required);
}

QueryRange rangeOf(const CrankingQuery& query) {
  QueryRange range;
  range.min_current = std::min(lowestCurrent(query), lowestOf(query.load));
  range.max_current = highestOf(query.load);
  range.charge_moved = std::abs(drawnInStop(query));
  range.temperature = query.temperature;
  return range;
}

}  // namespace

CrankingQuery asked(CrankingQuery request) {
  request.t_cranking = askedFor(request.t_cranking).value_or(CrankingQuery().t_cranking);
  request.u_required = askedFor(request.u_required);
  return request;
}

std::string faultsOf(const CrankingQuery& q) {
  std::string faults;
  if (q.load.empty()) {
    addFault(faults, q.i_load <= 0.0 && q.i_load >= -kMaxCurrent, "i_load [A]", q.i_load,
             "-5000 to 0 (negative: out of the battery)");
    addFault(faults, q.t_stop >= 0.0 && q.t_stop <= kLongestQuery, "t_stop [s]", q.t_stop,
             "0 to 86400");
  }
  if (q.crank.empty()) {
    addFault(faults, q.i_cranking < 0.0 && q.i_cranking >= -kMaxCurrent, "i_cranking [A]",
             q.i_cranking, "-5000 to below 0 (negative: out of the battery)");
    addFault(faults, q.t_cranking > 0.0 && q.t_cranking <= kLongestCrank, "t_cranking [s]",
             q.t_cranking, "above 0, up to 60");
  }
  addFault(faults, faultOf(q.load.time, q.load.current, "load", kMaxPoints));
  addFault(faults, faultOf(q.crank.time, q.crank.current, "crank", kMaxPoints));
  addFault(faults, q.crank.duration() <= kLongestCrank, "last crank time [s]", q.crank.duration(),
           "up to 60");
  if (faults.empty() && !q.crank.empty())
    addFault(faults, lowestCurrent(q) < 0.0, "lowest crank current [A]", lowestCurrent(q),
             "below 0");
  if (q.u_required)
    addFault(faults, *q.u_required > 0.0 && *q.u_required <= 100.0, "u_required [V]", *q.u_required,
             "above 0, up to 100");
  return faults;
}

double crankError(const Fit& fit, double current) {
  // Without a crank in the window the scores hold the error of normal driving: it grows with the
  // current.
  if (fit.scores.cranks > 0) return fit.scores.crank_error_std;
  const double seen = std::max({-fit.excited.min_current, fit.excited.max_current, 1.0});
  return fit.scores.rmse * std::max(1.0, std::abs(current) / seen);
}

Interval lowestOfCrank(Simulation simulation, const FittedModel& model, const CrankingQuery& query,
                       double ahead, const ErrorForecast& fall, double* beyond_identified) {
  const ResidualFilter errors(model);
  const double own = crankError(model.fit, lowestCurrent(query));
  std::optional<Interval> lowest;
  const auto look = [&](const Simulation& now, double since) {
    const Interval u = voltageAnswer(now, errors.forecastThrough(ahead + since), own,
                                     model.intervals.crank_calibration);
    if (!lowest || u.value <= lowest->value) lowest = u;
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
    hold(simulation, query.i_cranking, share * query.t_cranking - since);
    since = share * query.t_cranking;
    look(simulation, since);
  }
  return crankAnswer(model, lowestCurrent(query), *lowest, fall);
}

CrankingAnswer predictCranking(const FittedModel& model, const CrankingQuery& query,
                               double capacity) {
  return answered<CrankingAnswer>(
      model, faultsOf(query), capacity, [&](CrankingAnswer& answer) -> std::optional<QueryRange> {
        Simulation simulation = uncertainSimulationOf(model);
        if (query.load.empty())
          hold(simulation, query.i_load, query.t_stop);
        else
          run(simulation, query.load, [](const Simulation&, double) {});
        const double t_stop = query.load.empty() ? query.t_stop : query.load.duration();
        QueryRange range = rangeOf(query);
        answer.u_min = lowestOfCrank(std::move(simulation), model, query, t_stop,
                                     openCircuitFall(model.fit, drawnInStop(query), capacity),
                                     &range.beyond_identified);
        if (!areNumbers(*answer.u_min)) return std::nullopt;
        range.answered_voltage = answer.u_min;
        if (query.u_required) answer.capable = answer.u_min->lower >= *query.u_required;
        answer.message = sentenceOf(answer, query.u_required);
        return range;
      });
}

}  // namespace battery_sof

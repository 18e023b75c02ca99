#include <cstdio>

#include "experiment.hpp"

namespace battery_sof {
namespace {

constexpr double kLoad = -2.0, kCrank = -75.0;  // [A]
constexpr double kMaxGap = 3.0;                 // [s]
constexpr double kShortest = 10.0;              // [s], of a stop that is looked at
constexpr double kLooks[] = {0.0, 10.0, 30.0, 60.0, 120.0, 240.0};  // [s] into a stop

/// Samples of a discharge to a load, and of the crank that ends it if one does.
struct Stop {
  IndexRange load;
  std::size_t crank_end;
};

std::vector<Stop> stopsOf(const Series& series) {
  std::vector<Stop> stops;
  const auto is_load = [&](std::size_t n) {
    return series.current[n] < kLoad && series.current[n] > kCrank;
  };
  const auto joined = [&](std::size_t n) { return series.time[n] - series.time[n - 1] <= kMaxGap; };
  for (std::size_t n = 1; n < series.size(); ++n) {
    if (!is_load(n) || is_load(n - 1) || !joined(n)) continue;
    Stop stop{{n, n + 1}, 0};
    while (stop.load.last < series.size() && is_load(stop.load.last) && joined(stop.load.last))
      ++stop.load.last;
    stop.crank_end = stop.load.last;
    while (stop.crank_end < series.size() && series.current[stop.crank_end] <= kCrank &&
           joined(stop.crank_end))
      ++stop.crank_end;
    if (series.time[stop.load.last - 1] - series.time[n - 1] >= kShortest) stops.push_back(stop);
  }
  return stops;
}

/// What is expected at a moment of the rest of a stop and of its crank, from the currents that flow.
void ask(const OnlineSession& session, const Series& series, const Stop& stop, std::size_t next,
         double capacity) {
  const double now = series.time[next - 1], began = series.time[stop.load.first - 1];
  const std::string basis = toString(session.status().basis);
  const ModelSnapshot model = session.live();
  std::vector<double> time, current;
  for (std::size_t n = next; n < stop.load.last; ++n) {
    time.push_back(series.time[n] - now);
    current.push_back(series.current[n]);
  }
  if (time.empty()) return;
  const auto row = [&](const char* kind, double at, double drawn, bool valid, double measured,
                       const Interval& u) {
    std::printf("%s,%s,%.1f,%.1f,%.1f,%.4f,%d,%.4f,%.4f,%.4f,%.4f\n", kind, basis.c_str(), began,
                now - began, at, 100.0 * drawn / capacity, valid, measured, u.value, u.lower,
                u.upper);
  };
  const ProfileAnswer profile = model.simulateProfile(time, current);
  double drawn = 0.0, shown = 0.0;
  for (std::size_t n = 0; n < profile.predicted.voltage.size(); ++n) {
    drawn -= current[n] * (time[n] - (n > 0 ? time[n - 1] : 0.0)) / 3600.0;
    if (time[n] < shown + kShortest) continue;
    shown = time[n];
    row("voltage", time[n], drawn, profile.valid, series.voltage[next + n],
        {profile.predicted.voltage[n], profile.predicted.lower[n], profile.predicted.upper[n]});
  }
  if (stop.crank_end == stop.load.last) return;
  CrankingQuery query;
  query.load = {time, current};
  double lowest = series.voltage[stop.load.last];
  for (std::size_t n = stop.load.last; n < stop.crank_end; ++n) {
    query.crank.time.push_back(series.time[n] - series.time[stop.load.last - 1]);
    query.crank.current.push_back(series.current[n]);
    lowest = std::min(lowest, series.voltage[n]);
  }
  const CrankingAnswer crank = model.predictCranking(query);
  if (crank.u_min) row("crank", time.back(), drawn, crank.valid, lowest, *crank.u_min);
}

/// How long a stop is allowed, by the standing question with the load that flows.
void askLongest(const OnlineSession& session, const Series& series, const Stop& stop,
                std::size_t next) {
  const double began = series.time[stop.load.first - 1], now = series.time[next - 1];
  const auto t = session.live().predictStopTime(
      {std::min(series.current[next], kLoad), -200.0, 1.0, 7.2, {}, std::nullopt});
  if (!t.t_stop) return;
  std::printf("longest,%s,%.1f,%.1f,%.1f,0,%d,%.1f,%.1f,%.1f,%.1f\n",
              toString(session.status().basis).c_str(), began, now - began, 0.0, t.valid,
              series.time[stop.load.last - 1] - now, t.t_stop->value, t.t_stop->lower,
              std::min(t.t_stop->upper, 86400.0));
}

void print(const SessionEvents& events, const char* basis) {
  for (const EventComparison& s : events.stops)
    std::printf("stop,%s,%.1f,0,%.1f,0,1,%.4f,%.4f,%.4f,%.4f,%.4f\n", basis, s.time, s.duration,
                s.measured, s.expected.value, s.expected.lower, s.expected.upper, s.modelled);
}

}  // namespace

void printStops(const Recording& recording, const ExperimentOptions& o) {
  const Series& series = recording.series;
  const std::vector<Stop> stops = stopsOf(series);
  auto stop = stops.begin();
  SessionOptions options = o.session;
  options.capacity = o.capacity;
  OnlineSession session(options);
  std::size_t look = 0;
  play(samplesOf(series), session, [&](std::size_t n, const SessionEvents& events) {
    print(events, toString(session.status().basis).c_str());
    fitDue(session);
    const std::size_t next = n + 1;
    while (stop != stops.end() && next >= stop->load.last) {
      ++stop;
      look = 0;
    }
    if (stop == stops.end() || next < stop->load.first || look == std::size(kLooks) ||
        series.time[n] - series.time[stop->load.first - 1] < kLooks[look])
      return;
    ask(session, series, *stop, next, o.capacity);
    askLongest(session, series, *stop, next);
    ++look;
  });
}

}  // namespace battery_sof

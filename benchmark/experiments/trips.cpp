#include <cmath>
#include <cstdio>
#include <optional>

#include "experiment.hpp"

namespace battery_sof {
namespace {

/// What is tried, and where its rows go.
struct Trip {
  std::string name;
  double begin = 0.0;    // [s], of its first sample
  bool by_past = false;  // a charge was answered last because past ones support it, and only so
};

void print(const Trip& trip, const SessionEvents& events, const char* basis) {
  for (const EventComparison& c : events.cranks)
    std::printf("%s,%s,crank,%.2f,%.4f,%.4f,%.4f,%.4f,0\n", trip.name.c_str(), basis,
                c.time - trip.begin, c.measured, c.expected.value, c.expected.lower,
                c.expected.upper);
  for (const EventComparison& c : events.charges)
    std::printf("%s,%s,charge,%.2f,%.4f,%.4f,%.4f,%.4f,%d\n", trip.name.c_str(), basis,
                c.time - trip.begin, c.measured, c.expected.value, c.expected.lower,
                c.expected.upper, trip.by_past);
}

/// Whether a charge's answer is valid because of past charges alone.
bool restsOnPastCharges(const OnlineSession& session, const ChargeAcceptanceQuery& query,
                        double capacity) {
  std::optional<FittedModel> model = session.model();
  if (!model) return false;
  model->intervals.event_history = {};
  return !predictChargeAcceptance(*model, query, capacity).valid;
}

/// The standing questions with the node's defaults: valid or not, and the crank's width.
void ask(Trip& trip, const OnlineSession& session, double time, const char* basis,
         double capacity) {
  const ModelSnapshot model = session.live();
  const double u_boost = session.chargeVoltage().value_or(14.2);
  const auto crank = model.predictCranking({-20.0, 30.0, -200.0, 1.0, 7.2});
  const auto stop = model.predictStopTime({-20.0, -200.0, 1.0, 7.2});
  const ChargeAcceptanceQuery boost{u_boost, 10.0, 5000.0};
  const auto charge = model.predictChargeAcceptance(boost);
  trip.by_past = charge.valid && restsOnPastCharges(session, boost, capacity);
  const double width = crank.u_min ? crank.u_min->upper - crank.u_min->lower : -1.0;
  std::printf("%s,%s,valid,%.2f,%d,%d,%d,%.4f,%d\n", trip.name.c_str(), basis, time - trip.begin,
              crank.valid, stop.valid, charge.valid, width, trip.by_past);
}

/// The samples of a trip that begins at a moment, with the temperatures.
std::vector<RawSample> samplesOf(const Trip& trip, const Series& series) {
  std::vector<RawSample> samples = samplesOf(series);
  std::size_t next_temperature = 0;
  for (RawSample& sample : samples) {
    while (next_temperature < series.temperature.size() &&
           series.temperature_time[next_temperature] <= sample.time)
      sample.temperature = series.temperature[next_temperature++];
    sample.time = trip.begin + sample.time - series.time.front();
  }
  return samples;
}

/// Plays a trip. @return the model at its end.
std::optional<FittedModel> playTrip(Trip trip, const Series& series,
                                    const std::optional<FittedModel>& before,
                                    const ExperimentOptions& o) {
  SessionOptions options = o.session;
  options.capacity = o.capacity;
  OnlineSession session(options);
  if (before) session.restore(*before);
  double asked = -HUGE_VAL;
  AnswerBasis basis_before = AnswerBasis::kPopulation;
  const std::vector<RawSample> samples = samplesOf(trip, series);
  play(samples, session, [&](std::size_t n, const SessionEvents& events) {
    const double time = samples[n].time;
    const bool asks = time - asked >= 5.0;
    if (!asks && events.cranks.empty() && events.charges.empty()) return;
    const AnswerBasis basis = session.status().basis;
    const std::string name = toString(basis);
    if (basis_before == AnswerBasis::kPreviousTrip && basis == AnswerBasis::kPopulation)
      std::printf("%s,%s,swap,%.2f,0,0,0,0,0\n", trip.name.c_str(), name.c_str(),
                  time - trip.begin);
    basis_before = basis;
    print(trip, events, name.c_str());
    if (!asks) return;
    ask(trip, session, time, name.c_str(), o.capacity);
    asked = time;
  });
  return session.model();
}

}  // namespace

void playTrips(const std::vector<Recording>& recordings, const ExperimentOptions& o) {
  std::optional<FittedModel> model;
  double begin = 0.0;
  for (const Recording& recording : recordings) {
    const Series& series = recording.series;
    model = playTrip({recording.name, begin}, series, model, o);
    begin += series.time.back() - series.time.front() + o.parked;
  }
}

}  // namespace battery_sof

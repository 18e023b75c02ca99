#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "battery_sof/csv.hpp"
#include "column_options.hpp"
#include "prediction/online_session.hpp"

namespace {

using namespace battery_sof;

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

/// Plays a trip that begins at a moment. @return the model at its end.
std::optional<FittedModel> play(Trip trip, const Series& series,
                                const std::optional<FittedModel>& before, double capacity) {
  std::size_t next_temperature = 0;
  SessionOptions options;
  options.capacity = capacity;
  OnlineSession session(options);
  if (before) session.restore(*before);
  double asked = -HUGE_VAL;
  AnswerBasis basis_before = AnswerBasis::kPopulation;
  for (std::size_t n = 0; n < series.size(); ++n) {
    const double time = trip.begin + series.time[n] - series.time.front();
    std::optional<double> temperature;
    while (next_temperature < series.temperature.size() &&
           series.temperature_time[next_temperature] <= series.time[n])
      temperature = series.temperature[next_temperature++];
    const SessionEvents events =
        session.push({time, series.current[n], series.voltage[n], temperature});
    const bool asks = time - asked >= 5.0;
    if (asks || !events.cranks.empty() || !events.charges.empty()) {
      const AnswerBasis basis = session.status().basis;
      const std::string name = toString(basis);
      if (basis_before == AnswerBasis::kPreviousTrip && basis == AnswerBasis::kPopulation)
        std::printf("%s,%s,swap,%.2f,0,0,0,0,0\n", trip.name.c_str(), name.c_str(),
                    time - trip.begin);
      basis_before = basis;
      print(trip, events, name.c_str());
      if (asks) ask(trip, session, time, name.c_str(), capacity);
      if (asks) asked = time;
    }
    if (auto job = session.takeDueJob()) session.finish(runIdentification(*job));
  }
  return session.model();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Plays trips of one battery one after the other, the state file of each given to the next, "
      "and prints what was expected and which answers were valid.");
  std::vector<std::string> recordings;
  double parked = 43200.0, capacity = 50.0;
  CsvColumns columns;
  app.add_option("REC", recordings, "CSV recordings, in order")->required();
  app.add_option("--parked", parked, "[s] between trips");
  app.add_option("--capacity", capacity, "[Ah]");
  addColumnOptions(app, columns);
  CLI11_PARSE(app, argc, argv);
  std::puts("trip,basis,kind,time_s,measured,expected,lower,upper,by_past");
  std::optional<FittedModel> model;
  double begin = 0.0;
  for (const auto& path : recordings) {
    const Recording recording = readCsv(path, columns);
    const Series& series = recording.series;
    model = play({recording.name, begin}, series, model, capacity);
    begin += series.time.back() - series.time.front() + parked;
  }
  return 0;
}

// Identifies a window of a recording and asks whether a crank after a stop would succeed: ask REC.csv FROM_S TO_S
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "estimation/recording_fit.hpp"
#include "prediction/cranking.hpp"
#include "battery_sof/csv.hpp"
#include "recording/resample.hpp"

int ask(const char* file, double from, double to) {
  const battery_sof::Recording recording = battery_sof::readCsv(file);
  const battery_sof::Series series = battery_sof::atDesignRate(recording.series);
  battery_sof::FitRequest request;
  request.from = from;
  request.to = to;
  request.options.chooses_effects = true;
  battery_sof::FittedModel model = fitPlanned(series, planFit(series, request));
  if (!isUsable(model.fit)) {
    std::fprintf(stderr, "no model: %s\n", model.fit.message.c_str());
    return 1;
  }
  carryToEnd(model, series, request);

  battery_sof::CrankingQuery query;
  query.i_load = -15.0;       // [A], negative: out of the battery
  query.t_stop = 60.0;        // [s]
  query.i_cranking = -250.0;  // [A]
  query.u_required = 7.2;     // [V]
  const battery_sof::CrankingAnswer answer = predictCranking(model, query);
  if (!answer.u_min) {
    std::fprintf(stderr, "%s\n", answer.message.c_str());
    return 1;
  }
  std::printf("u_min %.6f V, 90 %% between %.6f and %.6f V, capable %d\n", answer.u_min->value, answer.u_min->lower, answer.u_min->upper,
              answer.capable.value_or(false) ? 1 : 0);
  return 0;
}

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: ask REC.csv FROM_S TO_S\n");
    return 2;
  }
  try {
    return ask(argv[1], std::atof(argv[2]), std::atof(argv[3]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ask: %s\n", error.what());
    return 2;
  }
}

// Identifies a window of a recording and asks whether a crank after a stop would succeed: ask
// REC.csv FROM_S TO_S
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "battery_sof/csv.hpp"
#include "battery_sof/model.hpp"

int ask(const char* file, double from, double to) {
  battery_sof::IdentifyRequest request;
  request.from = from;
  request.to = to;
  const battery_sof::Model model = identify(battery_sof::readCsv(file), request);
  if (!model.usable()) {
    std::fprintf(stderr, "no model: %s\n", model.message().c_str());
    return 1;
  }
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
  std::printf("u_min %.6f V, 90 %% between %.6f and %.6f V, capable %d\n", answer.u_min->value,
              answer.u_min->lower, answer.u_min->upper, answer.capable.value_or(false) ? 1 : 0);
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

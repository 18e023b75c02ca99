// Times the questions on saved models: [ms] of one answer, without node and network. Usage:
// query_bench MODEL.yaml ...

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "prediction/questions.hpp"
#include "report/model_yaml.hpp"
#include "stopwatch.hpp"

namespace {

using namespace battery_sof;

constexpr int kRepetitions = 101;

struct Question {
  std::string name;
  std::function<std::string(const FittedModel&)> ask;
};

StopTimeQuery stop(double i_load, double u_required) {
  StopTimeQuery query;
  query.i_load = i_load;
  query.i_cranking = -200.0;
  query.u_required = u_required;
  return query;
}

std::vector<Question> questions() {
  std::vector<Question> all;
  all.push_back({"crank after 30 s", [](const FittedModel& model) {
                   return predictCranking(model, {-20.0, 30.0, -200.0, 1.0, 7.2}).message;
                 }});
  all.push_back({"crank after an hour", [](const FittedModel& model) {
                   return predictCranking(model, {-20.0, 3600.0, -200.0, 1.0, 7.2}).message;
                 }});
  for (const double u : {7.2, 9.5, 10.8})
    all.push_back(
        {"stop time for " + std::to_string(u).substr(0, 4) + " V",
         [u](const FittedModel& model) { return predictStopTime(model, stop(-20.0, u)).message; }});
  for (const double t : {1.0, 10.0, 60.0})
    all.push_back({"charge over " + std::to_string(static_cast<int>(t)) + " s",
                   [t](const FittedModel& model) {
                     return predictChargeAcceptance(model, {14.2, t, 5000.0}).message;
                   }});
  all.push_back({"charge limited to 60 A", [](const FittedModel& model) {
                   return predictChargeAcceptance(model, {14.2, 10.0, 60.0}).message;
                 }});
  return all;
}

void time(const char* path) {
  const FittedModel model = readModelFile(path);
  std::string effects;
  for (const std::string& effect : model.fit.effects) effects += " + " + effect;
  std::printf("base%s\n", effects.c_str());
  for (const Question& question : questions()) {
    std::vector<double> times;
    std::string message;
    while (times.size() < kRepetitions && (times.size() < 5 || times.back() < 50.0))
      times.push_back(battery_sof_bench::wallMilliseconds([&] { message = question.ask(model); }));
    std::sort(times.begin(), times.end());
    std::printf("    %-22s median %8.3f ms, largest %8.3f ms: %s\n", question.name.c_str(),
                times[times.size() / 2], times.back(), message.c_str());
  }
}

}  // namespace

int main(int argc, char** argv) {
  for (int k = 1; k < argc; ++k) time(argv[k]);
  return argc > 1 ? 0 : 2;
}

// The live tracker with base + four effects beside an identification in another thread, and the
// starts of a search on two threads against one.
#include <algorithm>
#include <atomic>
#include <ctime>
#include <thread>
#include <vector>

#include "composed_record.hpp"
#include "estimation/composition_fit.hpp"
#include "estimation/identification.hpp"
#include "program.hpp"
#include "state/state_tracker.hpp"
#include "stopwatch.hpp"

namespace {

using namespace battery_sof;
using namespace battery_sof_bench;

constexpr double kWindow = 240.0;     // [s], fitted
constexpr double kMonitored = 900.0;  // [s], followed
constexpr double kMaxGap = 0.1;       // [s]

IdentifyOptions fourEffects() {
  IdentifyOptions options;
  options.effects = {"charge_acceptance", "acid_transport", "current_dependent_resistance",
                     "ocv_soc"};
  return options;
}

/// Processor time of the calling thread [s].
double threadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Samples a second of one thread's processor time, and on the wall.
struct Pace {
  double processor, wall;
  double last_voltage;
};

Pace track(const FittedModel& model, const Series& series) {
  StateTracker tracker(model, kMaxGap);
  const double begin = threadSeconds();
  const double wall = wallMilliseconds([&] {
    for (std::size_t n = 0; n < series.size(); ++n)
      if (series.time[n] > model.state.time)
        tracker.follow(series.time[n], series.current[n], series.voltage[n]);
  });
  const double samples = static_cast<double>(series.size()) - kWindow * 100.0;
  return {samples / (threadSeconds() - begin), samples / (1e-3 * wall), tracker.last()->voltage};
}

nlohmann::json monitor() {
  const BatteryModel composition = composedModel();
  const Series series =
      composedRecord(composition, composedTruth(composition), kWindow + kMonitored);
  const IndexRange window{0, static_cast<std::size_t>(kWindow * 100.0)};
  const FittedModel model = identify(series, window, fourEffects());
  const Pace alone = track(model, series);
  std::atomic<bool> stop{false};
  std::atomic<int> identifications{0};
  std::thread identifying([&] {
    while (!stop) {
      identify(series, window, fourEffects());
      ++identifications;
    }
  });
  // Long enough that several identifications end meanwhile.
  Pace beside{};
  int runs = 0;
  for (; identifications < 2 || runs < 3; ++runs) beside = track(model, series);
  stop = true;
  identifying.join();
  return {{"lanes", uncertainSimulationOf(model).tangents()},
          {"alone_processor", alone.processor},
          {"beside_processor", beside.processor},
          {"beside_wall", beside.wall},
          {"identifications", identifications.load()},
          {"same", alone.last_voltage == beside.last_voltage}};
}

constexpr int kStarts = 6;

CompositionFit searched(const CompositionProblem& problem, const CompositionPoint& start,
                        int threads, int starts = kStarts) {
  CompositionSearch search;
  search.more_starts = starts - 1;
  search.threads = threads;
  return fitComposition(problem, {start}, search);
}

/// @return what two threads gain at best when each start takes its own processor time: the next
/// free thread takes the
///   next start.
double gainOfTheStarts(const CompositionProblem& problem, const CompositionPoint& start) {
  double until_now = 0.0, busy[2] = {0.0, 0.0};
  for (int k = 1; k <= kStarts; ++k) {
    const double all_so_far = processorMilliseconds([&] { searched(problem, start, 1, k); });
    *std::min_element(busy, busy + 2) += std::max(0.0, all_so_far - until_now);
    until_now = all_so_far;
  }
  return until_now / std::max(busy[0], busy[1]);
}

/// Work that shares nothing: what a second thread can gain on this machine at this moment.
void count() {
  volatile double x = 1.0;
  for (int k = 0; k < 100000000; ++k) x = x * 1.0000001;
}

/// @return how much less wall time two threads need for two such loops than one thread does.
double gainOfTwoThreads() {
  const double one = wallMilliseconds([] {
    count();
    count();
  });
  const double two = wallMilliseconds([] {
    std::thread other(count);
    count();
    other.join();
  });
  return one / two;
}

nlohmann::json threaded(int rounds) {
  const BatteryModel model = composedModel();
  const Series series = composedRecord(model, composedTruth(model), 1800.0);
  const InputSequence inputs = compressedInputs(series, all(series));
  const CompositionPoint start = typicalStart(model, inputs);
  const CompositionProblem problem(model, inputs, {}, start);
  std::vector<double> one, two, possible;
  CompositionFit by_one, by_two;
  for (int k = 0; k < rounds; ++k) {
    one.push_back(wallMilliseconds([&] { by_one = searched(problem, start, 1); }));
    two.push_back(wallMilliseconds([&] { by_two = searched(problem, start, 2); }));
    possible.push_back(gainOfTwoThreads());
  }
  return {{"one_ms", one},
          {"two_ms", two},
          {"possible", possible},
          {"starts", gainOfTheStarts(problem, start)},
          {"cores", std::thread::hardware_concurrency()},
          {"same", by_one.x == by_two.x && by_one.best_start == by_two.best_start}};
}

}  // namespace

int main(int argc, char** argv) {
  return runBenchmark<int>(argc, argv, "composed_live ROUNDS", [](int rounds) {
    std::cout << nlohmann::json{{"tracker", monitor()}, {"threads", threaded(rounds)}} << "\n";
  });
}

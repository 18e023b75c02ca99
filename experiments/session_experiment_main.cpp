#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <numeric>

#include "battery_sof/csv.hpp"
#include "column_options.hpp"
#include "diagnosis/diagnose.hpp"
#include "prediction/event_corrections.hpp"
#include "prediction/online_session.hpp"
#include "util/text.hpp"

namespace {

using namespace battery_sof;

bool verbose = false;

void print(const std::string& recording, const SessionEvents& events,
           const OnlineSession& session) {
  for (const EventComparison& c : events.cranks)
    std::printf("%s,crank,%.2f,%.2f,%.4f,%.4f,%.4f,%.4f,%.4f\n", recording.c_str(), c.time,
                c.current, c.measured, c.expected.value, c.expected.lower, c.expected.upper,
                session.calibrations().crank_calibration.factor);
  for (const EventComparison& c : events.charges)
    std::printf("%s,charge,%.2f,%.3f,%.4f,%.4f,%.4f,%.4f,%.4f\n", recording.c_str(), c.time,
                c.voltage, c.measured, c.expected.value, c.expected.lower, c.expected.upper,
                session.calibrations().charge_calibration.factor);
}

/// Diagnoses what is buffered and has the extended composition fitted whatever its verdict; the node
/// fits named physics and what was estimated.
void adoptDiagnosis(OnlineSession& session) {
  Recording buffered;
  buffered.series = session.series();
  buffered.offered = buffered.series.size();
  DiagnoseOptions options;
  options.lists_detection_limits = false;
  const Diagnosis found = diagnose(buffered, options);
  std::fprintf(stderr, "%.0f s: %s\n", *session.newestTime(), found.summary.c_str());
  if (!found.extended.fit.effects.empty())
    session.fitWith(found.extended.fit.effects, 0.0, found.extended.fit.discrepancy);
}

/// The node's standing questions with their default parameters, asked once a second of driving as
/// ~status does.
class StandingAnswers {
 public:
  void askOf(const OnlineSession& session) {
    if (!session.newestTime() || std::floor(*session.newestTime()) <= asked_at_) return;
    asked_at_ = std::floor(*session.newestTime());
    const ModelSnapshot model = session.live();
    const double u_boost = session.chargeVoltage().value_or(14.2);
    count(0, model.predictCranking({-20.0, 30.0, -200.0, 1.0, 7.2}));
    count(1, model.predictStopTime({-20.0, -200.0, 1.0, 7.2}));
    count(2, model.predictChargeAcceptance({u_boost, 10.0, 5000.0}));
  }
  void print(const std::string& recording) const {
    for (int k = 0; k < 3; ++k) {
      std::printf("%s,%s,%d asked,%d answered,%d valid\n", recording.c_str(), kNames[k], asked_[k],
                  answered_[k], valid_[k]);
      for (const auto& [reason, times] : reasons_[k])
        std::printf("%s,%s,%d times: %s\n", recording.c_str(), kNames[k], times, reason.c_str());
    }
  }

 private:
  template <typename Answer>
  void count(int k, const Answer& answer) {
    ++asked_[k];
    if (answer.code == AnswerCode::kNoModel) return;
    ++answered_[k];
    valid_[k] += answer.valid;
    if (!answer.valid) ++reasons_[k][withoutNumbersIn(answer.message)];
  }
  /// What speaks against an answer, alike for alike answers.
  static std::string withoutNumbersIn(const std::string& message) {
    const std::size_t at = message.find("outside the identified range: ");
    std::string text;
    for (const char c : at == std::string::npos ? message : message.substr(at)) {
      const bool is_digit = std::strchr("0123456789.", c) != nullptr;
      if (!is_digit || text.empty() || text.back() != '#') text += is_digit ? '#' : c;
    }
    return text;
  }

  static constexpr const char* kNames[] = {"crank", "stop_time", "charge"};
  double asked_at_ = -HUGE_VAL;  // [s]
  int asked_[3] = {}, answered_[3] = {}, valid_[3] = {};
  std::map<std::string, int> reasons_[3];
};

/// Plays a recording through a session; identifications and diagnosis end before the next sample.
void play(const std::string& path, const CsvColumns& columns, const SessionOptions& options,
          double diagnose_at, bool asks) {
  const Recording recording = readCsv(path, columns);
  OnlineSession session(options);
  bool is_diagnosed = diagnose_at <= 0.0;
  StandingAnswers answers;
  for (std::size_t n = 0; n < recording.series.size(); ++n) {
    const SessionEvents events =
        session.push({recording.series.time[n], recording.series.current[n],
                      recording.series.voltage[n], std::nullopt});
    if (asks)
      answers.askOf(session);
    else
      print(recording.name, events, session);
    if (!is_diagnosed && session.driving() >= diagnose_at) {
      is_diagnosed = true;
      adoptDiagnosis(session);
    }
    if (auto job = session.takeDueJob()) {
      const IdentificationOutcome outcome = session.finish(runIdentification(*job));
      if (!is_diagnosed || diagnose_at <= 0.0) continue;
      std::fprintf(stderr, "%.0f s: %s%s; effects: %s\n", *session.newestTime(),
                   outcome.accepted ? "" : "refused: ", outcome.message.c_str(),
                   join(session.status().effects).c_str());
    }
  }
  if (asks) answers.print(recording.name);
}

/// Plays a recording and asks every few seconds, while the battery alone carries a load, for exactly
/// that load: the answer is held against the voltage measured at that moment, and against the one
/// measured a minute later where the load is still the same (to a tenth).
void askPresent(const std::string& path, const CsvColumns& columns, const SessionOptions& options,
                double every) {
  constexpr double kLeastLoad = -0.05, kLater = 60.0, kInstant = 0.05;  // [A], [s], [s]
  const Recording recording = readCsv(path, columns);
  const Series& series = recording.series;
  OnlineSession session(options);
  int asked = 0, valid = 0, now = 0, after = 0, later = 0, later_valid = 0, capable = 0;
  std::vector<double> widths;
  double asked_at = -HUGE_VAL;
  for (std::size_t n = 0; n < series.size(); ++n) {
    const double time = series.time[n], current = series.current[n], u = series.voltage[n];
    session.push({time, current, u, std::nullopt});
    if (auto job = session.takeDueJob()) session.finish(runIdentification(*job));
    if (time - asked_at < every) continue;
    asked_at = time;
    if (current > kLeastLoad || session.status().voltage_controlled) continue;
    ++asked;
    const ModelSnapshot model = session.live();
    const auto holds = [](const CrankingAnswer& answer, double voltage) {
      return answer.u_min->lower <= voltage && voltage <= answer.u_min->upper;
    };
    const CrankingAnswer one = model.predictCranking({current, 0.0, current, kInstant, 10.5});
    if (one.u_min && verbose)
      std::printf("%s,%.1f,%.2f,%.3f,%.3f,%.3f,%.3f,%d,%s\n", recording.name.c_str(), time, current,
                  u, one.u_min->value, one.u_min->lower, one.u_min->upper, one.valid,
                  one.valid ? "" : one.message.c_str());
    if (one.valid) {
      ++valid;
      now += holds(one, u);
      capable += one.capable.value_or(false) && u < 10.5;
      widths.push_back(one.u_min->upper - one.u_min->lower);
    }
    const CrankingAnswer minute = model.predictCranking({current, kLater, current, 1.0, {}});
    if (!minute.valid) continue;
    after += holds(minute, u);
    std::size_t k = n;
    bool is_alike = true;
    while (k + 1 < series.size() && series.time[k] < time + kLater) {
      ++k;
      is_alike = is_alike && std::abs(series.current[k] - current) <= 0.1 * -current;
    }
    if (!is_alike || series.time[k] > 1.5 * kLater + time || series.time[k] < time + kLater)
      continue;
    ++later_valid;
    later += holds(minute, series.voltage[k]);
  }
  const auto percent = [](int part, int all) { return all > 0 ? 100.0 * part / all : NAN; };
  std::printf("%s,%d,%.1f,%.1f,%.3f,%.1f,%d,%.1f,%d\n", recording.name.c_str(), asked,
              percent(valid, asked), percent(now, valid), medianOf(widths), percent(after, valid),
              later_valid, percent(later, later_valid), capable);
}

/// What was expected of one kind of event.
struct Tally {
  std::vector<double> errors, widths;
  double inside = 0.0;

  void add(double measured, const Interval& expected) {
    errors.push_back(std::abs(measured - expected.value));
    widths.push_back(expected.upper - expected.lower);
    inside += expected.lower <= measured && measured <= expected.upper ? 1.0 : 0.0;
  }
  void print() const {
    const double count = static_cast<double>(errors.size());
    std::printf(",%.0f,%.4f,%.4f,%.1f,%.3f", count,
                std::accumulate(errors.begin(), errors.end(), 0.0) / count, medianOf(errors),
                100.0 * inside / count, medianOf(widths));
  }
};

/// Plays a recording with each step of an answer left out in turn.
void leaveOutSteps(const std::string& path, const CsvColumns& columns, SessionOptions options) {
  const Recording recording = readCsv(path, columns);
  const std::pair<const char*, bool AnswerSteps::*> steps[] = {
      {"nothing", nullptr},
      {"residual filter", &AnswerSteps::residual_filter},
      {"event history", &AnswerSteps::event_history},
      {"interval calibration", &AnswerSteps::calibration}};
  const auto row = [&](const char* left_out, const Tally& cranks, const Tally& charges) {
    std::printf("%s,%s", recording.name.c_str(), left_out);
    cranks.print();
    charges.print();
    std::puts("");
  };
  for (const auto& [name, step] : steps) {
    options.steps = {};
    if (step) options.steps.*step = false;
    OnlineSession session(options);
    Tally cranks, charges;
    for (std::size_t n = 0; n < recording.series.size(); ++n) {
      const SessionEvents events =
          session.push({recording.series.time[n], recording.series.current[n],
                        recording.series.voltage[n], std::nullopt});
      for (const EventComparison& crank : events.cranks) {
        cranks.add(crank.measured, crank.expected);
      }
      for (const EventComparison& charge : events.charges) {
        charges.add(charge.measured, charge.expected);
      }
      if (auto job = session.takeDueJob()) session.finish(runIdentification(*job));
    }
    row(name, cranks, charges);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Plays recordings (CSV) through a session and prints every crank and charge with what was "
      "expected.");
  std::vector<std::string> recordings;
  double diagnose_at = 0.0;
  SessionOptions options;
  CsvColumns columns;
  app.add_option("REC", recordings, "CSV recordings")->required();
  app.add_option("--effects", options.identify.effects, "ids of further physics")->delimiter(',');
  app.add_option(
      "--diagnose-at", diagnose_at,
      "[s] of driving, when the buffer is diagnosed and what is found is fitted to the next "
      "windows; 0: never");
  app.add_option("--identify-period", options.identify_period, "[s]");
  bool asks = false;
  app.add_flag("--questions", asks,
               "asks the standing questions of ~status each second instead, and prints how many "
               "answers were valid");
  double present = 0.0;
  app.add_option(
      "--present", present,
      "[s], how often the present load is asked for instead; prints answers, share valid "
      "[%], of these the share that holds the present voltage and the median width [V], "
      "the same a minute ahead against the present voltage and against that of then, and "
      "valid answers that hold 10.5 V where less is measured");
  app.add_flag("--verbose", verbose, "with --present: every answer");
  bool leaves_out = false;
  app.add_flag("--steps", leaves_out,
               "leaves out each step of an answer in turn and prints what cranks and charges then "
               "miss: count, mean and median error, share inside [%], median width");
  addColumnOptions(app, columns);
  CLI11_PARSE(app, argc, argv);
  if (leaves_out)
    std::puts(
        "recording,left_out,cranks,mean_v,median_v,inside,width_v,charges,mean_a,median_a,inside,"
        "width_a");
  else if (present > 0.0)
    std::puts(
        "recording,asked,valid,holds_now,width_v,minute_holds_now,minutes,holds_then,capable_low");
  else if (!asks)
    std::puts("recording,kind,time_s,current_a_or_voltage_v,measured,expected,lower,upper,scale");
  try {
    for (const auto& path : recordings)
      present > 0.0 ? askPresent(path, columns, options, present)
      : leaves_out  ? leaveOutSteps(path, columns, options)
                    : play(path, columns, options, diagnose_at, asks);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "session_experiment: %s\n", error.what());
    return 2;
  }
  return 0;
}

#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>

#include "experiment.hpp"

namespace battery_sof {
namespace {

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

bool holds(const CrankingAnswer& answer, double voltage) {
  return answer.u_min->lower <= voltage && voltage <= answer.u_min->upper;
}

/// The sample a while after one if the load is still the same then, to a tenth.
std::optional<std::size_t> alikeLater(const Series& series, std::size_t n, double later) {
  const double end = series.time[n] + later, current = series.current[n];
  std::size_t k = n;
  while (k + 1 < series.size() && series.time[k] < end)
    if (std::abs(series.current[++k] - current) > 0.1 * -current) return std::nullopt;
  if (series.time[k] > end + 0.5 * later || series.time[k] < end) return std::nullopt;
  return k;
}

}  // namespace

void askStanding(const Recording& recording, const ExperimentOptions& o) {
  OnlineSession session(o.session);
  StandingAnswers answers;
  play(samplesOf(recording.series), session,
       [&](std::size_t, const SessionEvents&) { answers.askOf(session); });
  answers.print(recording.name);
}

/// Asks every `period` while the battery alone carries a load, for exactly
/// that load: the answer is held against the voltage measured at that moment, and against the one
/// measured a minute later where the load is still the same (to a tenth).
void askPresent(const Recording& recording, const ExperimentOptions& o) {
  constexpr double kLeastLoad = -0.05, kLater = 60.0, kInstant = 0.05;  // [A], [s], [s]
  const Series& series = recording.series;
  OnlineSession session(o.session);
  int asked = 0, valid = 0, now = 0, after = 0, later = 0, later_valid = 0, capable = 0;
  std::vector<double> widths;
  double asked_at = -HUGE_VAL;
  play(samplesOf(series), session, [&](std::size_t n, const SessionEvents&) {
    const double time = series.time[n], current = series.current[n], u = series.voltage[n];
    fitDue(session);
    if (time - asked_at < o.period) return;
    asked_at = time;
    if (current > kLeastLoad || session.status().voltage_controlled) return;
    ++asked;
    const ModelSnapshot model = session.live();
    const CrankingAnswer one = model.predictCranking({current, 0.0, current, kInstant, 10.5});
    if (one.u_min && o.verbose)
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
    if (!minute.valid) return;
    after += holds(minute, u);
    const std::optional<std::size_t> then = alikeLater(series, n, kLater);
    if (!then) return;
    ++later_valid;
    later += holds(minute, series.voltage[*then]);
  });
  const auto percent = [](int part, int all) { return all > 0 ? 100.0 * part / all : NAN; };
  std::printf("%s,%d,%.1f,%.1f,%.3f,%.1f,%d,%.1f,%d\n", recording.name.c_str(), asked,
              percent(valid, asked), percent(now, valid), medianOf(widths), percent(after, valid),
              later_valid, percent(later, later_valid), capable);
}

}  // namespace battery_sof

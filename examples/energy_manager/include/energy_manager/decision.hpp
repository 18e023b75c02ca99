#pragma once

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <optional>
#include <string>

namespace energy_manager {

/// What the car needs, and how careful to be.
struct Rule {
  /// [V], lowest voltage at which the starter and the car's computers still work
  double u_required = 7.2;
  /// [V], by which the lower bound of a crank has to lie above u_required
  double margin = 0.2;
  /// [s], from the wish to start the engine to the crank, and the shortest stop that is worth it
  double look_ahead = 3.0;
  /// [A], <= 0: consumers while the engine is off, before a stop was seen
  double i_load = -20.0;
  /// [A], < 0: the weakest crank to plan for; a stronger one that was seen counts instead
  double i_cranking = -200.0;
  double t_cranking = 0.5;  ///< [s]
  double u_boost = 14.2;    ///< [V], held by the generator while braking
  double i_limit = 150.0;   ///< [A], what the generator gives
  double t_boost = 10.0;    ///< [s], a braking
};

/// One answer of battery_sof: the lower end of its interval, and whether it is valid.
struct Answer {
  bool valid = false;
  double lower = std::numeric_limits<double>::quiet_NaN();
  std::string message;
};

/// The three answers that belong together.
struct Answers {
  Answer crank;      ///< [V], after look_ahead
  Answer stop_time;  ///< [s]
  Answer charge;     ///< [A], mean over t_boost
};

/// See Decision.msg.
struct Verdict {
  bool may_stop = false;
  double longest_stop = 0.0;
  double reserve = std::numeric_limits<double>::quiet_NaN();
  double planned_charge = 0.0;
  std::string reason;
};

/**
 * @brief Decides whether the engine may be off: a crank after look_ahead has to keep u_required
 * with a margin, and the answer that says so has to be valid.
 *
 *     may_stop = valid  and  lower >= u_required + margin  and  longest stop >= look_ahead
 *
 * The rule is applied again and again during a stop, so it also decides when to start the engine:
 * while there is still time for look_ahead. The engine runs if an answer is missing, late or not
 * valid. Braking plans with the lower bound of the charge.
 *
 * @param answers none if they are missing or late.  @param why the reason, if so.
 */
inline Verdict decide(const Rule& rule, const std::optional<Answers>& answers,
                      const std::string& why) {
  Verdict verdict;
  verdict.reason = why;
  if (!answers) return verdict;
  const Answer &crank = answers->crank, &stop = answers->stop_time, &charge = answers->charge;
  if (charge.valid && charge.lower > 0.0)
    verdict.planned_charge = std::min(charge.lower, rule.i_limit);
  verdict.reserve = crank.lower - rule.u_required;
  if (!crank.valid) {
    verdict.reason = "the engine runs: " + crank.message;
  } else if (!(verdict.reserve >= rule.margin)) {
    verdict.reason = "the engine runs: a crank might not keep the required voltage";
  } else if (!stop.valid || !(stop.lower >= rule.look_ahead)) {
    verdict.reason =
        "the engine runs: " +
        (stop.valid ? std::string("the stop would be too short to be worth it") : stop.message);
  } else {
    verdict.may_stop = true;
    verdict.longest_stop = stop.lower;
    verdict.reason = "a crank keeps the required voltage";
  }
  return verdict;
}

/// What stops and cranks of this car are like: the heaviest of the last ten count.
class Habits {
 public:
  explicit Habits(const Rule& rule) : rule_(rule) {}

  /// A sample while the engine is off. @param current [A]; charging counts as none.
  void addStanding(double current) {
    sum_ += std::min(current, 0.0);
    ++count_;
  }
  /// The engine runs again.
  void endStop() {
    if (count_ > 0) keep(loads_, sum_ / count_);
    sum_ = count_ = 0.0;
  }
  /// @param current [A], < 0, of largest magnitude in a crank.
  void addCrank(double current) { keep(cranks_, current); }

  /// [A], expected while the engine is off: this stop's own mean once it has begun.
  double load() const { return count_ > 0 ? sum_ / count_ : heaviest(loads_, rule_.i_load); }
  /// [A], expected of the next crank.
  double cranking() const {
    return std::min(heaviest(cranks_, rule_.i_cranking), rule_.i_cranking);
  }

 private:
  static void keep(std::deque<double>& list, double value) {
    list.push_back(value);
    if (list.size() > 10) list.pop_front();
  }
  static double heaviest(const std::deque<double>& list, double without) {
    return list.empty() ? without : *std::min_element(list.begin(), list.end());
  }

  Rule rule_;
  std::deque<double> loads_, cranks_;
  double sum_ = 0.0, count_ = 0.0;
};

}  // namespace energy_manager

#pragma once

#include <cstddef>
#include <vector>

namespace battery_sof {

/**
 * @brief Where the implicit Euler steps of one hold ended, for the next trial of the same hold
 * under another current.
 *
 * Trials of a hold make the same steps from the same state; only the current differs, and by
 * little. Each root is then known from the last trial's and its slope to the current: to second
 * order in the change.
 */
class StepTrail {
 public:
  /// One step's root under one current.
  struct Root {
    double length = 0.0, current = 0.0;        ///< of the step [s], held [A]
    double u = 0.0, to_current = 0.0;          ///< [V], du / di of the whole trial up to here [Ohm]
    double slope = 0.0, activity_slope = 0.0;  ///< of the balance at u [A/V], of the activity [1/V]
  };
  void clear() {
    roots_.clear();
    begin();
  }
  /// At the beginning of a trial.
  void begin() {
    next_ = 0;
    follows_ = true;
  }
  /// @return the last trial's root of the step that comes; none once a trial has gone another way.
  const Root* hint(double length) {
    follows_ = follows_ && next_ < roots_.size() && roots_[next_].length == length;
    return follows_ ? &roots_[next_] : nullptr;
  }
  /// The step's root in this trial.
  void leave(const Root& root) {
    if (!follows_) roots_.resize(next_);
    if (next_ < roots_.size())
      roots_[next_] = root;
    else
      roots_.push_back(root);
    ++next_;
  }
  /// Goes on to the next step and leaves what is known of this one.
  void skip() { ++next_; }

 private:
  std::vector<Root> roots_;
  std::size_t next_ = 0;
  bool follows_ = true;
};

}  // namespace battery_sof

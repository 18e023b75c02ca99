#pragma once

#include <cmath>
#include <string>

#include "simulator/case_draft.hpp"

namespace battery_sof_reference {

/**
 * @brief Draws what makes up one addition, times a scale, sets it in a scenario and writes it down.
 *
 * The scale acts on the addition's gamma, the measure that is 0 when the addition is gone. What is
 * drawn does not depend on it, so that one seed gives the same addition at every strength. Keys are
 * those of scenario files; what is written down is after scaling.
 */
class Strength {
 public:
  /// @param scale times which the addition is made, >= 0 and finite.
  Strength(CaseDraft& draft, Dice& dice, double scale)
      : draft_(draft), dice_(dice), scale_(scale) {}

  Scenario& scenario() { return draft_.scenario; }
  double scale() const { return scale_; }
  bool present() const { return scale_ > 0.0; }  ///< whether anything is left of the addition
  double share() { return dice_.share(); }
  double sign() { return dice_.share() < 0.5 ? -1.0 : 1.0; }
  double between(const Range& range) { return dice_.between(range); }
  double logBetween(const Range& range) {
    return range.low * std::pow(range.high / range.low, dice_.share());
  }

  void set(const std::string& key, double& place, double value) {
    place = draft_.strength[key] = value;
  }
  /// What has no part in the scale: times, places.
  void draw(const std::string& key, double& place, const Range& range) {
    set(key, place, between(range));
  }
  void drawLog(const std::string& key, double& place, const Range& range) {
    set(key, place, logBetween(range));
  }
  /// gamma is the value itself. Without the addition the place keeps what it has.
  void drawAmplitude(const std::string& key, double& place, const Range& range) {
    const double value = draft_.strength[key] = scale_ * between(range);
    if (present()) place = value;
  }
  /// gamma is 1 / value, infinite without the addition; the place then keeps what it has.
  void setLimit(const std::string& key, double& place, double value) {
    draft_.strength[key] = value / scale_;
    if (present()) place = value / scale_;
  }
  void drawLimit(const std::string& key, double& place, const Range& range) {
    setLimit(key, place, between(range));
  }
  void drawLogLimit(const std::string& key, double& place, const Range& range) {
    setLimit(key, place, logBetween(range));
  }

  /// Says that an effect is there, whatever the scale.
  void alsoTrue(const std::string& id) { draft_.effects.push_back(id); }

 private:
  CaseDraft& draft_;
  Dice& dice_;
  double scale_;
};

/// A limited main reaction that an addition needs, whatever that one's scale; without it a side
/// reaction does not show and sulphate has nothing to act on.
void addCompanion(Strength& strength, const Range& limit_a, const Range& time_s);

/// A side reaction without its companion.
void addSideReaction(Strength& strength);

/// What addFault() knows: instrument faults and forces outside the catalogue.
bool isFault(const std::string& id);

/// Switches an instrument fault or a force outside the catalogue on. @param id with isFault().
void addFault(Strength& strength, const std::string& id);

}  // namespace battery_sof_reference

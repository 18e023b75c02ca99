#include "simulator/generator/law_scenario.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

namespace battery_sof_simulator {
namespace {

const CrankRanges kCrank{{200.0, 320.0}, {0.3, 0.9}, {110.0, 200.0}};

ProfileOptions cityOf(double, Dice& dice) {
  CityOptions o;
  o.stop_a = {dice.between({5.0, 15.0}), dice.between({20.0, 40.0})};
  o.stop_s = {dice.between({4.0, 10.0}), dice.between({20.0, 60.0})};
  o.cruise_a = {dice.between({1.0, 4.0}), dice.between({8.0, 25.0})};
  o.braking_a = {dice.between({20.0, 45.0}), dice.between({55.0, 100.0})};
  o.braking_share = dice.between({0.5, 1.0});
  o.net_charge_ah = dice.between({-0.4, 0.8});
  return o;
}

ProfileOptions startStopOf(double, Dice& dice) {
  CityOptions o;
  o.stop_a = {dice.between({15.0, 25.0}), dice.between({30.0, 55.0})};
  o.stop_s = {dice.between({10.0, 20.0}), dice.between({30.0, 70.0})};
  o.rounds = {1.0, 2.0};
  o.cruise_a = {dice.between({3.0, 8.0}), dice.between({12.0, 35.0})};
  o.braking_a = {dice.between({30.0, 50.0}), dice.between({70.0, 110.0})};
  o.braking_share = 1.0;
  o.net_charge_ah = dice.between({-0.3, 0.3});
  return o;
}

ProfileOptions turnsOf(double, Dice& dice) {
  AlternatingOptions o;
  o.charge_a = {dice.between({5.0, 15.0}), dice.between({30.0, 60.0})};
  o.discharge_a = {dice.between({5.0, 15.0}), dice.between({40.0, 90.0})};
  o.turn_s = {dice.between({1.5, 4.0}), dice.between({8.0, 25.0})};
  o.rest_share = dice.between({0.05, 0.3});
  o.rest_s = {1.0, dice.between({4.0, 20.0})};
  o.charge_target_ah = dice.between({-0.2, 0.2});
  return o;
}

/// Phases that together keep the charge near where it began.
class Bookkeeper {
 public:
  Bookkeeper(double duration, double room_ah) : left_(duration), room_(room_ah) {}

  bool open() const { return left_ > 0.0; }
  void add(const Phase& phase) {
    charge_ += 0.5 * (phase.begin + phase.end) * phase.duration / kSecondsPerHour;
    left_ -= phase.duration;
    phases_.push_back(phase);
  }
  /// @return 1 to charge, -1 to discharge: by chance, surely towards the start at the room's end.
  double leaning(Dice& dice) const {
    return dice.share() < 0.5 + 0.5 * charge_ / room_ ? -1.0 : 1.0;
  }
  double charge() const { return charge_; }
  double roomAbove() const { return room_ - charge_; }  ///< [Ah]
  ListedPhases phases() const { return {phases_}; }

 private:
  double left_, room_, charge_ = 0.0;
  std::vector<Phase> phases_;
};

/// A test stand's pulses of several sizes and lengths, a rest after most.
ProfileOptions benchOf(double duration, Dice& dice) {
  Bookkeeper book(duration, dice.between({0.4, 1.2}));
  const double largest = dice.between({40.0, 120.0}), longest = dice.between({15.0, 90.0});
  book.add(rest(dice.between({5.0, 30.0})));
  while (book.open()) {
    const double current = std::round(largest * dice.between({0.1, 1.0}));
    book.add(steady(dice.logBetween({1.0, longest}), book.leaning(dice) * current));
    if (dice.share() < 0.7) book.add(rest(dice.logBetween({2.0, 60.0})));
    if (dice.share() < 0.1)
      book.add(steady(dice.between({0.5, 2.0}), -dice.between({120.0, 250.0})));
  }
  return book.phases();
}

/// Long charges that the limit tapers or consumers modulate, and loads that take it out again.
ProfileOptions motorwayOf(double duration, Dice& dice) {
  Bookkeeper book(duration, dice.between({0.5, 1.5}));
  const double strong = dice.between({20.0, 60.0});
  book.add(rest(dice.between({3.0, 15.0})));
  book.add(steady(0.6, -dice.between({150.0, 220.0})));
  while (book.open()) {
    const double begin = dice.between({0.3, 1.0}) * strong;
    const double room = std::max(8.0, book.roomAbove() * kSecondsPerHour / begin);
    book.add(
        {std::min(room, dice.logBetween({15.0, 150.0})), begin, begin * dice.between({0.4, 1.0})});
    book.add(steady(dice.logBetween({8.0, 40.0}) * (book.charge() > 0.0 ? 1.5 : 0.5),
                    -dice.between({10.0, 55.0})));
    if (dice.share() < 0.25) book.add(rest(dice.between({3.0, 30.0})));
  }
  return book.phases();
}

/// Plays phases at shares of the drive that are even but for some chance.
void insertEvenly(Scenario& s, int count, Dice& dice,
                  const std::function<std::vector<Phase>()>& phases) {
  for (int k = 0; k < count; ++k) {
    const double at = s.duration * (k + dice.between({0.2, 0.8})) / count;
    insertAt(s, at, phases());
  }
}

/// How often something of a length [s] comes, all together at most a share of the drive.
int timesIn(const Scenario& s, double length, double share) {
  return std::max(3, static_cast<int>(share * s.duration / length));
}

void exerciseAcceptance(Scenario& s, Dice& dice) {
  insertEvenly(s, timesIn(s, 120.0, 0.4), dice, [&]() -> std::vector<Phase> {
    const double out = dice.between({0.15, 0.5});
    return {swing(-out, dice.between({25.0, 60.0})), rest(dice.between({1.0, 20.0})),
            swing(out * dice.between({0.7, 1.1}), dice.between({25.0, 60.0}))};
  });
}

/// Plateaus of strong charge, what went in taken out again.
void exerciseSideReactions(Scenario& s, Dice& dice) {
  s.voltage_limit = dice.between({14.2, 15.0});
  insertEvenly(s, timesIn(s, 160.0, 0.6), dice, [&]() -> std::vector<Phase> {
    const double length = dice.between({40.0, 110.0}), current = dice.between({15.0, 45.0});
    return {steady(length, current), rest(dice.between({2.0, 20.0})),
            swing(-current * length / kSecondsPerHour * dice.between({0.8, 1.0}),
                  dice.between({40.0, 80.0}))};
  });
}

void exerciseAcid(Scenario& s, Dice& dice) {
  insertEvenly(s, timesIn(s, 130.0, 0.5), dice, [&]() -> std::vector<Phase> {
    std::vector<Phase> phases{
        swing(dice.sign() * dice.between({0.3, 0.7}), dice.between({30.0, 60.0}))};
    if (dice.share() < 0.5)
      phases.push_back(steady(dice.between({10.0, 30.0}), -dice.between({70.0, 120.0})));
    if (dice.share() < 0.5) appendCrank(phases, kCrank, dice);
    phases.push_back(rest(dice.between({30.0, 90.0})));
    return phases;
  });
}

/// Up and down by about an ampere-hour.
void exerciseOpenCircuit(Scenario& s, Dice& dice) {
  double sign = dice.sign();
  insertEvenly(s, timesIn(s, 130.0, 0.6), dice, [&]() -> std::vector<Phase> {
    sign = -sign;
    return {swing(sign * dice.between({0.5, 1.2}), dice.between({35.0, 60.0})),
            rest(dice.between({5.0, 40.0}))};
  });
}

void exerciseStructure(Scenario& s, Dice& dice) {
  insertEvenly(s, timesIn(s, 80.0, 0.3), dice, [&]() -> std::vector<Phase> {
    const double sign = dice.sign();
    return {steady(dice.between({3.0, 20.0}), sign * dice.between({30.0, 90.0})),
            rest(dice.between({5.0, 40.0})),
            steady(dice.between({3.0, 20.0}), -sign * dice.between({30.0, 90.0}))};
  });
}

void exerciseAgeing(Scenario& s, Dice& dice) {
  insertEvenly(s, timesIn(s, 60.0, 0.4), dice, [&]() -> std::vector<Phase> {
    const double current = dice.between({50.0, 120.0}), length = dice.between({5.0, 15.0});
    std::vector<Phase> phases{steady(length, -current), steady(length, 0.8 * current)};
    if (dice.share() < 0.4) appendCrank(phases, kCrank, dice);
    return phases;
  });
}

/// Small currents, rests and steps.
void exerciseInstrument(Scenario& s, Dice& dice) {
  insertEvenly(s, timesIn(s, 60.0, 0.4), dice, [&]() -> std::vector<Phase> {
    return {steady(dice.between({5.0, 30.0}), dice.sign() * dice.logBetween({0.5, 5.0})),
            rest(dice.between({5.0, 30.0})),
            steady(dice.between({2.0, 6.0}), dice.sign() * dice.between({40.0, 90.0}))};
  });
}

void exerciseMechanism(Scenario& s, const std::string& mechanism, Dice& dice) {
  const std::map<std::string, void (*)(Scenario&, Dice&)> needs{
      {"acceptance", exerciseAcceptance},
      {"side_reactions", exerciseSideReactions},
      {"acid", exerciseAcid},
      {"open_circuit", exerciseOpenCircuit},
      {"structure", exerciseStructure},
      {"ageing", exerciseAgeing},
      {"instrument", exerciseInstrument}};
  const auto need = needs.find(mechanism);
  if (need != needs.end()) need->second(s, dice);
}

}  // namespace

void drawLawDrive(Scenario& s, const std::string& kind, const std::string& mechanism, Dice& dice) {
  ProfileOptions (*const profileOf[])(double, Dice&){cityOf, startStopOf, benchOf, motorwayOf,
                                                     turnsOf};
  const auto* const found = std::find(kLawDrives.begin(), kLawDrives.end(), kind);
  if (found == kLawDrives.end()) throw std::invalid_argument("no drive is called \"" + kind + "\"");
  s.voltage_limit = dice.between({13.8, 14.8});
  s.profile = profileOf[found - kLawDrives.begin()](s.duration, dice);
  insertEvenly(s, 2 + static_cast<int>(3.0 * dice.share()), dice, [&] {
    std::vector<Phase> phases{rest(dice.between({15.0, 90.0}))};
    if (kind != "bench" && dice.share() < 0.5) appendCrank(phases, kCrank, dice);
    return phases;
  });
  exerciseMechanism(s, mechanism, dice);
}

}  // namespace battery_sof_simulator

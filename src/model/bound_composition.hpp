#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "effects/effect_definition.hpp"
#include "model/battery_model.hpp"

namespace battery_sof {

/// Which effects a battery is composed of, where their numbers begin, and what their hooks ask of a
/// step. Never changes.
struct BoundComposition {
  struct Member {
    const Effect* effect;
    int parameter, state;  ///< first of its own
    bool adapts = false;   ///< changes the base model's parameters
  };

  explicit BoundComposition(const BatteryModel& composed);

  BatteryModel model;
  /// in the order in which they are applied
  std::vector<Member> members;
  int activity_state = -1, ladder_state = -1;  ///< first ones; -1: none
  /// first factor of a discrepancy model; -1: none
  int discrepancy_parameter = -1;
  bool steps_finely = false, adapts = false, limits_reaction = false;  ///< whether a member does
  double longest_piece = 0.0;                                          ///< [s], see EffectHooks

  /// @return columns of `seeds`, first those that move something which can reach the double layer:
  /// its steps, where the time goes, then carry no others.
  std::vector<int> tangentOrder(const Eigen::Ref<const Eigen::MatrixXd>& seeds) const;
};

}  // namespace battery_sof

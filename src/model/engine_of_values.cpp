#include "engine_choice.hpp"
#include "simulation_engine.hpp"

namespace battery_sof {

std::unique_ptr<Simulation::Engine> engineOfValues(const BatteryModel& model,
                                                   const ModelPoint& start,
                                                   const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  return std::make_unique<EngineOf<double>>(model, start, seeds);
}

}  // namespace battery_sof

#include "engine_choice.hpp"
#include "simulation_engine.hpp"

namespace battery_sof {

std::unique_ptr<Simulation::Engine> engineOf48(const BatteryModel& model, const ModelPoint& start,
                                               const Eigen::Ref<const Eigen::MatrixXd>& seeds) {
  return std::make_unique<EngineOf<Dual<48>>>(model, start, seeds);
}

}  // namespace battery_sof

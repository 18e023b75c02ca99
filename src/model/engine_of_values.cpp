#include "simulation_engine.hpp"

template std::unique_ptr<battery_sof::Simulation::Engine> battery_sof::engineOf<0>(
    const BatteryModel&, const ModelPoint&, const Eigen::Ref<const Eigen::MatrixXd>&);

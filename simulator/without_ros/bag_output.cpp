#include "simulator/recording_output.hpp"

#include <stdexcept>

namespace battery_sof_simulator {

void writeBag(const std::filesystem::path&, const std::vector<RecordedSample>&,
              const std::vector<double>&) {
  throw std::runtime_error(
      "this build has no ROS and writes no bags; expected a name ending in .csv");
}

}  // namespace battery_sof_simulator

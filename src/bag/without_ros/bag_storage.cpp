#include "bag/bag_storage.hpp"

namespace battery_sof {

Recording readBag(const std::filesystem::path& path, const std::string& topic) {
  throw RecordingError(path.string() + ": the topic '" + topic +
                       "' of a bag was to be read, but this build has no ROS "
                       "(BATTERY_SOF_ROS=OFF); expected a CSV file");
}

void writeBag(const std::filesystem::path& path, const Series&, const std::string& topic) {
  throw RecordingError(path.string() + ": a bag with the topic '" + topic +
                       "' was to be written, but this build has no ROS (BATTERY_SOF_ROS=OFF); "
                       "expected a name ending in .csv");
}

}  // namespace battery_sof

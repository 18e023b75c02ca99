#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "estimation/parameter_space.hpp"

namespace battery_sof {

/// Version of the layout, the value of the key `schema` (docs/model-file.md).
inline constexpr char kPriorsSchema[] = "battery_sof/priors/1";

/**
 * @brief PRIORS.yaml: what is known of such batteries beforehand.
 * @param vehicle_type of the battery; populations of all types serve where the file has none of it.
 * @return one population a set of effects.
 * @throws ModelFileError when the file cannot be read, is of another schema, has no entry that
 * serves, or a number is missing or out of its range.
 */
std::vector<KnownPopulation> readPriorsFile(const std::filesystem::path& path,
                                            const std::string& vehicle_type);

/// As readPriorsFile(), from text. @param source name for messages.
std::vector<KnownPopulation> parsePriorsYaml(const std::string& text, const std::string& source,
                                             const std::string& vehicle_type);

}  // namespace battery_sof

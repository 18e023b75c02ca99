#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "state/fitted_model.hpp"

namespace battery_sof {

/// A model file that cannot be used; the message names the file, the field, what was found and what
/// was expected.
class ModelFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Version of the layout, the value of the key `schema`.
inline constexpr char kModelSchema[] = "battery_sof/model/2";
/// That of the JSON of `sof identify`, which is no model file: it has no covariance.
inline constexpr char kIdentificationSchema[] = "battery_sof/model/1";

/// @return MODEL.yaml: parameters with units, standard errors, correlation, state, effects, window,
/// scores, origin.
std::string modelYaml(const FittedModel& model);

/// @param source name for messages. @throws ModelFileError.
FittedModel parseModelYaml(const std::string& text, const std::string& source);

/// Whole or not at all. @throws std::runtime_error when it cannot be written.
void writeModelFile(const std::filesystem::path& path, const FittedModel& model);

/// @throws ModelFileError when it cannot be read or is not a model.
FittedModel readModelFile(const std::filesystem::path& path);

}  // namespace battery_sof

#pragma once

#include <stdexcept>

namespace battery_sof {

/// Thrown if a recording as a whole cannot be used. The message names the file, the place, what was
/// found and what was expected.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace battery_sof

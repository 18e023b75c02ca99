#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <vector>

#include "battery_sof/intake.hpp"
#include "battery_sof/series.hpp"

namespace battery_sof::python {

/// A recording as Python holds it; nothing of it changes once it is made.
struct HeldRecording {
  Recording recording;
  Series fitted;     ///< the series at the rate models are fitted at
  std::string hash;  ///< of the file, "sha256:..."; empty without one
};

using Numbers = pybind11::array_t<double, pybind11::array::c_style | pybind11::array::forcecast>;

/// @return a copy as a numpy array of one dimension.
Numbers numpyOf(const std::vector<double>& values);

/// @param temperature [degC], NaN where it was not measured; none: never.
/// @throws std::invalid_argument for arrays that are not of one dimension or differ in size.
std::vector<RawSample> samplesOf(const Numbers& time, const Numbers& current,
                                 const Numbers& voltage, const std::optional<Numbers>& temperature);

/// Defines Recording, and Model, Diagnosis and the functions on them.
void defineRecording(pybind11::module_& module);
void defineModels(pybind11::module_& module);
/// Defines Session, which needs Model.
void defineSession(pybind11::module_& module);

}  // namespace battery_sof::python

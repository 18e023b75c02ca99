#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <vector>

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

/// Defines Recording, and Model, Diagnosis and the functions on them.
void defineRecording(pybind11::module_& module);
void defineModels(pybind11::module_& module);

}  // namespace battery_sof::python

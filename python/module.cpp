#include "battery_sof/recording/recording_error.hpp"
#include "battery_sof/report/model_yaml.hpp"
#include "battery_sof/report/version.hpp"
#include "bindings.hpp"

namespace battery_sof::python {

namespace py = pybind11;

Numbers numpyOf(const std::vector<double>& values) { return Numbers(static_cast<py::ssize_t>(values.size()), values.data()); }

std::vector<double> vectorOf(const Numbers& numbers, const char* name) {
  if (numbers.ndim() != 1)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(numbers.ndim()) + " dimensions, expected one");
  return {numbers.data(), numbers.data() + numbers.size()};
}

}  // namespace battery_sof::python

PYBIND11_MODULE(_core, module) {
  namespace py = pybind11;
  py::register_exception_translator([](std::exception_ptr pointer) {
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const battery_sof::RecordingError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    } catch (const battery_sof::ModelFileError& error) {
      PyErr_SetString(PyExc_ValueError, error.what());
    }
  });
  module.def("version", &battery_sof::version);
  battery_sof::python::defineRecording(module);
  battery_sof::python::defineModels(module);
}

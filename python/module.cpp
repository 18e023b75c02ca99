#include <stdexcept>

#include "battery_sof/recording_error.hpp"
#include "battery_sof/version.hpp"
#include "bindings.hpp"
#include "report/model_yaml.hpp"
#include "util/text.hpp"

namespace battery_sof::python {

namespace py = pybind11;

namespace {

/// The core's sentence as a Python exception; names of files in it need not be UTF-8, which Python
/// needs.
void raise(PyObject* kind, const std::exception& error) {
  PyErr_SetString(kind, printable(error.what(), LineBreaks::kKept).c_str());
}

void translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const RecordingError& error) {
    raise(PyExc_ValueError, error);
  } catch (const ModelFileError& error) {
    raise(PyExc_ValueError, error);
  } catch (const std::invalid_argument& error) {
    raise(PyExc_ValueError, error);
  } catch (const std::runtime_error& error) {
    raise(PyExc_RuntimeError, error);
  }
}

}  // namespace

Numbers numpyOf(const std::vector<double>& values) {
  return Numbers(static_cast<py::ssize_t>(values.size()), values.data());
}

}  // namespace battery_sof::python

PYBIND11_MODULE(_core, module) {
  pybind11::register_exception_translator(&battery_sof::python::translate);
  module.def("version", &battery_sof::version);
  battery_sof::python::defineRecording(module);
  battery_sof::python::defineModels(module);
  battery_sof::python::defineSession(module);
}

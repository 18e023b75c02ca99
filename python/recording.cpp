#include <stdexcept>

#include "battery_sof/csv.hpp"
#include "battery_sof/sample_list.hpp"
#include "bindings.hpp"
#include "recording/resample.hpp"
#include "util/constants.hpp"

namespace battery_sof::python {

namespace py = pybind11;

namespace {

/// @throws std::invalid_argument naming the argument when it has another number of dimensions than
/// one.
std::vector<double> vectorOf(const Numbers& numbers, const char* name) {
  if (numbers.ndim() != 1)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(numbers.ndim()) +
                                " dimensions, expected one");
  return {numbers.data(), numbers.data() + numbers.size()};
}

void requireLength(const std::vector<double>& values, std::size_t length, const char* name) {
  if (values.size() != length)
    throw std::invalid_argument(std::string(name) + " has " + std::to_string(values.size()) +
                                " values, expected " + std::to_string(length) + " as time_s");
}

HeldRecording held(Recording recording, std::string hash) {
  Series fitted = atDesignRate(recording.series);
  return {std::move(recording), std::move(fitted), std::move(hash)};
}

HeldRecording fromArrays(const Numbers& time, const Numbers& current, const Numbers& voltage,
                         const std::optional<Numbers>& temperature, const std::string& name) {
  const std::vector<RawSample> samples = samplesOf(time, current, voltage, temperature);
  const py::gil_scoped_release released;
  return held(recordingOf(name, samples), "");
}

HeldRecording fromCsv(const std::string& path, const CsvColumns& columns, const std::string& hash) {
  const py::gil_scoped_release released;
  return held(readCsv(path, columns), hash);
}

py::dict rejectedOf(const HeldRecording& held) {
  const RejectedCounts& counts = held.recording.rejected;
  py::dict rejected;
  rejected["missing_value"] = counts.missing_value;
  rejected["not_finite"] = counts.not_finite;
  rejected["duplicate_stamp"] = counts.duplicate_stamp;
  rejected["clock_step_back"] = counts.clock_step_back;
  rejected["out_of_range"] = counts.out_of_range;
  return rejected;
}

}  // namespace

std::vector<RawSample> samplesOf(const Numbers& time, const Numbers& current,
                                 const Numbers& voltage,
                                 const std::optional<Numbers>& temperature) {
  const auto t = vectorOf(time, "time_s"), i = vectorOf(current, "current_a"),
             u = vectorOf(voltage, "voltage_v");
  const auto celsius =
      temperature ? vectorOf(*temperature, "temperature_c") : std::vector<double>();
  requireLength(i, t.size(), "current_a");
  requireLength(u, t.size(), "voltage_v");
  if (temperature) requireLength(celsius, t.size(), "temperature_c");
  std::vector<RawSample> samples;
  samples.reserve(t.size());
  for (std::size_t n = 0; n < t.size(); ++n) {
    samples.push_back({t[n], i[n], u[n], std::nullopt});
    if (temperature && celsius[n] == celsius[n])
      samples.back().temperature = celsius[n] + kZeroCelsius;
  }
  return samples;
}

void defineRecording(py::module_& module) {
  py::class_<HeldRecording>(module, "Recording")
      .def_static("from_arrays", &fromArrays)
      .def_static(
          "from_csv",
          [](const std::string& path, const std::string& time, const std::string& current,
             const std::string& voltage, const std::optional<std::string>& temperature,
             bool discharge_positive, std::optional<double> time_unit, const std::string& hash) {
            if (time_unit && (!(*time_unit > 0.0) || !(*time_unit <= 86400.0)))
              throw std::invalid_argument("time_unit_s is " + std::to_string(*time_unit) +
                                          ", expected above 0, up to 86400");
            return fromCsv(
                path, {time, current, voltage, temperature, discharge_positive, time_unit}, hash);
          })
      .def_property_readonly("name", [](const HeldRecording& held) { return held.recording.name; })
      .def_property_readonly(
          "time_s", [](const HeldRecording& held) { return numpyOf(held.recording.series.time); })
      .def_property_readonly(
          "current_a",
          [](const HeldRecording& held) { return numpyOf(held.recording.series.current); })
      .def_property_readonly(
          "voltage_v",
          [](const HeldRecording& held) { return numpyOf(held.recording.series.voltage); })
      .def_property_readonly("offered",
                             [](const HeldRecording& held) { return held.recording.offered; })
      .def_property_readonly("rejected", &rejectedOf);
}

}  // namespace battery_sof::python

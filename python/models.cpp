#include <nlohmann/json.hpp>
#include <stdexcept>

#include "answers.hpp"
#include "battery_sof/model.hpp"
#include "bindings.hpp"
#include "diagnosis/change.hpp"
#include "diagnosis/diagnosis.hpp"
#include "estimation/identification.hpp"
#include "prediction/questions.hpp"
#include "prediction/scores.hpp"
#include "report/change_results.hpp"
#include "report/results.hpp"
#include "util/files.hpp"
#include "util/text.hpp"

namespace battery_sof::python {

namespace py = pybind11;

namespace {

using Seconds = std::optional<double>;

bool isPaperStart(const std::string& name) {
  if (name != "robust" && name != "paper")
    throw std::invalid_argument("start is \"" + name + "\", expected robust or paper");
  return name == "paper";
}

PredictionMode modeOf(const std::optional<std::string>& name) {
  if (!name) return PredictionMode::kAsFitted;
  if (*name == "mixed") return PredictionMode::kMixed;
  if (*name == "current") return PredictionMode::kCurrent;
  throw std::invalid_argument("mode is \"" + *name + "\", expected mixed, current or None");
}

Model identifyHeld(const HeldRecording& held, Seconds from, Seconds to, bool chooses_window,
                   const std::optional<std::vector<std::string>>& effects, const std::string& start,
                   double series_blocks, int threads, bool anyway,
                   std::optional<double> crank_current, std::optional<double> capacity_ah) {
  const py::gil_scoped_release released;
  return identify(held.recording,
                  {from, to, chooses_window, effects, isPaperStart(start), series_blocks, threads,
                   held.hash, anyway, crank_current, checkedCapacity(capacity_ah)});
}

py::dict arraysOf(const Series& part, const FollowedPrediction& course) {
  py::dict arrays;
  arrays["time_s"] = numpyOf(part.time);
  arrays["current_a"] = numpyOf(part.current);
  arrays["voltage_v"] = numpyOf(part.voltage);
  arrays["predicted_v"] = numpyOf(course.voltage);
  arrays["lower_v"] = numpyOf(course.voltage_lower);
  arrays["upper_v"] = numpyOf(course.voltage_upper);
  arrays["predicted_a"] = numpyOf(course.current);
  arrays["lower_a"] = numpyOf(course.current_lower);
  arrays["upper_a"] = numpyOf(course.current_upper);
  py::array_t<bool> driven(static_cast<py::ssize_t>(course.voltage_controlled.size()));
  for (py::ssize_t n = 0; n < driven.size(); ++n)
    driven.mutable_at(n) = course.voltage_controlled[static_cast<std::size_t>(n)] != 0;
  arrays["voltage_controlled"] = driven;
  return arrays;
}

std::pair<py::dict, std::string> predictHeld(const Model& model, const HeldRecording& held,
                                             Seconds from, Seconds to,
                                             const std::optional<std::string>& mode,
                                             std::optional<double> crank_current) {
  RangePrediction prediction;
  Series part;
  {
    const py::gil_scoped_release released;
    if (!model.usable()) throw std::invalid_argument("no model: " + model.message());
    const IndexRange range = samplesBetween(held.fitted, from, to);
    FittedModel fitted = model.fitted();
    if (crank_current) fitted.fit.crank_current = -std::abs(*crank_current);
    prediction = predictRange(std::move(fitted), held.fitted, range, modeOf(mode));
    part = slice(held.fitted, range);
  }
  return {arraysOf(part, prediction.course), jsonText(resultJson(prediction.report))};
}

std::string askCrank(const Model& model, double i_load, double t_stop, double i_cranking,
                     double t_cranking, std::optional<double> u_required,
                     std::optional<double> capacity_ah) {
  const py::gil_scoped_release released;
  const CrankingQuery query =
      asked(CrankingQuery{i_load, t_stop, i_cranking, t_cranking, u_required});
  return answerText(predictCranking(model, query, checkedCapacity(capacity_ah)));
}

std::string askStopTime(const Model& model, double i_load, double i_cranking, double t_cranking,
                        double u_required, std::optional<double> capacity_ah) {
  const py::gil_scoped_release released;
  const StopTimeQuery query = asked(StopTimeQuery{i_load, i_cranking, t_cranking, u_required});
  return answerText(predictStopTime(model, query, checkedCapacity(capacity_ah)));
}

std::string askCharge(const Model& model, double u_boost, double t_sof2, double i_limit,
                      std::optional<double> capacity_ah) {
  const py::gil_scoped_release released;
  const ChargeAcceptanceQuery query = asked(ChargeAcceptanceQuery{u_boost, t_sof2, i_limit});
  return answerText(predictChargeAcceptance(model, query, checkedCapacity(capacity_ah)));
}

DiagnosisReport diagnoseHeld(const HeldRecording& held, Seconds from, Seconds to,
                             double holdout_share, const std::vector<std::string>& hypotheses,
                             const std::vector<std::string>& given, double series_blocks,
                             int threads, bool anyway, std::optional<double> crank_current,
                             std::optional<double> capacity_ah) {
  const py::gil_scoped_release released;
  return diagnose(held.recording,
                  {from, to, holdout_share, hypotheses, given, series_blocks, threads, nullptr,
                   held.hash, anyway, crank_current, checkedCapacity(capacity_ah)});
}

/// @return JSON and text of a comparison. @param from, to of the recording; references are whole.
std::pair<std::string, std::string> diagnoseChangeHeld(
    const HeldRecording& held, const std::vector<const HeldRecording*>& recordings,
    const std::vector<Model>& models, Seconds from, Seconds to, bool anyway) {
  const py::gil_scoped_release released;
  ChangeOptions options;
  options.anyway = anyway;
  ChangeReference then;
  std::vector<std::string> names;
  for (const Model& model : models) {
    then.models.push_back(model.fitted());
    names.push_back(model.fitted().provenance.recording);
  }
  for (const HeldRecording* one : recordings) {
    then.recordings.push_back(one->fitted);
    names.push_back(one->recording.name);
  }
  const ChangeDiagnosis found =
      diagnoseChange({slice(held.fitted, samplesBetween(held.fitted, from, to))}, then, options);
  return {jsonText(resultJson(found, {held.recording.name}, names)), resultText(found)};
}

Numbers covarianceOf(const Model& model) {
  const Eigen::MatrixXd& covariance = model.fitted().fit.covariance;
  Numbers rows({covariance.rows(), covariance.cols()});
  for (Eigen::Index j = 0; j < covariance.rows(); ++j)
    for (Eigen::Index k = 0; k < covariance.cols(); ++k) rows.mutable_at(j, k) = covariance(j, k);
  return rows;
}

void defineModel(py::module_& module) {
  const py::call_guard<py::gil_scoped_release> released;
  py::class_<Model>(module, "Model")
      .def_static(
          "read", [](const std::string& path) { return Model::read(path); }, released)
      .def_property_readonly("usable", &Model::usable)
      .def_property_readonly("covariance", &covarianceOf)
      .def_property_readonly(
          "recording_hash",
          [](const Model& model) { return model.fitted().provenance.recording_hash; })
      .def("json", &Model::json)
      .def("rested", &Model::rested)
      .def(
          "write", [](const Model& model, const std::string& path) { model.write(path); },
          released);
}

void defineDiagnosis(py::module_& module) {
  using Report = DiagnosisReport;
  py::class_<Report>(module, "Diagnosis")
      .def("json", &Report::json)
      .def("text", [](const Report& report) { return printable(report.text(), LineBreaks::kKept); })
      .def("base", &Report::base)
      .def("extended", &Report::extended)
      .def("time_s", [](const Report& report) { return numpyOf(report.recording().series.time); })
      .def("base_voltage",
           [](const Report& report) { return numpyOf(report.diagnosis().base_voltage); })
      .def("extended_voltage",
           [](const Report& report) { return numpyOf(report.diagnosis().extended_voltage); })
      .def(
          "write_page",
          [](const Report& report, const std::string& path) {
            writeFileAtomically(path, report.page());
          },
          py::call_guard<py::gil_scoped_release>());
}

}  // namespace

void defineModels(py::module_& module) {
  defineModel(module);
  defineDiagnosis(module);
  module.def("identify", &identifyHeld);
  module.def("predict", &predictHeld);
  module.def("crank", &askCrank);
  module.def("stop_time", &askStopTime);
  module.def("charge", &askCharge);
  module.def("diagnose", &diagnoseHeld);
  module.def("diagnose_change", &diagnoseChangeHeld);
}

}  // namespace battery_sof::python

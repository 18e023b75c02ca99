#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bindings.hpp"
#include "diagnosis/diagnose.hpp"
#include "estimation/recording_fit.hpp"
#include "prediction/range_prediction.hpp"
#include "recording/series_blocks.hpp"
#include "report/answers.hpp"
#include "report/diagnosis_page.hpp"
#include "report/diagnosis_results.hpp"
#include "report/model_yaml.hpp"
#include "report/results.hpp"
#include "util/atomic_file.hpp"
#include "util/printable.hpp"

namespace battery_sof::python {

namespace py = pybind11;

namespace {

using Seconds = std::optional<double>;

void requireUsableModel(const Fit& fit) {
  if (!isUsable(fit)) throw std::invalid_argument("no model: " + fit.message);
}

void nameOrigin(FittedModel& model, const HeldRecording& held, double series_blocks) {
  model.provenance.recording = held.recording.name;
  model.provenance.recording_hash = held.hash;
  model.fit.series_blocks = series_blocks;
}

/// The recording with the voltage of one block of the row.
Series seriesOfOne(const HeldRecording& held, double series_blocks) {
  if (!areSeriesBlocks(series_blocks))
    throw std::invalid_argument(format("series_blocks is %g, expected ", series_blocks) +
                                kAllowedSeriesBlocks);
  return perBlock(held.fitted, series_blocks);
}

FitStart startOf(const std::string& name) {
  if (name == "robust") return FitStart::kRobust;
  if (name == "paper") return FitStart::kPaper;
  throw std::invalid_argument("start is \"" + name + "\", expected robust or paper");
}

PredictionMode modeOf(const std::optional<std::string>& name) {
  if (!name) return PredictionMode::kAsFitted;
  if (*name == "mixed") return PredictionMode::kMixed;
  if (*name == "current") return PredictionMode::kCurrent;
  throw std::invalid_argument("mode is \"" + *name + "\", expected mixed, current or None");
}

FittedModel identifyHeld(const HeldRecording& held, Seconds from, Seconds to, bool chooses_window,
                         const std::optional<std::vector<std::string>>& effects, bool whiten,
                         const std::string& start, double series_blocks, int threads) {
  const py::gil_scoped_release released;
  const Series series = seriesOfOne(held, series_blocks);
  FitRequest request{from, to, chooses_window, {}};
  request.options.chooses_effects = !effects.has_value();
  if (effects) request.options.effects = *effects;
  request.options.whiten = whiten;
  request.options.start = startOf(start);
  request.options.threads = threads;
  const FitPlan plan = planFit(series, request);
  const auto begin = std::chrono::steady_clock::now();
  FittedModel model = fitPlanned(series, plan);
  model.provenance.fit_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  if (isUsable(model.fit)) carryToEnd(model, series, request);
  nameOrigin(model, held, series_blocks);
  return model;
}

/// JSON as text; what is not UTF-8 in it (names of files) is replaced, as the command does.
std::string textOf(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
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

std::pair<py::dict, std::string> predictHeld(const FittedModel& model, const HeldRecording& held,
                                             Seconds from, Seconds to,
                                             const std::optional<std::string>& mode) {
  RangePrediction prediction;
  Series part;
  {
    const py::gil_scoped_release released;
    requireUsableModel(model.fit);
    const IndexRange range = samplesBetween(held.fitted, from, to);
    prediction = predictRange(model, held.fitted, range, modeOf(mode));
    part = slice(held.fitted, range);
  }
  return {arraysOf(part, prediction.course), textOf(predictionJson(prediction.report))};
}

double checkedCapacity(double capacity_ah) {
  if (capacity_ah > 0.0 && std::isfinite(capacity_ah)) return capacity_ah;
  throw std::invalid_argument(
      format("capacity_ah is %g, expected above 0 and finite", capacity_ah));
}

/// An answer as JSON. @throws std::invalid_argument for a query that is none.
template <typename Answer, typename ToJson>
std::string jsonOf(const Answer& answer, const ToJson& json) {
  if (answer.code == AnswerCode::kInvalidQuery) throw std::invalid_argument(answer.message);
  return textOf(json(answer));
}

std::string askCrank(const FittedModel& model, double i_load, double t_stop, double i_cranking,
                     double t_cranking, std::optional<double> u_required, double capacity_ah) {
  const py::gil_scoped_release released;
  const CrankingQuery query =
      asked(CrankingQuery{i_load, t_stop, i_cranking, t_cranking, u_required});
  return jsonOf(predictCranking(model, query, checkedCapacity(capacity_ah)), crankingJson);
}

std::string askStopTime(const FittedModel& model, double i_load, double i_cranking,
                        double t_cranking, double u_required, double capacity_ah) {
  const py::gil_scoped_release released;
  const StopTimeQuery query = asked(StopTimeQuery{i_load, i_cranking, t_cranking, u_required});
  return jsonOf(predictStopTime(model, query, checkedCapacity(capacity_ah)), stopTimeJson);
}

std::string askCharge(const FittedModel& model, double u_boost, double t_sof2, double i_limit,
                      double capacity_ah) {
  const py::gil_scoped_release released;
  const ChargeAcceptanceQuery query = asked(ChargeAcceptanceQuery{u_boost, t_sof2, i_limit});
  return jsonOf(predictChargeAcceptance(model, query, checkedCapacity(capacity_ah)),
                chargeAcceptanceJson);
}

HeldDiagnosis diagnoseHeld(const HeldRecording& held, Seconds from, Seconds to,
                           double holdout_share, const std::vector<std::string>& hypotheses,
                           const std::vector<std::string>& given, double series_blocks,
                           int threads) {
  const py::gil_scoped_release released;
  HeldDiagnosis result{held.recording, {}};
  result.stretch.series =
      slice(seriesOfOne(held, series_blocks), samplesBetween(held.fitted, from, to));
  DiagnoseOptions options;
  options.holdout_share = holdout_share;
  options.hypotheses = hypotheses;
  options.given = given;
  options.threads = threads;
  result.diagnosis = diagnose(result.stretch, options);
  nameOrigin(result.diagnosis.base, held, series_blocks);
  nameOrigin(result.diagnosis.extended, held, series_blocks);
  if (series_blocks != 1.0)
    result.diagnosis.instrument.insert(result.diagnosis.instrument.begin(),
                                       seriesBlocksSentence(series_blocks));
  return result;
}

Numbers covarianceOf(const FittedModel& model) {
  Numbers rows({model.fit.covariance.rows(), model.fit.covariance.cols()});
  for (Eigen::Index j = 0; j < model.fit.covariance.rows(); ++j)
    for (Eigen::Index k = 0; k < model.fit.covariance.cols(); ++k)
      rows.mutable_at(j, k) = model.fit.covariance(j, k);
  return rows;
}

void defineModel(py::module_& module) {
  py::class_<FittedModel>(module, "Model")
      .def_static("read",
                  [](const std::string& path) {
                    const py::gil_scoped_release released;
                    return readModelFile(path);
                  })
      .def_property_readonly("usable", [](const FittedModel& model) { return isUsable(model.fit); })
      .def_property_readonly("covariance", &covarianceOf)
      .def_property_readonly(
          "recording_hash",
          [](const FittedModel& model) { return model.provenance.recording_hash; })
      .def("json", [](const FittedModel& model) { return textOf(identifyJson(model)); })
      .def("rested",
           [](const FittedModel& model) {
             requireUsableModel(model.fit);
             return rested(model);
           })
      .def("write", [](const FittedModel& model, const std::string& path) {
        const py::gil_scoped_release released;
        requireUsableModel(model.fit);
        writeModelFile(path, model);
      });
}

void defineDiagnosis(py::module_& module) {
  py::class_<HeldDiagnosis>(module, "Diagnosis")
      .def("json", [](const HeldDiagnosis& held) { return textOf(diagnosisJson(held.diagnosis)); })
      .def("text",
           [](const HeldDiagnosis& held) {
             return printable(diagnosisText(held.diagnosis), LineBreaks::kKept);
           })
      .def("base", [](const HeldDiagnosis& held) { return held.diagnosis.base; })
      .def("extended", [](const HeldDiagnosis& held) { return held.diagnosis.extended; })
      .def("time_s", [](const HeldDiagnosis& held) { return numpyOf(held.stretch.series.time); })
      .def("base_voltage",
           [](const HeldDiagnosis& held) { return numpyOf(held.diagnosis.base_voltage); })
      .def("extended_voltage",
           [](const HeldDiagnosis& held) { return numpyOf(held.diagnosis.extended_voltage); })
      .def("write_page", [](const HeldDiagnosis& held, const std::string& path) {
        const py::gil_scoped_release released;
        writeFileAtomically(path, diagnosisPage(held.stretch, held.diagnosis));
      });
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
}

}  // namespace battery_sof::python

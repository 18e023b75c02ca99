#include "answers.hpp"
#include "battery_sof/session.hpp"
#include "bindings.hpp"
#include "prediction/questions.hpp"

namespace battery_sof::python {

namespace py = pybind11;

namespace {

Session sessionOf(std::optional<double> capacity_ah, double series_blocks, double buffer_s,
                  std::optional<double> window_s) {
  return Session({checkedCapacity(capacity_ah), series_blocks, buffer_s, window_s});
}

void pushAll(Session& session, const Numbers& time_s, const Numbers& current_a,
             const Numbers& voltage_v, const std::optional<Numbers>& temperature_c) {
  const auto samples = samplesOf(time_s, current_a, voltage_v, temperature_c);
  const py::gil_scoped_release released;
  for (const RawSample& sample : samples) session.push(sample);
}

}  // namespace

void defineSession(py::module_& module) {
  const py::call_guard<py::gil_scoped_release> released;
  py::class_<Session>(module, "Session")
      .def(py::init(&sessionOf))
      .def("push", &pushAll)
      .def("identify_when_due", &Session::identifyWhenDue, released)
      .def("restore", &Session::restore, released)
      .def("model", &Session::model, released)
      .def("reason", &Session::reason, released)
      .def(
          "crank",
          [](const Session& session, double i_load, double t_stop, double i_cranking,
             double t_cranking, std::optional<double> u_required) {
            return answerText(session.predictCranking(
                asked(CrankingQuery{i_load, t_stop, i_cranking, t_cranking, u_required})));
          },
          released)
      .def(
          "stop_time",
          [](const Session& session, double i_load, double i_cranking, double t_cranking,
             double u_required) {
            return answerText(session.predictStopTime(
                asked(StopTimeQuery{i_load, i_cranking, t_cranking, u_required})));
          },
          released)
      .def(
          "charge",
          [](const Session& session, double u_boost, double t_sof2, double i_limit) {
            return answerText(session.predictChargeAcceptance(
                asked(ChargeAcceptanceQuery{u_boost, t_sof2, i_limit})));
          },
          released);
}

}  // namespace battery_sof::python

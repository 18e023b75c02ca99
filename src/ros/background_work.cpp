#include "ros/background_work.hpp"

#include <chrono>
#include <stdexcept>

#include "diagnosis/diagnose.hpp"

namespace battery_sof {
namespace {

class WallTimer {
 public:
  double milliseconds() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun_)
        .count();
  }

 private:
  std::chrono::steady_clock::time_point begun_ = std::chrono::steady_clock::now();
};

}  // namespace

IdentificationResult timedIdentification(const IdentificationJob& job) {
  const WallTimer watch;
  IdentificationResult result;
  try {
    result = runIdentification(job);
  } catch (const std::exception& error) {
    result.epoch = job.epoch;
    result.message = std::string("the identification failed: ") + error.what();
  }
  if (result.model) result.model->provenance.fit_ms = watch.milliseconds();
  if (result.extended && result.extended->model)
    result.extended->model->provenance.fit_ms = watch.milliseconds();
  return result;
}

DiagnosisReport timedDiagnosis(const Recording& recording,
                               const std::vector<KnownPopulation>& priors,
                               const std::function<std::string()>& why_end,
                               const std::function<void(const std::string& stage)>& begins) {
  const WallTimer watch;
  DiagnosisReport report;
  report.from = recording.series.time.front();
  report.to = recording.series.time.back();
  report.samples = recording.series.size();
  DiagnoseOptions options;
  options.priors = priors;
  options.pulse = [&why_end] {
    const std::string why = why_end();
    if (!why.empty()) throw std::runtime_error(why);
  };
  options.progress = begins;
  try {
    report.diagnosis = diagnose(recording, options);
  } catch (const std::exception& error) {
    report.fault = std::string("the diagnosis broke off: ") + error.what();
  }
  report.duration_ms = watch.milliseconds();
  return report;
}

}  // namespace battery_sof

#include "ros/background_work.hpp"

#include <ros/time.h>

#include <algorithm>
#include <stdexcept>

#include "diagnosis/diagnose.hpp"
#include "model/discrepancy_model.hpp"
#include "model/effect.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

bool isInstrument(const std::string& id) {
  return id != kDiscrepancyEffect && effectInfo(id).tier() == 'I';
}

/// Instruments marked.
std::string marked(std::vector<std::string> ids) {
  for (std::string& id : ids)
    if (isInstrument(id)) id += " (instrument)";
  return join(ids);
}

}  // namespace

IdentificationResult timedIdentification(const IdentificationJob& job) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  IdentificationResult result;
  try {
    result = runIdentification(job);
  } catch (const std::exception& error) {
    result.epoch = job.epoch;
    result.message = std::string("the identification failed: ") + error.what();
  }
  const double fit_ms = 1e3 * (ros::SteadyTime::now() - begun).toSec();
  if (result.model) result.model->provenance.fit_ms = fit_ms;
  if (result.extended && result.extended->model) result.extended->model->provenance.fit_ms = fit_ms;
  return result;
}

FinishedDiagnosis timedDiagnosis(const Recording& recording,
                                 const std::vector<KnownPopulation>& priors,
                                 const std::function<std::string()>& why_end,
                                 const std::function<void(const std::string& stage)>& begins) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  FinishedDiagnosis report;
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
  report.duration_ms = 1e3 * (ros::SteadyTime::now() - begun).toSec();
  return report;
}

Adoption adoptionOf(const Diagnosis& diagnosis, bool allowed) {
  const bool names =
      diagnosis.verdict == Verdict::kEffect || diagnosis.verdict == Verdict::kSeveral;
  const std::vector<std::string>& effects = diagnosis.extended.fit.effects;
  if (!allowed) return {{}, "not asked for: parameter use_diagnosis is false"};
  if (!names && !diagnosis.extended.fit.discrepancy)
    return {{}, "nothing to adopt: the verdict is " + toString(diagnosis.verdict)};
  if (diagnosis.withheld_rmse)
    return {{},
            "nothing to adopt: what was found predicts the part that was held out worse than the "
            "base model"};
  if (std::all_of(effects.begin(), effects.end(), isInstrument))
    return {
        {},
        "nothing to adopt: instruments are to be repaired, not modelled (" + marked(effects) + ")"};
  return {effects,
          "runs with the base model and answers while its error is smaller: " + marked(effects),
          diagnosis.extended.fit.discrepancy};
}

}  // namespace battery_sof

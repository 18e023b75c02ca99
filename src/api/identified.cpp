#include "api/identified.hpp"

#include <chrono>

#include "diagnosis/response_table.hpp"
#include "recording/resample.hpp"
#include "recording/series_blocks.hpp"

namespace battery_sof {

FittedModel identified(const Series& series, const FitRequest& request) {
  FittedModel model;
  if (series.empty()) {
    model.fit.status = FitStatus::kWindowTooShort;
    model.fit.message = kTooShortForDesignRate;
    return model;
  }
  const FitPlan plan = planFit(series, request);
  const auto begin = std::chrono::steady_clock::now();
  model = fitPlanned(series, plan);
  model.provenance.fit_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  if (!isUsable(model.fit)) return model;
  carryToEnd(model, series, request);
  model.responses = responseTable(series, request);
  return model;
}

void nameOrigin(FittedModel& model, const Recording& recording, const std::string& hash,
                double series_blocks) {
  model.provenance.recording = recording.name;
  model.provenance.recording_hash = hash;
  model.fit.series_blocks = series_blocks;
}

void nameOrigin(Diagnosis& diagnosis, const Recording& recording, const std::string& hash,
                double series_blocks) {
  nameOrigin(diagnosis.base, recording, hash, series_blocks);
  nameOrigin(diagnosis.extended, recording, hash, series_blocks);
  if (series_blocks != 1.0)
    diagnosis.instrument.insert(diagnosis.instrument.begin(), seriesBlocksSentence(series_blocks));
}

}  // namespace battery_sof

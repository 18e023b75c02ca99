#include "battery_sof/model.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "api/identified.hpp"
#include "diagnosis/diagnose.hpp"
#include "estimation/identification.hpp"
#include "prediction/questions.hpp"
#include "recording/resample.hpp"
#include "recording/series_blocks.hpp"
#include "report/diagnosis_page.hpp"
#include "report/model_yaml.hpp"
#include "report/results.hpp"

namespace battery_sof {
namespace {

void requireUsable(const Fit& fit) {
  if (!isUsable(fit)) throw std::invalid_argument("no model: " + fit.message);
}

/// A recording as models are fitted to it: at the design rate, with the voltage of one block of the
/// row.
Series fittedSeries(const Recording& recording, double series_blocks) {
  requireInvariants(recording.series);
  requireThat(areSeriesBlocks(series_blocks), "series_blocks", series_blocks, kAllowedSeriesBlocks);
  return perBlock(atDesignRate(recording.series), series_blocks);
}

}  // namespace

Model::Model(FittedModel model) : fitted_(std::make_shared<const FittedModel>(std::move(model))) {}

Model Model::read(const std::filesystem::path& file) { return Model(readModelFile(file)); }

void Model::write(const std::filesystem::path& file) const {
  requireUsable(fitted_->fit);
  writeModelFile(file, *fitted_);
}

bool Model::usable() const { return isUsable(fitted_->fit); }

std::string Model::message() const { return fitted_->fit.message; }

std::vector<std::string> Model::effects() const { return fitted_->fit.effects; }

std::vector<ParameterEstimate> Model::parameters() const { return fitted_->fit.estimates; }

Model Model::rested() const {
  requireUsable(fitted_->fit);
  return Model(battery_sof::rested(*fitted_));
}

std::string Model::json() const { return jsonText(resultJson(*fitted_)); }

std::string Model::text() const { return resultText(*fitted_); }

namespace {

/// A crank's current is out of the battery, whichever sign it was given with.
std::optional<double> dischargeOf(const std::optional<double>& current) {
  if (!current) return std::nullopt;
  return -std::abs(*current);
}

}  // namespace

Model identify(const Recording& recording, const IdentifyRequest& request) {
  const Series series = fittedSeries(recording, request.series_blocks);
  FitRequest fit{request.from, request.to, request.chooses_window, request.anyway, {}};
  fit.options.chooses_effects = !request.effects.has_value();
  if (request.effects) fit.options.effects = *request.effects;
  fit.options.start = request.paper_start ? FitStart::kPaper : FitStart::kRobust;
  fit.options.threads = request.threads;
  fit.options.capacity = request.capacity;
  fit.crank_current = dischargeOf(request.crank_current);
  FittedModel model = identified(series, fit);
  nameOrigin(model, recording, request.recording_hash, request.series_blocks);
  return Model(std::move(model));
}

CrankingAnswer predictCranking(const Model& model, const CrankingQuery& query,
                               std::optional<double> capacity) {
  return predictCranking(model.fitted(), query, capacityFor(model.fitted().fit, capacity));
}

StopTimeAnswer predictStopTime(const Model& model, const StopTimeQuery& query,
                               std::optional<double> capacity) {
  return predictStopTime(model.fitted(), query, capacityFor(model.fitted().fit, capacity));
}

ChargeAcceptanceAnswer predictChargeAcceptance(const Model& model,
                                               const ChargeAcceptanceQuery& query,
                                               std::optional<double> capacity) {
  return predictChargeAcceptance(model.fitted(), query, capacityFor(model.fitted().fit, capacity));
}

ProfileAnswer simulateProfile(const Model& model, const std::vector<double>& time,
                              const std::vector<double>& current, const WorkWatch& watch) {
  return simulateProfile(model.fitted(), time, current, watch);
}

DiagnosisReport::DiagnosisReport(Recording recording, Diagnosis diagnosis)
    : recording_(std::make_shared<const Recording>(std::move(recording))),
      diagnosis_(std::make_shared<const Diagnosis>(std::move(diagnosis))) {}

std::string DiagnosisReport::verdict() const { return toString(diagnosis_->verdict); }

std::string DiagnosisReport::summary() const { return diagnosis_->summary; }

std::string DiagnosisReport::json() const { return jsonText(resultJson(*diagnosis_)); }

std::string DiagnosisReport::text() const { return resultText(*diagnosis_); }

std::string DiagnosisReport::page() const { return diagnosisPage(*recording_, *diagnosis_); }

Model DiagnosisReport::base() const { return Model(diagnosis_->base); }

Model DiagnosisReport::extended() const { return Model(diagnosis_->extended); }

DiagnosisReport diagnose(const Recording& recording, const DiagnosisRequest& request) {
  Recording stretch = recording;
  const Series series = fittedSeries(recording, request.series_blocks);
  stretch.series = slice(series, samplesBetween(series, request.from, request.to));
  DiagnoseOptions options;
  options.holdout_share = request.holdout_share;
  options.hypotheses = request.hypotheses;
  options.given = request.given;
  options.threads = request.threads;
  options.anyway = request.anyway;
  options.crank_current = dischargeOf(request.crank_current);
  options.capacity = request.capacity;
  options.progress = request.progress;
  Diagnosis diagnosis = diagnose(stretch, options);
  nameOrigin(diagnosis, recording, request.recording_hash, request.series_blocks);
  return {std::move(stretch), std::move(diagnosis)};
}

}  // namespace battery_sof

#include "ros/diagnosis_runner.hpp"

#include <utility>

#include "recording/series_blocks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kNice = 15;  // identifications (10) go first: answers stand on them

}  // namespace

DiagnosisRunner::DiagnosisRunner(ros::NodeHandle& private_node, const Options& options, Adopt adopt)
    : options_(options),
      adopt_(std::move(adopt)),
      publisher_(private_node.advertise<DiagnosisMessage>("diagnosis", 10, true)),
      next_due_(options.period),
      worker_([this](const Job& job) { return run(job); }, kNice) {}

std::optional<std::future<DiagnosisRunner::Outcome>> DiagnosisRunner::begin(
    const Series& series, const std::string& name) {
  const std::lock_guard<std::mutex> lock(mutex_);
  return post(series, name, 0.0);
}

void DiagnosisRunner::beginIfDue(const Series& series, const std::string& name, double driving) {
  if (options_.period <= 0.0 || driving < next_due_ || series.empty()) return;
  next_due_ += options_.period;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!post(series, name, driving + options_.settle)) ++line_.skipped;
}

std::optional<std::future<DiagnosisRunner::Outcome>> DiagnosisRunner::post(const Series& series,
                                                                           const std::string& name,
                                                                           double from_driving) {
  if (line_.runs) return std::nullopt;
  line_.runs = true;
  cancelled_ = false;
  stage_ = "waiting for its turn";
  begun_ = ros::SteadyTime::now();
  ROS_INFO("diagnosis begins on %zu samples", series.size());
  Job job;
  job.recording.name = name;
  job.recording.series = series;
  job.recording.offered = series.size();
  job.from_driving = from_driving;
  return worker_.post(std::move(job));
}

DiagnosisRunner::Outcome DiagnosisRunner::run(const Job& job) {
  Outcome outcome;
  try {
    return diagnosed(job);
  } catch (const std::exception& error) {
    outcome.fault = std::string("the diagnosis failed: ") + error.what();
    ROS_ERROR("%s", outcome.fault.c_str());
  }
  DiagnosisReport report;
  report.fault = outcome.fault;
  note(report, {});
  return outcome;
}

DiagnosisRunner::Outcome DiagnosisRunner::diagnosed(const Job& job) {
  const auto why_end = [this]() -> std::string {
    if (stopped_) return "the node is shutting down";
    return cancelled_ ? "it was cancelled" : "";
  };
  const auto begins = [this](const std::string& stage) {
    const std::lock_guard<std::mutex> lock(mutex_);
    stage_ = stage;
  };
  DiagnosisReport report = timedDiagnosis(job.recording, options_.priors, why_end, begins);
  if (report.diagnosis && options_.series_blocks != 1.0)
    report.diagnosis->instrument.push_back(seriesBlocksSentence(options_.series_blocks));
  const Adoption adoption =
      report.diagnosis ? adopt(*report.diagnosis, job.from_driving) : Adoption();
  Outcome outcome;
  outcome.fault = report.fault;
  if (report.diagnosis) {
    outcome.message = messageOf(report, adoption);
    publisher_.publish(*outcome.message);
    ROS_INFO("diagnosis (%s) after %.1f s: %s", outcome.message->verdict.c_str(),
             1e-3 * report.duration_ms, outcome.message->summary.c_str());
  } else {
    ROS_WARN("%s", report.fault.c_str());
  }
  note(report, adoption);
  return outcome;
}

Adoption DiagnosisRunner::adopt(const Diagnosis& diagnosis, double from_driving) {
  Adoption adoption = adoptionOf(diagnosis, options_.adopt);
  try {
    if (!adoption.effects.empty()) adopt_(adoption, from_driving);
  } catch (const std::exception& error) {
    adoption = {{}, std::string("not adopted: ") + error.what()};
  }
  return adoption;
}

void DiagnosisRunner::note(const DiagnosisReport& report, const Adoption& adoption) {
  const std::lock_guard<std::mutex> lock(mutex_);
  line_.runs = false;
  line_.fault = report.fault;
  line_.duration_ms = report.duration_ms;
  if (!report.diagnosis) return;
  ++line_.finished;
  line_.verdict = toString(report.diagnosis->verdict);
  line_.summary = report.diagnosis->summary;
  line_.adoption = adoption.sentence;
}

DiagnosisLine DiagnosisRunner::line() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return line_;
}

std::optional<std::string> DiagnosisRunner::cancel() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!line_.runs) return std::nullopt;
  cancelled_ = true;
  return format("cancelled after %.1f s while ", (ros::SteadyTime::now() - begun_).toSec()) +
         stage_;
}

void DiagnosisRunner::stop() {
  stopped_ = true;
  worker_.stop();
}

}  // namespace battery_sof

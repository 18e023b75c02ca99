#include "ros/diagnosis_runner.hpp"

#include <utility>

#include "recording/series_blocks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kDiagnosisNice = 15;  // identifications (10) go first: answers stand on them

}  // namespace

DiagnosisRunner::DiagnosisRunner(ros::NodeHandle& private_node, const Options& options, Adopt adopt)
    : options_(options),
      adopt_(std::move(adopt)),
      publisher_(private_node.advertise<DiagnosisMessage>("diagnosis", 10, true)),
      next_due_(options.period),
      worker_([this](Job job) { run(std::move(job)); }, kDiagnosisNice) {}

bool DiagnosisRunner::begin(const Series& series, const std::string& name, const Goal& goal) {
  const std::string id = goal.getGoalID().id;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!post(series, name, 0.0, goal)) return false;
  goal_id_ = id;
  return true;
}

void DiagnosisRunner::beginIfDue(const Series& series, const std::string& name, double driving) {
  if (options_.period <= 0.0 || driving < next_due_ || series.empty()) return;
  next_due_ += options_.period;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!post(series, name, driving + options_.settle, {})) ++line_.skipped;
}

bool DiagnosisRunner::post(const Series& series, const std::string& name, double from_driving,
                           const Goal& goal) {
  if (line_.runs) return false;
  line_.runs = true;
  goal_id_.clear();
  cancelled_ = false;
  ROS_INFO("diagnosis begins on %zu samples", series.size());
  worker_.post({{name, series, {}, series.size(), 0.0}, from_driving, goal});
  return true;
}

void DiagnosisRunner::run(Job job) {
  if (job.goal.isValid()) job.goal.setAccepted();
  DiagnosisOutcome outcome;
  try {
    outcome = diagnosed(job);
  } catch (const std::exception& error) {
    outcome.fault = std::string("the diagnosis failed: ") + error.what();
    ROS_ERROR("%s", outcome.fault.c_str());
    FinishedDiagnosis report;
    report.fault = outcome.fault;
    note(report, {});
  }
  if (!job.goal.isValid()) return;
  const DiagnoseResult result = resultOf(outcome);
  if (result.success) {
    job.goal.setSucceeded(result, result.message);
  } else if (outcome.is_cancelled) {
    job.goal.setCanceled(result, result.message);
  } else {
    job.goal.setAborted(result, result.message);
  }
}

DiagnosisOutcome DiagnosisRunner::diagnosed(Job& job) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  std::string stage = "beginning";
  const auto why_end = [&]() -> std::string {
    if (stopped_) return "the node is shutting down";
    if (!cancelled_) return "";
    return format("cancelled after %.1f s while ", (ros::SteadyTime::now() - begun).toSec()) +
           stage;
  };
  const auto begins = [&](const std::string& next) {
    stage = next;
    if (job.goal.isValid()) job.goal.publishFeedback(feedbackOf<DiagnoseFeedback>(stage));
  };
  FinishedDiagnosis report = timedDiagnosis(job.recording, options_.priors, why_end, begins);
  if (report.diagnosis && options_.series_blocks != 1.0)
    report.diagnosis->instrument.push_back(seriesBlocksSentence(options_.series_blocks));
  const Adoption adoption =
      report.diagnosis ? adopt(*report.diagnosis, job.from_driving) : Adoption();
  DiagnosisOutcome outcome;
  outcome.fault = report.fault;
  outcome.is_cancelled = cancelled_;
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

void DiagnosisRunner::note(const FinishedDiagnosis& report, const Adoption& adoption) {
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

void DiagnosisRunner::cancel(const Goal& goal) {
  const std::string id = goal.getGoalID().id;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (line_.runs && goal_id_ == id) cancelled_ = true;
}

void DiagnosisRunner::stop() {
  stopped_ = true;
  worker_.stop();
}

}  // namespace battery_sof

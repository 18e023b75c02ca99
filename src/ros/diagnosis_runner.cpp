#include "ros/diagnosis_runner.hpp"

#include <stdexcept>
#include <utility>

#include "diagnosis/diagnose.hpp"
#include "recording/series_blocks.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kDiagnosisNice = 15;  // identifications (10) go first: answers stand on them

}  // namespace

DiagnosisRunner::DiagnosisRunner(ros::NodeHandle& private_node, const NodeOptions& options,
                                 Adopt adopt)
    : options_(options),
      adopt_(std::move(adopt)),
      publisher_(private_node.advertise<DiagnosisMessage>("diagnosis", 10, true)),
      next_due_(options.diagnose_period),
      worker_(kDiagnosisNice) {}

bool DiagnosisRunner::begin(const Series& series, const std::string& name, const Goal& goal) {
  const std::string id = goal.getGoalID().id;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!post(series, name, 0.0, goal)) return false;
  goal_id_ = id;
  return true;
}

void DiagnosisRunner::beginIfDue(const Series& series, const std::string& name, double driving) {
  if (options_.diagnose_period <= 0.0 || driving < next_due_ || series.empty()) return;
  next_due_ += options_.diagnose_period;
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!post(series, name, driving + options_.session.identify_period, {})) ++line_.skipped;
}

bool DiagnosisRunner::post(const Series& series, const std::string& name, double from_driving,
                           const Goal& goal) {
  if (line_.runs) return false;
  line_.runs = true;
  goal_id_.clear();
  cancelled_ = false;
  ROS_INFO("starting a diagnosis of %zu samples", series.size());
  worker_.post(
      [this, job = Job{{name, series, {}, series.size(), 0.0}, from_driving, goal}]() mutable {
        run(std::move(job));
      });
  return true;
}

void DiagnosisRunner::run(Job job) {
  if (job.goal.isValid()) job.goal.setAccepted();
  FinishedDiagnosis report;
  Adoption adoption;
  DiagnoseResult result;
  try {
    report = diagnosed(job);
    if (report.diagnosis) adoption = adopt(*report.diagnosis, job.from_driving);
    result = resultOf(report, adoption);
    if (report.diagnosis) {
      publisher_.publish(result.diagnosis);
      ROS_INFO("diagnosis finished, verdict %s, after %.1f s: %s", result.diagnosis.verdict.c_str(),
               1e-3 * report.duration_ms, result.message.c_str());
    } else {
      ROS_WARN("%s", report.fault.c_str());
    }
  } catch (const std::exception& error) {
    report = {};
    report.fault = std::string("the diagnosis failed: ") + error.what();
    ROS_ERROR("%s", report.fault.c_str());
    result = resultOf(report, {});
  }
  const bool is_cancelled = cancelled_;
  note(report, adoption);
  if (!job.goal.isValid()) return;
  if (result.success) {
    job.goal.setSucceeded(result, result.message);
  } else if (is_cancelled) {
    job.goal.setCanceled(result, result.message);
  } else {
    job.goal.setAborted(result, result.message);
  }
}

FinishedDiagnosis DiagnosisRunner::diagnosed(Job& job) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  const auto elapsed = [begun] { return (ros::SteadyTime::now() - begun).toSec(); };
  const Series& series = job.recording.series;
  FinishedDiagnosis report;
  report.from = series.time.front();
  report.to = series.time.back();
  report.samples = series.size();
  std::string stage = "beginning";
  DiagnoseOptions options;
  options.priors = options_.session.identify.priors;
  options.crank_current = options_.session.events.crank_current;
  options.capacity = options_.session.capacity;
  options.pulse = [&] {
    if (stopped_) throw std::runtime_error("the node is shutting down");
    if (cancelled_)
      throw std::runtime_error(format("cancelled after %.1f s while ", elapsed()) + stage);
  };
  options.progress = [&](const std::string& next) {
    stage = next;
    if (job.goal.isValid()) job.goal.publishFeedback(feedbackOf<DiagnoseFeedback>(stage));
  };
  try {
    report.diagnosis = diagnose(job.recording, options);
  } catch (const std::exception& error) {
    report.fault = std::string("the diagnosis stopped: ") + error.what();
  }
  report.duration_ms = 1e3 * elapsed();
  const double series_blocks = options_.session.series_blocks;
  if (report.diagnosis && series_blocks != 1.0)
    report.diagnosis->instrument.push_back(seriesBlocksSentence(series_blocks));
  return report;
}

Adoption DiagnosisRunner::adopt(const Diagnosis& diagnosis, double from_driving) {
  Adoption adoption = adoptionOf(diagnosis, options_.use_diagnosis);
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

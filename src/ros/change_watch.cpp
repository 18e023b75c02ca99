#include "ros/change_watch.hpp"

#include <std_msgs/String.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <utility>

#include "diagnosis/change.hpp"
#include "recording/checks.hpp"
#include "report/change_results.hpp"
#include "report/results.hpp"
#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr int kComparisonNice = 15;  // identifications (10) go first: answers stand on them

/// Samples after a time. @param after [s]; later than all of them: a clock that stepped back, all.
Series newerThan(const Series& series, double after) {
  std::size_t first = 0;
  if (after < series.time.back())
    while (first < series.size() && series.time[first] <= after) ++first;
  return slice(series, {first, series.size()});
}

/// Why a recording cannot serve as a reference.
std::string whyNoReference(const Series& series) {
  const auto problems = findProblems(series);
  if (!problems.empty()) return "the buffered samples have a problem: " + format(problems);
  return format(
      "the %zu buffered samples are too few or have too few changes of current of 8 A and more; "
      "drive on and ask again",
      series.size());
}

}  // namespace

ChangeWatch::ChangeWatch(ros::NodeHandle& private_node, double period)
    : period_(period),
      publisher_(private_node.advertise<std_msgs::String>("change", 10, true)),
      next_due_(period),
      worker_(kComparisonNice) {}

void ChangeWatch::restore(const std::shared_ptr<const ResponseTable>& reference,
                          const std::string& topic) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    reference_ = reference;
  }
  if (reference) publish(reference, topic);
}

void ChangeWatch::forget(const std::string& topic) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    reference_.reset();
    ++epoch_;
  }
  publish(nullptr, topic);
}

std::shared_ptr<const ResponseTable> ChangeWatch::responses() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return reference_;
}

void ChangeWatch::beginIfDue(const Series& series, const std::string& topic, double driving) {
  if (period_ <= 0.0 || driving < next_due_ || series.empty()) return;
  next_due_ = driving + period_;
  Series newest;
  int epoch = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    newest = newerThan(series, std::exchange(taken_to_, series.time.back()));
    epoch = epoch_;
  }
  worker_.post([this, newest = std::move(newest), topic, epoch] {
    try {
      compare(newest, topic, epoch);
    } catch (const std::exception& error) {
      ROS_ERROR("the comparison with the reference failed: %s", error.what());
    }
  });
}

void ChangeWatch::compare(const Series& series, const std::string& topic, int epoch) {
  const auto before = responses();
  const auto after = withDrive(before, series);
  if (!after) return;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (epoch != epoch_) return;
    reference_ = after;
  }
  publish(after, topic);
}

void ChangeWatch::publish(const std::shared_ptr<const ResponseTable>& reference,
                          const std::string& topic) {
  const ChangeDiagnosis found = diagnoseChange(reference);
  std_msgs::String message;
  message.data = jsonText(resultJson(found, {topic}, {topic}));
  publisher_.publish(message);
  const std::size_t drives = reference && reference->since ? reference->since->drives : 0;
  const std::string said =
      format("changes over %zu drives (%s): ", drives, toString(found.verdict).c_str()) +
      found.summary;
  if (found.verdict == ChangeVerdict::kChanged) {
    ROS_WARN("%s", said.c_str());
  } else {
    ROS_INFO("%s", said.c_str());
  }
}

ChangeWatch::Outcome ChangeWatch::setReference(const Series& series, const std::string& topic) {
  if (series.empty()) return {false, "no samples are buffered yet"};
  const auto table = withDrive(nullptr, series);
  if (!table) return {false, whyNoReference(series)};
  const std::string said = format(
      "%zu samples, from %.0f to %.0f s, are the first of the %zu drives that make up the "
      "reference "
      "for changes",
      table->samples, table->from, table->to, kSoundDrives);
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    reference_ = table;
    taken_to_ = series.time.back();
    ++epoch_;
  }
  publish(table, topic);
  return {true, said};
}

}  // namespace battery_sof

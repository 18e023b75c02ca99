#include "battery_sof/ros/battery_sof_node.hpp"

#include <filesystem>
#include <utility>

#include "battery_sof/bag/bag_storage.hpp"
#include "battery_sof/bag/battery_state_message.hpp"
#include "battery_sof/report/model_yaml.hpp"

namespace battery_sof {

namespace {

constexpr std::uint32_t kQueueSize = 100000;  // 20 s of a 100 Hz bag played at 50x
constexpr double kStatusPeriod = 1.0;         // [s], SofStatus is a 1 Hz topic
constexpr double kNoDataAfter = 5.0;          // [s], the shortest gap of a recording (gapThreshold)

}  // namespace

BatterySofNode::BatterySofNode(ros::NodeHandle node, ros::NodeHandle private_node,
                               NodeOptions options)
    : options_(std::move(options)),
      node_(std::move(node)),
      private_node_(std::move(private_node)),
      session_(options_.session),
      worker_([this](IdentificationResult result) { return onIdentified(std::move(result)); }),
      diagnostics_([this] { return snapshot(); }),
      identify_spinner_(1, &identify_queue_) {
  loadStateFile();
  advertise();
  const std::lock_guard<std::mutex> lock(mutex_);
  publishStatus();
}

BatterySofNode::~BatterySofNode() {
  worker_.stop();
  identify_spinner_.stop();
}

void BatterySofNode::advertise() {
  status_publisher_ = private_node_.advertise<SofStatus>("status", 10, true);
  model_publisher_ = private_node_.advertise<IdentifiedModel>("model", 10, true);
  predict_cranking_ =
      private_node_.advertiseService("predict_cranking", &BatterySofNode::onPredictCranking, this);
  simulate_profile_ =
      private_node_.advertiseService("simulate_profile", &BatterySofNode::onSimulateProfile, this);
  ros::NodeHandle waiting_node(private_node_);
  waiting_node.setCallbackQueue(&identify_queue_);
  identify_ = waiting_node.advertiseService("identify", &BatterySofNode::onIdentify, this);
  identify_spinner_.start();
  subscriber_ = node_.subscribe(kDefaultTopic, kQueueSize, &BatterySofNode::onBatteryState, this,
                                ros::TransportHints().tcpNoDelay());
  wall_timer_ =
      node_.createWallTimer(ros::WallDuration(kStatusPeriod), &BatterySofNode::onWallTimer, this);
}

// ----------------------------------------------------------------------------------------------------
// state file

void BatterySofNode::loadStateFile() {
  if (options_.state_file.empty()) return;
  if (!std::filesystem::exists(options_.state_file)) {
    ROS_INFO("no saved model in %s yet", options_.state_file.c_str());
    return;
  }
  try {
    session_.restore(readModelFile(options_.state_file));
    ROS_INFO("read the saved model in %s", options_.state_file.c_str());
  } catch (const std::exception& error) {
    state_file_fault_ = error.what();
    ROS_WARN("the saved model is not used: %s", error.what());
  }
}

void BatterySofNode::saveStateFile(const FittedModel& model) {
  if (options_.state_file.empty()) return;
  std::string fault;
  try {
    const std::filesystem::path path(options_.state_file);
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path());
    writeModelFile(path, model);
  } catch (const std::exception& error) {
    fault = std::string("the model cannot be saved: ") + error.what();
    ROS_ERROR("%s", fault.c_str());
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  state_file_fault_ = fault;
}

// ----------------------------------------------------------------------------------------------------
// samples

void BatterySofNode::onBatteryState(const sensor_msgs::BatteryStateConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  last_arrival_ = ros::Time::now();
  const SessionEvents events = session_.push(rawSampleOf(*message));
  for (const CrankComparison& crank : events.cranks) {
    cranks_.add(crank);
    logCrank(crank);
  }
  if (auto job = session_.takeDueJob()) {
    ROS_INFO("identification begins on %zu samples", job->series.size());
    worker_.post(std::move(*job));
  }
  if (isStatusDue()) publishStatus();
}

void BatterySofNode::logCrank(const CrankComparison& crank) const {
  const Interval& expected = crank.expected_minimum;
  std::string answered = "no query was answered before";
  if (last_answer_) {
    char text[160];
    std::snprintf(text, sizeof(text),
                  "the last answer, %.1f s before for %.0f A, was %.2f V [%.2f, %.2f]",
                  crank.time - last_answer_->time, last_answer_->query.i_cranking,
                  last_answer_->u_min.value, last_answer_->u_min.lower, last_answer_->u_min.upper);
    answered = text;
  }
  ROS_INFO(
      "crank at %.2f s, %.0f A: measured %.2f V; expected of this current %.2f V [%.2f, %.2f]; %s",
      crank.time, crank.current, crank.measured_minimum, expected.value, expected.lower,
      expected.upper, answered.c_str());
}

// ----------------------------------------------------------------------------------------------------
// status

bool BatterySofNode::isStatusDue() const {
  const std::optional<double> newest = session_.newestTime();
  if (!newest) return false;
  if (!last_status_time_ || *newest < *last_status_time_) return true;
  return *newest - *last_status_time_ >= kStatusPeriod;
}

std::optional<double> BatterySofNode::noDataFor() const {
  if (!last_arrival_) return std::nullopt;
  const double silent = (ros::Time::now() - *last_arrival_).toSec();
  return silent > kNoDataAfter ? std::optional<double>(silent) : std::nullopt;
}

SessionStatus BatterySofNode::statusNow() const {
  SessionStatus status = session_.status();
  if (const auto silent = noDataFor()) {
    status.state = SessionState::kNoSample;
    status.reason = "no sample for " + std::to_string(std::lround(*silent)) + " s";
  }
  return status;
}

void BatterySofNode::publishStatus() {
  StatusContents contents;
  contents.session = statusNow();
  contents.counts = session_.counts();
  contents.standing_query = options_.standing_query;
  contents.standing_answer = session_.predictCranking(options_.standing_query);
  contents.last_crank = cranks_.last;
  contents.cranks = cranks_.count;
  SofStatus message = messageOf(contents);
  const std::optional<double> newest = contents.session.newest_time;
  message.header.stamp = newest ? rosTime(*newest) : ros::Time::now();
  status_publisher_.publish(message);
  last_status_time_ = newest;
  last_status_wall_ = ros::WallTime::now();
}

void BatterySofNode::onWallTimer(const ros::WallTimerEvent&) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const ros::WallDuration since = ros::WallTime::now() - last_status_wall_;
    if (since.toSec() >= kStatusPeriod) publishStatus();
  }
  diagnostics_.publish();
}

DiagnosticsSnapshot BatterySofNode::snapshot() {
  const std::lock_guard<std::mutex> lock(mutex_);
  DiagnosticsSnapshot snapshot;
  snapshot.status = statusNow();
  snapshot.counts = session_.counts();
  snapshot.fit_ms = fit_ms_;
  snapshot.no_data_for = noDataFor();
  snapshot.cranks = cranks_;
  snapshot.state_file = options_.state_file.empty() ? "off" : options_.state_file;
  snapshot.state_file_fault = state_file_fault_;
  return snapshot;
}

// ----------------------------------------------------------------------------------------------------
// queries

bool BatterySofNode::onPredictCranking(PredictCranking::Request& request,
                                       PredictCranking::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const CrankingQuery query = queryOf(request);
  const CrankingAnswer answer = session_.predictCranking(query);
  remember(query, answer);
  response = responseOf(answer);
  return true;
}

void BatterySofNode::remember(const CrankingQuery& query, const CrankingAnswer& answer) {
  if (!answer.u_min) {
    ROS_DEBUG("crank query not answered (%s): %s", describe(answer.code).c_str(),
              answer.message.c_str());
    return;
  }
  const double time = session_.newestTime().value_or(0.0);
  last_answer_ = Answered{time, query, *answer.u_min};
  ROS_INFO(
      "crank query at %.2f s: %.1f A for %.1f s, then %.0f A for %.2f s: lowest %.2f V [%.2f, "
      "%.2f], %s",
      time, query.i_load, query.t_stop, query.i_cranking, query.t_cranking, answer.u_min->value,
      answer.u_min->lower, answer.u_min->upper, describe(answer.code).c_str());
}

bool BatterySofNode::onSimulateProfile(SimulateProfile::Request& request,
                                       SimulateProfile::Response& response) {
  std::optional<ProfileAnswer> answer;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    answer = session_.simulateProfile(request.time, request.current);
  }
  response = responseOf(*answer);
  return true;
}

// ----------------------------------------------------------------------------------------------------
// identification

IdentificationOutcome BatterySofNode::onIdentified(IdentificationResult result) {
  IdentificationOutcome outcome;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (result.model) {
      result.model->recording = subscriber_.getTopic();
      fit_ms_ = result.model->fit_ms;
    }
    outcome = session_.finish(std::move(result));
    publishStatus();
  }
  if (!outcome.accepted) {
    ROS_INFO("identification refused: %s", outcome.message.c_str());
    return outcome;
  }
  ROS_INFO("identification accepted: %s", outcome.message.c_str());
  model_publisher_.publish(messageOf(*outcome.model));
  saveStateFile(*outcome.model);
  return outcome;
}

std::optional<std::future<IdentificationOutcome>> BatterySofNode::postRequested() {
  while (ros::ok()) {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (auto job = session_.takeJob()) return worker_.post(std::move(*job));
      if (!session_.isJobOut()) return std::nullopt;
    }
    worker_.waitUntilIdle();
  }
  return std::nullopt;
}

bool BatterySofNode::onIdentify(Identify::Request&, Identify::Response& response) {
  auto outcome = postRequested();
  if (!outcome) {
    response.code = Identify::Response::NO_DATA;
    response.message = "no samples are buffered yet";
    return true;
  }
  try {
    response = responseOf(outcome->get());
  } catch (const std::future_error&) {
    response.code = Identify::Response::REFUSED;
    response.message = "the node is shutting down";
  }
  return true;
}

}  // namespace battery_sof

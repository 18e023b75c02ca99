#include "battery_sof/ros/battery_sof_node.hpp"

#include <boost/make_shared.hpp>
#include <cmath>
#include <filesystem>
#include <functional>
#include <utility>

#include "battery_sof/bag/bag_storage.hpp"
#include "battery_sof/bag/battery_state_message.hpp"
#include "battery_sof/report/model_yaml.hpp"
#include "battery_sof/ros/background_work.hpp"

namespace battery_sof {

namespace {

constexpr std::uint32_t kQueueSize = 100000;  // 20 s of a 100 Hz bag played at 50x
constexpr double kStatusPeriod = 1.0;         // [s], SofStatus is a 1 Hz topic
constexpr double kNoDataAfter = 5.0;          // [s], the shortest gap of a recording (gapThreshold)

constexpr int kPatientThreads = 2;            // a map does not wait for a fit
constexpr int kDiagnoseThreads = 2;           // a second request is refused while the first waits
constexpr int kNice = 10;                     // of identifications: the other threads go first

/// Calls a function once from a callback queue.
class Errand : public ros::CallbackInterface {
 public:
  explicit Errand(std::function<void()> work) : work_(std::move(work)) {}
  CallResult call() override {
    work_();
    return Success;
  }

 private:
  std::function<void()> work_;
};

/// Adds the time it lived to the queries' times.
class QueryTimer {
 public:
  explicit QueryTimer(ResponseClock& clock) : clock_(clock) {}
  QueryTimer(const QueryTimer&) = delete;
  QueryTimer& operator=(const QueryTimer&) = delete;
  ~QueryTimer() { clock_.addQuery(1e3 * (ros::WallTime::now() - begun_).toSec()); }

 private:
  ResponseClock& clock_;
  ros::WallTime begun_ = ros::WallTime::now();
};

}  // namespace

BatterySofNode::BatterySofNode(ros::NodeHandle node, ros::NodeHandle private_node,
                               NodeOptions options)
    : options_(std::move(options)),
      node_(std::move(node)),
      private_node_(std::move(private_node)),
      session_(options_.session),
      worker_([this](const IdentificationJob& job) { return onIdentified(job); }, kNice),
      diagnoses_(private_node_,
                 {options_.diagnose_period, options_.session.identify_period, options_.adopt_diagnosis},
                 [this](const Adoption& adoption, double from_driving) {
                   onAdopted(adoption, from_driving);
                 }),
      diagnostics_([this] { return snapshot(); }),
      question_spinner_(1, &question_queue_),
      patient_spinner_(kPatientThreads, &patient_queue_),
      diagnose_spinner_(kDiagnoseThreads, &diagnose_queue_) {
  loadStateFile();
  advertise();
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    demandStatus();
  }
  question_spinner_.start();
  patient_spinner_.start();
  diagnose_spinner_.start();
}

BatterySofNode::~BatterySofNode() {
  diagnoses_.stop();
  worker_.stop();
  question_spinner_.stop();
  patient_spinner_.stop();
  diagnose_spinner_.stop();
}

template <typename Service>
ros::ServiceServer BatterySofNode::serve(
    const char* name, ros::CallbackQueue& queue,
    bool (BatterySofNode::*callback)(typename Service::Request&, typename Service::Response&)) {
  ros::NodeHandle node(private_node_);
  node.setCallbackQueue(&queue);
  return node.advertiseService(name, callback, this);
}

void BatterySofNode::advertise() {
  status_publisher_ = private_node_.advertise<SofStatus>("status", 10, true);
  model_publisher_ = private_node_.advertise<IdentifiedModel>("model", 10, true);
  using Node = BatterySofNode;
  services_ = {
      serve<PredictCranking>("predict_cranking", question_queue_, &Node::onPredictCranking),
      serve<PredictStopTime>("predict_stop_time", question_queue_, &Node::onPredictStopTime),
      serve<PredictChargeAcceptance>("predict_charge_acceptance", question_queue_,
                                     &Node::onPredictChargeAcceptance),
      serve<PredictMap>("predict_map", patient_queue_, &Node::onPredictMap),
      serve<SimulateProfile>("simulate_profile", patient_queue_, &Node::onSimulateProfile),
      serve<Identify>("identify", patient_queue_, &Node::onIdentify),
      serve<Diagnose>("diagnose", diagnose_queue_, &Node::onDiagnose)};
  subscriber_ = node_.subscribe(kDefaultTopic, kQueueSize, &BatterySofNode::onBatteryState, this,
                                ros::TransportHints().tcpNoDelay());
  ros::NodeHandle question_node(node_);
  question_node.setCallbackQueue(&question_queue_);
  wall_timer_ = question_node.createWallTimer(ros::WallDuration(kStatusPeriod),
                                              &BatterySofNode::onWallTimer, this);
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

void BatterySofNode::onBatteryState(const SampleEvent& event) {
  const ros::WallTime begun = ros::WallTime::now();
  // The receipt is on ROS time; what is simulated is no measure of a delay.
  const double waited =
      ros::Time::isSystemTime() ? (ros::Time::now() - event.getReceiptTime()).toSec() : 0.0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    take(rawSampleOf(*event.getConstMessage()));
  }
  response_clock_.addSample(1e3 * (waited + (ros::WallTime::now() - begun).toSec()));
}

void BatterySofNode::take(const RawSample& sample) {
  last_arrival_ = ros::Time::now();
  const SessionEvents events = session_.push(sample);
  events_.add(events);
  for (const CrankComparison& crank : events.cranks) logCrank(crank);
  if (auto job = session_.takeDueJob()) {
    ROS_INFO("identification begins on %zu samples", job->series.size());
    worker_.post(std::move(*job));
  }
  diagnoses_.beginIfDue(session_.series(), subscriber_.getTopic(), session_.driving());
  announceWhoAnswers();
  if (isStatusDue()) demandStatus();
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

void BatterySofNode::announceWhoAnswers() {
  if (session_.doesExtendedAnswer() == extended_answered_) return;
  extended_answered_ = session_.doesExtendedAnswer();
  const std::optional<FittedModel> model = session_.model();
  if (!model) return;
  ROS_INFO("%s", session_.status().extension.c_str());
  question_queue_.addCallback(boost::make_shared<Errand>(
      [this, model] { model_publisher_.publish(messageOf(*model)); }));
}

// ----------------------------------------------------------------------------------------------------
// status

bool BatterySofNode::isStatusDue() const {
  const std::optional<double> newest = session_.newestTime();
  if (!newest) return false;
  if (!last_status_time_ || *newest < *last_status_time_) return true;
  // With the first sample of each period: the same stamps however fast a bag is played.
  return std::floor(*newest / kStatusPeriod) > std::floor(*last_status_time_ / kStatusPeriod);
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

void BatterySofNode::demandStatus() {
  StatusContents contents;
  contents.session = statusNow();
  contents.counts = session_.counts();
  contents.standing = options_.standing;
  contents.events = events_;
  contents.events.crank_scale = session_.crankScale();
  contents.events.charge_scale = session_.chargeScale();
  last_status_time_ = contents.session.newest_time;
  last_status_wall_ = ros::WallTime::now();
  const bool is_waiting = due_status_.has_value();
  due_status_.emplace(DueStatus{std::move(contents), session_.live()});
  if (!is_waiting)
    question_queue_.addCallback(boost::make_shared<Errand>([this] { publishDueStatus(); }));
}

void BatterySofNode::publishDueStatus() {
  std::optional<DueStatus> due;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    due = std::exchange(due_status_, std::nullopt);
  }
  if (!due) return;
  due->contents.answers = answersTo(options_.standing, due->model);
  SofStatus message = messageOf(due->contents);
  const std::optional<double> newest = due->contents.session.newest_time;
  message.header.stamp = newest ? rosTime(*newest) : ros::Time::now();
  status_publisher_.publish(message);
}

void BatterySofNode::onWallTimer(const ros::WallTimerEvent&) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    const ros::WallDuration since = ros::WallTime::now() - last_status_wall_;
    if (since.toSec() >= kStatusPeriod) demandStatus();
  }
  diagnostics_.publish();
}

DiagnosticsSnapshot BatterySofNode::snapshot() {
  DiagnosticsSnapshot snapshot;
  snapshot.response_times = response_clock_.report();
  snapshot.diagnosis = diagnoses_.line();
  const std::lock_guard<std::mutex> lock(mutex_);
  snapshot.status = statusNow();
  snapshot.counts = session_.counts();
  snapshot.fit_ms = fit_ms_;
  snapshot.no_data_for = noDataFor();
  snapshot.events = events_;
  snapshot.events.crank_scale = session_.crankScale();
  snapshot.events.charge_scale = session_.chargeScale();
  snapshot.state_file = options_.state_file.empty() ? "off" : options_.state_file;
  snapshot.state_file_fault = state_file_fault_;
  return snapshot;
}

// ----------------------------------------------------------------------------------------------------
// queries

LiveModel BatterySofNode::live() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return session_.live();
}

bool BatterySofNode::onPredictCranking(PredictCranking::Request& request,
                                       PredictCranking::Response& response) {
  const QueryTimer timer(response_clock_);
  const CrankingQuery query = queryOf(request);
  const LiveModel model = live();
  const CrankingAnswer answer = model.predictCranking(query);
  if (answer.u_min) {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_answer_ = Answered{model.model().state.time, query, *answer.u_min};
  }
  ROS_DEBUG("crank query at %.2f s (%s): %s", model.model().state.time, describe(answer.code).c_str(),
            answer.message.c_str());
  response = responseOf(answer);
  return true;
}

bool BatterySofNode::onPredictStopTime(PredictStopTime::Request& request,
                                       PredictStopTime::Response& response) {
  const QueryTimer timer(response_clock_);
  response = responseOf(live().predictStopTime(queryOf(request)));
  return true;
}

bool BatterySofNode::onPredictChargeAcceptance(PredictChargeAcceptance::Request& request,
                                               PredictChargeAcceptance::Response& response) {
  const QueryTimer timer(response_clock_);
  response = responseOf(live().predictChargeAcceptance(queryOf(request)));
  return true;
}

bool BatterySofNode::onPredictMap(PredictMap::Request& request, PredictMap::Response& response) {
  response = mapsOf(live(), request);
  return true;
}

bool BatterySofNode::onSimulateProfile(SimulateProfile::Request& request,
                                       SimulateProfile::Response& response) {
  response = responseOf(live().simulateProfile(request.time, request.current));
  return true;
}

// ----------------------------------------------------------------------------------------------------
// identification

IdentificationOutcome BatterySofNode::onIdentified(const IdentificationJob& job) {
  const IdentificationOutcome outcome = takeBack(timedIdentification(job));
  ROS_INFO("identification %s: %s", outcome.accepted ? "accepted" : "refused",
           outcome.message.c_str());
  if (outcome.accepted) {
    model_publisher_.publish(messageOf(*outcome.model));
    saveStateFile(*outcome.model);
  }
  if (outcome.extended) model_publisher_.publish(messageOf(*outcome.extended));
  return outcome;
}

IdentificationOutcome BatterySofNode::takeBack(IdentificationResult result) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (result.model) {
    result.model->recording = subscriber_.getTopic();
    fit_ms_ = result.model->fit_ms;
  }
  if (result.extended && result.extended->model)
    result.extended->model->recording = subscriber_.getTopic();
  IdentificationOutcome outcome = session_.finish(std::move(result));
  announceWhoAnswers();
  demandStatus();
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

// ----------------------------------------------------------------------------------------------------
// diagnosis

void BatterySofNode::onAdopted(const Adoption& adoption, double from_driving) {
  const std::lock_guard<std::mutex> lock(mutex_);
  session_.extendWith(adoption.effects, from_driving, adoption.force);
}

std::optional<std::future<DiagnosisRunner::Outcome>> BatterySofNode::beginDiagnosis(
    Diagnose::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (session_.series().empty()) {
    response.code = Diagnose::Response::NO_DATA;
    response.message = "no samples are buffered yet";
    return std::nullopt;
  }
  auto running = diagnoses_.begin(session_.series(), subscriber_.getTopic());
  if (running) return running;
  response.code = Diagnose::Response::BUSY;
  response.message = "a diagnosis is running; its result will be on ~diagnosis";
  return std::nullopt;
}

bool BatterySofNode::onDiagnose(Diagnose::Request&, Diagnose::Response& response) {
  auto running = beginDiagnosis(response);
  if (!running) return true;
  try {
    response = responseOf(running->get());
  } catch (const std::future_error&) {
    response.code = Diagnose::Response::FAILED;
    response.message = "the node is shutting down";
  }
  return true;
}

}  // namespace battery_sof

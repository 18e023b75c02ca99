#include "ros/battery_sof_node.hpp"

#include <atomic>
#include <boost/make_shared.hpp>
#include <chrono>
#include <cmath>
#include <functional>
#include <future>
#include <memory>
#include <utility>

#include "bag/bag_storage.hpp"
#include "ros/background_work.hpp"
#include "util/text.hpp"

namespace battery_sof {

namespace {

constexpr std::uint32_t kQueueSize = 100000;  // 20 s of a 100 Hz bag played at 50x
constexpr double kStatusPeriod = 1.0;         // [s], SofStatus is a 1 Hz topic
constexpr double kNoDataAfter = 5.0;          // [s], the shortest gap of a recording (gapThreshold)

// [s] of the process' own time between two saves of the state file: after an event, and without one
constexpr double kSaveAfterEvent = 10.0, kSaveInAnyCase = 50.0;

constexpr int kIdentificationNice = 10;  // of identifications: the other threads go first
constexpr std::chrono::milliseconds kLook{50};

/// [s]; a ros::Duration holds 2^31 s, and throws where a clock jumps further.
double secondsBetween(const ros::Time& from, const ros::Time& to) {
  return to.toSec() - from.toSec();
}

/// Calls a function once, on the thread of a queue.
void callFrom(ros::CallbackQueue& queue, std::function<void()> work) {
  struct Errand : ros::CallbackInterface {
    explicit Errand(std::function<void()> of) : work(std::move(of)) {}
    CallResult call() override {
      work();
      return Success;
    }
    std::function<void()> work;
  };
  queue.addCallback(boost::make_shared<Errand>(std::move(work)));
}

}  // namespace

BatterySofNode::BatterySofNode(const ros::NodeHandle& node, const ros::NodeHandle& private_node,
                               NodeOptions options)
    : options_(std::move(options)),
      state_file_(options_.state_file),
      node_(node),
      private_node_(private_node),
      session_(options_.session),
      worker_(kIdentificationNice),
      saver_(kIdentificationNice),
      diagnoses_(private_node_, options_,
                 [this](const Adoption& adoption, double from_driving) {
                   onQueryThread([&] {
                     session_.fitWith(adoption.effects, from_driving, adoption.discrepancy);
                   });
                 }),
      changes_(private_node_, options_.change_period),
      identify_server_(
          actions_.handleOf(private_node_), "identify",
          [this](const IdentifyServer::GoalHandle& goal) { onIdentifyGoal(goal); },
          [this](const IdentifyServer::GoalHandle& goal) { onIdentifyCancel(goal); }),
      diagnose_server_(
          actions_.handleOf(private_node_), "diagnose",
          [this](const DiagnoseServer::GoalHandle& goal) { onDiagnoseGoal(goal); },
          [this](const DiagnoseServer::GoalHandle& goal) { diagnoses_.cancel(goal); }) {
  loadStateFile();
  advertise();
  guarded("the first status", [this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    demandStatus();
  });
  for (QueueThread* thread : {&questions_, &maps_, &profiles_, &actions_}) thread->spinner.start();
}

BatterySofNode::~BatterySofNode() {
  // First of all: what follows may wait for a computation, and the shutdown limit ends the process.
  saver_.stop();  // with what it has not begun
  guarded("the last save", [this] {
    std::optional<FittedModel> model;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      model = modelToSave();
    }
    if (!model) return;
    const StateFile::Result result = state_file_.save(*model);
    if (result.is_fault) ROS_ERROR("%s", result.said.c_str());
  });
  diagnoses_.stop();
  worker_.stop();
  for (QueueThread* thread : {&questions_, &maps_, &profiles_, &actions_}) thread->spinner.stop();
}

void BatterySofNode::onQueryThread(const std::function<void()>& work) {
  const auto task = std::make_shared<std::packaged_task<void()>>([this, &work] {
    const std::lock_guard<std::mutex> lock(mutex_);
    work();
  });
  const auto is_taken = std::make_shared<std::atomic_flag>();
  const auto once = [task, is_taken] {
    if (!is_taken->test_and_set()) (*task)();
  };
  std::future<void> done = task->get_future();
  callFrom(questions_.queue, once);
  while (done.wait_for(kLook) != std::future_status::ready)
    if (!ros::ok()) once();  // nobody calls the queue any more
  done.get();
}

void BatterySofNode::advertise() {
  status_publisher_ = private_node_.advertise<SofStatus>("status", 10, true);
  model_publisher_ = private_node_.advertise<IdentifiedModel>("model", 10, true);
  advertiseQuestions();
  identify_server_.begin();
  diagnose_server_.begin();
  subscriber_ = node_.subscribe(kDefaultTopic, kQueueSize, &BatterySofNode::onBatteryState, this,
                                ros::TransportHints().tcpNoDelay());
  steady_timer_ = questions_.handleOf(node_).createSteadyTimer(
      ros::WallDuration(kStatusPeriod), &BatterySofNode::onSteadyTimer, this);
}

// ----------------------------------------------------------------------------------------------------
// state file

void BatterySofNode::loadStateFile() {
  const StateFile::Result result = state_file_.read();
  if (result.is_fault) {
    record_.state_file_fault = result.said;
    ROS_WARN("%s", result.said.c_str());
  } else if (!result.said.empty()) {
    ROS_INFO("%s", result.said.c_str());
  }
  if (!result.model) return;
  session_.restore(*result.model);
  changes_.restore(result.model->responses, node_.resolveName(kDefaultTopic));
  battery_.expect(result.model->provenance.serial_number);
  stands_on_state_file_ = true;
}

void BatterySofNode::saveStateFile(const FittedModel& model) {
  const StateFile::Result result = state_file_.save(model);
  if (result.is_fault) ROS_ERROR("%s", result.said.c_str());
  onQueryThread([&] { record_.state_file_fault = result.said; });
}

std::optional<FittedModel> BatterySofNode::modelToSave() const {
  std::optional<FittedModel> model = session_.modelToSave();
  if (!model) return model;
  model->provenance.serial_number = battery_.serialNumber();
  model->responses = changes_.responses();
  return model;
}

void BatterySofNode::save(bool at_once) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double since = (ros::SteadyTime::now() - unsaved_.since).toSec();
  const bool is_early = since < (unsaved_.events ? kSaveAfterEvent : kSaveInAnyCase);
  if (!unsaved_.samples || (is_early && !at_once)) return;
  std::optional<FittedModel> model = modelToSave();
  if (!model) return;
  unsaved_ = {};
  saver_.post([this, model = std::move(*model)] {
    guarded("saving the state file", [&] { saveStateFile(model); });
  });
}

// ----------------------------------------------------------------------------------------------------
// faults

void BatterySofNode::noteFault(const char* what, const char* why) {
  ROS_ERROR_THROTTLE(1.0, "%s failed: %s", what, printable(why).c_str());
  const std::lock_guard<std::mutex> lock(mutex_);
  ++record_.internal_faults;
  record_.internal_fault = std::string(what) + " failed: " + printable(why);
}

void BatterySofNode::beginAnew(const char* why) {
  session_.beginAnew();
  const std::string aside = stands_on_state_file_ ? state_file_.setAside() : "";
  stands_on_state_file_ = false;
  if (!aside.empty())
    record_.state_file_fault =
        "the saved model could not be followed: " + printable(why) + "; " + aside;
}

// ----------------------------------------------------------------------------------------------------
// samples

void BatterySofNode::onBatteryState(const SampleEvent& event) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  // The receipt is on ROS time; what is simulated is no measure of a delay.
  const double waited =
      ros::Time::isSystemTime() ? secondsBetween(event.getReceiptTime(), ros::Time::now()) : 0.0;
  guarded("taking a sample", [&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    try {
      take(*event.getConstMessage());
    } catch (const std::exception& error) {
      beginAnew(error.what());
      throw;
    }
  });
  response_clock_.addSample(1e3 * (waited + (ros::SteadyTime::now() - begun).toSec()));
}

void BatterySofNode::take(const sensor_msgs::BatteryState& message) {
  const BatteryIdentity::Sample sample = battery_.observe(message);
  if (sample == BatteryIdentity::Sample::kOfNone) return;
  if (sample == BatteryIdentity::Sample::kOfOther) beginOtherBattery();
  if (!options_.session.capacity) session_.setCapacity(battery_.designCapacity());
  push(rawSampleOf(message));
}

void BatterySofNode::beginOtherBattery() {
  record_.other_battery =
      "the serial number changed to " + battery_.serialNumber() + ": another battery is followed";
  ROS_WARN("%s", record_.other_battery.c_str());
  session_.beginAnew();
  changes_.forget(subscriber_.getTopic());
  if (stands_on_state_file_)
    ROS_WARN("the saved model belongs to the previous battery: %s", state_file_.setAside().c_str());
  stands_on_state_file_ = false;
}

void BatterySofNode::push(const RawSample& sample) {
  last_arrival_ = ros::Time::now();
  const std::size_t deep_discharges = session_.deepDischarges().count();
  const SessionEvents events = session_.push(sample);
  record_.events.add(events);
  unsaved_.samples = true;
  if (!events.cranks.empty() || !events.charges.empty() || !events.stops.empty())
    unsaved_.events = true;
  if (session_.deepDischarges().count() > deep_discharges)
    ROS_WARN("%s", session_.status().deep_discharge.c_str());
  for (const EventComparison& crank : events.cranks) logCrank(crank);
  if (auto job = session_.takeDueJob()) {
    ROS_INFO("starting an identification on %zu samples", job->series.size());
    worker_.post([this, job = std::move(*job)] { onIdentification(job, 0); });
  }
  diagnoses_.beginIfDue(session_.series(), subscriber_.getTopic(), session_.driving());
  changes_.beginIfDue(session_.series(), subscriber_.getTopic(), session_.driving());
  if (isStatusDue()) demandStatus();
}

void BatterySofNode::logCrank(const EventComparison& crank) const {
  const Interval& expected = crank.expected;
  std::string answered = "no query was answered before it";
  if (last_answer_) {
    const Interval& u_min = last_answer_->u_min;
    answered = format("the last answer, %.1f s earlier and for %.0f A, was %.2f V [%.2f, %.2f]",
                      crank.time - last_answer_->time, last_answer_->query.i_cranking, u_min.value,
                      u_min.lower, u_min.upper);
  }
  ROS_INFO(
      "crank at %.2f s: measured %.2f V at %.0f A, for which %.2f V [%.2f, %.2f] was expected; %s",
      crank.time, crank.measured, crank.current, expected.value, expected.lower, expected.upper,
      answered.c_str());
}

// ----------------------------------------------------------------------------------------------------
// identifications

void BatterySofNode::onIdentification(const IdentificationJob& job, int request) {
  IdentifyResult result;
  result.code = IdentifyResult::REFUSED;
  result.message = "the identification failed; /diagnostics says why";
  guarded("the identification", [&] { result = resultOf(identified(job, request != 0)); });
  callFrom(actions_.queue, [this, result, request] {
    guarded("the identification", [&] { endRequested(request, result); });
  });
}

IdentificationOutcome BatterySofNode::identified(const IdentificationJob& job, bool is_requested) {
  const ros::SteadyTime begun = ros::SteadyTime::now();
  IdentificationResult result = runIdentification(job);
  const double fit_ms = 1e3 * (ros::SteadyTime::now() - begun).toSec();
  if (result.model) result.model->provenance.fit_ms = fit_ms;
  IdentificationOutcome outcome;
  onQueryThread([&] { outcome = takenBack(std::move(result), is_requested); });
  ROS_INFO("identification %s: %s", outcome.accepted ? "accepted" : "refused",
           outcome.message.c_str());
  if (outcome.accepted) {
    model_publisher_.publish(messageOf(*outcome.model));
    save(true);
  }
  return outcome;
}

IdentificationOutcome BatterySofNode::takenBack(IdentificationResult result, bool is_requested) {
  if (is_requested && !std::exchange(is_request_wanted_, false)) {
    result.model.reset();
    result.message = "the goal was cancelled";
  }
  if (result.model) {
    result.model->provenance.recording = subscriber_.getTopic();
    record_.fit_ms = result.model->provenance.fit_ms;
  }
  IdentificationOutcome outcome = session_.finish(std::move(result));
  if (outcome.accepted) stands_on_state_file_ = false;
  demandStatus();
  return outcome;
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
  const double silent = secondsBetween(*last_arrival_, ros::Time::now());
  return silent > kNoDataAfter ? std::optional<double>(silent) : std::nullopt;
}

SessionStatus BatterySofNode::statusNow() const {
  SessionStatus status = session_.status();
  if (!battery_.whyNone().empty()) {
    status.state = SessionState::kNoSample;
    status.reason = battery_.whyNone();
  } else if (const auto silent = noDataFor()) {
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
  contents.standing.charge = options_.standing.chargeAt(session_.chargeVoltage());
  contents.events = record_.events;
  contents.events.calibrations = session_.calibrations();
  last_status_time_ = contents.session.newest_time;
  last_status_steady_ = ros::SteadyTime::now();
  const bool is_waiting = due_status_.has_value();
  contents.model = session_.live();
  due_status_ = std::move(contents);
  if (!is_waiting)
    callFrom(questions_.queue, [this] { guarded("the status", [this] { publishDueStatus(); }); });
}

void BatterySofNode::publishDueStatus() {
  std::optional<StatusContents> due;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    due = std::exchange(due_status_, std::nullopt);
  }
  if (!due) return;
  SofStatus message = messageOf(*due);
  const std::optional<double> newest = due->session.newest_time;
  message.header.stamp = newest ? rosTime(*newest) : ros::Time::now();
  status_publisher_.publish(message);
}

void BatterySofNode::onSteadyTimer(const ros::SteadyTimerEvent&) {
  guarded("the status timer", [this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    const ros::WallDuration since = ros::SteadyTime::now() - last_status_steady_;
    if (since.toSec() >= kStatusPeriod) demandStatus();
  });
  guarded("the state file", [this] { save(false); });
  guarded("the diagnostics", [this] {
    // Half a timer's period: a late timer shifts none.
    const double since = (ros::SteadyTime::now() - last_diagnostics_steady_).toSec();
    if (since < options_.diagnostic_period - 0.5 * kStatusPeriod) return;
    last_diagnostics_steady_ = ros::SteadyTime::now();
    diagnostics_.publish(snapshot());
  });
}

DiagnosticsSnapshot BatterySofNode::snapshot() {
  DiagnosticsSnapshot snapshot;
  snapshot.response_times = response_clock_.report();
  snapshot.diagnosis = diagnoses_.line();
  const std::lock_guard<std::mutex> lock(mutex_);
  snapshot.status = statusNow();
  snapshot.counts = session_.counts();
  snapshot.no_data_for = noDataFor();
  static_cast<NodeRecord&>(snapshot) = record_;
  snapshot.events.calibrations = session_.calibrations();
  snapshot.state_file = options_.state_file.empty() ? "off" : options_.state_file;
  snapshot.battery = battery_;
  snapshot.capacity = session_.capacity();
  const std::string& name =
      options_.battery_name.empty() ? battery_.serialNumber() : options_.battery_name;
  snapshot.hardware_id = name.empty() ? "battery" : name;
  return snapshot;
}

}  // namespace battery_sof

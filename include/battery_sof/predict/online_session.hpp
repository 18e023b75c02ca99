#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "battery_sof/predict/charge_watch.hpp"
#include "battery_sof/predict/crank_watch.hpp"
#include "battery_sof/predict/identification_job.hpp"
#include "battery_sof/predict/interval_scale.hpp"
#include "battery_sof/predict/live_model.hpp"
#include "battery_sof/predict/sample_stream.hpp"
#include "battery_sof/predict/state_tracker.hpp"

namespace battery_sof {

/// Settings of a session.
struct SessionOptions {
  double buffer = 1800.0;               ///< [s], past kept for identification
  std::optional<double> window_length;  ///< [s]; else defaultWindowLength()
  double min_suitability = 0.2;         ///< [0, 1], a window below it is not fitted
  double identify_period = 600.0;       ///< [s] of driving between identifications
  double retry_period = 60.0;           ///< [s] of driving between tries while there is no model
  double model_max_age =
      3600.0;              ///< [s] from the window's end; the paper's predictions hold for minutes
  double capacity = 50.0;  ///< [Ah], nominal
  EventLimits events;
  IdentifyOptions identify;
};

/// What the session can do at present.
enum class SessionState { kNoSample, kCollecting, kIdentifying, kReady, kStale };

/// How the model in use has done since it was accepted.
struct BacktestScore {
  std::optional<double>
      q_dyn_percent;      ///< paper, eq. 6, open loop; none until the voltage has varied
  double duration = 0.0;  ///< [s], from the first to the last sample compared
};

/// What ended with a sample and was set beside the model's expectation.
struct SessionEvents {
  std::vector<CrankComparison> cranks;
  std::vector<ChargeComparison> charges;
};

/// A summary for a status message.
struct SessionStatus {
  SessionState state = SessionState::kNoSample;
  std::string reason;                 ///< one sentence
  std::optional<double> newest_time;  ///< [s]
  std::optional<double> model_age;    ///< [s] from the window's end to the newest sample
  std::optional<double> suitability;  ///< [0, 1], of the model's window
  BacktestScore backtest;
};

/// What came of a finished identification.
struct IdentificationOutcome {
  bool accepted = false;
  std::string message;  ///< one sentence
  std::optional<FittedModel>
      model;  ///< accepted: state at the newest sample; refused: the candidate, if there was one
};

/**
 * @brief What a node does with samples: without threads, clocks or ROS. Time is the samples' own.
 *
 * Samples go in one by one; a StateTracker carries the model's state along. When an identification
 * is due, the session hands out a self-contained job; the caller runs it wherever it likes and
 * brings the result back. At most one job is out at a time.
 *
 * Due: without a model, once the newest stretch without a gap is a window long, holds charge and
 * discharge and is suitable enough (looked at every 10 s of driving, tried at most every
 * retry_period); with a model, every identify_period of driving. Driving is the sum of sampling
 * intervals without the gaps.
 *
 * Accepted: a usable fit whose r_discharge and u_dc are determined (a crank's voltage is u_dc +
 * r_discharge i + u_c2, and u_c2's share is the smallest), and whose error on the most recent
 * window is at most 1.1 times that of the model in use, unless that is too old. A refused model
 * leaves the old one in use.
 *
 * Periods count from when a job was taken, and what happened since is judged by the new model once it is accepted: how
 * long an identification takes changes no answer after it.
 *
 * Clock jump back (SampleStream): the past and the state are begun anew, the model stays with its
 * age, and the result of a job from before is dropped.
 */
class OnlineSession {
 public:
  /// @throws std::invalid_argument for options that are not finite or outside their domain.
  explicit OnlineSession(SessionOptions options = {});

  /// Offers one sample. @return the cranks and charges that ended; while a job is out they wait for its result.
  SessionEvents push(const RawSample& sample);

  /// @return a job when an identification is due and none is out.
  std::optional<IdentificationJob> takeDueJob();
  /// @return a job now, due or not; none when nothing is buffered or a job is out.
  std::optional<IdentificationJob> takeJob();
  /// Takes the result of the job that is out.
  IdentificationOutcome finish(IdentificationResult result);

  /**
   * @brief Offers a model from an earlier run. It is judged against the first sample that comes:
   * refused when that is earlier than the model's state or too late after its window.
   */
  void restore(const FittedModel& model);

  /// What may be asked, state at the newest sample, as a copy that needs no lock.
  LiveModel live() const;
  /// SOF1 from the live state; kNoModel with the reason when there is none or it is too old.
  CrankingAnswer predictCranking(const CrankingQuery& query) const;
  /// The longest stop and SOF2 from the live state; kNoModel likewise.
  StopTimeAnswer predictStopTime(const StopTimeQuery& query) const;
  ChargeAcceptanceAnswer predictChargeAcceptance(const ChargeAcceptanceQuery& query) const;
  /// Why nothing is answered; none when queries are.
  std::optional<std::string> whyNoModel() const;
  double capacity() const { return options_.capacity; }  ///< [Ah]
  /// How wide intervals are, as past events ask for.
  IntervalScale crankScale() const { return judging_.crank_scale; }
  IntervalScale chargeScale() const { return judging_.charge_scale; }

  /// A what-if profile from the live state; kNoModel likewise.
  ProfileAnswer simulateProfile(const std::vector<double>& time,
                                const std::vector<double>& current) const;

  SessionStatus status() const;
  StreamCounts counts() const { return stream_.counts(); }
  std::optional<double> inputRate() const { return stream_.inputRate(); }

  /// @return time of the newest sample on the session's clock [s]; none before the first.
  std::optional<double> newestTime() const;
  bool isJobOut() const { return job_is_out_; }

  /// @return the model in use with its state at the newest sample; none before the first.
  std::optional<FittedModel> model() const;

 private:
  /// One compared instant of the back-test.
  struct Compared {
    double time, measured, expected;
  };

  /// What is in progress of setting the model beside what happens.
  struct Judging {
    explicit Judging(const EventLimits& limits = {}) : crank_watch(limits) {}
    CrankWatch crank_watch;
    ChargeWatch charge_watch;
    IntervalScale crank_scale, charge_scale;
  };

  void restartClock(double old_newest, const StreamSample& first);
  void advance(const StreamSample& sample);
  void follow(const StreamSample& sample, double max_gap);
  void judgeRestored(const StreamSample& first);
  void install(const FittedModel& model, double max_gap);
  void compare(const StreamSample& sample);
  bool isDue();
  std::string missingForFirst() const;
  IdentificationJob makeJob();
  std::string refusalOf(const IdentificationResult& result) const;
  std::optional<double> modelAge() const;
  bool isTooOld() const;
  BacktestScore backtest() const;

  SessionOptions options_;
  SampleStream stream_;
  Judging judging_, judging_at_job_;
  SessionEvents events_;  // not handed out yet
  std::optional<StreamSample> newest_;
  double driving_ = 0.0;    // [s]
  double next_look_ = 0.0;  // [s] of driving
  double job_driving_ = 0.0;  // [s], when the job that is out was taken
  int epoch_ = 0;
  bool job_is_out_ = false;

  std::optional<FittedModel> model_;     // as accepted
  std::optional<FittedModel> restored_;  // waits for the first sample
  std::optional<StateTracker> tracker_;
  double fitted_until_ = 0.0;  // [s], end of the model's window on the present clock
  std::deque<Compared> compared_;
  std::string last_outcome_;
};

}  // namespace battery_sof

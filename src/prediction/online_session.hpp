#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prediction/identification_job.hpp"
#include "prediction/model_monitor.hpp"
#include "prediction/questions.hpp"
#include "prediction/sample_stream.hpp"
#include "recording/deep_discharge.hpp"

namespace battery_sof {

/// Settings of a session.
struct SessionOptions : IdentificationSettings {
  double buffer = 1800.0;          ///< [s], past kept for identification
  double identify_period = 600.0;  ///< [s] of driving between identifications
  double retry_period = 60.0;      ///< [s] of driving between tries while no window was fitted
  double capacity = 50.0;          ///< [Ah], nominal
  /// 12 V blocks in series that samples, questions and answers are of (recording/series_blocks.hpp)
  double series_blocks = 1.0;
};

/// What the session can do at present.
enum class SessionState { kNoSample, kCollecting, kIdentifying, kReady };

/// What the answers rest on: the population, a trip before, or a window of this one.
enum class AnswerBasis { kPopulation, kPreviousTrip, kThisTrip };

/// @return "population", "previous_trip", "this_trip".
std::string toString(AnswerBasis basis);

/// What the model that answers expects of the last sample it settled: of the quantity that was not
/// controlled there.
struct ExpectedSample {
  double time = 0.0;              ///< [s]
  std::optional<double> voltage;  ///< [V], where the current is the input
  std::optional<double> current;  ///< [A], where the voltage is the input
};

/// A summary for a status message.
struct SessionStatus {
  SessionState state = SessionState::kNoSample;
  AnswerBasis basis = AnswerBasis::kPopulation;
  std::string reason;                 ///< one sentence
  std::string not_valid;              ///< OnlineSession::whyNotValid(), which `reason` begins with
  std::optional<double> newest_time;  ///< [s]
  std::optional<double> model_age;    ///< [s] from the window's end to the newest sample
  std::optional<double> window_quality;  ///< [0, 1], of the model's window
  BacktestScore backtest;
  /// physics beyond the base model in the model that answers
  std::vector<std::string> effects;
  /// something charges the battery: by the last identification's samples
  bool charger_present = false;
  /// [0, 1], of the buffered samples whose voltage is controlled; none before the first
  std::optional<double> charger_share;
  std::optional<ExpectedSample> expected;  ///< none before the model followed a sample
  /// the model that answers is driven by the voltage at the newest sample
  bool voltage_controlled = false;
  /// where the battery was discharged deeply since the session began, one sentence; else empty
  std::string deep_discharge;
};

/// What came of a finished identification.
struct IdentificationOutcome {
  bool accepted = false;
  std::string message;  ///< one sentence
  /// accepted: state at the newest sample; refused: the candidate, if there was one
  std::optional<FittedModel> model;
};

/**
 * @brief What a session would answer at one moment, to be asked without the session: a copy that
 * shares nothing with it.
 *
 * Every question is that of the free function of its name; kNoModel with the session's reason when
 * there is no model, and nothing is valid while the session knows why.
 */
class ModelSnapshot {
 public:
  /// @param why_no_model the reason when there is no model; `model` is then an empty one.
  /// @param why_not_valid OnlineSession::whyNotValid().
  ModelSnapshot(FittedModel model, std::optional<std::string> why_no_model, double capacity,
                std::string why_not_valid = {})
      : model_(std::move(model)),
        why_no_model_(std::move(why_no_model)),
        why_not_valid_(std::move(why_not_valid)),
        capacity_(capacity) {
    if (why_no_model_) model_.fit.status = FitStatus::kNotExcited;
  }

  CrankingAnswer predictCranking(const CrankingQuery& query) const {
    return explained(battery_sof::predictCranking(model_, query, capacity_));
  }
  StopTimeAnswer predictStopTime(const StopTimeQuery& query) const {
    return explained(battery_sof::predictStopTime(model_, query, capacity_));
  }
  ChargeAcceptanceAnswer predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
    return explained(battery_sof::predictChargeAcceptance(model_, query, capacity_));
  }
  CrankingMap mapCranking(const CrankingQuery& query, const std::vector<double>& i_load,
                          const std::vector<double>& t_stop,
                          const WorkWatch& watch = nullptr) const {
    return explained(battery_sof::mapCranking(model_, query, i_load, t_stop, capacity_, watch));
  }
  ChargeAcceptanceMap mapChargeAcceptance(const ChargeAcceptanceQuery& query,
                                          const std::vector<double>& u_boost,
                                          const std::vector<double>& t_sof2,
                                          const WorkWatch& watch = nullptr) const {
    return explained(
        battery_sof::mapChargeAcceptance(model_, query, u_boost, t_sof2, capacity_, watch));
  }
  ProfileAnswer simulateProfile(const std::vector<double>& time, const std::vector<double>& current,
                                const WorkWatch& watch = nullptr) const {
    return explained(battery_sof::simulateProfile(model_, time, current, watch));
  }

  const FittedModel& model() const { return model_; }

 private:
  /// The reason in place of the free functions' general one, and why no number is valid; faults of
  /// the query come first.
  template <typename Answer>
  Answer explained(Answer answer) const {
    if (why_no_model_ && answer.code == AnswerCode::kNoModel) answer.message = *why_no_model_;
    invalidate(answer);
    return answer;
  }
  template <typename Answer>
  void invalidate(Answer& answer) const {
    if (why_not_valid_.empty() || hasNoNumbers(answer.code)) return;
    battery_sof::invalidate(answer, why_not_valid_);
  }
  template <typename Answer>
  void invalidate(AnswerMap<Answer>& map) const {
    for (Answer& answer : map.answers) invalidate(answer);
  }
  static bool hasNoNumbers(AnswerCode code) {
    return code == AnswerCode::kInvalidQuery || code == AnswerCode::kNoModel;
  }

  FittedModel model_;
  std::optional<std::string> why_no_model_;
  std::string why_not_valid_;
  double capacity_;  // [Ah]
};

/**
 * @brief What a node does with samples: without threads, clocks or ROS. Time is the samples' own.
 *
 * Samples go in one by one; a StateTracker carries the model's state along. When an identification
 * is due, the session hands out a self-contained job; the caller runs it wherever it likes and
 * brings the result back. At most one job is out at a time.
 *
 * Due at once: when a model is denied (denialOf()), and every retry_period while it is.
 *
 * Due: while no window was fitted, once the newest stretch without a gap is a window long, holds charge and
 * discharge and is suitable enough (looked at every 10 s of driving, tried at most every
 * retry_period); then every identify_period of driving. Driving is the sum of sampling
 * intervals without the gaps.
 *
 * Accepted: a usable fit whose r_discharge and u_dc are determined (a crank's voltage is u_dc +
 * r_discharge i + u_c2, and u_c2's share is the smallest), and whose error on the most recent
 * window is at most 1.1 times that of the model in use (IdentificationTrial::worsening); a model that still learns is
 * replaced in any case. A refused model leaves the old one in use.
 *
 * Periods count from when a job was taken, and the new model follows the samples since once it is
 * accepted. Events are reported, and intervals calibrated, by the answer that was given before each.
 *
 * Clock jump back (SampleStream): the past and the state are begun again, the model stays with its
 * age, and the result of a job from before is dropped.
 *
 * A clock that jumps, is believed, and within a minute goes on where it had been was wrong
 * meanwhile: the session goes on as it stood before the jump, and the samples between are lost.
 *
 * fitWith() gives the next windows another composition, until a fit with it is refused.
 */
class OnlineSession {
 public:
  /// @throws std::invalid_argument for options that are not finite or outside their domain.
  explicit OnlineSession(const SessionOptions& options = {});

  /// From now on. @param capacity [Ah], nominal, > 0; std::invalid_argument else.
  void setCapacity(double capacity);
  double capacity() const { return options_.capacity; }  ///< [Ah]

  /// Offers one sample. @return cranks, charges and stops that ended, with what was answered before.
  SessionEvents push(const RawSample& sample);

  /// @return a job when an identification is due and none is out.
  std::optional<IdentificationJob> takeDueJob();
  /// @return a job now, due or not; none when nothing is buffered or a job is out.
  std::optional<IdentificationJob> takeJob();
  /// Takes the result of the job that is out.
  IdentificationOutcome finish(IdentificationResult result);

  /// Forgets samples and models, as after a fault; the counts stay, and the job that is out will be
  /// dropped.
  void beginAnew();

  /**
   * @brief Offers a model from an earlier run. It is judged against the first sample that comes:
   * refused when that is earlier than the model's state, and when the model's fit is not usable or
   * of other series blocks. Else it answers from that sample on. While nothing else is in use a
   * refused one is judged again wherever the clock jumps: a first stamp may be wrong.
   */
  void restore(const FittedModel& model);

  /**
   * @brief Fits another composition to the next windows in place of the session's own, which may
   * lack physics.
   *
   * An identification is due once there is a model; its fit takes that model's place where it is
   * usable, later ones under the same rule as any new fit. Where one is refused, the session's own
   * composition is fitted again. The same composition again changes nothing while it is in use.
   * @param effects, discrepancy the whole composition, as in IdentifyOptions; a discrepancy that
   * was estimated again makes another composition.
   * @param from_driving [s] of driving(), not before: what comes from a computation of unknown
   * length takes effect at one moment of the recording, however fast that is played.
   * @throws std::invalid_argument for an empty composition, one that cannot be, or
   * FitStart::kPaper.
   */
  void fitWith(const std::vector<std::string>& effects, double from_driving = 0.0,
               std::shared_ptr<const DiscrepancyModel> discrepancy = nullptr);
  double driving() const { return driving_; }  ///< [s]
  /// The past that is kept, of one block.
  const Series& series() const { return stream_.series(); }

  /// What may be asked, state at the newest sample, as a copy that needs no lock; kNoModel with the
  /// reason when there is no model.
  ModelSnapshot live() const;
  /// Why nothing is answered; none when queries are.
  std::optional<std::string> whyNoModel() const;
  /// Why no answer is valid at present, though it has numbers: one sentence without a full stop,
  /// which every answer and the status give. Empty when answers may be valid.
  std::string whyNotValid() const { return stream_.whyNotValid(); }
  /// [V], ModelMonitor::chargeVoltage(), of a saved model too.
  std::optional<double> chargeVoltage() const;
  /// How wide intervals are, as past events ask for.
  IntervalCalibrations calibrations() const { return monitor_.calibrations(); }

  /// Where the battery was discharged deeply since the session began.
  const DeepDischargeDetector& deepDischarges() const { return deep_discharges_; }
  /**
   * @brief What a later session is to begin from: the model in use with all that was estimated on
   * this trip, state at the newest sample.
   * @return none where nothing of it is worth keeping: before the first sample, while the
   * saved model is not judged yet, while nothing is valid, and where a saved model was refused by
   * its clock and no window of this trip was fitted since.
   */
  std::optional<FittedModel> modelToSave() const;

  SessionStatus status() const;
  StreamCounts counts() const { return stream_.counts(); }

  /// @return time of the newest sample on the session's clock [s]; none before the first.
  std::optional<double> newestTime() const;
  bool isJobOut() const { return job_.has_value(); }

  /// @return the model in use with its state at the newest sample; none before the first.
  std::optional<FittedModel> model() const;

 private:
  SessionEvents take(const RawSample& sample);
  /// A model as it leaves the session; inside all is of one block.
  FittedModel ofRow(FittedModel model) const;

  /// What stood when the job that is out was taken.
  struct JobOut {
    ModelMonitor monitor;
    double driving;  // [s]
  };

  /// A composition of fitWith().
  struct Composition {
    std::vector<std::string> effects;
    std::shared_ptr<const DiscrepancyModel> discrepancy;  // of "discrepancy" among them
    double from_driving = 0.0;                            // [s]
    bool is_in_use = false;                               // a fit with it was accepted
  };

  /// Keeps the session as it stands before a jump of the clock, or goes back to it where the clock
  /// does.
  void watchForJumps(const RawSample& sample);
  void goBackTo(const OnlineSession& before);
  void restartClock(double old_newest, const Sample& first);
  void advance(const Sample& sample);
  void follow(const Sample& sample, double max_gap);
  SessionEvents followed(const Sample& sample, double max_gap);
  void followAgain(double after, double max_gap);
  void judgeRestored(const Sample& first);
  void beginFromPopulation(const Sample& sample);
  /// A denied model is to be fitted again at once.
  void watchForDenial();
  /// Where a first rest or crank denies the model of the trip before: another battery.
  void watchForSwap(const Sample& sample);
  /// Where the clock jumped: a saved model that was refused by the clock before is judged once
  /// more.
  void offerRefusedAgain();
  void loseModel(const std::string& why);
  std::string whyNoSample() const;
  /// Why the saved model cannot be used from a first sample on; empty when it can.
  std::string refusalOfRestored(double first_time) const;
  /// Why the saved model, not judged for good yet, does not answer; empty when it does.
  std::string whyRestoredWaits() const;
  /// A saved model after its parking, about to follow samples from a time [s] on.
  ModelMonitor restoredAt(const FittedModel& saved, double time) const;
  /// The saved model at the newest sample, while the stream still measures its rate.
  FittedModel restoredNow() const;
  void beginDueComposition();
  bool isDue();
  std::string missingForFirst() const;
  IdentificationJob makeJob();
  std::string refusalOf(const IdentificationTrial& trial, bool may_compare) const;
  void install(const IdentificationResult& result);
  void takeSource(const ChargerShare& source);
  std::optional<ExpectedSample> expectedSample() const;

  SessionOptions options_;
  SampleStream stream_;
  ModelMonitor monitor_;
  std::optional<JobOut> job_;
  SessionEvents events_;  // not handed out yet
  std::optional<Sample> newest_;
  double driving_ = 0.0;    // [s]
  double next_look_ = 0.0;  // [s] of driving
  int epoch_ = 0;

  bool is_denied_ = false;
  ChargerShare source_;
  std::optional<FittedModel> restored_;               // waits until the stream knows its rate
  std::optional<FittedModel> refused_;                // was restored and refused
  std::shared_ptr<const OnlineSession> before_jump_;  // none a minute after a jump
  double jumped_to_ = 0.0;                            // [s], first stamp after it
  std::optional<Composition> composition_, next_composition_;  // none: the session's own
  std::string last_outcome_, missing_;
  AnswerBasis basis_ = AnswerBasis::kPopulation;
  DeepDischargeDetector deep_discharges_;
};

}  // namespace battery_sof

#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimation/depth_physics.hpp"
#include "prediction/history.hpp"
#include "prediction/pipeline.hpp"
#include "prediction/questions.hpp"

namespace battery_sof {

/// Settings of a session.
struct SessionOptions : IdentificationSettings {
  double buffer = 1800.0;          ///< [s], past kept for identification
  double identify_period = 600.0;  ///< [s] of driving between identifications
  double retry_period = 60.0;      ///< [s] of driving between tries while no window was fitted
  std::optional<double> capacity;  ///< [Ah], nominal; none: kTypicalCapacity
  /// 12 V blocks in series that samples, questions and answers are of (recording/series_blocks.hpp)
  double series_blocks = 1.0;
};

/// What the session can do at present.
enum class SessionState { kNoSample, kCollecting, kIdentifying, kReady };

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
 * Every question is that of the free function of its name. Without a model it is kNoModel with the
 * session's reason, unless the query itself is invalid; nothing is valid while the session knows why.
 */
class ModelSnapshot {
 public:
  /// @param why_no_model one sentence where `model` is none.
  /// @param why_not_valid OnlineSession::whyNotValid().
  ModelSnapshot(std::optional<FittedModel> model, const std::optional<std::string>& why_no_model,
                double capacity, std::optional<std::string> why_not_valid = std::nullopt)
      : model_(std::move(model)),
        why_no_model_(why_no_model.value_or("")),
        why_not_valid_(std::move(why_not_valid)),
        capacity_(capacity) {}

  CrankingAnswer predictCranking(const CrankingQuery& query) const {
    if (!model_) return withoutModel<CrankingAnswer>(faultsOf(query), why_no_model_);
    return judged(battery_sof::predictCranking(*model_, query, capacity_));
  }
  StopTimeAnswer predictStopTime(const StopTimeQuery& query) const {
    if (!model_) return withoutModel<StopTimeAnswer>(faultsOf(query), why_no_model_);
    return judged(battery_sof::predictStopTime(*model_, query, capacity_));
  }
  ChargeAcceptanceAnswer predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
    if (!model_) return withoutModel<ChargeAcceptanceAnswer>(faultsOf(query), why_no_model_);
    return judged(battery_sof::predictChargeAcceptance(*model_, query, capacity_));
  }
  CrankingMap mapCranking(const CrankingQuery& query, const std::vector<double>& i_load,
                          const std::vector<double>& t_stop,
                          const WorkWatch& watch = nullptr) const {
    if (!model_)
      return withoutModel<CrankingMap>(faultsOfMap(i_load, "i_load", t_stop, "t_stop"),
                                       why_no_model_);
    return judged(battery_sof::mapCranking(*model_, query, i_load, t_stop, capacity_, watch));
  }
  ChargeAcceptanceMap mapChargeAcceptance(const ChargeAcceptanceQuery& query,
                                          const std::vector<double>& u_boost,
                                          const std::vector<double>& t_sof2,
                                          const WorkWatch& watch = nullptr) const {
    if (!model_)
      return withoutModel<ChargeAcceptanceMap>(faultsOfMap(u_boost, "u_boost", t_sof2, "t_sof2"),
                                               why_no_model_);
    return judged(
        battery_sof::mapChargeAcceptance(*model_, query, u_boost, t_sof2, capacity_, watch));
  }
  ProfileAnswer simulateProfile(const std::vector<double>& time, const std::vector<double>& current,
                                const WorkWatch& watch = nullptr) const {
    if (!model_) return withoutModel<ProfileAnswer>(faultsOfProfile(time, current), why_no_model_);
    return judged(battery_sof::simulateProfile(*model_, time, current, watch));
  }

  const std::optional<FittedModel>& model() const { return model_; }

 private:
  template <typename Answer>
  Answer judged(Answer answer) const {
    const bool has_numbers =
        answer.code != AnswerCode::kInvalidQuery && answer.code != AnswerCode::kNoModel;
    if (has_numbers && why_not_valid_) invalidate(answer, *why_not_valid_);
    return answer;
  }
  template <typename Answer>
  AnswerMap<Answer> judged(AnswerMap<Answer> map) const {
    for (Answer& answer : map.answers) answer = judged(std::move(answer));
    return map;
  }

  std::optional<FittedModel> model_;
  std::string why_no_model_;
  std::optional<std::string> why_not_valid_;
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
 * window is at most 1.1 times that of the model in use (IdentificationResult::worsening); a model that still learns is
 * replaced in any case. A refused model leaves the old one in use.
 *
 * Periods count from when a job was taken, and the new model follows the samples since once it is
 * accepted (History::replay()). Events are reported, and intervals calibrated, by the answer that
 * was given before each.
 *
 * Clock jump back (SampleStream): the past and the state are begun again, the model stays with its
 * age, and the result of a job from before is dropped.
 *
 * A clock that jumps, is believed, and within a minute goes on where it had been was wrong
 * meanwhile: the session is rewound to before the jump (History::rewindTo()), and the samples
 * between are lost.
 *
 * fitWith() gives the next windows another composition, until a fit with it is refused.
 */
class OnlineSession {
 public:
  /// @throws std::invalid_argument for options that are not finite or outside their domain.
  explicit OnlineSession(const SessionOptions& options = {});

  /// From now on. @param nominal [Ah], > 0, none: kTypicalCapacity; std::invalid_argument else.
  void setCapacity(std::optional<double> nominal);
  double capacity() const { return nominalCapacity(options_.capacity); }  ///< [Ah]

  /// Offers one sample. @return cranks, charges and stops that ended, with what was answered before.
  SessionEvents push(const RawSample& sample);

  /// @return a job when an identification is due and none is out.
  std::optional<IdentificationJob> takeDueJob();
  /// @return a job now, due or not; none when nothing is buffered or a job is out.
  std::optional<IdentificationJob> takeJob();
  /// Takes the result of the job that is out. @throws std::invalid_argument when none is.
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
  double driving() const { return now().driving; }  ///< [s]
  /// The past that is kept, of one block.
  const Series& series() const { return now().stream.series(); }

  /// What may be asked, state at the newest sample, as a copy that needs no lock; kNoModel with the
  /// reason when there is no model.
  ModelSnapshot live() const;
  /// Why nothing is answered; none when queries are.
  std::optional<std::string> whyNoModel() const;
  /// Why no answer is valid at present, though it has numbers: one sentence without a full stop,
  /// which every answer and the status give. None when answers may be valid.
  std::optional<std::string> whyNotValid() const { return now().stream.whyNotValid(); }
  /// [V], at which the battery was charged lately: median over the past charges that the model
  /// knows, a saved one too, else over those that passed; none where none was seen.
  std::optional<double> chargeVoltage() const;
  /// How wide intervals are, as past events ask for.
  IntervalCalibrations calibrations() const { return now().monitor.calibrations(); }

  /// Where the battery was discharged deeply since the session began.
  const DeepDischargeDetector& deepDischarges() const { return now().deep_discharges; }
  /**
   * @brief What a later session is to begin from: the model in use with all that was estimated on
   * this trip, state at the newest sample.
   * @return none where nothing of it is worth keeping: before the first sample, while the
   * saved model is not judged yet, while nothing is valid, and where a saved model was refused by
   * its clock and no window of this trip was fitted since.
   */
  std::optional<FittedModel> modelToSave() const;

  SessionStatus status() const;
  StreamCounts counts() const { return now().stream.counts(); }

  /// @return time of the newest sample on the session's clock [s]; none before the first.
  std::optional<double> newestTime() const;
  bool isJobOut() const { return history_.has(Mark::kJobTaken); }

  /// @return the model in use with its state at the newest sample; none before the first.
  std::optional<FittedModel> model() const;

 private:
  /// A composition of fitWith().
  struct Composition {
    std::vector<std::string> effects;
    std::shared_ptr<const DiscrepancyModel> discrepancy;  // of "discrepancy" among them
    double from_driving = 0.0;                            // [s]
    bool is_in_use = false;                               // a fit with it was accepted
  };

  Standing& now() { return history_.now(); }
  const Standing& now() const { return history_.now(); }

  SessionEvents accept(const RawSample& sample);
  /// Where this sample confirms a jump of the clock: marks what stood before, or rewinds to it where
  /// the clock goes on from there.
  void watchForJumps(const RawSample& sample);
  void restartClock(const Sample& first);
  void advance(const Sample& sample);
  void follow(const Sample& sample);
  /// A denied model is to be fitted again at once.
  void watchForDenial();
  /// Where a first rest or crank denies the model of the trip before: another battery.
  void watchForSwap(const Sample& sample);
  void beginFromPopulation(const Sample& sample);
  void loseModel(const std::string& why);

  /// Judges the saved model by a sample. @return whether it answers from there on.
  bool startSaved(const Sample& first);
  /// While the stream measures its rate, a saved model answers by the samples as they come; on
  /// their rate it is judged again, and follows them again.
  void tryWaiting();
  /// Where the clock jumped and nothing else is in use: a refused model is judged once more.
  void offerRefusedAgain();

  void beginDueComposition();
  bool isDue();
  std::optional<std::string> missingForFirst() const;
  IdentificationJob makeJob();
  std::optional<std::string> refusalOf(const IdentificationResult& result) const;
  /// Puts a fit in where its job was taken. @return why not; none when it is in use.
  std::optional<std::string> install(const IdentificationResult& result, const Standing& taken);

  SessionOptions options_;
  History history_;
  double jumped_to_ = 0.0;  // [s], first stamp after the last jump
  SessionEvents events_;    // not handed out yet
  std::optional<Composition> composition_, next_composition_;  // none: the session's own
};

}  // namespace battery_sof

#pragma once

#include <memory>
#include <optional>
#include <string>

#include "battery_sof/intake.hpp"
#include "battery_sof/model.hpp"
#include "battery_sof/queries.hpp"

namespace battery_sof {

class OnlineSession;

/// What a session has to know of its battery.
struct SessionSettings {
  double capacity = 50.0;  ///< [Ah], nominal
  /// of 12 V in series that samples, questions and answers are of
  double series_blocks = 1.0;
  double buffer = 1800.0;               ///< [s], past kept for identification
  std::optional<double> window_length;  ///< [s], of an identification; none: by the sampling rate
};

/**
 * @brief What the node does with samples, without ROS: follows a battery and answers questions of
 * the newest sample's moment.
 *
 * No threads and no clock: time is the samples' own; an identification runs where identifyWhenDue()
 * is called.
 */
class Session {
 public:
  /// @throws std::invalid_argument for settings outside their ranges.
  explicit Session(const SessionSettings& settings = {});
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// Offers a model from an earlier run, which is judged against the first sample that comes.
  void restore(const Model& model);
  /// Takes a sample; one that cannot be is refused and counted.
  void push(const RawSample& sample);
  /// Identifies when an identification is due; may take seconds. @return how it ended, one
  /// sentence; none when none was due.
  std::optional<std::string> identifyWhenDue();

  CrankingAnswer predictCranking(const CrankingQuery& query) const;
  StopTimeAnswer predictStopTime(const StopTimeQuery& query) const;
  ChargeAcceptanceAnswer predictChargeAcceptance(const ChargeAcceptanceQuery& query) const;

  /// The model that answers, its state at the newest sample; none before the first.
  std::optional<Model> model() const;
  /// One sentence: why there is no answer, or what the last identification came to.
  std::string reason() const;

 private:
  std::unique_ptr<OnlineSession> session_;
};

}  // namespace battery_sof

#pragma once

#include <memory>
#include <optional>
#include <string>

#include "battery_sof/intake.hpp"
#include "battery_sof/model.hpp"
#include "battery_sof/queries.hpp"

namespace battery_sof {

class OnlineSession;

/// Settings of a Session.
struct SessionSettings {
  std::optional<double> capacity;  ///< [Ah], nominal; none: 50 Ah, and the fit knows nothing of it
  /// number of 12 V blocks in series; samples, queries and answers are those of all blocks
  double series_blocks = 1.0;
  double buffer = 1800.0;               ///< [s], length of the past that is kept
  std::optional<double> window_length;  ///< [s], fitted window; default: by the sampling rate
};

/**
 * @brief Follows a battery and answers queries that begin at the newest sample, as the node does,
 * but without ROS.
 *
 * A session has no threads and reads no clock. Time is that of the samples, and an identification
 * runs on the thread that calls identifyWhenDue().
 */
class Session {
 public:
  /// @throws std::invalid_argument for settings outside their ranges.
  explicit Session(const SessionSettings& settings = {});
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  /// Sets the model of an earlier run, which is compared with the first samples that arrive.
  void restore(const Model& model);
  /// Processes a sample; an invalid one is refused and counted.
  void push(const RawSample& sample);
  /// Identifies if an identification is due, which may take seconds. @return one sentence on the
  /// outcome; none if no identification was due.
  std::optional<std::string> identifyWhenDue();

  CrankingAnswer predictCranking(const CrankingQuery& query) const;
  StopTimeAnswer predictStopTime(const StopTimeQuery& query) const;
  ChargeAcceptanceAnswer predictChargeAcceptance(const ChargeAcceptanceQuery& query) const;

  /// The model that answers, with its state at the newest sample; none before the first one.
  std::optional<Model> model() const;
  /// One sentence: why there is no answer, or the outcome of the last identification.
  std::string reason() const;

 private:
  std::unique_ptr<OnlineSession> session_;
};

}  // namespace battery_sof

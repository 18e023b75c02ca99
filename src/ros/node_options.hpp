#pragma once

#include <XmlRpcValue.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "prediction/online_session.hpp"

namespace battery_sof {

/// The questions asked again with every status: SOF1, the longest stop before the same crank, and
/// SOF2. Voltages are those of one block by default; parseNodeOptions() makes them those of the
/// row.
struct StandingQueries {
  CrankingQuery cranking{-20.0, 30.0, -200.0, 1.0, 7.2};
  ChargeAcceptanceQuery charge{14.2, 10.0, 5000.0};
  /// else it is predicted at the voltage at which the battery was charged lately, see chargeAt()
  bool u_boost_is_given = false;
  /// @return without an u_required where that is not given.
  StopTimeQuery stopTime() const;
  /// @param lately [V], OnlineSession::chargeVoltage().
  ChargeAcceptanceQuery chargeAt(const std::optional<double>& lately) const;
};

/// All that the node's private parameters say; config/battery_sof.yaml explains each.
struct NodeOptions {
  /// Its capacity where that is given, else BatteryState's design_capacity, where there is one.
  SessionOptions session;
  /// of /diagnostics; empty: the battery's serial number, or "battery"
  std::string battery_name;
  double diagnostic_period = 1.0;  ///< [s] between two /diagnostics, at least 1 s
  StandingQueries standing;
  double diagnose_period = 0.0;  ///< [s] of driving; 0: only on request
  bool use_diagnosis = false;    ///< fits what is diagnosed to the next windows
  double change_period = 900.0;  ///< [s] of driving between comparisons with the reference; 0: none
  std::string state_file;        ///< empty: the model is not kept
  /// PRIORS.yaml that session.identify.priors came from; empty: the catalogue's
  std::string priors;
  std::string vehicle_type;  ///< of the priors; empty: those of all types
};

/// Parameters the node does not start with; the message has one line a fault.
class NodeOptionsError : public std::runtime_error {
 public:
  explicit NodeOptionsError(const std::vector<std::string>& faults);
};

/**
 * @brief Reads the node's private parameters; what is not given keeps its default.
 * @param parameters the struct below the node's name; an invalid (empty) value: none are given.
 * @throws NodeOptionsError naming all faults at once: unknown keys, wrong types, values out of
 * range, values that contradict each other, priors that cannot be read.
 */
NodeOptions parseNodeOptions(XmlRpc::XmlRpcValue parameters);

}  // namespace battery_sof

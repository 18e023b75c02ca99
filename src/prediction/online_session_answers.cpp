#include "prediction/online_session.hpp"
#include "recording/channel_statistics.hpp"

namespace battery_sof {

std::optional<std::string> OnlineSession::whyNoModel() const {
  if (now().monitor.holdsModel()) return std::nullopt;
  if (now().saved && !now().newest) return whySavedWaits();
  return "no model has been identified yet" +
         (now().last_outcome.empty() ? "" : ": " + now().last_outcome);
}

ModelSnapshot OnlineSession::live() const {
  std::optional<FittedModel> live = model();
  if (live && !series().temperature.empty()) live->state.temperature = series().temperature.back();
  return ModelSnapshot(std::move(live), whyNoModel(), options_.capacity, whyNotValid());
}

std::optional<double> OnlineSession::chargeVoltage() const {
  std::optional<double> of_one;
  if (now().monitor.holdsModel())
    of_one = usualVoltage(now().monitor.tracker().intervals().event_history.charges);
  else if (now().saved)
    of_one = usualVoltage(now().saved->model.intervals.event_history.charges);
  const std::deque<double>& passed = now().charge_voltages;
  if (!of_one && !passed.empty()) of_one = medianOf({passed.begin(), passed.end()});
  if (of_one) *of_one *= options_.series_blocks;
  return of_one;
}

std::optional<double> OnlineSession::newestTime() const {
  return now().newest ? std::optional<double>(now().newest->time) : std::nullopt;
}

std::optional<FittedModel> OnlineSession::model() const {
  if (!now().monitor.holdsModel()) return std::nullopt;
  FittedModel model = now().monitor.now();
  model.fit.series_blocks = options_.series_blocks;
  return model;
}

std::optional<FittedModel> OnlineSession::modelToSave() const {
  const bool saved_is_better = now().saved && now().basis != AnswerBasis::kThisTrip;
  if (saved_is_better || !whyNotValid().empty()) return std::nullopt;
  return model();
}

std::optional<ExpectedSample> OnlineSession::expectedSample() const {
  const ModelMonitor& monitor = now().monitor;
  if (!monitor.holdsModel() || !monitor.tracker().last()) return std::nullopt;
  const SettledSample& last = *monitor.tracker().last();
  if (last.voltage_controlled) return ExpectedSample{last.time, std::nullopt, last.current};
  return ExpectedSample{last.time, last.voltage * options_.series_blocks, std::nullopt};
}

std::string OnlineSession::whyNoSample() const {
  const std::string why = counts().rejectedTotal() == 0
                              ? "no sample yet"
                              : "no usable sample yet, " + toString(counts());
  return why + (now().saved ? ": " + whySavedWaits() : "");
}

SessionStatus OnlineSession::status() const {
  const Standing& here = now();
  const ModelMonitor& monitor = here.monitor;
  const bool saved_waits = here.saved && here.saved->refusal.empty();
  SessionStatus status;
  status.reason = here.last_outcome;
  if (monitor.learns()) {
    status.reason += status.reason.empty() ? "" : "; ";
    status.reason += "answers rest on ";
    const bool has_priors = !knownOf(options_.identify.priors, {}).empty();
    status.reason += here.basis != AnswerBasis::kPopulation ? "the previous trip"
                     : has_priors                           ? "the given priors"
                                  : "what is known of lead-acid batteries";
    status.reason += " and this trip's samples" +
                     (here.missing_for_first.empty() ? "" : "; " + here.missing_for_first);
  }
  status.basis = saved_waits ? AnswerBasis::kPreviousTrip : here.basis;
  status.newest_time = newestTime();
  if (monitor.holdsModel()) {
    status.model_age = monitor.age();
    status.window_quality = monitor.accepted().fit.window_quality;
    status.effects = monitor.accepted().fit.effects;
    status.voltage_controlled = monitor.tracker().isVoltageControlled();
  }
  status.backtest = monitor.backtest();
  status.deep_discharge = here.deep_discharges.toString(options_.series_blocks);
  status.charger_present = here.source.seen();
  status.charger_share = here.source.share();
  status.expected = expectedSample();
  if (const auto reason = whyNoModel()) {
    status.state = !here.newest ? SessionState::kNoSample
                   : isJobOut() ? SessionState::kIdentifying
                                : SessionState::kCollecting;
    if (!here.newest) status.reason = whyNoSample();
    if (status.reason.empty()) status.reason = *reason;
  } else {
    status.state = SessionState::kReady;
    status.not_valid = whyNotValid();
  }
  if (!status.not_valid.empty())
    status.reason = "no answer is valid, because " + status.not_valid +
                    (status.reason.empty() ? "" : "; " + status.reason);
  return status;
}

}  // namespace battery_sof

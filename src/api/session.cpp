#include "battery_sof/session.hpp"

#include "prediction/online_session.hpp"

namespace battery_sof {
namespace {

SessionOptions optionsOf(const SessionSettings& settings) {
  SessionOptions options;
  options.capacity = settings.capacity;
  options.series_blocks = settings.series_blocks;
  options.buffer = settings.buffer;
  options.window_length = settings.window_length;
  return options;
}

}  // namespace

Session::Session(const SessionSettings& settings)
    : session_(std::make_unique<OnlineSession>(optionsOf(settings))) {}
Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

void Session::restore(const Model& model) { session_->restore(model.fitted()); }

void Session::push(const RawSample& sample) { session_->push(sample); }

std::optional<std::string> Session::identifyWhenDue() {
  const auto job = session_->takeDueJob();
  if (!job) return std::nullopt;
  return session_->finish(runIdentification(*job)).message;
}

CrankingAnswer Session::predictCranking(const CrankingQuery& query) const {
  return session_->live().predictCranking(query);
}

StopTimeAnswer Session::predictStopTime(const StopTimeQuery& query) const {
  return session_->live().predictStopTime(query);
}

ChargeAcceptanceAnswer Session::predictChargeAcceptance(const ChargeAcceptanceQuery& query) const {
  return session_->live().predictChargeAcceptance(query);
}

std::optional<Model> Session::model() const {
  auto model = session_->model();
  return model ? std::optional<Model>(Model(*std::move(model))) : std::nullopt;
}

std::string Session::reason() const { return session_->status().reason; }

}  // namespace battery_sof

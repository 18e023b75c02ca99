#include "battery_sof/diagnose/detectable.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "battery_sof/diagnose/held_out_blocks.hpp"

namespace battery_sof {
namespace {

constexpr double kNamed = 6.0;  // z: its square pays for two parameters and the evidence of a name, nearly

/// The effect's strength that is told; none for one without a typical strength.
const ParameterInfo* toldStrength(const EffectInfo& info) {
  const auto found = std::find_if(info.parameters.begin(), info.parameters.end(), [](const ParameterInfo& parameter) {
    return !parameter.held && parameter.vanishes_at && parameter.magnitude != *parameter.vanishes_at;
  });
  return found == info.parameters.end() ? nullptr : &*found;
}

/// What an effect at its magnitude adds to the voltage and the parameters do not take up [V].
class FreeVoltage {
 public:
  FreeVoltage(const WhitenedFit& fit, const Drive& drive)
      : fit_(fit), drive_(drive), whitening_(fit.noise, drive.samples), modelled_(simulatedVoltage(fit.model, fit.point, drive)) {
    Eigen::MatrixXd columns(fit.jacobian.rows(), fit.jacobian.cols());
    for (Eigen::Index k = 0; k < columns.cols(); ++k) columns.col(k) = whitening_.whitened(fit.jacobian.col(k));
    qr_.compute(columns);
  }

  Eigen::VectorXd of(const Signature& signature) const {
    const BatteryModel larger = enlarged(fit_.model, signature.id);
    CompositionPoint point = signature.start;
    for (const ParameterInfo& info : effectInfo(signature.id).parameters)
      if (info.vanishes_at && !info.held && info.magnitude != *info.vanishes_at)
        point.parameters[*larger.parameterRow(info.name)] = info.magnitude;
    Eigen::VectorXd added = simulatedVoltage(larger, point, drive_) - modelled_;
    if (!added.allFinite()) return Eigen::VectorXd::Zero(added.size());
    for (Eigen::Index n = 0; n < added.size(); ++n)
      if (!(drive_.samples[static_cast<std::size_t>(n)].count > 0.0)) added[n] = 0.0;
    return added - fit_.jacobian * qr_.solve(whitening_.whitened(added));
  }

 private:
  const WhitenedFit& fit_;
  const Drive& drive_;
  Whitening whitening_;
  Eigen::VectorXd modelled_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

/// rms(s_free) / rms(e) over the samples on which s_free acts most; the larger of that and of all samples. @param error e, held out [V].
double shareOfError(const Eigen::VectorXd& free, const Eigen::VectorXd& error, const Drive& drive) {
  double share = 0.0;
  for (const double least : {0.0, leastActing(free)}) {
    double own = 0.0, all = 0.0;
    for (Eigen::Index n = 0; n < free.size(); ++n) {
      const double count = drive.samples[static_cast<std::size_t>(n)].count;
      if (!(count > 0.0) || std::abs(free[n]) < least) continue;
      own += count * free[n] * free[n];
      all += count * error[n] * error[n];
    }
    if (all > 0.0) share = std::max(share, std::sqrt(own / all));
  }
  return share;
}

/// z of the strongest that is not the effect itself nor one of its twins: it would be taken first.
double strongestBeside(const EffectInfo& info, const std::vector<Signature>& screened) {
  double score = 0.0;
  for (const Signature& other : screened)
    if (other.id != info.id && std::find(info.same_as.begin(), info.same_as.end(), other.id) == info.same_as.end())
      score = std::max(score, other.score);
  return std::sqrt(score);
}

}  // namespace

std::vector<Detectable> detectableBeside(const WhitenedFit& fit, const Drive& drive, const std::vector<Signature>& screened,
                                         const DiagnosisThresholds& thresholds, int threads) {
  const FreeVoltage free(fit, drive);
  const Eigen::VectorXd held_out = heldOutErrors(fit, drive, kHeldOutBlocks, threads).error;
  std::vector<Detectable> list;
  for (const Signature& signature : screened) {
    const EffectInfo& info = effectInfo(signature.id);
    const ParameterInfo* told = toldStrength(info);
    if (!told) continue;
    Detectable one{info.id, told->name, told->unit, told->upper, told->magnitude, false};
    const double from_nothing = std::abs(told->magnitude - *told->vanishes_at);
    const double kept = 1.0 - (info.tier() == 'S' ? thresholds.least_structure_share : thresholds.least_share);
    const double share = shareOfError(free.of(signature), held_out, drive);
    if (signature.sensitivity > 0.0 && share > 0.0)
      one.strength = from_nothing * std::max(std::max(kNamed, strongestBeside(info, screened)) / signature.sensitivity, std::sqrt(1.0 / (kept * kept) - 1.0) / share);
    one.visible = one.strength <= from_nothing;
    list.push_back(one);
  }
  return list;
}

}  // namespace battery_sof

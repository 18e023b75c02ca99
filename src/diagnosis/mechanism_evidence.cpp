#include "diagnosis/mechanism_evidence.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace battery_sof {
namespace {

constexpr double kSetProbability = 0.9;
// ln odds of what the model selection gained most by: likeliest of 80 batteries with a structure of
// their own, half of them with an effect of the catalogue (scripts/proof seal --levels N2,X1)
constexpr double kAcceptedWeight = 3.0;
constexpr std::size_t kNumbers = 6;  // of a mechanism
using Numbers = std::array<double, kNumbers>;

/// w, and b as the last, of every mechanism.
constexpr std::array<std::array<double, kNumbers + 1>, kMechanisms> kWeights =
#include "diagnosis/mechanism_weights.inc"
    ;

/// Differences of ln evidence of any length and rate on one scale.
double compressed(double difference) {
  return std::copysign(std::log1p(std::abs(difference)), difference);
}

/// x of every mechanism: how far its evidence lies below the largest, and its share of it.
std::array<Numbers, kMechanisms> numbersOf(const MechanismEvidence& evidence) {
  std::array<Numbers, kMechanisms> numbers{};
  std::size_t column = 0;
  for (const auto part :
       {&MechanismSupport::alone, &MechanismSupport::lost, &MechanismSupport::effect}) {
    double largest = evidence.front().*part;
    for (const MechanismSupport& one : evidence) largest = std::max(largest, one.*part);
    for (std::size_t k = 0; k < kMechanisms; ++k) {
      numbers[k][column] = compressed(evidence[k].*part - largest);
      numbers[k][column + 1] = evidence[k].*part / std::max(largest, 1.0);
    }
    column += 2;
  }
  return numbers;
}

}  // namespace

std::vector<MechanismProbability> mechanismProbabilities(
    const std::vector<MechanismEvidence>& samples, bool is_lead_acid) {
  std::vector<MechanismProbability> all;
  for (const Mechanism mechanism : kAllMechanisms)
    if (is_lead_acid || !isOfLeadAcid(mechanism)) all.push_back({mechanism, 0.0});
  for (const MechanismEvidence& evidence : samples) {
    const std::array<Numbers, kMechanisms> numbers = numbersOf(evidence);
    Eigen::ArrayXd odds(all.size());
    for (Eigen::Index j = 0; j < odds.size(); ++j) {
      const auto k = static_cast<std::size_t>(all[j].mechanism);
      odds[j] = std::inner_product(numbers[k].begin(), numbers[k].end(), kWeights[k].begin(),
                                   kWeights[k].back()) +
                kAcceptedWeight * evidence[k].accepted;
    }
    odds = (odds - odds.maxCoeff()).exp();
    odds /= odds.sum() * static_cast<double>(samples.size());
    for (std::size_t j = 0; j < all.size(); ++j) all[j].probability += odds[j];
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const MechanismProbability& one, const MechanismProbability& other) {
                     return one.probability > other.probability;
                   });
  return all;
}

std::vector<MechanismProbability> likelyMechanisms(const std::vector<MechanismEvidence>& samples,
                                                   bool is_lead_acid) {
  std::vector<MechanismProbability> found;
  double sum = 0.0;
  for (const MechanismProbability& one : mechanismProbabilities(samples, is_lead_acid)) {
    if (sum < kSetProbability) found.push_back(one);
    sum += one.probability;
  }
  return found;
}

}  // namespace battery_sof

#include "diagnosis/mechanism_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace battery_sof {
namespace {

constexpr double kSetProbability = 0.9;
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

MechanismEvidence& operator+=(MechanismEvidence& sum, const MechanismEvidence& other) {
  for (std::size_t k = 0; k < kMechanisms; ++k) {
    sum[k].alone += other[k].alone;
    sum[k].lost += other[k].lost;
    sum[k].effect += other[k].effect;
  }
  return sum;
}

std::vector<MechanismProbability> mechanismProbabilities(const MechanismEvidence& evidence) {
  const std::array<Numbers, kMechanisms> numbers = numbersOf(evidence);
  std::vector<MechanismProbability> all;
  for (std::size_t k = 0; k < kMechanisms; ++k)
    all.push_back({kAllMechanisms[k], std::inner_product(numbers[k].begin(), numbers[k].end(),
                                                         kWeights[k].begin(), kWeights[k].back())});
  std::stable_sort(all.begin(), all.end(),
                   [](const MechanismProbability& one, const MechanismProbability& other) {
                     return one.probability > other.probability;
                   });
  double sum = 0.0;
  const double largest = all.front().probability;
  for (MechanismProbability& one : all)
    sum += one.probability = std::exp(one.probability - largest);
  for (MechanismProbability& one : all) one.probability /= sum;
  return all;
}

std::vector<MechanismProbability> likelyMechanisms(const MechanismEvidence& evidence,
                                                   std::optional<Mechanism> holds) {
  std::vector<MechanismProbability> all = mechanismProbabilities(evidence);
  std::stable_partition(all.begin(), all.end(), [&](const MechanismProbability& one) {
    return holds && one.mechanism == *holds;
  });
  double sum = 0.0;
  std::size_t count = 0;
  while (count < all.size() && sum < kSetProbability) sum += all[count++].probability;
  all.resize(count);
  return all;
}

}  // namespace battery_sof

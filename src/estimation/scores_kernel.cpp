#include "estimation/scores_kernel.hpp"

#include "model/instruction_sets.hpp"

namespace battery_sof {
namespace {

template <int kWidth>
BATTERY_SOF_INLINE void leave(const OverpotentialStates& states,
                              const double (&linear)[kLinearColumns], MeasuredBlock& measured,
                              ResidualSums& sums) {
  using Value = typename Register<kWidth>::Type;
  for (int lane = 0; lane < kLanes; lane += kWidth) {
    Value sum = at<kWidth>(sums.residual + lane), squares = at<kWidth>(sums.squares + lane);
    Value lagged = at<kWidth>(sums.lagged + lane), before = {};
    for (int n = lane; n < kBlockSize; n += kLanes) {
      const Value here = at<kWidth>(measured.voltage + n) - at<kWidth>(states.u_c2 + n) -
                         linear[0] * at<kWidth>(measured.discharge + n) -
                         linear[1] * at<kWidth>(measured.charge + n) - linear[2];
      at<kWidth>(measured.voltage + n) = here;
      sum += here;
      squares += here * here;
      lagged += here * before;
      before = here;
    }
    at<kWidth>(sums.residual + lane) = sum;
    at<kWidth>(sums.squares + lane) = squares;
    at<kWidth>(sums.lagged + lane) = lagged;
  }
}

template <int kWidth>
struct Scores {
  typename Register<kWidth>::Type of[kScoreColumns];
};

/// The scores of the samples n to n + kWidth - 1 in lane order.
template <int kWidth>
BATTERY_SOF_INLINE Scores<kWidth> scoresAt(const MeasuredBlock& left,
                                           const DerivativeBlock& derivatives, int n) {
  const typename Register<kWidth>::Type weighted =
      at<kWidth>(left.weight + n) * at<kWidth>(left.voltage + n);
  return {{weighted * at<kWidth>(left.discharge + n), weighted * at<kWidth>(left.charge + n),
           weighted, weighted * at<kWidth>(derivatives.d_log_c2 + n),
           weighted * at<kWidth>(derivatives.d_log_beta + n),
           weighted * at<kWidth>(derivatives.d_initial + n)}};
}

template <int kWidth>
BATTERY_SOF_INLINE void addUp(const MeasuredBlock& left, const DerivativeBlock& derivatives,
                              ScoreSums& sums) {
  for (int k = 0; k < kScoreSums; ++k)
    for (int lane = 0; lane < kLanes; lane += kWidth) {
      Scores<kWidth> sum = {};
      for (int step = k * kScoreSteps; step < (k + 1) * kScoreSteps; ++step) {
        const Scores<kWidth> scores = scoresAt<kWidth>(left, derivatives, step * kLanes + lane);
        for (int j = 0; j < kScoreColumns; ++j) sum.of[j] += scores.of[j];
      }
      for (int j = 0; j < kScoreColumns; ++j) at<kWidth>(sums.scores[k][j] + lane) = sum.of[j];
    }
}

template <int kWidth>
BATTERY_SOF_INLINE Scores<kWidth> keepScores(const MeasuredBlock& left,
                                             const DerivativeBlock& derivatives, int step, int lane,
                                             MovingScores& moving) {
  const Scores<kWidth> scores = scoresAt<kWidth>(left, derivatives, step * kLanes + lane);
  for (int j = 0; j < kScoreColumns; ++j) at<kWidth>(moving.here[step][j] + lane) = scores.of[j];
  return scores;
}

/// Finds what lies before a block's lanes: the end of the lane before, the first lane's in the
/// block before.
template <int kWidth>
BATTERY_SOF_INLINE void lookBack(const MeasuredBlock& left, const DerivativeBlock& derivatives,
                                 int width, MovingScores& moving) {
  for (int step = kLaneSteps - width; step < kLaneSteps; ++step) {
    for (int j = 0; j < kScoreColumns; ++j)
      moving.before[step][j][0] = moving.here[step][j][kLanes - 1];
    for (int lane = 0; lane < kLanes; lane += kWidth)
      keepScores<kWidth>(left, derivatives, step, lane, moving);
    for (int j = 0; j < kScoreColumns; ++j)
      for (int lane = 1; lane < kLanes; ++lane)
        moving.before[step][j][lane] = moving.here[step][j][lane - 1];
  }
}

template <int kWidth>
BATTERY_SOF_INLINE void multiply(const MeasuredBlock& left, const DerivativeBlock& derivatives,
                                 int width, int lane, MovingScores& moving,
                                 ScoreProducts& products) {
  using Value = typename Register<kWidth>::Type;
  Value total[kScoreColumns][kScoreColumns], sum[kScoreColumns] = {};
  for (int j = 0; j < kScoreColumns; ++j) {
    for (int k = 0; k <= j; ++k) total[j][k] = at<kWidth>(products.sums[j][k] + lane);
    for (int step = kLaneSteps - width; step < kLaneSteps; ++step)
      sum[j] += at<kWidth>(moving.before[step][j] + lane);
  }
  for (int step = 0; step < kLaneSteps; ++step) {
    const Scores<kWidth> scores = keepScores<kWidth>(left, derivatives, step, lane, moving);
    const auto& gone =
        step < width ? moving.before[step + kLaneSteps - width] : moving.here[step - width];
    for (int j = 0; j < kScoreColumns; ++j) sum[j] += scores.of[j] - at<kWidth>(gone[j] + lane);
    for (int j = 0; j < kScoreColumns; ++j)
      for (int k = 0; k <= j; ++k) total[j][k] += sum[j] * sum[k];
  }
  for (int j = 0; j < kScoreColumns; ++j)
    for (int k = 0; k <= j; ++k) at<kWidth>(products.sums[j][k] + lane) = total[j][k];
}

template <int kWidth>
BATTERY_SOF_INLINE void addMoving(const MeasuredBlock& left, const DerivativeBlock& derivatives,
                                  int width, MovingScores& moving, ScoreProducts& products) {
  lookBack<kWidth>(left, derivatives, width, moving);
  for (int lane = 0; lane < kLanes; lane += kWidth)
    multiply<kWidth>(left, derivatives, width, lane, moving, products);
}

#if BATTERY_SOF_X86_DISPATCH
BATTERY_SOF_TARGET_AVX2 void leaveAvx2(const OverpotentialStates& states,
                                       const double (&linear)[kLinearColumns],
                                       MeasuredBlock& measured, ResidualSums& sums) {
  leave<4>(states, linear, measured, sums);
}

BATTERY_SOF_TARGET_AVX512 void leaveAvx512(const OverpotentialStates& states,
                                           const double (&linear)[kLinearColumns],
                                           MeasuredBlock& measured, ResidualSums& sums) {
  leave<kLanes>(states, linear, measured, sums);
}

BATTERY_SOF_TARGET_AVX2 void addUpAvx2(const MeasuredBlock& left,
                                       const DerivativeBlock& derivatives, ScoreSums& sums) {
  addUp<4>(left, derivatives, sums);
}

BATTERY_SOF_TARGET_AVX512 void addUpAvx512(const MeasuredBlock& left,
                                           const DerivativeBlock& derivatives, ScoreSums& sums) {
  addUp<kLanes>(left, derivatives, sums);
}

BATTERY_SOF_TARGET_AVX2 void addMovingAvx2(const MeasuredBlock& left,
                                           const DerivativeBlock& derivatives, int width,
                                           MovingScores& moving, ScoreProducts& products) {
  addMoving<4>(left, derivatives, width, moving, products);
}

BATTERY_SOF_TARGET_AVX512 void addMovingAvx512(const MeasuredBlock& left,
                                               const DerivativeBlock& derivatives, int width,
                                               MovingScores& moving, ScoreProducts& products) {
  addMoving<kLanes>(left, derivatives, width, moving, products);
}
#endif

}  // namespace

void leaveResidual(const OverpotentialStates& states, const double (&linear)[kLinearColumns],
                   MeasuredBlock& measured, ResidualSums& sums, InstructionSet set) {
#if BATTERY_SOF_X86_DISPATCH
  if (set == InstructionSet::kAvx512) return leaveAvx512(states, linear, measured, sums);
  if (set == InstructionSet::kAvx2) return leaveAvx2(states, linear, measured, sums);
#endif
  static_cast<void>(set);
  leave<2>(states, linear, measured, sums);
}

void addUpScores(const MeasuredBlock& left, const DerivativeBlock& derivatives, ScoreSums& sums,
                 InstructionSet set) {
#if BATTERY_SOF_X86_DISPATCH
  if (set == InstructionSet::kAvx512) return addUpAvx512(left, derivatives, sums);
  if (set == InstructionSet::kAvx2) return addUpAvx2(left, derivatives, sums);
#endif
  static_cast<void>(set);
  addUp<2>(left, derivatives, sums);
}

void addMovingProducts(const MeasuredBlock& left, const DerivativeBlock& derivatives, int width,
                       MovingScores& moving, ScoreProducts& products, InstructionSet set) {
#if BATTERY_SOF_X86_DISPATCH
  if (set == InstructionSet::kAvx512)
    return addMovingAvx512(left, derivatives, width, moving, products);
  if (set == InstructionSet::kAvx2)
    return addMovingAvx2(left, derivatives, width, moving, products);
#endif
  static_cast<void>(set);
  addMoving<2>(left, derivatives, width, moving, products);
}

}  // namespace battery_sof

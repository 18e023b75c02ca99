#include "estimation/base_kernel.hpp"

#include "model/instruction_sets.hpp"

namespace battery_sof {
namespace {

/// The state columns kFirst to kLast - 1, kWidth samples side by side.
template <int kWidth, int kFirst, int kLast>
BATTERY_SOF_INLINE void addRows(const MeasuredBlock& measured, const OverpotentialStates& states,
                                int lane, LaneProducts& products) {
  using Value = typename Register<kWidth>::Type;
  Value linear[kStateColumns][kLinearColumns], own[kStateColumns][kStateColumns];
  for (int j = kFirst; j < kLast; ++j) {
    for (int k = 0; k < kLinearColumns; ++k)
      linear[j][k] = at<kWidth>(products.with_linear[j][k] + lane);
    for (int k = j; k < kStateColumns; ++k)
      own[j][k] = at<kWidth>(products.with_states[j][k] + lane);
  }
  for (int n = lane; n < kBlockSize; n += kLanes) {
    const Value column[kStateColumns] = {
        at<kWidth>(states.d_log_c2 + n), at<kWidth>(states.d_log_beta + n),
        at<kWidth>(states.d_initial + n),
        at<kWidth>(measured.voltage + n) - at<kWidth>(states.u_c2 + n)};
    for (int j = kFirst; j < kLast; ++j) {
      const Value weighted = at<kWidth>(measured.weight + n) * column[j];
      linear[j][0] += weighted * at<kWidth>(measured.discharge + n);
      linear[j][1] += weighted * at<kWidth>(measured.charge + n);
      linear[j][2] += weighted;
      for (int k = j; k < kStateColumns; ++k) own[j][k] += weighted * column[k];
    }
  }
  for (int j = kFirst; j < kLast; ++j) {
    for (int k = 0; k < kLinearColumns; ++k)
      at<kWidth>(products.with_linear[j][k] + lane) = linear[j][k];
    for (int k = j; k < kStateColumns; ++k)
      at<kWidth>(products.with_states[j][k] + lane) = own[j][k];
  }
}

/// In two halves where the registers do not hold all 22 sums.
template <int kWidth>
BATTERY_SOF_INLINE void add(const MeasuredBlock& measured, const OverpotentialStates& states,
                            LaneProducts& products) {
  for (int lane = 0; lane < kLanes; lane += kWidth) {
    if constexpr (kWidth == kLanes) {
      addRows<kWidth, 0, kStateColumns>(measured, states, lane, products);
    } else {
      addRows<kWidth, 0, 2>(measured, states, lane, products);
      addRows<kWidth, 2, kStateColumns>(measured, states, lane, products);
    }
  }
}

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

}  // namespace

BATTERY_SOF_DISPATCH(addProducts, add,
                     (const MeasuredBlock& measured, const OverpotentialStates& states,
                      LaneProducts& products),
                     (measured, states, products))
BATTERY_SOF_DISPATCH(leaveResidual, leave,
                     (const OverpotentialStates& states, const double (&linear)[kLinearColumns],
                      MeasuredBlock& measured, ResidualSums& sums),
                     (states, linear, measured, sums))
BATTERY_SOF_DISPATCH(addUpScores, addUp,
                     (const MeasuredBlock& left, const DerivativeBlock& derivatives,
                      ScoreSums& sums),
                     (left, derivatives, sums))
BATTERY_SOF_DISPATCH(addMovingProducts, addMoving,
                     (const MeasuredBlock& left, const DerivativeBlock& derivatives, int width,
                      MovingScores& moving, ScoreProducts& products),
                     (left, derivatives, width, moving, products))

}  // namespace battery_sof

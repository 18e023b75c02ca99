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

}  // namespace

BATTERY_SOF_DISPATCH(addProducts, add,
                     (const MeasuredBlock& measured, const OverpotentialStates& states,
                      LaneProducts& products),
                     (measured, states, products))

}  // namespace battery_sof

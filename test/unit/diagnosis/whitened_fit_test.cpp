#include "diagnosis/whitened_fit.hpp"

#include <gtest/gtest.h>

namespace battery_sof {
namespace {

constexpr double kInterval = 0.01;  // [s]

/// A drive at 100 Hz whose current is `before` for a second, then `after`.
InputSequence stepped(double before, double after) {
  Series series;
  for (int n = 0; n < 200; ++n) {
    series.append({kInterval * n, n < 100 ? before : after, 12.5});
  }
  return inputSequence(series, {0, series.size()});
}

/// Samples that do not count, the drive's beginning left out.
std::size_t isHiddenBy(double before, double after) {
  const InputSequence quiet = withoutEdges(stepped(before, after), 5.0, 0.1, 0.15);
  std::size_t hidden = 0;
  for (std::size_t n = 50; n < quiet.samples.size(); ++n) hidden += quiet.samples[n].count == 0.0;
  return hidden;
}

TEST(WithoutEdges, AnEdgeHidesWhatIsAroundIt) {
  EXPECT_NEAR(25.0, static_cast<double>(isHiddenBy(10.0, 20.0)), 2.0);
  EXPECT_EQ(0u, isHiddenBy(10.0, 13.0));
}

TEST(WithoutEdges, AChangeOfSignIsAnEdgeFromAFifthOn) {
  EXPECT_NEAR(25.0, static_cast<double>(isHiddenBy(-1.0, 2.0)), 2.0);
  EXPECT_EQ(0u, isHiddenBy(-0.2, 0.3)) << "noise around zero is none";
  EXPECT_EQ(0u, isHiddenBy(0.0, 3.0));
}

}  // namespace
}  // namespace battery_sof

#include "simulator/filters.hpp"

#include <complex>
#include <stdexcept>
#include <string>

#include "simulator/units.hpp"

namespace battery_sof_simulator {
namespace {

using Complex = std::complex<double>;

/// The roots of theta_8 above the real axis, and w_3, where |theta_8(j w)| is sqrt 2 times
/// theta_8(0).
constexpr double kHalfPower = 3.179617237510652;
const std::array<Complex, BesselFilter::kOrder / 2> kRoots{
    {{-5.5878860432632926, 0.86761444535210752},
     {-2.8389839488976341, 6.3539112986048858},
     {-4.3682892172024701, 4.4144425004715657},
     {-5.2048407906367364, 2.616175152642795}}};

}  // namespace

BesselFilter::BesselFilter(double cutoff, double rate) {
  if (!(cutoff > 0.0 && rate > 0.0 && cutoff < 0.5 * rate))
    throw std::invalid_argument("Bessel filter: cut-off is " + std::to_string(cutoff) +
                                " Hz, expected above 0 and below half of " + std::to_string(rate) +
                                " Hz");
  const double warped = 2.0 * rate * std::tan(kPi * cutoff / rate);
  for (std::size_t k = 0; k < kRoots.size(); ++k) {
    const Complex pole = kRoots[k] * warped / kHalfPower;
    const Complex z = (2.0 * rate + pole) / (2.0 * rate - pole);
    const double a1 = -2.0 * z.real(), a2 = std::norm(z);
    sections_[k] = {0.25 * (1.0 + a1 + a2), a1, a2};
  }
  delay_ = kHalfPower / warped;  // theta_n delays by 1 at s = 0
}

}  // namespace battery_sof_simulator

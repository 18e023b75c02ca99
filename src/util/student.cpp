#include "util/student.hpp"

#include <boost/math/distributions/students_t.hpp>
#include <stdexcept>

#include "util/text.hpp"

namespace battery_sof {

double studentQuantile(double probability, double degrees) {
  if (!(probability > 0.0 && probability < 1.0 && degrees > 0.0))
    throw std::invalid_argument(format(
        "studentQuantile: probability is %g and degrees are %g, expected in (0, 1) and above 0",
        probability, degrees));
  return boost::math::quantile(boost::math::students_t(degrees), probability);
}

}  // namespace battery_sof

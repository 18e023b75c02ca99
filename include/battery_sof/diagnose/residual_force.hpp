#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "battery_sof/diagnose/diagnosis.hpp"
#include "battery_sof/diagnose/whitened_fit.hpp"

namespace battery_sof {

/// What a term of the library makes of the drive.
enum class Force {
  kCurrent,           ///< i [A]
  kCharging,          ///< max(i, 0) [A]
  kCompressed,        ///< asinh(i / 5 A) [1]
  kQuadratic,         ///< i |i| [A^2]
  kMagnitude,         ///< |i| [A]
  kCurrentMagnitude,  ///< i times the memory of |i| [A^2]
  kCharge,            ///< charge moved since the first sample [Ah]
  kTime,              ///< since the first sample [s]
  kDoubleLayer,       ///< u_c2 [V]
};

/// A force through a low-pass of first order with this time constant; 0: as it is.
struct ForceTerm {
  Force force;
  double time = 0.0;  ///< [s]
};

/// @return the library of PHYSICS 2.4 with time constants of 0.05 to 1000 s, up to a third of the drive's span.
std::vector<ForceTerm> forceLibrary(const Drive& drive);

/// @return samples x terms, in the terms' units; the memories begin empty.
Eigen::MatrixXd forceColumns(const WhitenedFit& fit, const Drive& drive, const std::vector<ForceTerm>& library);

/**
 * @brief Whether the residual holds anything that currents and their memory explain (PHYSICS 2.2, L1).
 *
 *     z_O = (|P_X v|^2 / s^2 - k) / sqrt(2 k),   X: the library after projection, k: its numerical rank
 *
 * s^2 is innovationVariance(): the library does not lessen it.
 *
 * @return 0 when no column is left.
 */
double omnibusZ(const WhitenedFit& fit, const Drive& drive);

/**
 * @brief Describes a residual without a hypothesis (PHYSICS 2.4).
 *
 * - omnibus_z as omnibusZ();
 * - charge, discharge: weights of LP_tau[max(i, 0)] and LP_tau[min(i, 0)] by a ridge whose strength makes the data most
 *   likely. What is instantaneous is r_charge's and r_discharge's own and does not show;
 * - rms: of the whole library's ridge fit after what the parameters would take up;
 * - terms: chosen one after the other by what each adds (orthogonal matching pursuit), each worth z^2 > 16 and found again
 *   in 40 of 50 halves of 20 blocks of time, itself or a look-alike (cosine above 0.9). Empty when three stable terms hold
 *   less than 0.8 of what the library explains beyond chance.
 *
 * nearest and cosine are left for the caller.
 */
ResidualForce describeResidual(const WhitenedFit& fit, const Drive& drive);

}  // namespace battery_sof

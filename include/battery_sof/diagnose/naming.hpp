#pragma once

#include <functional>
#include <string>
#include <vector>

#include "battery_sof/diagnose/diagnosis.hpp"
#include "battery_sof/diagnose/hypotheses.hpp"
#include "battery_sof/diagnose/thresholds.hpp"

namespace battery_sof {

/// An effect that was accepted, with what it was weighed against.
struct Accepted {
  std::string id;
  double score = 0.0;            ///< when it was found
  double evidence = 0.0;         ///< fall of the criterion it brings to the final model
  double rms = 0.0;              ///< [V], what it adds to the voltage that the others cannot
  std::vector<std::string> tied; ///< ids that could stand in its place
  double confidence = 0.0;
  double share = 0.0;            ///< [1], of the RMS error on blocks held out of the fit, that it took out when it was found
};

/// What the search through the catalogue ended with.
struct Naming {
  WhitenedFit extended;
  std::vector<Accepted> accepted;
  std::vector<Candidate> candidates;   ///< of the first step, and those accepted or rejected later
  std::vector<Signature> last_screen;  ///< beside the extended model
  bool unnamed = false;                ///< the best hypothesis was significant but below what a name needs
};

struct NamingOptions {
  DiagnosisThresholds thresholds;
  std::vector<std::string> hypotheses;
  int threads = 1;
  double least_white = 1e-5;  ///< [V]
  double interval = 0.0;      ///< [s] between the recording's samples; a delay or lag below a tenth of it is not named
  std::function<void(const std::string&)> progress;
};

/**
 * @brief Forward selection over the catalogue with a backward check (PHYSICS 2.3).
 *
 * In every step all hypotheses are scored, the best and their look-alikes refitted jointly with what was accepted, noise
 * included; the one of most evidence
 *
 *     evidence = D_nested - D - c_n k,   D: -2 ln likelihood with priors,  c_n = max(ln n_eff, 6),  k: free strengths and shapes
 *
 * is accepted if it also gains on blocks held out of the fit. At the end every accepted effect must still be worth its
 * place, and is compared with what could stand there.
 *
 * @param start a fit to this drive: the base model's, or that of what was accepted before on another grid (so_far).
 */
Naming nameEffects(const Drive& drive, const WhitenedFit& start, const NamingOptions& options, Naming so_far = {});

/**
 * @brief The start with these effects added one after the other, and what they need: no test, no objection.
 *
 * For what is known to be there. Each is found where its signature fits best, as a hypothesis would be; its evidence is
 * what it brought when it came.
 */
Naming withEffects(const Drive& drive, const WhitenedFit& start, const std::vector<std::string>& ids,
                   const WhitenedSearch& search, Naming so_far = {});

/// @return samples that count as independent: n / (1 + 2 sum of the residual's autocorrelations up to the first not above zero).
double effectiveSamples(const Eigen::VectorXd& residual, const Drive& drive);

/// @return c_n = max(ln n_eff, 6): what the criterion takes for each parameter more.
double penaltyOf(const WhitenedFit& fit, const Drive& drive);

/// What speaks for a name beside structure, its evidence apart.
struct NameBeside {
  double share = 0.0;  ///< [1], of the RMS error on blocks held out of the fit, that the effect takes out
  double left = 0.0;   ///< of -2 ln likelihood, what stays unexplained with it (leftUnexplained())
};

/**
 * @brief Evidence that a name of the effect takes beside what was accepted.
 *
 * The catalogue's structure stands for a battery's own, which is never quite that: what is left of it is no physics, and can
 * be as large as the structure's evidence E_s and what stays unexplained allow. A name of tier P or I needs
 *
 *     share >= 1/2:  max(T2, min(0.02 E_s, left)),     share < 1/2:  max(T2, 0.1 E_s, left)
 *
 * and one that acts at edges alone max(T2, 0.02 E_s). E_s: of the most evident piece on the grid without edges; where there
 * is none, T2.
 */
double evidenceNeeded(const std::string& id, const std::vector<Accepted>& accepted, const DiagnosisThresholds& thresholds,
                      const NameBeside& beside);

/// @return what currents and their memory explain of a fit's residual, in units of -2 ln likelihood: 10 z_O (omnibusZ()).
double leftUnexplained(const WhitenedFit& fit, const Drive& drive);

}  // namespace battery_sof

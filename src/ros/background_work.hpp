#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnosis.hpp"

namespace boost::asio {
class thread_pool;
}

namespace battery_sof {

/// One thread that does one piece of work after the other, so that nothing else waits for it. The
/// work throws nothing.
class BackgroundWorker {
 public:
  /// @param nice 0 to 19; higher gives way to more. On Linux it is a thread's own; threads it
  /// starts inherit it.
  explicit BackgroundWorker(int nice);
  /// Lets running work end, then joins.
  ~BackgroundWorker();

  /// Hands over work, which waits for what was posted before. It is dropped when the worker ends
  /// first.
  void post(std::function<void()> work);
  /// Begins nothing more and joins the thread.
  void stop();

 private:
  std::unique_ptr<boost::asio::thread_pool> thread_;
};

/// What a diagnosis came to.
struct FinishedDiagnosis {
  std::optional<Diagnosis> diagnosis;  ///< none when it broke off
  std::string fault;                   ///< why, one sentence
  double from = 0.0, to = 0.0;         ///< [s], of the recording
  std::size_t samples = 0;
  double duration_ms = 0.0;  ///< [ms], wall time
};

/// What a session is to fit of a diagnosis, and why.
struct Adoption {
  std::vector<std::string> effects;  ///< the extended composition; empty: nothing
  std::string sentence;
  /// of "discrepancy" among the effects
  std::shared_ptr<const DiscrepancyModel> discrepancy = nullptr;
};

/**
 * @brief Whether a diagnosis' extended composition is fitted to the session's next windows.
 *
 * It is where the current is the input (while a charger regulates the voltage, an identification
 * chooses its effects by itself), when the verdict is effect or several and the composition holds structure or physics (tiers
 * S and P), and whenever it holds a discrepancy; never where the hold-out denied it. Instrument
 * effects (tier I) come along with those, and the sentence names them all; alone they do not: a
 * faulty instrument needs repair, and a question's currents are true ones, not what that instrument
 * would have read.
 * @param allowed parameter use_diagnosis.
 */
Adoption adoptionOf(const Diagnosis& diagnosis, bool allowed);

}  // namespace battery_sof

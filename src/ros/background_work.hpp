#pragma once

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "diagnosis/diagnosis.hpp"

namespace battery_sof {

/// Lets other threads go first: on Linux a nice value is a thread's own; threads it starts inherit
/// it.
inline void giveWay(int nice) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), nice);
}

/// One thread that does jobs, one at a time, so that nothing else waits for them. The work is
/// called on the worker's thread and throws nothing.
template <typename Job>
class BackgroundWorker {
 public:
  using Work = std::function<void(Job)>;

  /// @param nice 0 to 19; higher gives way to more.
  BackgroundWorker(Work work, int nice)
      : work_(std::move(work)), thread_([this, nice] { loop(nice); }) {}
  /// Lets a running job end, then joins.
  ~BackgroundWorker() { stop(); }

  BackgroundWorker(const BackgroundWorker&) = delete;
  BackgroundWorker& operator=(const BackgroundWorker&) = delete;

  /// Hands over a job; none may be posted already. While one runs this one waits for its end. It is
  /// dropped when the worker ends first.
  void post(Job job) {
    const std::lock_guard<std::mutex> lock(mutex_);
    posted_.emplace(std::move(job));
    changed_.notify_all();
  }

  /// Begins nothing more and joins the thread.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
      changed_.notify_all();
    }
    if (thread_.joinable()) thread_.join();
  }

 private:
  void loop(int nice) {
    giveWay(nice);
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stopping_ || posted_; });
      if (stopping_) return;
      Job job = std::move(*posted_);
      posted_.reset();
      lock.unlock();
      work_(std::move(job));
      lock.lock();
    }
  }

  Work work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Job> posted_;
  bool stopping_ = false;
  std::thread thread_;
};

/// What a diagnosis came to.
struct FinishedDiagnosis {
  std::optional<Diagnosis> diagnosis;  ///< none when it broke off
  std::string fault;                   ///< why, one sentence
  double from = 0.0, to = 0.0;         ///< [s], of the recording
  std::size_t samples = 0;
  double duration_ms = 0.0;  ///< [ms], wall time
};

/// What a session is to try of a diagnosis, and why.
struct Adoption {
  std::vector<std::string> effects;  ///< the extended composition; empty: nothing
  std::string sentence;
  /// of "discrepancy" among the effects
  std::shared_ptr<const DiscrepancyModel> discrepancy = nullptr;
};

/**
 * @brief Whether a diagnosis' extended composition is evaluated in parallel to the base model.
 *
 * It does when the verdict is named or several and the composition holds structure or physics
 * (tiers S and P), and whenever it holds a discrepancy. Instrument effects (tier I)
 * come along with those, and the sentence names them all; alone they do not: a faulty instrument
 * needs repair, and a question's currents are true ones, not what that instrument would have read.
 * @param allowed parameter use_diagnosis.
 */
Adoption adoptionOf(const Diagnosis& diagnosis, bool allowed);

}  // namespace battery_sof

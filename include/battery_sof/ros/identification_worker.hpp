#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <thread>

#include "battery_sof/predict/online_session.hpp"

namespace battery_sof {

/**
 * @brief One thread that runs identifications, one at a time, so that nothing else waits for them.
 *
 * fit_ms of the models is filled in here, where a clock is at hand. An exception out of an
 * identification becomes a result without a model.
 */
class IdentificationWorker {
 public:
  using TakeBack = std::function<IdentificationOutcome(IdentificationResult)>;

  /// @param take_back called on the worker's thread with every result; its outcome fulfils the
  /// job's future.
  explicit IdentificationWorker(TakeBack take_back);
  /// Lets a running identification end, then joins.
  ~IdentificationWorker();

  IdentificationWorker(const IdentificationWorker&) = delete;
  IdentificationWorker& operator=(const IdentificationWorker&) = delete;

  /// Hands over a job; the worker must be idle. @return its outcome to come; a broken promise when
  /// the worker ends first.
  std::future<IdentificationOutcome> post(IdentificationJob job);

  /// Returns when no job is posted or running, at once when it is so already or the worker has been
  /// told to end.
  void waitUntilIdle();

  /// Accepts nothing more and joins the thread.
  void stop();

 private:
  struct Posted {
    IdentificationJob job;
    std::promise<IdentificationOutcome> outcome;
  };

  void loop();

  TakeBack take_back_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Posted> posted_;
  bool busy_ = false;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace battery_sof

#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <future>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace battery_sof {

/// Lets other threads go first: on Linux a nice value is a thread's own; threads it starts inherit
/// it.
void giveWay(int nice);

/**
 * @brief One thread that does jobs, one at a time, so that nothing else waits for them.
 *
 * The work is called on the worker's thread; what it throws is thrown by the outcome's get().
 */
template <typename Job, typename Outcome>
class BackgroundWorker {
 public:
  using Work = std::function<Outcome(Job)>;

  /// @param nice 0 to 19; higher gives way to more.
  BackgroundWorker(Work work, int nice)
      : work_(std::move(work)), thread_([this, nice] { loop(nice); }) {}
  /// Lets a running job end, then joins.
  ~BackgroundWorker() { stop(); }

  BackgroundWorker(const BackgroundWorker&) = delete;
  BackgroundWorker& operator=(const BackgroundWorker&) = delete;

  /// Hands over a job; the worker must be idle. @return its outcome to come; a broken promise when
  /// the worker ends first.
  std::future<Outcome> post(Job job) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stopping_) return std::promise<Outcome>().get_future();
    posted_.emplace(Posted{std::move(job), {}});
    busy_ = true;
    changed_.notify_all();
    return posted_->outcome.get_future();
  }

  /// Returns when no job is posted or running, at once when it is so already or the worker has been
  /// reported to end, and after `longest` in any case.
  void waitUntilIdle(std::chrono::milliseconds longest) {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait_for(lock, longest, [this] { return stopping_ || !busy_; });
  }

  /// Accepts nothing more and joins the thread.
  void stop() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stopping_ = true;
      changed_.notify_all();
    }
    if (thread_.joinable()) thread_.join();
    posted_.reset();
  }

 private:
  struct Posted {
    Job job;
    std::promise<Outcome> outcome;
  };

  void loop(int nice) {
    giveWay(nice);
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stopping_ || posted_; });
      if (stopping_) return;
      Posted posted = std::move(*posted_);
      posted_.reset();
      lock.unlock();
      try {
        posted.outcome.set_value(work_(std::move(posted.job)));
      } catch (...) {
        posted.outcome.set_exception(std::current_exception());
      }
      lock.lock();
      // A job may have been posted since the work handed its result on.
      busy_ = posted_.has_value();
      changed_.notify_all();
    }
  }

  Work work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Posted> posted_;
  bool busy_ = false;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace battery_sof

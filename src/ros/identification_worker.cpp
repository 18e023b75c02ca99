#include "battery_sof/ros/identification_worker.hpp"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <utility>

namespace battery_sof {

namespace {

IdentificationResult timedIdentification(const IdentificationJob& job) {
  const auto start = std::chrono::steady_clock::now();
  IdentificationResult result;
  try {
    result = runIdentification(job);
  } catch (const std::exception& error) {
    result.epoch = job.epoch;
    result.message = std::string("the identification failed: ") + error.what();
  }
  const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
  if (result.model) result.model->fit_ms = taken.count();
  return result;
}

/// Lets the other threads go first. On Linux a nice value is a thread's own; threads it starts inherit it.
void standBack() {
  constexpr int kNice = 10;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNice);
}

}  // namespace

IdentificationWorker::IdentificationWorker(TakeBack take_back)
    : take_back_(std::move(take_back)), thread_([this] { loop(); }) {}

IdentificationWorker::~IdentificationWorker() { stop(); }

std::future<IdentificationOutcome> IdentificationWorker::post(IdentificationJob job) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (stopping_) return std::promise<IdentificationOutcome>().get_future();
  posted_ = Posted{std::move(job), {}};
  busy_ = true;
  changed_.notify_all();
  return posted_->outcome.get_future();
}

void IdentificationWorker::waitUntilIdle() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return stopping_ || !busy_; });
}

void IdentificationWorker::stop() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stopping_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  posted_.reset();
}

void IdentificationWorker::loop() {
  standBack();
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || posted_; });
    if (stopping_) return;
    Posted posted = std::move(*posted_);
    posted_.reset();
    lock.unlock();
    posted.outcome.set_value(take_back_(timedIdentification(posted.job)));
    lock.lock();
    // A job may have been posted since the session took the result back.
    busy_ = posted_.has_value();
    changed_.notify_all();
  }
}

}  // namespace battery_sof

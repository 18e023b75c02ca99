#include "progress.hpp"

#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <ostream>

#include "util/text.hpp"

namespace battery_sof {
namespace {

constexpr double kProgressAfter = 2.0;      // [s]
constexpr double kMinShare = 0.02;          // below it the pace is not known
constexpr char kEmptied[] = "\r\033[K";     // the line under the cursor
constexpr std::chrono::seconds kPeriod{1};  // of the line below the stage

/// A thread that leaves all signals to the others.
template <typename Work>
std::thread unsignalled(Work work) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  std::thread thread(std::move(work));
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return thread;
}

/// Time of the clock that is never set [s].
double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

constexpr long kLook = 20L * 1000 * 1000;  // [ns], how often it checks whether the work is over

sigset_t interrupts() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

std::string pace(double elapsed, double in_stage, std::optional<double> share) {
  const std::string passed = format("%.0f s", elapsed);
  if (!share || *share < kMinShare || *share > 1.0) return passed;
  return passed + format(", about %.0f s left", in_stage * (1.0 - *share) / *share);
}

Progress::Progress(std::ostream& err)
    : err_(err), started_(steadySeconds()), stage_("reading"), stage_began_(started_) {
  if (isatty(STDERR_FILENO)) ticker_ = unsignalled([this] { tick(); });
}

void Progress::end() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_over_ = true;
    clear();
    changed_.notify_all();
  }
  if (ticker_.joinable()) ticker_.join();
}

void Progress::hide() {
  const std::lock_guard<std::mutex> lock(mutex_);
  clear();
}

void Progress::clear() {
  if (line_is_shown_) err_ << kEmptied << std::flush;
  line_is_shown_ = false;
}

void Progress::stage(const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  stage_ = what;
  stage_began_ = steadySeconds();
  share_.reset();
  stage_is_shown_ = false;
  if (ticker_.joinable() && stage_began_ - started_ > kProgressAfter) show();
}

void Progress::done(double share) {
  const std::lock_guard<std::mutex> lock(mutex_);
  share_ = share;
}

void Progress::tick() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(kProgressAfter),
                    [this] { return is_over_; });
  while (!is_over_) {
    show();
    changed_.wait_for(lock, kPeriod, [this] { return is_over_; });
  }
}

void Progress::show() {
  clear();
  if (!stage_is_shown_) err_ << stage_ << " ...\n";
  const double now = steadySeconds();
  err_ << "  " << pace(now - started_, now - stage_began_, share_) << std::flush;
  stage_is_shown_ = line_is_shown_ = true;
}

void Progress::sayStopped() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (ticker_.joinable()) err_ << kEmptied;
  err_ << format("sof: stopped after %.0f s while ", steadySeconds() - started_) << stage_
       << "; no file was written\n"
       << std::flush;
}

Interruption::Interruption(Progress& progress) : progress_(progress) {
  const sigset_t set = interrupts();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  watcher_ = std::thread([this] { wait(); });
}

Interruption::~Interruption() {
  is_over_ = true;
  watcher_.join();
  const sigset_t set = interrupts();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

void Interruption::wait() {
  const sigset_t set = interrupts();
  const timespec look = {0, kLook};
  while (!is_over_) {
    const int signal = sigtimedwait(&set, nullptr, &look);
    if (signal <= 0) continue;
    progress_.sayStopped();
    ::signal(signal, SIG_DFL);
    raise(signal);  // waits until this thread lets the signal through
    pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
    return;
  }
}

}  // namespace battery_sof

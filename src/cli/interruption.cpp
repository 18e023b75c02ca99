#include "interruption.hpp"

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <ostream>

#include "progress.hpp"
#include "util/text.hpp"

namespace battery_sof {

namespace {

constexpr long kLook = 20L * 1000 * 1000;  // [ns], how often it checks whether the work is over

sigset_t interrupts() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

}  // namespace

Interruption::Interruption(std::ostream& err) : err_(err), started_(steadySeconds()) {
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

void Interruption::stage(const std::string& what) {
  const std::lock_guard<std::mutex> lock(mutex_);
  stage_ = what;
}

void Interruption::wait() {
  const sigset_t set = interrupts();
  const timespec look = {0, kLook};
  while (!is_over_) {
    const int signal = sigtimedwait(&set, nullptr, &look);
    if (signal > 0) return end(signal);
  }
}

void Interruption::end(int signal) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (isatty(STDERR_FILENO)) err_ << "\r\033[K";  // over the line of Progress
  err_ << format("sof: stopped after %.0f s while ", steadySeconds() - started_) << stage_
       << "; no file was written\n"
       << std::flush;
  ::signal(signal, SIG_DFL);
  raise(signal);  // waits until this thread lets the signal through
  const sigset_t set = interrupts();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

}  // namespace battery_sof

#pragma once

#include <atomic>
#include <iosfwd>
#include <mutex>
#include <string>
#include <thread>

namespace battery_sof {

/**
 * @brief While it lives, an interrupt (Ctrl-C) or a request to end says what was done by then, and
 * ends the program at once.
 *
 * The program still ends by that signal, so that a shell or a script sees it. Nothing that is being
 * written appears: files are written whole or not at all. Threads that are started while it lives
 * leave the signals to it.
 */
class Interruption {
 public:
  explicit Interruption(std::ostream& err);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// What has begun, in words that fit behind "while".
  void stage(const std::string& what);

 private:
  void wait();
  void end(int signal);

  std::ostream& err_;
  const double started_;
  std::mutex mutex_;
  std::string stage_ = "reading";
  std::atomic<bool> is_over_{false};
  std::thread watcher_;
};

}  // namespace battery_sof

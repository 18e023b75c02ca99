#pragma once

#include <atomic>
#include <condition_variable>
#include <iosfwd>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace battery_sof {

/// @return what is said of a stage under way: how long it all has taken and, where a share of the
/// stage is known to be done, how long the rest of it will take at that pace. @param elapsed [s].
/// @param in_stage [s].
std::string pace(double elapsed, double in_stage, std::optional<double> share);

/**
 * @brief Says on err what is being done, from two seconds of work on and only when standard error
 * is a terminal: the stage, and below it, again every second, the time it has taken and will still
 * take.
 */
class Progress {
 public:
  explicit Progress(std::ostream& err);
  ~Progress() { end(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// @param what has begun, in words that fit behind "while".
  void stage(const std::string& what);
  /// How much of the stage is done, 0 to 1. May be called as often as one likes.
  void done(double share);
  /// Clears its line, for something else to be said there.
  void hide();
  /// Says that the work is ended in the middle of its stage.
  void sayStopped();
  /// Says nothing more, before the result is printed.
  void end();

 private:
  void tick();
  // These need mutex_ held.
  void show();
  void clear();

  std::ostream& err_;
  const double started_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::string stage_;
  double stage_began_;
  std::optional<double> share_;
  bool stage_is_shown_ = false, line_is_shown_ = false, is_over_ = false;
  std::thread ticker_;  // none where nothing is shown
};

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
  explicit Interruption(Progress& progress);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

 private:
  void wait();

  Progress& progress_;
  std::atomic<bool> is_over_{false};
  std::thread watcher_;
};

}  // namespace battery_sof

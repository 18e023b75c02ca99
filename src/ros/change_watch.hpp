#pragma once

#include <ros/ros.h>

#include <cmath>
#include <memory>
#include <mutex>
#include <string>

#include "battery_sof/series.hpp"
#include "diagnosis/response_table.hpp"
#include "ros/background_work.hpp"

namespace battery_sof {

/**
 * @brief What has changed in the battery or its instruments since a reference, over drives.
 *
 * Stretches of `period` [s] of driving are drives. The reference is the mean of the first five that
 * can serve (kSoundDrives), of which setReference() may give the first; the state file keeps it
 * together with the responses of the drives since. What these come to is published after each of them on ~change (latched, std_msgs/String) as the JSON of `sof diagnose --reference`. Models are not run:
 * another battery is known by its serial number alone.
 *
 * May be called from any thread; the work is a thread's own.
 */
class ChangeWatch {
 public:
  /// @param period [s] of driving between comparisons; 0: nothing is compared by itself.
  ChangeWatch(ros::NodeHandle& private_node, double period);
  ~ChangeWatch() { worker_.stop(); }

  /// Goes on from a state file, whose finding is published again. @param reference none: there is
  /// none yet.
  void restore(const std::shared_ptr<const ResponseTable>& reference, const std::string& topic);
  /// Compares what came since the last time when it is due: by one thread at a time. @param driving [s].
  void beginIfDue(const Series& series, const std::string& topic, double driving);
  /// Another battery: the next stretch becomes the reference, and until then nothing can be said.
  void forget(const std::string& topic);
  /// @return the reference, with what came since, for the state file; none before the first.
  std::shared_ptr<const ResponseTable> responses() const;

  struct Outcome {
    bool success = false;
    std::string message;
  };
  /// Begins a reference with a recording as its first drive, whatever was before; nothing can be
  /// said until it is complete. @return why not, where it cannot serve.
  Outcome setReference(const Series& series, const std::string& topic);

 private:
  void compare(const Series& series, const std::string& topic, int epoch);
  /// @param reference none, or without drives since: that nothing can be said.
  void publish(const std::shared_ptr<const ResponseTable>& reference, const std::string& topic);

  const double period_;
  ros::Publisher publisher_;
  double next_due_;           // [s] of driving, of beginIfDue() alone
  mutable std::mutex mutex_;  // guards the next three
  std::shared_ptr<const ResponseTable> reference_;
  double taken_to_ = -HUGE_VAL;  // [s], up to which samples are in the reference or were compared
  int epoch_ = 0;                // of references: work on an older one is dropped
  BackgroundWorker worker_;
};

}  // namespace battery_sof

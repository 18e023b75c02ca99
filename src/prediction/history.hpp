#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "prediction/identification_job.hpp"
#include "prediction/model_monitor.hpp"
#include "prediction/sample_stream.hpp"
#include "recording/deep_discharge.hpp"

namespace battery_sof {

/// What the answers rest on: the population, a trip before, or a window of this one.
enum class AnswerBasis { kPopulation, kPreviousTrip, kThisTrip };

/// @return "population", "previous_trip", "this_trip".
std::string toString(AnswerBasis basis);

/// A model of an earlier trip. It starts at the first sample, where it is not refused.
struct SavedModel {
  FittedModel model;  ///< of one block
  /// one sentence: why it did not start at the sample that it was judged by; empty while it waits
  /// for one
  std::string refusal = {};
};

/// What a session knows at one moment: all that samples move. Everything is of one block.
struct Standing {
  SampleStream stream;   ///< the samples that are kept
  ModelMonitor monitor;  ///< the model that answers
  AnswerBasis basis = AnswerBasis::kPopulation;
  std::optional<SavedModel> saved = std::nullopt;  ///< until it starts
  std::optional<Sample> newest = std::nullopt;     ///< of the stream's samples on its rate
  double driving = 0.0;                            ///< [s], sampling intervals without the gaps
  double next_look = 0.0;  ///< [s] of driving, whether an identification is due
  bool is_denied = false;  ///< the model, at the newest sample
  ChargerShare source = {};
  DeepDischargeDetector deep_discharges = {};
  std::deque<double> charge_voltages = {};                ///< [V], means of the last charges
  std::string last_outcome = {}, missing_for_first = {};  ///< one sentence each, or empty
};

/// Moments that a session may go back to.
enum class Mark {
  kBeginning,        ///< before the first sample
  kBeforeClockJump,  ///< the last jump, as long as it may turn out wrong
  kJobTaken          ///< the identification that is out
};

/**
 * @brief The one way back: standings at marks, in order of time, and the samples since.
 *
 *     mark -> rewindTo   what came since was on a wrong clock: the session goes on from the mark
 *     mark -> replay     a model of the samples up to the mark: it follows those since
 *
 * The samples are those of the present stream. A copy shares the marked standings, which do not
 * change.
 */
class History {
 public:
  explicit History(Standing beginning);

  Standing& now() { return now_; }
  const Standing& now() const { return now_; }

  /// Keeps the present standing; one mark of a kind, the last.
  void mark(Mark mark);
  bool has(Mark mark) const;
  const Standing& at(Mark mark) const;  ///< needs the mark
  /// Whether the stream goes on from a mark, without a jump back of its clock. Needs the mark.
  bool continuesFrom(Mark mark) const;
  void remove(Mark mark);

  /**
   * @brief Goes on from a mark as if the samples since had not come. Needs the mark.
   *
   * What was counted stays (SampleStream::resumeAfter()). A job that was taken since
   * counts as taken at the mark. A jump of the clock is over.
   */
  void rewindTo(Mark mark);
  /// Lets a model answer that follows the samples behind its state first. They were reported
  /// before. @return whether its numbers stay finite.
  bool replay(ModelMonitor monitor);

 private:
  struct Marked {
    Mark mark;
    std::shared_ptr<const Standing> standing;
  };

  std::vector<Marked> marks_;  // in order of time
  Standing now_;
};

}  // namespace battery_sof

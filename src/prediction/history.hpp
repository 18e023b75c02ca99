#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

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
  /// one sentence: why it did not start at the sample that it was judged by; none while it waits
  /// for one
  std::optional<std::string> refusal = std::nullopt;
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
  std::deque<double> charge_voltages = {};                      ///< [V], means of the last charges
  std::string last_outcome = {};                                ///< one sentence, or empty
  std::optional<std::string> missing_for_first = std::nullopt;  ///< one sentence
};

/// Moments that a session may go back to.
enum class Mark {
  kBeginning,        ///< before the first sample
  kBeforeClockJump,  ///< the last jump, as long as it may turn out wrong
  kJobTaken          ///< the identification that is out
};

/**
 * @brief The one way back: what a session knew at marks, and the samples since, which are those of
 * the present stream.
 *
 *     mark -> rewindTo   what came since was on a wrong clock: the session goes on from the mark
 *     mark -> replay     a model of the samples up to the mark: it follows those since
 */
class History {
 public:
  explicit History(Standing beginning) : now_(std::move(beginning)) { mark(Mark::kBeginning); }

  Standing& now() { return now_; }
  const Standing& now() const { return now_; }

  /// Keeps the present standing, in place of the one that had this mark.
  void mark(Mark mark) { marks_[mark] = std::make_shared<const Standing>(now_); }
  bool has(Mark mark) const { return marks_.count(mark) > 0; }
  const Standing& at(Mark mark) const { return *marks_.at(mark); }  ///< needs the mark
  void remove(Mark mark) { marks_.erase(mark); }
  /// Removes a mark. Needs the mark. @return the standing at it.
  std::shared_ptr<const Standing> take(Mark mark) { return marks_.extract(mark).mapped(); }
  /// Whether the stream goes on from a standing, without a jump back of its clock.
  bool continuesFrom(const Standing& then) const;

  /// Goes on from a mark as if the samples since had not come; what was counted stays
  /// (SampleStream::resumeAfter()). A job that was taken since counts as taken at the mark, and no
  /// jump of the clock is left that may turn out wrong. Needs the mark.
  void rewindTo(Mark mark);
  /// Lets a model answer, after it followed the samples behind its state. Their events were reported
  /// before. @return whether its numbers stay finite.
  bool replay(ModelMonitor monitor);

 private:
  std::map<Mark, std::shared_ptr<const Standing>> marks_;  // a copy shares them
  Standing now_;
};

}  // namespace battery_sof

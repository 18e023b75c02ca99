#pragma once

#include <optional>
#include <string>
#include <vector>

#include "battery_sof/intake.hpp"
#include "battery_sof/series.hpp"
#include "prediction/stream_watch.hpp"
#include "recording/resample.hpp"

namespace battery_sof {

/// How many offered samples came to what.
struct StreamCounts {
  std::size_t accepted = 0;
  RejectedCounts rejected;  ///< by Intake
  /// a stamp more than kClockAhead ahead that the next sample did not confirm
  std::size_t stamp_ahead = 0;
  /// that none can be; the samples they came with are not counted as rejected
  std::size_t rejected_temperatures = 0;
  std::size_t clock_restarts = 0;
  std::size_t rejectedTotal() const { return rejected.total() + stamp_ahead; }
};

/// @return why samples were refused, as reasonsOf(RejectedCounts).
std::string reasonsOf(const StreamCounts& counts);
/// @return how many were refused and why, e.g. "12 rejected (10 duplicate stamp, 2 stamp ahead)".
std::string toString(const StreamCounts& counts);

/**
 * @brief Samples as they arrive, one by one: judged by Intake, brought to 100 Hz when they come
 * faster than 200 Hz, and the last stretch of them kept.
 *
 * The rate is that of the first second (at least five intervals), so the first samples come out
 * together.
 *
 * A stamp more than kClockBack before or kClockAhead after the newest is not believed alone: the
 * sample waits until the next one either goes on from it (a bag was looped, the ignition was off)
 * or does not (one bad stamp, counted and dropped). A confirmed jump back empties the stream and
 * begins again; the counts stay.
 */
class SampleStream {
 public:
  static constexpr double kClockBack = 10.0;   ///< [s]; real sensors' clocks step back by up to 3 s
  static constexpr double kClockAhead = 60.0;  ///< [s]; beyond it a stamp needs a witness

  /// @param kept [s], how much of the past is kept at least; > 0.  @param battery what the samples,
  /// each of one of its blocks, are said to be of.
  explicit SampleStream(double kept, const StreamBattery& battery = {});

  void setCapacity(double capacity) { watch_.setCapacity(capacity); }  ///< [Ah]

  /// @return what is new in the series, in order, on its rate.
  std::vector<Sample> push(const RawSample& sample);

  /// The first sample on the new clock, where this sample would confirm a jump of the clock; none
  /// else.
  std::optional<RawSample> jumpConfirmedBy(const RawSample& sample) const;
  /// Goes on where this stream stands, as if what another copy of it took since had not come. What
  /// that one counted and watched stays.
  void resumeAfter(const SampleStream& since);
  /// [s], last accepted stamp; none before the first.
  std::optional<double> newestStamp() const { return newest_; }

  /// The past, at least `kept` and at most 1.25 times as long.
  const Series& series() const { return series_; }
  /// Accepted as they came, and waiting for the rate to be known; empty afterwards.
  const Series& waiting() const { return probe_; }
  StreamCounts counts() const;
  /// The model that follows them misses their voltage: StreamWatch::doubt().
  void doubt() { watch_.doubt(series_, max_gap_); }
  /// Why nothing that rests on these samples is valid at present (StreamWatch); empty when it may be.
  std::optional<std::string> whyNotValid() const { return watch_.whyNotValid(reasonsOf(counts())); }

  /// Longest interval that is joined [s]: gapThreshold() of the measured rate; 5 s before it is
  /// known.
  double maxGap() const { return max_gap_; }

 private:
  bool isSuspicious(double time) const;
  void dropHeld();
  void restart();
  void enter(const RawSample& sample, std::vector<Sample>& added);
  void probe(const Sample& sample, std::vector<Sample>& added);
  void emit(const Sample& sample, std::vector<Sample>& added);
  void forgetOld();

  double kept_;
  Intake intake_;
  StreamCounts counts_;
  StreamWatch watch_;
  std::optional<double> newest_;      // [s], last accepted stamp
  std::optional<RawSample> held_;     // waits for a witness
  Series probe_;                      // first samples, until the rate is known
  std::optional<double> input_rate_;  // [Hz]
  std::optional<Decimator> decimator_;
  double max_gap_ = 5.0;
  Series series_;
};

}  // namespace battery_sof

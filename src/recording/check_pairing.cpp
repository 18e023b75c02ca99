#include <algorithm>
#include <cmath>

#include "check_parts.hpp"
#include "recording/channel_statistics.hpp"
#include "recording/deep_discharge.hpp"
#include "recording/events.hpp"
#include "recording/series_blocks.hpp"

/// Findings about current and voltage as a pair, and about what the pair can tell of a battery.
namespace battery_sof::check_parts {
namespace {

// [V], of a block that is not empty: a median below it is that of another kind of cell
constexpr double kLeastOfBlock = 6.0;
constexpr std::size_t kEdgesForSign = 3;
constexpr std::size_t kEdgesForSkew = 6;
constexpr std::size_t kEdgesForDoubt = 10;
// channels of different recordings reach 0.26 by chance in 100 edges
constexpr double kNoCorrelation = 0.3;
constexpr double kMinSkew = 0.003;       // [s]; leaves 1.5 mV at 100 Hz (docs/physics.md#time_skew)
constexpr double kMinSkewSamples = 0.3;  // what noise and unfiltered edges move the lag by
// how much better a shift by a whole sample must explain the edges
constexpr double kWholeSampleGain = 1.5;
constexpr double kRestShare = 0.01;     // of the largest current
constexpr double kRestDuration = 60.0;  // [s]
// [V] of a block: under one current, what a battery moves by and a sensor that is stuck does not
constexpr double kMovingVoltage = 0.02;
constexpr double kMovingSigmas = 12.0;  // of its noise, which a million samples do not span
constexpr std::size_t kRestSamples = 20;
constexpr double kRestVoltage = 13.0;  // [V], above it a charger holds the battery
constexpr double kRestDrift = 0.05;    // [V], from the first to the last quarter
// of the largest current: 0.05 A of 250 A (docs/physics.md#current_offset)
constexpr double kMinOffsetShare = 2e-4;

double median(const std::vector<double>& values, IndexRange range) {
  return quantile({values.begin() + range.first, values.begin() + range.last}, 0.5);
}

bool isEven(const Evidence& evidence, IndexRange range) {
  const std::size_t quarter = range.size() / 4;
  const IndexRange first{range.first, range.first + quarter};
  const IndexRange last{range.last - quarter, range.last};
  const Series& series = evidence.series;
  const double current_change = median(series.current, last) - median(series.current, first);
  const double voltage_change = median(series.voltage, last) - median(series.voltage, first);
  return std::abs(current_change) <=
             std::max(6.0 * evidence.current.noise, 0.2 * kRestShare * evidence.largest_current) &&
         std::abs(voltage_change) <= kRestDrift && median(series.voltage, range) < kRestVoltage;
}

/// The correlation that chance does not reach: three standard deviations of unrelated edges, within
/// 0.3 to 0.6.
double clearCorrelation(std::size_t edges) {
  return std::clamp(3.0 / std::sqrt(static_cast<double>(edges)), kNoCorrelation, 0.6);
}

bool isSkewed(const Evidence& evidence, const EdgeResponse& edges) {
  const double tolerance = std::max(kMinSkew, kMinSkewSamples * evidence.interval);
  const bool agrees = std::abs(edges.lag_first - edges.lag_second) <=
                      std::max(tolerance, 0.25 * std::abs(edges.lag));
  return std::abs(edges.lag) > tolerance && agrees;
}

bool isSkewedByASample(const EdgeResponse& edges) {
  return edges.lag != 0.0 && edges.lag_first == edges.lag && edges.lag_second == edges.lag &&
         std::abs(edges.correlation) > kWholeSampleGain * std::abs(edges.correlation_unshifted);
}

std::string describeSeriesOf(double voltage) {
  const auto [blocks, row] = seriesThatFits(voltage);
  return row.empty() ? "" : "it could be " + row + " (--series-blocks " + number(blocks) + "); ";
}

Finding excitation(Severity severity, const std::string& what, const std::string& meaning,
                   double value) {
  return Finding{"excitation", severity, what, meaning, value, "A"};
}

double typicalVoltage(const Evidence& evidence) { return quantile(evidence.series.voltage, 0.5); }

/// The only one the limits here are meant for.
bool isTwelveVoltBlock(const Evidence& evidence) {
  const double typical = typicalVoltage(evidence);
  return typical >= kLowestBlock && typical <= kHighestBlock;
}

/// Ranges in which the battery seems to rest: small, even current and a voltage that barely moves,
/// for a minute or more.
std::vector<IndexRange> apparentRests(const Evidence& evidence) {
  const double limit = kRestShare * evidence.largest_current;
  const auto is_quiet = [&](std::size_t k) {
    return std::abs(evidence.series.current[k]) <= limit;
  };
  std::vector<IndexRange> rests;
  for (const IndexRange& stretch : evidence.stretches)
    for (const IndexRange& range : rangesWhere(stretch, is_quiet))
      if (range.size() >= kRestSamples && durationOf(evidence, range) >= kRestDuration &&
          isEven(evidence, range))
        rests.push_back(range);
  return rests;
}

}  // namespace

std::vector<Finding> findSign(const Evidence& evidence) {
  if (!evidence.excited || !evidence.edges || evidence.edges->edges < kEdgesForSign) return {};
  // Of a voltage whose own sign is flipped nothing follows for the current's.
  if (typicalVoltage(evidence) < 0.0) return {};
  const std::size_t edges = evidence.edges->edges;
  const double correlation = evidence.edges->correlation;
  const bool is_reversed = correlation <= -clearCorrelation(edges);
  if (!is_reversed && (std::abs(correlation) >= kNoCorrelation || edges < kEdgesForDoubt))
    return {};
  return {Finding{
      "sign", is_reversed ? Severity::kProblem : Severity::kWarning,
      (is_reversed ? "voltage falls when current rises: correlation "
                   : "voltage does not follow the current: correlation ") +
          number(correlation) + " at " + counted(edges, "edge"),
      is_reversed ? "discharge is counted as positive here; read the file with --discharge-positive"
                  : "current and voltage may belong to different batteries or to different clocks",
      correlation, "", edges}};
}

std::vector<Finding> findSkew(const Evidence& evidence) {
  if (!evidence.excited || !evidence.edges || evidence.edges->edges < kEdgesForSkew) return {};
  const EdgeResponse& edges = *evidence.edges;
  if (std::abs(edges.correlation) < clearCorrelation(edges.edges)) return {};
  if (!(evidence.fast ? isSkewed(evidence, edges) : isSkewedByASample(edges))) return {};
  const char* late = edges.lag > 0.0 ? "voltage" : "current";
  const char* early = edges.lag > 0.0 ? "current" : "voltage";
  return {Finding{
      "skew", Severity::kWarning,
      std::string(late) + " comes " + twoDigits(std::abs(edges.lag)) + " s after " + early +
          " at " + counted(edges.edges, "edge") +
          (evidence.fast ? "" : " (to the nearest whole sample)"),
      "every edge leaves an error that the model cannot explain, and cranks are predicted from the "
      "wrong samples; shift the current before fitting: sof convert IN OUT --shift-current " +
          twoDigits(edges.lag),
      edges.lag, "s", edges.edges}};
}

std::vector<Finding> findOffset(const Evidence& evidence) {
  if (!evidence.excited || !isTwelveVoltBlock(evidence)) return {};
  const std::vector<IndexRange> rests = apparentRests(evidence);
  std::vector<double> currents;
  for (const IndexRange& rest : rests) currents.push_back(median(evidence.series.current, rest));
  const double offset = quantile(currents, 0.5);
  const double spread = quantile(currents, 0.9) - quantile(currents, 0.1);
  const double least = std::max(kMinOffsetShare * evidence.largest_current,
                                1.5 * evidence.current.step.value_or(0.0));
  if (std::abs(offset) < least || spread > std::abs(offset)) return {};
  return {
      Finding{"offset", Severity::kNote,
              "current reads " + number(offset) + " A at " + counted(rests.size(), "apparent rest"),
              std::string("either the sensor's zero is off by that much or ") +
                  (offset < 0.0 ? "a consumer really draws it" : "a charger really supplies it") +
                  "; current and voltage alone cannot tell which. If it is the zero, counted "
                  "charge drifts by " +
                  number(24.0 * std::abs(offset)) + " Ah a day",
              offset, "A", totalSamples(rests), startsOf(evidence, rests)}};
}

std::vector<Finding> findVoltageLevel(const Evidence& evidence) {
  if (isTwelveVoltBlock(evidence)) return {};
  const double typical = typicalVoltage(evidence);
  if (typical < 0.0)
    return {Finding{"voltage_level", Severity::kProblem,
                    "the voltage is negative: typically " + number(typical) + " V (" +
                        number(evidence.voltage.lowest) + " V to " +
                        number(evidence.voltage.highest) + " V)",
                    "its sign is flipped, or the column is not a voltage: negate it, or name "
                    "another one (--voltage-column)",
                    typical, "V", evidence.series.size()}};
  return {Finding{
      "voltage_level", Severity::kProblem,
      "the voltage is typically " + number(typical) + " V (" + number(evidence.voltage.lowest) +
          " V to " + number(evidence.voltage.highest) + " V)",
      "this is not a 12 V lead-acid block, whose voltage is between " + number(kLowestBlock) +
          " V and " + number(kHighestBlock) + " V most of the time; " + describeSeriesOf(typical) +
          "parameter bounds and limits of this program do not apply",
      typical, "V", evidence.series.size()}};
}

std::vector<Finding> findDeepDischarge(const Evidence& evidence) {
  const double typical = typicalVoltage(evidence);
  const bool is_of_other_blocks = typical > kHighestBlock || seriesThatFits(typical).first == 0.5;
  if (is_of_other_blocks) return {};
  const DeepDischargeDetector deep = findDeepDischarges(evidence.series);
  const bool is_lead_acid = quantile(evidence.series.voltage, 0.5) > kLeastOfBlock;
  if (deep.count() == 0 || !is_lead_acid) return {};
  return {
      Finding{"deep_discharge",
              Severity::kWarning,
              deep.toString(1.0),
              "a lead-acid battery that is discharged so deeply sulphates and loses capacity; a "
              "model of the time before it no longer applies",
              deep.deepest()->lowest,
              "V",
              0,
              {deep.first()->from}}};
}

std::vector<Finding> findExcitation(const Evidence& evidence) {
  const Channel& current = evidence.current;
  const double low = current.lowest, high = current.highest;
  if (!evidence.excited && evidence.voltage.highest - evidence.voltage.lowest >=
                               std::max(kMovingVoltage, kMovingSigmas * evidence.voltage.noise))
    return {excitation(Severity::kWarning,
                       "the current is held at one value, " + number(low) +
                           " A, while the voltage moves "
                           "from " +
                           number(evidence.voltage.values.front()) + " V to " +
                           number(evidence.voltage.values.back()) + " V",
                       "this is a bench test and not a stuck sensor; it shows how the voltage "
                       "moves with the charge, but a resistance cannot be distinguished from the "
                       "open-circuit voltage, and sign and skew cannot be checked",
                       high - low)};
  if (!evidence.excited)
    return {
        excitation(Severity::kProblem,
                   "the current does not change: " + number(low) + " A to " + number(high) + " A",
                   "neither resistance nor dynamics can be identified from it, and sign and skew "
                   "cannot be checked",
                   high - low)};
  const double negligible =
      evidence.largest_current *
      std::clamp(6.0 * current.noise / evidence.largest_current, kRestShare, 0.05);
  std::vector<Finding> findings;
  if (high <= negligible)
    findings.push_back(
        excitation(Severity::kWarning,
                   "the battery is never charged: current stays at or below " + number(high) + " A",
                   "charging resistance and charge acceptance cannot be identified; check that the "
                   "sensor shows both directions",
                   high));
  if (low >= -negligible)
    findings.push_back(excitation(
        Severity::kWarning,
        "the battery is never discharged: current stays at or above " + number(low) + " A",
        "discharging resistance and cranking capability cannot be identified; check that the "
        "sensor shows both directions",
        low));
  else if (low > evidence.crank_current)
    findings.push_back(excitation(
        Severity::kNote, "the largest discharging current is " + number(low) + " A",
        "there is no engine start to identify from, so a predicted start is an extrapolation",
        low));
  return findings;
}

std::vector<std::string> listNotJudged(const Evidence& evidence) {
  std::vector<std::string> list;
  const std::size_t edges = evidence.excited && evidence.edges ? evidence.edges->edges : 0;
  const std::string few = "only " + counted(edges, "steep change") + " of current";
  if (edges < kEdgesForSign) list.push_back("sign: " + few);
  if (edges < kEdgesForSkew) {
    list.push_back("skew: " + few);
  } else if (!evidence.fast) {
    list.push_back("skew below one sample (" + number(evidence.interval) +
                   " s): sampled too slowly");
  }
  if (!isTwelveVoltBlock(evidence)) {
    list.push_back("offset: rests are only recognised for a 12 V lead-acid block");
  } else if (!evidence.excited || apparentRests(evidence).empty()) {
    list.push_back(
        "offset: no rest of a minute with a small steady current and a steady voltage below " +
        number(kRestVoltage) + " V");
  }
  if (!evidence.excited || !evidence.edges) {
    list.push_back("aliasing: no current to compare the voltage with");
  } else if (const std::size_t blocks = evenBlocks(evidence); blocks < kLineBlocksMin) {
    list.push_back("aliasing: only " + counted(blocks, "block") + " of " +
                   std::to_string(kLineBlock) + " evenly spaced samples");
  }
  return list;
}

}  // namespace battery_sof::check_parts

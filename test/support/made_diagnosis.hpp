#pragma once

#include <algorithm>
#include <cmath>

#include "diagnosis/diagnosis.hpp"
#include "support/known_model.hpp"

/// Diagnoses made by hand, with the drive they pretend to be of: for tests of what reports make of
/// them.
namespace battery_sof::test {

struct MadeDiagnosis {
  Recording recording;
  Diagnosis diagnosis;
};

/// Twenty minutes of stops, cranks, long charges and discharges [A], and a gap of two minutes.
inline Series madeDrive() {
  Random random(7);
  Series series;
  double level = -12.0;
  for (long n = 0; n < 20L * 1200; ++n) {
    const double t = 0.05 * static_cast<double>(n);
    if (t > 700.0 && t < 820.0) continue;
    const double phase = std::fmod(t, 150.0);
    if (n % 100 == 0) level = random.uniform(-45.0, 35.0);
    double current = level;
    if (phase < 25.0)
      current = -9.0;
    else if (phase < 25.8)
      current = -310.0 * std::exp(-1.2 * (phase - 25.0));
    else if (phase < 75.0)
      current = 18.0 + 50.0 * std::exp(-(phase - 25.8) / 9.0);
    series.time.push_back(t);
    series.current.push_back(current);
  }
  return series;
}

/// A source controls the voltage while it charges after each crank.
inline ControlModeOverview madeSource(const Series& series) {
  ControlModeOverview source;
  source.seen = true;
  source.summary = "A source holds the voltage in a third of the samples, those above -3 A.";
  std::size_t held = 0;
  for (const double t : series.time)
    held += std::fmod(t, 150.0) >= 25.8 && std::fmod(t, 150.0) < 75.0 ? 1 : 0;
  source.share = static_cast<double>(held) / static_cast<double>(series.size());
  source.totals = {{"a load: the current is lower than while a source is connected",
                    ControlMode::kCurrent, 8, series.size() - held},
                   {"the voltage is held while the current moves", ControlMode::kVoltage, 8, held}};
  for (int k = 0; k < 8; ++k)
    source.times.push_back({std::max(150.0 * k + 25.8, k == 5 ? 820.0 : 0.0), 150.0 * k + 75.0});
  return source;
}

/// The drive's measured voltage is the base model's plus `missing` of a slow overpotential of
/// charging [V].
inline MadeDiagnosis madeDrivenBy(double missing) {
  MadeDiagnosis made;
  Random random(11);
  const BaseStep step(drivenBattery());
  Series series = madeDrive();
  double u_c2 = 0.0, slow = 0.0;
  for (std::size_t n = 0; n < series.size(); ++n) {
    const double dt = n > 0 ? series.time[n] - series.time[n - 1] : 0.0;
    if (n > 0) u_c2 = step.advance(u_c2, 0.5 * (series.current[n - 1] + series.current[n]), dt);
    slow += (1.0 - std::exp(-dt / 15.0)) * (std::max(series.current[n], 0.0) * missing - slow);
    const double base = terminalVoltage(drivenBattery(), series.current[n], u_c2);
    series.voltage.push_back(base + slow + 0.003 * random.normal());
    made.diagnosis.base_voltage.push_back(base + 0.25 * missing * 18.0);
    made.diagnosis.extended_voltage.push_back(base + 0.96 * slow);
  }
  made.recording.name = "drive <b>of</b> \"Monday\" & </script> \xc3\xa4.bag";
  made.recording.offered = series.size();
  made.recording.series = series;
  made.diagnosis.base = knownModel();
  made.diagnosis.extended = knownModel();
  made.diagnosis.base.provenance.recording = made.diagnosis.extended.provenance.recording =
      made.recording.name;
  made.diagnosis.source = madeSource(made.recording.series);
  made.diagnosis.fit.train = {0.0, 900.0, 16000};
  made.diagnosis.fit.holdout = {900.05, 1199.95, 6000};
  return made;
}

inline std::vector<DetectionLimit> madeDetectionLimit() {
  return {{"gassing", "gassing_current", "A", 1.9, 0.05, false},
          {"ocv_hysteresis", "hysteresis_voltage", "V", 0.045, 0.02, false},
          {"self_heating", "warming", "K/J", 0.004, 0.0008, false},
          {"cpe2", "cpe2_deficit", "1", 0.01, 0.12, true},
          {"contact_resistance", "contact_resistance", "ohm", 0.0002, 0.002, true},
          {"time_skew", "skew", "s", 0.0006, 0.01, true}};
}

/// Charge acceptance found, with everything a diagnosis can hold.
inline MadeDiagnosis madeNamed() {
  MadeDiagnosis made = madeDrivenBy(0.012);
  Diagnosis& d = made.diagnosis;
  d.verdict = Verdict::kEffect;
  d.summary =
      "The battery takes charge less and less readily than the base model says: the charging "
      "reaction runs out of "
      "dissolved lead (charge_acceptance), which lowers the error of the held-out drive from 121 "
      "to 6 mV.";
  d.extended = uncertainModel(0.02, {"charge_acceptance"});
  d.extended.provenance.recording = made.recording.name;
  d.base.fit.estimates[1].value *= 1.31;
  NamedEffect effect;
  effect.id = "charge_acceptance";
  effect.confidence = 0.97;
  effect.biased_parameters = {"r_charge", "beta"};
  for (const ParameterInfo& info : effectInfo(effect.id).parameters)
    effect.parameters.push_back({info.name, info.unit, 1.2 * info.magnitude,
                                 0.1 * std::abs(info.magnitude), info.magnitude,
                                 1.4 * info.magnitude, false});
  effect.parameters.back().upper.reset();
  effect.parameters.back().at_bound = true;
  effect.evidence = 1840.0;
  effect.voltage_rms = 0.119;
  effect.mechanism = "acceptance";
  effect.probability = 0.97;
  d.effects = {effect};
  d.mechanism = Mechanism::kAcceptance;
  d.probability = 0.97;
  d.evidence_base = 5210.0;
  d.evidence_extended = 7050.0;
  d.effective_sample_fraction = 0.11;
  d.unexplained = {0.0004, 0.002, 0.006, {0.0015, 0.010, 0.03}, 0.0007};
  d.candidates = {{"charge_acceptance", 1840.0, 0.97, "", "acceptance", 95.0},
                  {"acid_transport", 1610.0, 0.0,
                   "what was accepted instead explains more of the error", "acid"},
                  {"sulphate_history", 410.0, 0.0,
                   "what was accepted instead explains more of the error", "acceptance"},
                  {"gassing", 38.0, 0.0, "what was accepted instead explains more of the error",
                   "side_reactions"},
                  {"current_offset", 9.5, 0.0, "its evidence is too small", "instrument"},
                  {"charge_transfer", 0.4, 0.0, "its evidence is too small", "structure"},
                  {"time_skew", -1.2, 0.0, "its evidence is too small", "instrument"}};
  for (int k = 0; k < 8; ++k) {
    const double from = 150.0 * k + 37.0;
    if (from > 690.0 && from < 820.0) continue;
    d.mismatch.push_back({from, from + 38.0, "long_charge", 0.17 + 0.004 * k, 0.31, 1e-6});
  }
  d.regimes = {{"long_charge", "mean", 7, 0.168, 0.151, 0.185, 0.001, true},
               {"long_charge", "slope", 7, 0.0021, 0.0015, 0.0027, 0.002, true},
               {"long_charge", "end", 7, 0.141, 0.120, 0.162, 0.001, true},
               {"discharge", "mean", 24, -0.051, -0.060, -0.042, 0.001, true},
               {"crank", "mean", 7, -0.004, -0.012, 0.004, 0.31, false},
               {"post_charge_rest", "mean", 6, 0.031, -0.002, 0.064, 0.06, false}};
  const std::vector<std::string> regimes = {"edge",         "crank",     "long_charge",
                                            "short_charge", "discharge", "post_charge_rest"};
  const std::vector<std::string> parameters = {"r_discharge", "r_charge", "c2", "beta", "u_dc"};
  for (std::size_t p = 0; p < parameters.size(); ++p)
    for (std::size_t r = 0; r < regimes.size(); ++r) {
      const double z =
          14.0 * std::sin(1.7 * static_cast<double>(p) + 0.9 * static_cast<double>(r) + 0.4);
      d.parameter_bias.push_back({parameters[p], regimes[r], z, p == 4 ? 0.002 * z : 0.011 * z});
    }
  d.instrument = {"The voltage is quantised to 1 mV: finer effects than 0.3 mV cannot show.",
                  "2 of 24,000 samples were refused: duplicate stamps."};
  d.detection_limits = madeDetectionLimit();
  d.outside = {
      "A wrong gain of the voltage sensor, a constant cable resistance: the base parameters take "
      "them up whole."};
  d.fit.base_train = {38.0, 0.118, 0.402, 0.034, 0.171, 12.5};
  d.fit.extended_train = {96.4, 0.006, 0.049, 0.011, 0.003, 0.8};
  d.fit.base_holdout = {35.5, 0.121, 0.411, 0.036, 0.176, 13.1};
  d.fit.extended_holdout = {95.9, 0.0064, 0.052, 0.0125, 0.004, 0.9};
  d.fit.regimes = {{"long_charge", 2100, 0.176, 0.005, -0.171, -0.180, -0.160},
                   {"discharge", 2400, 0.052, 0.006, -0.046, -0.050, -0.042},
                   {"crank", 64, 0.036, 0.033, -0.003, -0.011, 0.006},
                   {"post_charge_rest", 480, 0.004, 0.0075, 0.0035, 0.0012, 0.0058}};
  d.next_experiment =
      "After a drive, hold 14.4 V for ten minutes, then 13.6 V for ten: the current that stays "
      "reports gassing from a "
      "sensor's offset (12 mV apart at the end).";
  return made;
}

/// Nothing found: the table of detection limits is all there is to say.
inline MadeDiagnosis madeNoMismatch() {
  MadeDiagnosis made = madeDrivenBy(0.0);
  Diagnosis& d = made.diagnosis;
  d.verdict = Verdict::kNoMismatch;
  d.summary =
      "Base model and measurement agree to 3 mV everywhere; no effect of the catalogue shows.";
  d.candidates = {{"time_skew", 2.1, 0.0, "its evidence is too small", "instrument"},
                  {"cpe2", -0.7, 0.0, "its evidence is too small", "structure"}};
  d.unexplained = {0.0003, 0.001, 0.002, {0.0015, 0.010, 0.03}};
  d.regimes = {{"long_charge", "mean", 7, 0.0004, -0.0003, 0.0011, 0.3, false}};
  d.detection_limits = madeDetectionLimit();
  d.outside = {"A wrong gain of the voltage sensor."};
  d.fit.base_train = d.fit.extended_train = {98.7, 0.003, 0.012, 0.002, 0.0001, 0.1};
  d.fit.base_holdout = d.fit.extended_holdout = {98.6, 0.003, 0.013, 0.002, 0.0002, 0.1};
  d.next_experiment = "None is needed; ten minutes at 14.4 V would bring gassing within sight.";
  return made;
}

/// Something is missing that the catalogue does not hold: it is estimated. Metrics are absent, one
/// is not a number.
inline MadeDiagnosis madeUnknown() {
  MadeDiagnosis made = madeDrivenBy(0.006);
  Diagnosis& d = made.diagnosis;
  d.verdict = Verdict::kUnexplained;
  d.summary =
      "Of what is missing the kind is known and the form is not: charging is limited by how fast "
      "the battery takes charge up.";
  d.mechanism = Mechanism::kAcceptance;
  d.probability = 0.94;
  d.mismatch = {{187.0, 225.0, "long_charge", 0.08, 0.15, 1e-4}};
  d.candidates = {{"acid_transport", 55.0, 0.0,
                   "what was accepted instead explains more of the error", "acid"}};
  DiscrepancyFinding discrepancy;
  discrepancy.is_used = true;
  discrepancy.left_out = {0.064, 0.021};
  discrepancy.rms = 0.061;
  discrepancy.mechanisms = {{Mechanism::kAcceptance, 340.0, 0.058},
                            {Mechanism::kAcid, 12.0, 0.004}};
  discrepancy.answer_current = 20.0;
  discrepancy.answers = {{0.1, 0.0002, 0.0, 0.0001, 0.0001},
                         {1.0, 0.0061, 0.0001, 0.001, 0.0005},
                         {10.0, 0.052, -0.0004, 0.004, 0.002},
                         {100.0, 0.113, -0.0011, 0.011, 0.005}};
  discrepancy.curve = {{-100.0, -0.0002, -0.006},
                       {-10.0, 0.0, -0.001},
                       {1.0, 0.0001, 0.004},
                       {10.0, 0.0001, 0.05},
                       {50.0, 0.0004, 0.21}};
  discrepancy.terms = {"memory of charging over 10 s", "memory of charging over 30 s"};
  discrepancy.description =
      "The discrepancy, a function of the currents and their memory, moves the voltage by 61.0 mV "
      "RMS.";
  d.discrepancy = discrepancy;
  d.unexplained = {0.0004, 0.001, 0.004, {0.0015, 0.010, 0.03}};
  d.detection_limits = madeDetectionLimit();
  d.fit.base_train = {61.0, 0.064, 0.21, std::nullopt, std::nullopt, std::nullopt};
  d.fit.base_holdout = {std::nan(""), 0.066, 0.22, std::nullopt, std::nullopt, std::nullopt};
  d.fit.extended_train = {95.2, 0.018, 0.11, std::nullopt, std::nullopt, std::nullopt};
  d.fit.extended_holdout = {94.0, 0.0207, 0.12, std::nullopt, std::nullopt, std::nullopt};
  d.next_experiment = "A charge of 60 s at 40 A, once after a rest and once after a discharge.";
  return made;
}

}  // namespace battery_sof::test

#include <stdexcept>

#include "simulator/full_battery.hpp"
#include "simulator/generator/law.hpp"
#include "simulator/generator/series.hpp"

namespace battery_sof_simulator {
namespace {

/// Shortest time that a recording still shows [s]: two samples, at least a twentieth of a second.
double shortestShown(const Circumstances& drive) {
  return std::max(0.05, 2.0 / drive.sample_rate_hz);
}

/// A depressed arc: resistance beside a constant phase element, by its spread of times.
///     Z = R / (1 + (j w tau_0)^a),   v = R sum_k g_k z_k,   tau_k dz_k/dt = i - z_k
///     g(ln tau) = sin((1 - a) pi) / (2 pi (cosh(a ln(tau / tau_0)) - cos((1 - a) pi)))
/// Cole and Cole, J. Chem. Phys. 9 (1941). Thirteen times, three a decade.
void depressedArc(Law& law, Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kTimes = 13;
  const double power = dice.between({0.5, 0.75}),
               centre = std::max(dice.logBetween({0.3, 8.0}), 2.0 * shortestShown(drive));
  Memories<kTimes> memories;
  for (std::size_t k = 0; k < kTimes; ++k) {
    const double decades = (static_cast<double>(k) - 0.5 * (kTimes - 1)) / 3.0;
    memories.time[k] = std::max(0.02, centre * std::pow(10.0, decades));
    const double spread = std::cosh(power * std::log(10.0) * decades);
    memories.weight[k] = std::sin((1.0 - power) * kPi) / (spread - std::cos((1.0 - power) * kPi));
  }
  memories.normalise();
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    return memories.advance(x, now.step, now.current);
  };
  law.voltage = [=](const Law::State& x, const LawInstant&) { return 1.5e-3 * memories.mean(x); };
}

/// A film that conducts by the charge brought into it: its voltage goes with a root of the current.
///     v = V sgn(i) [ (|i| / i_f + 0.01)^m - 0.01^m ],   m 0.35 to 0.6
/// Space-charge-limited current (Mott and Gurney 1940: m = 1/2), films on lead: Pavlov (2011).
void conductingFilm(Law& law, Dice& dice, const Circumstances&) {
  static constexpr double kFloor = 0.01;
  const double scale = dice.logBetween({8.0, 60.0}), power = dice.between({0.35, 0.6});
  law.voltage = [=](const Law::State&, const LawInstant& now) {
    const double size = std::pow(std::abs(now.current) / scale + kFloor, power);
    return std::copysign(0.05 * (size - std::pow(kFloor, power)), now.current);
  };
}

/// Something adsorbed that the current moves between empty and full, and that relaxes by pairs.
///     dh/dt = i / Q (1 - h sgn i) - h |h| / tau,   v = V h
/// Pseudocapacitance with few sites (Conway 1999); relaxation of second order falls as 1/t.
void adsorbedSites(Law& law, Dice& dice, const Circumstances& drive) {
  const double charge = dice.logBetween({30.0, 300.0}),
               time = std::max(dice.logBetween({3.0, 60.0}), 4.0 * shortestShown(drive));
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double open = 1.0 - (now.current > 0.0 ? x[0] : -x[0]);
    const double rate = now.current / charge * open - x[0] * std::abs(x[0]) / time;
    return Law::State{std::clamp(x[0] + now.step * rate, -1.0, 1.0)};
  };
  law.voltage = [](const Law::State& x, const LawInstant&) { return 0.05 * x[0]; };
}

/// Another electrode whose current goes with the square of its voltage.
///     dy/dt = (i - 40 A y |y|^(n - 1)) / Q,   v = V y,   n 1.7 to 3
/// A power law between ohmic and Tafel kinetics, as of a surface with a spread of barriers.
void powerElectrode(Law& law, Dice& dice, const Circumstances& drive) {
  const double charge = std::max(dice.logBetween({20.0, 500.0}), 40.0 * shortestShown(drive)),
               power = dice.between({1.7, 3.0});
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double back = 40.0 * x[0] * std::pow(std::abs(x[0]), power - 1.0);
    return Law::State{x[0] + now.step * (now.current - back) / charge};
  };
  law.voltage = [](const Law::State& x, const LawInstant&) { return 0.05 * x[0]; };
}

/// A resistance that grows with a power of time.
///     v = R i (t / T)^p,   p 0.4 to 0.7 or 1.7 to 2.5,  T: the drive's length
/// Layers grow so: p = 1/2 by diffusion, above 1 once they crack (Lander 1956, lead grids).
void growingLayer(Law& law, Dice& dice, const Circumstances& drive) {
  const double length = drive.duration,
               power = dice.share() < 0.5 ? dice.between({0.4, 0.7}) : dice.between({1.7, 2.5});
  law.voltage = [=](const Law::State&, const LawInstant& now) {
    return 2e-3 * now.current * std::pow(now.time / length, power);
  };
}

/// The block warms inside first; warm acid and plates conduct better.
///     C_1 dT_1/dt = 8 mOhm i^2 - g (T_1 - T_2),   C_2 dT_2/dt = g (T_1 - T_2) - h T_2
///     v = -R i [ 1 - (1 + T_1 / 20 K)^-m ]
/// Two bodies, the inside and the case; a power law near the measured 0.5 to 1 % a kelvin of acid
/// (Bode 1977), amplified by the strength.
void warmingInside(Law& law, Dice& dice, const Circumstances&) {
  const double inside = dice.logBetween({500.0, 4000.0}),
               outside = dice.logBetween({2000.0, 8000.0});
  const double across = dice.between({2.0, 20.0}), outwards = dice.between({1.0, 5.0}),
               power = dice.between({1.0, 3.0});
  law.advance = [=](const Law::State& x, const LawInstant& now) {
    const double heat = 8e-3 * now.current * now.current, flow = across * (x[0] - x[1]);
    return Law::State{x[0] + now.step * (heat - flow) / inside,
                      x[1] + now.step * (flow - outwards * x[1]) / outside};
  };
  law.voltage = [=](const Law::State& x, const LawInstant& now) {
    return -5e-3 * now.current * (1.0 - std::pow(1.0 + std::max(0.0, x[0]) / 20.0, -power));
  };
}

/// Contacts inside the plates that work loose one after the other with the charge put through.
///     v = R i sum_k S((Q - Q_k) / W_k) / 3,   Q: integral of |i|,  S: smooth step,  k = 1 to 3
/// Softening, shedding with throughput (Ruetschi, J. Power Sources 127 (2004)): a threshold each.
void looseningContacts(Law& law, Dice& dice, const Circumstances& drive) {
  static constexpr std::size_t kContacts = 3;
  std::array<double, kContacts> from{}, width{};
  for (std::size_t k = 0; k < kContacts; ++k) {
    from[k] = drive.throughput_as * (static_cast<double>(k) + 0.7 * dice.share()) / kContacts;
    width[k] = drive.throughput_as * dice.between({0.1, 0.3});
  }
  law.advance = [](const Law::State& x, const LawInstant& now) {
    return Law::State{x[0] + now.step * std::abs(now.current)};
  };
  law.voltage = [=](const Law::State& x, const LawInstant& now) {
    double loose = 0.0;
    for (std::size_t k = 0; k < kContacts; ++k) loose += smoothStep((x[0] - from[k]) / width[k]);
    return 2e-3 * now.current * loose / kContacts;
  };
}

/// Active surface that is lost by and by: the overpotential grows.
///     v = 0.4 u2 y^n / (1 + y^n),   y = t / T,  T 0.5 to 1.2 of the drive's length, n 1.5 to 3
/// Loss of a limited stock by an S-shaped law (Avrami 1939), rational here.
void fadingSurface(Law& law, Dice& dice, const Circumstances& drive) {
  const double time = drive.duration * dice.between({0.5, 1.2}), order = dice.between({1.5, 3.0});
  law.voltage = [=](const Law::State&, const LawInstant& now) {
    return 0.4 * now.u2 * saturated(std::pow(now.time / time, order));
  };
}

constexpr double kStep = FullBattery::kStep;  // [s]

/// An instrument that changes what it shows of a true course.
void instrument(
    Law& law, double max_strength,
    const std::function<void(const Course& truth, double strength, Course& shown)>& change) {
  law.max_strength = max_strength;
  law.shown = [change](const Course& truth, double strength) {
    Course shown = truth;
    change(truth, strength, shown);
    return shown;
  };
}

/// A vehicle's sensor that shows next to nothing of small currents.
///     i_shown = i (1 - 1 / (1 + (i / s i_d)^4)),   i_d 1 to 3 A
/// Zero-clamping of shunt amplifiers to hide their offset.
void deadBand(Law& law, Dice& dice, const Circumstances&) {
  const double width = dice.between({1.0, 3.0});
  instrument(law, 2.0, [=](const Course&, double strength, Course& shown) {
    const double band = strength * width;
    if (band <= 0.0) return;
    for (double& current : shown.current) {
      const double x = current / band, fourth = x * x * x * x;
      current *= fourth / (1.0 + fourth);
    }
  });
}

/// A sensor whose core stays magnetised by the last large current.
///     m <- clamp(m + di / i_m, -1, 1),   i_shown = i + s 0.5 A m,   i_m 60 to 250 A
/// Remanence as an elastic and plastic element of current (Preisach 1935); open-loop Hall sensors
/// show 0.2 to 1 A of it after a crank (data sheets).
void remanence(Law& law, Dice& dice, const Circumstances&) {
  const double reach = dice.between({60.0, 250.0});
  instrument(law, 4.0, [=](const Course& truth, double strength, Course& shown) {
    double magnetised = 0.0;
    for (std::size_t n = 1; n < truth.current.size(); ++n) {
      const double moved = (truth.current[n] - truth.current[n - 1]) / reach;
      magnetised = std::clamp(magnetised + moved, -1.0, 1.0);
      shown.current[n] += strength * 0.5 * magnetised;
    }
  });
}

/// Two loggers whose clocks run apart.
///     u_shown(t) = u(t - d(t)),   d = s d_1 [t / T + 0.2 sin(2 pi t / T_w)]
/// d_1 one sample, at least 20 ms; crystals differ by 10 to 100 ppm and wander with temperature.
void clockDrift(Law& law, Dice& dice, const Circumstances& drive) {
  const double length = drive.duration,
               reach =
                   std::max(0.02, 1.0 / drive.sample_rate_hz) * (dice.share() < 0.5 ? -1.0 : 1.0),
               wander = dice.between({0.1, 0.4}) * drive.duration;
  instrument(law, 4.0, [=](const Course& truth, double strength, Course& shown) {
    if (strength == 0.0) return;
    for (std::size_t n = 0; n < truth.voltage.size(); ++n) {
      const double time = static_cast<double>(n) * kStep;
      const double delay = reach * (time / length + 0.2 * std::sin(2.0 * kPi * time / wander));
      shown.voltage[n] = valueAt(truth.voltage, static_cast<double>(n) - strength * delay / kStep);
    }
  });
}

/// A voltage channel that rings.
///     y'' + 2 z w y' + w^2 y = w^2 u,   u_shown = u + s (y - u),   z 0.15 to 0.4
/// Period four to ten samples, at least 60 ms. An active filter near its limit of stability.
void ringingChannel(Law& law, Dice& dice, const Circumstances& drive) {
  const double period = std::max(0.06, dice.between({4.0, 10.0}) / drive.sample_rate_hz),
               damping = dice.between({0.15, 0.4});
  instrument(law, 1.0, [=](const Course& truth, double strength, Course& shown) {
    const double w = 2.0 * kPi / period;
    double y = truth.voltage.front(), rate = 0.0;
    for (std::size_t n = 0; n < truth.voltage.size(); ++n) {
      rate += kStep * (w * w * (truth.voltage[n] - y) - 2.0 * damping * w * rate);
      y += kStep * rate;
      shown.voltage[n] += strength * (y - truth.voltage[n]);
    }
  });
}

/// A consumer past the sensor that a thermostat switches.
///     i_shown = i + s 1 A g(t)
///     g: 1 for a share 0.3 to 0.7 of each period of 40 to 200 s, edges of 1 s
/// A relay's cycle, not a constant load. The battery's current is below what is shown.
void thermostatLoad(Law& law, Dice& dice, const Circumstances& drive) {
  const double period = std::min(dice.between({40.0, 200.0}), drive.duration / 8.0),
               on = dice.between({0.3, 0.7}), phase = dice.share();
  instrument(law, 4.0, [=](const Course& truth, double strength, Course& shown) {
    for (std::size_t n = 1; n < truth.current.size(); ++n) {
      const double cycles = static_cast<double>(n) * kStep / period + phase;
      const double inside = (cycles - std::floor(cycles)) * period;  // [s] since switched on
      shown.current[n] += strength * (smoothStep(inside) - smoothStep(inside - on * period));
    }
  });
}

}  // namespace

const std::vector<LawForm>& lawForms() {
  static const std::vector<LawForm> all = [] {
    std::vector<LawForm> forms = chemistryLaws();
    forms.insert(forms.end(), {{"structure", "depressed_arc", depressedArc},
                               {"structure", "conducting_film", conductingFilm},
                               {"structure", "adsorbed_sites", adsorbedSites},
                               {"structure", "power_electrode", powerElectrode},
                               {"ageing", "growing_layer", growingLayer},
                               {"ageing", "warming_inside", warmingInside},
                               {"ageing", "loosening_contacts", looseningContacts},
                               {"ageing", "fading_surface", fadingSurface},
                               {"instrument", "dead_band", deadBand},
                               {"instrument", "remanence", remanence},
                               {"instrument", "clock_drift", clockDrift},
                               {"instrument", "ringing_channel", ringingChannel},
                               {"instrument", "thermostat_load", thermostatLoad}});
    return forms;
  }();
  return all;
}

const LawForm& lawNamed(const std::string& mechanism, const std::string& id) {
  for (const LawForm& form : lawForms())
    if (form.mechanism == mechanism && form.id == id) return form;
  throw std::invalid_argument("no law is \"" + mechanism + " " + id +
                              "\"; --list names what there is");
}

}  // namespace battery_sof_simulator

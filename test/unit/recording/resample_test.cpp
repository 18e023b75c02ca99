#include "recording/resample.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>

#include "support/synthetic_recording.hpp"

namespace battery_sof {
namespace {

constexpr double kPi = 3.14159265358979323846;

double gainAt(const std::array<Biquad, 4>& sections, double frequency, double rate) {
  const std::complex<double> z1 = std::polar(1.0, -2.0 * kPi * frequency / rate);
  std::complex<double> gain = 1.0;
  for (const Biquad& s : sections) {
    gain *= (s.b0 + s.b1 * z1 + s.b2 * z1 * z1) / (1.0 + s.a1 * z1 + s.a2 * z1 * z1);
  }
  return std::abs(gain);
}

double decibel(double gain) { return 20.0 * std::log10(gain); }

/// A series at rate whose current is a function of time and whose voltage is 12 V + 5 mOhm times
/// it.
template <typename Function>
Series sampled(double duration, double rate, Function current) {
  Series series;
  for (int k = 0; k < duration * rate; ++k) {
    series.time.push_back(k / rate);
    series.current.push_back(current(k / rate));
    series.voltage.push_back(12.0 + 0.005 * series.current.back());
  }
  return series;
}

/// First time at which the current, interpolated, falls below level.
double timeOfFall(const Series& series, double level) {
  for (std::size_t k = 1; k < series.size(); ++k) {
    if (series.current[k] > level) continue;
    const double share =
        (level - series.current[k - 1]) / (series.current[k] - series.current[k - 1]);
    return series.time[k - 1] + share * (series.time[k] - series.time[k - 1]);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// 0.5 s of engine turning at -180 A behind an inrush to -300 A that lasts long enough to pass 20
/// Hz.
double crank(double time) {
  const double t = time - 2.0;
  if (t < 0.0 || t >= 0.5) return -10.0;
  return t < 0.12 ? -300.0 : -180.0;
}

// ---------------------------------------------------------------------------------------------
// design

struct Golden {
  double cutoff, rate;
  double a1[4], a2[4];
  double delay;
};

// scipy 1.10: z, p, k = scipy.signal.bessel(8, cutoff, norm='mag', fs=rate, output='zpk'), which
// prewarps the cut-off; a1 = -2 p.real and a2 = |p|^2 of the poles above the real axis in rising
// order of |p|; the delay is -angle(H) / (2 pi f) of scipy.signal.freqz_zpk at f = 0.001 Hz.
constexpr Golden kGolden[] = {
    {20.0,
     1000.0,
     {-1.600904088311836, -1.6185439513000408, -1.6581213705972129, -1.7343376249200269},
     {0.6414980820383048, 0.6621314463973078, 0.7089665530902975, 0.8013823407537335},
     0.02526928},
    {15.0,
     1000.0,
     {-1.6933411754549879, -1.708532330355379, -1.742463784333467, -1.807243979674938},
     {0.7173326434406732, 0.7342320083293491, 0.7722840329014885, 0.8461670385969673},
     0.03371181},
    {40.0,
     200.0,
     {0.2563923562333915, 0.2997071647380984, 0.4046978421821813, 0.6335241749464935},
     {0.02219663525333826, 0.07634266258047175, 0.2030858047019088, 0.4623404189350058},
     0.01094092}};

TEST(Bessel8, HasThePolesAndTheDelayThatScipyGives) {
  for (const Golden& golden : kGolden) {
    const auto sections = designBessel8(golden.cutoff, golden.rate);
    for (std::size_t k = 0; k < sections.size(); ++k) {
      EXPECT_NEAR(sections[k].a1, golden.a1[k], 1e-10);
      EXPECT_NEAR(sections[k].a2, golden.a2[k], 1e-10);
    }
    EXPECT_NEAR(groupDelayAtZero(sections, golden.rate), golden.delay, 1e-8);
  }
}

TEST(Bessel8, IsThreeDecibelsDownAtTheCutoffAndOneAtZero) {
  for (const double cutoff : {1.0, 15.0, 20.0, 40.0, 200.0, 450.0}) {
    const auto sections = designBessel8(cutoff, 1000.0);
    EXPECT_NEAR(gainAt(sections, cutoff, 1000.0), std::sqrt(0.5), 1e-9);
    for (const Biquad& s : sections) {
      EXPECT_NEAR((s.b0 + s.b1 + s.b2) / (1.0 + s.a1 + s.a2), 1.0, 1e-12);
    }
  }
}

TEST(Bessel8, AtTwentyHertzSuppressesFiftyBy23AndHundredBy67Decibels) {
  const auto sections = designBessel8(20.0, 1000.0);
  EXPECT_NEAR(decibel(gainAt(sections, 50.0, 1000.0)), -23.4, 0.1);
  EXPECT_LT(decibel(gainAt(sections, 100.0, 1000.0)), -67.0);
}

TEST(Bessel8, CutoffOutsideZeroToHalfTheRateIsRefused) {
  for (const double cutoff : {0.0, -1.0, 500.0, 600.0, std::nan("")}) {
    EXPECT_THROW(designBessel8(cutoff, 1000.0), std::invalid_argument) << cutoff;
  }
  EXPECT_THROW(designBessel8(20.0, 0.0), std::invalid_argument);
}

// ---------------------------------------------------------------------------------------------
// decimation

TEST(Decimation, StepOvershootsByLessThanOnePercent) {
  const Series step =
      atDesignRate(sampled(4.0, 1000.0, [](double t) { return t < 2.0 ? 0.0 : 100.0; }));
  EXPECT_LT(*std::max_element(step.current.begin(), step.current.end()), 101.0);
  EXPECT_GT(*std::min_element(step.current.begin(), step.current.end()), -1.0);
}

TEST(Decimation, KeepsTheMinimumOfACrankWithinOnePercentOfItsDepth) {
  const Series fast = sampled(4.0, 1000.0, crank);
  const Series slow = atDesignRate(fast);
  const double lowest = *std::min_element(fast.voltage.begin(), fast.voltage.end());
  const double kept = *std::min_element(slow.voltage.begin(), slow.voltage.end());
  EXPECT_NEAR(kept, lowest, 0.01 * (fast.voltage.front() - lowest));
}

TEST(Decimation, LeavesEdgesWhereTheyWere) {
  const Series fast = sampled(4.0, 1000.0, [](double t) { return t < 2.0 ? 0.0 : -200.0; });
  EXPECT_NEAR(timeOfFall(atDesignRate(fast), -100.0), 2.0, 0.002);
}

TEST(Decimation, PassesBothChannelsAlike) {
  const Series slow = atDesignRate(sampled(4.0, 1000.0, crank));
  for (std::size_t k = 0; k < slow.size(); ++k) {
    EXPECT_NEAR(slow.voltage[k], 12.0 + 0.005 * slow.current[k], 1e-9);
  }
}

TEST(Decimation, GivesTheRateItWasAskedForFromTheFirstSampleOn) {
  const Series slow = atDesignRate(sampled(2.0, 1000.0, crank));
  EXPECT_EQ(slow.time.front(), 0.0);
  for (std::size_t k = 1; k < slow.size(); ++k) {
    EXPECT_NEAR(slow.time[k] - slow.time[k - 1], 0.01, 1e-12);
  }
  EXPECT_NEAR(slow.time.back(), 2.0 - 0.025, 0.011);
}

TEST(Decimation, WorksAtStampsSince1970AndAtRatesThatDoNotDivide) {
  Series fast = sampled(4.0, 730.0, [](double t) { return t < 2.0 ? 0.0 : -200.0; });
  for (double& time : fast.time) time += 1.5e9;
  const Series slow = atDesignRate(fast);
  EXPECT_NEAR(timeOfFall(slow, -100.0) - 1.5e9, 2.0, 0.002);
  EXPECT_NEAR(static_cast<double>(slow.size()), 397.0, 2.0);
}

TEST(Decimation, JitterOfTheInputMovesTheResultByLittle) {
  const auto wave = [](double t) { return 50.0 * std::sin(2.0 * kPi * 2.0 * t); };
  test::Random random(3);
  Series jittered;
  for (int k = 0; k < 4000; ++k) {
    const double time = 1e-3 * (k + random.uniform(-0.4, 0.4));
    jittered.append({time, wave(time), 12.0});
  }
  const Series slow = atDesignRate(jittered);
  const double gain = gainAt(designBessel8(20.0, 1000.0), 2.0, 1000.0);
  for (std::size_t k = 20; k < slow.size(); ++k) {
    EXPECT_NEAR(slow.current[k], gain * wave(slow.time[k]), 0.1);
  }
}

TEST(Decimation, StartsAnewAfterAGapAndFillsNothingIn) {
  Series fast = sampled(4.0, 1000.0, [](double t) { return t < 2.0 ? -100.0 : 40.0; });
  for (std::size_t k = 2000; k < fast.size(); ++k) fast.time[k] += 30.0;
  const Series slow = atDesignRate(fast);
  for (std::size_t k = 0; k < slow.size(); ++k) {
    EXPECT_TRUE(slow.time[k] < 2.0 || slow.time[k] >= 32.0) << slow.time[k];
    EXPECT_NEAR(slow.current[k], slow.time[k] < 2.0 ? -100.0 : 40.0, 1e-9);
  }
  EXPECT_GT(slow.time.back(), 33.9);
}

TEST(Decimation, BridgesAFewMissingSamples) {
  Series fast = sampled(4.0, 1000.0, crank);
  for (auto* values : {&fast.time, &fast.current, &fast.voltage}) {
    values->erase(values->begin() + 1000, values->begin() + 1008);
  }
  const Series slow = atDesignRate(fast);
  for (std::size_t k = 1; k < slow.size(); ++k) {
    EXPECT_NEAR(slow.time[k] - slow.time[k - 1], 0.01, 1e-9);
  }
}

TEST(Decimation, SeriesUpToTwiceTheRateIsReturnedUnchanged) {
  const Series slow = sampled(4.0, 150.0, crank);
  const Series same = atDesignRate(slow);
  EXPECT_EQ(same.time, slow.time);
  EXPECT_EQ(same.current, slow.current);
  EXPECT_TRUE(atDesignRate({}).empty());
}

TEST(Decimation, SeriesAboveTwiceTheRateIsFiltered) {
  const Series fast = sampled(4.0, 201.0, crank);
  EXPECT_NEAR(static_cast<double>(atDesignRate(fast).size()), 398.0, 2.0);
}

TEST(Decimation, CarriesTemperaturesOver) {
  Series fast = sampled(1.0, 1000.0, crank);
  fast.temperature_time = {0.5};
  fast.temperature = {298.0};
  EXPECT_EQ(atDesignRate(fast).temperature, fast.temperature);
}

TEST(Decimator, StreamsTheSameAsTheWholeSeries) {
  const Series fast = sampled(4.0, 1000.0, crank);
  const Series whole = atDesignRate(fast);
  Decimator decimator(1.0 / medianInterval(fast));
  std::vector<double> current;
  for (std::size_t k = 0; k < fast.size(); ++k) {
    for (const auto& output : decimator.push(fast[k])) {
      current.push_back(output.current);
    }
  }
  EXPECT_EQ(current, whole.current);
}

TEST(Decimator, RatesAndSamplesOutsideTheirRangesAreRefused) {
  EXPECT_THROW(Decimator(150.0), std::invalid_argument);
  EXPECT_THROW(Decimator(std::nan("")), std::invalid_argument);
  Decimator decimator(1000.0);
  decimator.push({1.0, 0.0, 12.0});
  EXPECT_THROW(decimator.push({1.0, 0.0, 12.0}), std::invalid_argument);
  EXPECT_THROW(decimator.push({2.0, std::nan(""), 12.0}), std::invalid_argument);
}

}  // namespace
}  // namespace battery_sof

#include "estimation/composition_fit.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numeric>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace battery_sof {
namespace {

TEST(ParallelFor, DoesEveryPieceOfWorkOnce) {
  for (int threads : {0, 1, 2, 3, 8, 200}) {
    std::vector<std::atomic<int>> done(101);
    parallelFor(done.size(), threads, [&](std::size_t k) { ++done[k]; });
    for (const auto& times : done) EXPECT_EQ(times, 1) << threads << " threads";
  }
}

TEST(ParallelFor, GivesTheSameResultsWithAnyNumberOfThreads) {
  const auto results = [](int threads) {
    std::vector<double> out(64);
    parallelFor(out.size(), threads, [&](std::size_t k) {
      double x = static_cast<double>(k);
      for (int n = 0; n < 1000; ++n) x = std::sin(x) + 1.0;
      out[k] = x;
    });
    return out;
  };
  const auto one = results(1);
  EXPECT_EQ(results(2), one);
  EXPECT_EQ(results(7), one);
}

TEST(ParallelFor, WithOneThreadWorksInOrderOnTheCallersThread) {
  std::vector<std::size_t> order;
  std::set<std::thread::id> threads;
  parallelFor(10, 1, [&](std::size_t k) {
    order.push_back(k);
    threads.insert(std::this_thread::get_id());
  });
  std::vector<std::size_t> expected(10);
  std::iota(expected.begin(), expected.end(), 0u);
  EXPECT_EQ(order, expected);
  EXPECT_EQ(threads, std::set<std::thread::id>{std::this_thread::get_id()});
}

TEST(ParallelFor, ThrowsTheFirstFailureByIndexAfterAllWorkIsDone) {
  for (int threads : {1, 2, 5}) {
    std::atomic<int> done{0};
    try {
      parallelFor(20, threads, [&](std::size_t k) {
        ++done;
        if (k == 7 || k == 13) throw std::runtime_error("piece " + std::to_string(k));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "piece 7");
    }
    EXPECT_EQ(done, 20);
  }
}

TEST(ParallelFor, OfNothingDoesNothing) {
  parallelFor(0, 4, [](std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace battery_sof

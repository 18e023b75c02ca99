#include "ros/background_worker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <vector>

#include "prediction/online_session.hpp"
#include "ros/response_times.hpp"
#include "support/composed.hpp"

using namespace battery_sof;
using namespace battery_sof::test;

constexpr std::chrono::milliseconds kLong{60000};

TEST(BackgroundWorker, DoesOneJobAfterTheOtherWhoeverPostsThem) {
  int running = 0, done = 0;  // guarded by there being one job at a time
  BackgroundWorker<int, int> worker(
      [&](int job) {
        EXPECT_EQ(++running, 1);
        --running;
        ++done;
        return 2 * job;
      },
      0);
  for (int k = 0; k < 200; ++k) {
    std::thread other([&] { worker.waitUntilIdle(kLong); });
    worker.waitUntilIdle(kLong);
    EXPECT_EQ(worker.post(k).get(), 2 * k);
    other.join();
  }
  worker.stop();
  EXPECT_EQ(done, 200);
}

TEST(BackgroundWorker, ThrowsWhatTheWorkThrowsWhereItIsWaitedFor) {
  BackgroundWorker<int, int> worker([](int) -> int { throw std::runtime_error("broken"); }, 0);
  EXPECT_THROW(worker.post(1).get(), std::runtime_error);
}

TEST(BackgroundWorker, BreaksItsPromisesWhenItEndsAndKeepsNobodyWaiting) {
  for (int k = 0; k < 100; ++k) {
    BackgroundWorker<int, int> worker([](int job) { return job; }, 0);
    std::thread waiting([&] { worker.waitUntilIdle(kLong); });
    std::future<int> outcome = worker.post(k);
    worker.stop();
    waiting.join();
    try {
      EXPECT_EQ(outcome.get(), k);
    } catch (const std::future_error& error) {
      EXPECT_EQ(error.code(), std::future_errc::broken_promise);
    }
    EXPECT_THROW(worker.post(k).get(), std::future_error);
  }
}

/// As the node has them: samples on one thread, questions on another, fits on a third, one mutex
/// for the session.
TEST(BackgroundWorker, FitsASessionThatTakesSamplesAndIsAsked) {
  SessionOptions options;
  options.buffer = 60.0;
  options.window_length = 30.0;
  options.identify_period = 20.0;
  options.retry_period = 5.0;
  options.min_window_quality = 0.0;
  OnlineSession session(options);
  std::mutex mutex;
  std::atomic<bool> ends{false};
  BackgroundWorker<IdentificationJob, bool> worker(
      [&](const IdentificationJob& job) {
        IdentificationResult result = runIdentification(job);
        const std::lock_guard<std::mutex> lock(mutex);
        return session.finish(std::move(result)).accepted;
      },
      0);
  std::atomic<int> answered{0};  // while the drive goes on
  std::thread asks([&] {
    while (!ends) {
      std::optional<ModelSnapshot> model;
      {
        const std::lock_guard<std::mutex> lock(mutex);
        model.emplace(session.live());
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // a mutex is not fair
      answered += model->predictCranking({-20.0, 10.0, -200.0, 0.5, 7.2}).u_min.has_value();
    }
  });
  std::vector<std::future<bool>> fits;
  const Series drive = recordingOf({}, 120.0);
  for (std::size_t n = 0; n < drive.size(); ++n) {
    const std::lock_guard<std::mutex> lock(mutex);
    session.push({drive.time[n], drive.current[n], drive.voltage[n], {}});
    if (auto job = session.takeDueJob()) fits.push_back(worker.post(std::move(*job)));
  }
  for (std::future<bool>& fit : fits) fit.get();  // accepted or not
  ends = true;
  asks.join();
  EXPECT_GT(fits.size(), 0u);
  EXPECT_FALSE(session.isJobOut());
  EXPECT_EQ(session.counts().accepted, drive.size());
}

TEST(ResponseClock, CountsWhatThreadsAddWhileAnotherReports) {
  ResponseClock clock;
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k)
    threads.emplace_back([&] {
      for (int n = 0; n < 2000; ++n) {
        clock.addQuery(1.0);
        clock.addSample(2.0);
      }
    });
  double longest = 0.0;
  for (int k = 0; k < 20; ++k) longest = std::max(longest, clock.report().sample_longest_ms);
  for (std::thread& thread : threads) thread.join();
  const ResponseTimes times = clock.report();
  EXPECT_EQ(times.queries, 8000u);
  EXPECT_EQ(std::max(longest, times.sample_longest_ms), 2.0);
}

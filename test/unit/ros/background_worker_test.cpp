#include "ros/background_work.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <mutex>
#include <thread>
#include <vector>

#include "prediction/online_session.hpp"
#include "ros/node_statistics.hpp"
#include "support/composed.hpp"

using namespace battery_sof;
using namespace battery_sof::test;

TEST(BackgroundWorker, DoesOneJobAfterTheOtherWhoeverPostsThem) {
  int running = 0, sum = 0;  // guarded by there being one job at a time
  for (int k = 0; k < 200; ++k) {
    std::promise<void> first, second;
    std::function<void(int)> work;
    BackgroundWorker worker(0);
    work = [&](int job) {
      EXPECT_EQ(++running, 1);
      if (job == 1) worker.post([&] { work(2); });
      sum += job;
      --running;
      (job == 1 ? first : second).set_value();
    };
    std::thread([&] { worker.post([&] { work(1); }); }).join();
    first.get_future().get();
    second.get_future().get();
  }
  EXPECT_EQ(sum, 600);
}

TEST(BackgroundWorker, DropsWhatItHasNotBegunWhenItEnds) {
  for (int k = 0; k < 100; ++k) {
    std::atomic<int> done{0};
    BackgroundWorker worker(0);
    worker.post([&] { ++done; });
    worker.stop();
    const int before = done;
    EXPECT_LE(before, 1);
    worker.post([&] { ++done; });
    EXPECT_EQ(done, before);
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
  std::atomic<int> fitted{0};
  const auto fit = [&](const IdentificationJob& job) {
    IdentificationResult result = runIdentification(job);
    const std::lock_guard<std::mutex> lock(mutex);
    session.finish(std::move(result));  // accepted or not
    ++fitted;
  };
  BackgroundWorker worker(0);
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
  int posted = 0;
  const Series drive = recordingOf({}, 120.0);
  for (std::size_t n = 0; n < drive.size(); ++n) {
    const std::lock_guard<std::mutex> lock(mutex);
    session.push({drive.time[n], drive.current[n], drive.voltage[n], {}});
    if (auto job = session.takeDueJob()) {
      worker.post([&fit, job = std::move(*job)] { fit(job); });
      ++posted;
    }
  }
  while (fitted < posted) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  ends = true;
  asks.join();
  EXPECT_GT(posted, 0);
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

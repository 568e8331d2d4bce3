#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/detail/worker_pool.hpp>

using holdfast::detail::WorkerPool;

TEST_CASE("every item is done once and before run returns, for any number of threads and items") {
  for (const int threads : {1, 2, 3, 7}) {
    WorkerPool pool(threads);
    CHECK(pool.threads() == threads);
    int wrong = 0;
    for (int items = 0; items < 60; ++items) {
      for (int repeat = 0; repeat < 5; ++repeat) {
        // Plain ints: a race on them, or a late writer, is what ThreadSanitizer would find.
        std::vector<int> done(static_cast<std::size_t>(items), 0);
        pool.run(items, [&done](int i) { ++done[static_cast<std::size_t>(i)]; });
        for (const int count : done) wrong += count != 1;
      }
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("pools come and go, worked or not") {
  for (int i = 0; i < 50; ++i) {
    const auto pool = std::make_unique<WorkerPool>(1 + i % 4);
    std::atomic<int> sum{0};
    if (i % 3 != 0) pool->run(10, [&sum](int item) { sum += item; });
    CHECK(sum == (i % 3 != 0 ? 45 : 0));
  }
}

TEST_CASE("threads help: with work that takes time, more than one takes part") {
  WorkerPool pool(2);
  std::atomic<int> others{0};
  const std::thread::id me = std::this_thread::get_id();
  // A worker must wake within the 2 s that the items last at most; it does in some microseconds.
  for (int round = 0; round < 100 && others == 0; ++round) {
    pool.run(20, [&](int) {
      if (std::this_thread::get_id() != me) ++others;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    });
  }
  CHECK(others > 0);
}

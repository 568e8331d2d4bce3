// The exchange between the tracker's thread and the renderers'. The tests with threads are those that the tsan preset
// runs; they check, beside what ThreadSanitizer does, that no reader ever sees parts of two estimates.
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/pipeline/latest_pose.hpp>

namespace holdfast::detail {
/// Stops a writer between the two ends of a write.
struct NewestWordsTestAccess {
  template <typename Words>
  static void begin_write(Words& words) {
    words.begin_write();
  }
  template <typename Words>
  static void end_write(Words& words) {
    words.end_write();
  }
};
}  // namespace holdfast::detail

using namespace holdfast;

namespace {

/// An estimate all of whose numbers follow from one: parts of two would disagree.
PoseEstimate estimate_number(std::int64_t n) {
  PoseEstimate e;
  const double x = static_cast<double>(n);
  e.t = HostTime(Duration(n));
  e.X_WB = Rigid::translation(Vector3(x, x + 1, x + 2));
  e.velocity = Twist{Vector3(x, -x, 2 * x), Vector3(3 * x, x, x)};
  e.covariance = Matrix12::Constant(x);
  return e;
}

bool is_whole(const PoseEstimate& e) {
  const double x = static_cast<double>(e.t.time_since_epoch().count());
  return e.X_WB.p() == Vector3(x, x + 1, x + 2) && e.velocity && e.velocity->v_WB == Vector3(x, -x, 2 * x) &&
         e.velocity->w_WB_B == Vector3(3 * x, x, x) && e.covariance == Matrix12::Constant(x);
}

}  // namespace

TEST_CASE("an estimate comes out as it went in") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  LatestPose latest;
  CHECK_FALSE(latest.newest().has_value());
  for (int i = 1; i <= 50; ++i) {
    PoseEstimate e;
    e.t = time_at(0.001 * i);
    e.X_WB = Rigid(Quaternion(normal(random), normal(random), normal(random), normal(random)),
                   Vector3(normal(random), normal(random), normal(random)));
    if (i % 3 != 0) {
      e.velocity = Twist{Vector3(normal(random), normal(random), normal(random)),
                         Vector3(normal(random), normal(random), normal(random))};
    }
    for (int r = 0; r < 12; ++r) {
      for (int c = 0; c < 12; ++c) e.covariance(r, c) = normal(random);
    }
    REQUIRE(latest.publish(e) == PublishResult::published);
    const std::optional<PoseEstimate> out = latest.newest();
    REQUIRE(out.has_value());
    CHECK(out->t == e.t);
    CHECK(out->X_WB.p() == e.X_WB.p());
    // Normalised once more on the way: a unit of the last digit.
    CHECK((out->X_WB.q().coeffs() - e.X_WB.q().coeffs()).cwiseAbs().maxCoeff() <= 3e-16);
    CHECK(out->velocity.has_value() == e.velocity.has_value());
    if (e.velocity) {
      CHECK(out->velocity->v_WB == e.velocity->v_WB);
      CHECK(out->velocity->w_WB_B == e.velocity->w_WB_B);
    }
    CHECK(out->covariance == e.covariance);
    // Two reads of one estimate agree to the last bit.
    CHECK(latest.newest()->X_WB.q().coeffs() == out->X_WB.q().coeffs());
  }
  CHECK(latest.counters().published == 50);
  CHECK(latest.counters().refused() == 0);
}

TEST_CASE("bad estimates are refused, counted by their reason, and leave what was there") {
  LatestPose latest;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(latest.publish(estimate_number(1000)) == PublishResult::published);

  PoseEstimate bad = estimate_number(2000);
  bad.covariance(3, 4) = nan;
  CHECK(latest.publish(bad) == PublishResult::not_finite);
  bad = estimate_number(2000);
  bad.velocity->w_WB_B.x() = std::numeric_limits<double>::infinity();
  CHECK(latest.publish(bad) == PublishResult::not_finite);
  bad = estimate_number(2000);
  bad.X_WB = Rigid::translation(Vector3(0, nan, 0));
  CHECK(latest.publish(bad) == PublishResult::not_finite);
  CHECK(latest.publish(estimate_number(1000)) == PublishResult::not_newer);
  CHECK(latest.publish(estimate_number(999)) == PublishResult::not_newer);
  CHECK(latest.publish(estimate_number(2000000), HostTime(Duration(10))) == PublishResult::from_future);

  const LatestPoseCounters c = latest.counters();
  CHECK(c.published == 1);
  CHECK(c.not_finite == 3);
  CHECK(c.not_newer == 2);
  CHECK(c.from_future == 1);
  CHECK(c.refused() == 6);
  CHECK(c.restarts == 0);
  CHECK(latest.newest()->t == HostTime(Duration(1000)));
  CHECK(latest.publish(estimate_number(1001), HostTime(Duration(10))) == PublishResult::published);
}

TEST_CASE("times at both ends of the clock do not overflow") {
  LatestPose latest;
  PoseEstimate e = estimate_number(0);
  e.t = HostTime(Duration(std::numeric_limits<std::int64_t>::max()));
  CHECK(latest.publish(e, HostTime(Duration(std::numeric_limits<std::int64_t>::min()))) == PublishResult::from_future);
  e.t = HostTime(Duration(std::numeric_limits<std::int64_t>::min()));
  CHECK(latest.publish(e, HostTime(Duration(std::numeric_limits<std::int64_t>::max()))) == PublishResult::published);
}

TEST_CASE("a tracker whose times start anew is believed after a while, a stray old stamp never") {
  LatestPose latest;
  REQUIRE(latest.publish(estimate_number(1'000'000'000)) == PublishResult::published);  // a stamp from the far future
  for (int i = 1; i < LatestPose::restart_after; ++i) {
    CHECK(latest.publish(estimate_number(100 + i)) == PublishResult::not_newer);
  }
  CHECK(latest.publish(estimate_number(500)) == PublishResult::restarted);
  CHECK(latest.newest()->t == HostTime(Duration(500)));
  CHECK(latest.publish(estimate_number(501)) == PublishResult::published);
  CHECK(latest.counters().restarts == 1);
  // Old stamps among good ones, or the same one again and again, start nothing.
  for (int i = 0; i < 100; ++i) {
    CHECK(latest.publish(estimate_number(300 + i)) == PublishResult::not_newer);
    CHECK(latest.publish(estimate_number(600 + i)) == PublishResult::published);
  }
  for (int i = 0; i < 100; ++i) CHECK(latest.publish(estimate_number(300)) == PublishResult::not_newer);
  CHECK(latest.counters().restarts == 1);
}

TEST_CASE("a writer paused in the middle of a write holds up no reader") {
  using Words = detail::NewestWords<4, 3>;
  using Access = detail::NewestWordsTestAccess;
  const auto words = std::make_unique<Words>();
  Words::Record record{};
  CHECK(words->read(record) == detail::WordsRead::nothing_yet);
  Access::begin_write(*words);
  CHECK(words->read(record) == detail::WordsRead::nothing_yet);
  Access::end_write(*words);
  CHECK(words->read(record) == detail::WordsRead::ok);
  for (std::uint64_t n = 0; n < 10; ++n) {
    words->write({n, n + 1, n + 2, n + 3});
    Access::begin_write(*words);  // descheduled here
    for (int reads = 0; reads < 3; ++reads) {
      REQUIRE(words->read(record) == detail::WordsRead::ok);
      CHECK(record == Words::Record{n, n + 1, n + 2, n + 3});
    }
    Access::end_write(*words);
  }
  CHECK(words->count() == 21);
}

TEST_CASE("one thread publishes, three read: whole estimates, ever newer, and the last is seen") {
  const auto latest = std::make_unique<LatestPose>();
  constexpr std::int64_t last = 20000;
  std::atomic<bool> torn{false}, backward{false};
  std::atomic<std::int64_t> reads{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 3; ++i) {
    readers.emplace_back([&] {
      HostTime seen{};
      std::int64_t n = 0;
      while (seen < HostTime(Duration(last))) {
        const std::optional<PoseEstimate> e = latest->newest();
        ++n;
        if (!e) continue;
        if (!is_whole(*e)) torn = true;
        if (e->t < seen) backward = true;
        seen = e->t;
      }
      reads += n;
    });
  }
  std::thread tracker([&] {
    for (std::int64_t n = 1; n <= last; ++n) {
      latest->publish(estimate_number(n));
      if (n % 64 == 0) std::this_thread::yield();  // let the readers in also on one core
    }
  });
  tracker.join();
  for (std::thread& reader : readers) reader.join();
  CHECK_FALSE(torn);
  CHECK_FALSE(backward);
  CHECK(reads >= 3);
  CHECK(latest->counters().published == static_cast<std::uint64_t>(last));
  CHECK(latest->counters().refused() == 0);
}

TEST_CASE("the fewest slots and the fastest writer: a torn record is never handed out") {
  // Two slots are overtaken as soon as a reader is slow: what a reader cannot copy whole it must not return.
  using Words = detail::NewestWords<32, 2>;
  const auto words = std::make_unique<Words>();
  std::atomic<bool> stop{false}, torn{false};
  std::atomic<std::int64_t> whole{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back([&] {
      Words::Record record{};
      while (!stop || whole == 0) {
        if (words->read(record) != detail::WordsRead::ok) continue;
        for (const std::uint64_t word : record) {
          if (word != record[0]) torn = true;
        }
        ++whole;
      }
    });
  }
  for (std::uint64_t n = 1; n <= 100000; ++n) {
    Words::Record record;
    record.fill(n);
    words->write(record);
  }
  stop = true;
  for (std::thread& reader : readers) reader.join();
  CHECK_FALSE(torn);
  CHECK(whole > 0);
}

#include <cmath>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/timing/clock_offset_estimator.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

using TrackerTime = TimePoint<TrackerClock>;
using Estimator = ClockOffsetEstimator<TrackerClock, HostClock>;

// Nothing in it owns memory, so nothing can allocate.
static_assert(std::is_trivially_copyable_v<Estimator>);

struct Message {
  TrackerTime stamp;
  HostTime arrival;
};

/// What the network does to a message.
struct Delay {
  double least_ms = 0.0, mean_ms = 1.0;  ///< exponential above the least
  double pause_probability = 0.0;        ///< of a pause of 60-200 ms (001 section 5.3)
};

std::vector<Message> send(const ClockOffset<TrackerClock, HostClock>& truth, double seconds, double rate_hz,
                          const Delay& delay, unsigned seed) {
  std::mt19937_64 random(seed);
  std::exponential_distribution<double> jitter(1.0 / delay.mean_ms);
  std::uniform_real_distribution<double> uniform;
  std::vector<Message> messages;
  HostTime last_arrival = HostTime::min();
  for (int i = 0; i < static_cast<int>(seconds * rate_hz); ++i) {
    const TrackerTime stamp = time_at<TrackerClock>(1000.0 + i / rate_hz);
    double ms = delay.least_ms + jitter(random);
    if (uniform(random) < delay.pause_probability) ms += 60.0 + 140.0 * uniform(random);
    // Messages queue: none overtakes another.
    last_arrival = std::max(last_arrival, truth.convert(stamp) + from_milliseconds(ms));
    messages.push_back({stamp, last_arrival});
  }
  return messages;
}

Estimator feed(const std::vector<Message>& messages, const ClockOffsetOptions& options = {}) {
  Estimator estimator(options);
  for (const Message& m : messages) CHECK(estimator.update(m.stamp, m.arrival) == ClockSample::accepted);
  return estimator;
}

double error_ms(const ClockEstimate<TrackerClock, HostClock>& estimate,
                const ClockOffset<TrackerClock, HostClock>& truth, TrackerTime t) {
  return to_milliseconds(estimate.offset.convert(t) - truth.convert(t));
}

const ClockOffset<TrackerClock, HostClock> one_second_in_six_hours(time_at<TrackerClock>(1000.0), time_at(3.25),
                                                                   1.0 / 21'600);

}  // namespace

TEST_CASE("the skew of 001 section 5.3, under late deliveries and pauses, is found within 2 parts in a million") {
  const auto messages = send(one_second_in_six_hours, 180, 120, {0.0, 2.0, 0.01}, 71);
  const auto estimate = feed(messages).estimate();
  REQUIRE(estimate);
  const TrackerTime now = messages.back().stamp;
  MESSAGE("offset off by " << error_ms(*estimate, one_second_in_six_hours, now) * 1e3 << " us, stated "
                           << to_milliseconds(estimate->uncertainty) * 1e3 << " us; skew off by "
                           << (estimate->offset.skew() - 1.0 / 21'600) * 1e6 << " ppm, stated "
                           << estimate->skew_uncertainty * 1e6);
  // The earliest of 60 messages per bin is late by 2 ms / 60 = 33 us, and the hull touches the earliest of those.
  CHECK(std::abs(error_ms(*estimate, one_second_in_six_hours, now)) < 0.03);
  CHECK(estimate->offset.skew() == doctest::Approx(46.3e-6).epsilon(2e-6 / 46.3e-6));
  // Left uncorrected, the skew would have cost 8.3 ms by now.
  CHECK(to_milliseconds(now - messages.front().stamp) / 21'600 > 8.3);
}

TEST_CASE("a plain mean would be late by the mean delay; the envelope is not") {
  const ClockOffset<TrackerClock, HostClock> truth(time_at<TrackerClock>(1000.0), time_at(3.25), 0.0);
  const auto messages = send(truth, 20, 100, {0.0, 5.0, 0.02}, 72);
  double mean = 0.0;
  for (const Message& m : messages)
    mean += to_milliseconds(m.arrival - truth.convert(m.stamp)) / static_cast<double>(messages.size());
  CHECK(mean > 5.0);
  const auto estimate = feed(messages).estimate();
  REQUIRE(estimate);
  CHECK(std::abs(error_ms(*estimate, truth, messages.back().stamp)) < 0.2);
}

TEST_CASE("the stated uncertainty holds in about 95 of 100 cases, and is not idle") {
  int within_offset = 0, within_skew = 0, runs = 0;
  double stated = 0.0, actual = 0.0;
  for (const double mean_ms : {0.2, 2.0, 10.0}) {
    for (const double seconds : {0.4, 0.9, 3.0, 10.0, 60.0, 150.0}) {
      for (unsigned seed = 0; seed < 25; ++seed) {
        const double skew = (static_cast<double>(seed) - 12.0) * 1e-5;
        const ClockOffset<TrackerClock, HostClock> truth(time_at<TrackerClock>(1000.0), time_at(3.25), skew);
        const auto messages =
            send(truth, seconds, 100, {0.0, mean_ms, 0.005}, 100 * seed + static_cast<unsigned>(seconds));
        const auto estimate = feed(messages).estimate();
        REQUIRE(estimate);
        const double error = std::abs(error_ms(*estimate, truth, messages.back().stamp));
        ++runs;
        within_offset += error <= to_milliseconds(estimate->uncertainty) ? 1 : 0;
        within_skew += std::abs(estimate->offset.skew() - skew) <= estimate->skew_uncertainty ? 1 : 0;
        if (seconds > 5.0) {
          stated += to_milliseconds(estimate->uncertainty) / mean_ms;
          actual += error / mean_ms;
        }
      }
    }
  }
  MESSAGE("within: offset " << 100.0 * within_offset / runs << " %, skew " << 100.0 * within_skew / runs
                            << " %; stated over actual " << stated / actual);
  CHECK(within_offset > 0.93 * runs);
  CHECK(within_skew > 0.93 * runs);
  CHECK(stated / actual < 8.0);  // a 95 % bound of an exponential error is three times its mean
}

TEST_CASE("a known least delay is taken off, an unknown one stays") {
  const ClockOffset<TrackerClock, HostClock> truth(time_at<TrackerClock>(1000.0), time_at(3.25), 20e-6);
  const auto messages = send(truth, 30, 200, {4.0, 1.0, 0.0}, 73);
  ClockOffsetOptions options;
  CHECK(error_ms(*feed(messages, options).estimate(), truth, messages.back().stamp) ==
        doctest::Approx(4.0).epsilon(0.01));
  options.least_delay = 4ms;
  CHECK(std::abs(error_ms(*feed(messages, options).estimate(), truth, messages.back().stamp)) < 0.04);
}

TEST_CASE("nothing is said before ten messages") {
  Estimator estimator;
  CHECK_FALSE(estimator.estimate());
  for (int i = 0; i < 9; ++i) estimator.update(time_at<TrackerClock>(i), time_at(i));
  CHECK_FALSE(estimator.estimate());
  estimator.update(time_at<TrackerClock>(9), time_at(9));
  CHECK(estimator.estimate());
}

TEST_CASE("skew is believed only within its bounds") {
  // A burst of two seconds with delays of 10 ms would support any slope; 200 ppm is the most allowed.
  const ClockOffset<TrackerClock, HostClock> truth(time_at<TrackerClock>(1000.0), time_at(3.25), 0.0);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const auto estimate = feed(send(truth, 2, 20, {0.0, 10.0, 0.0}, 200 + seed)).estimate();
    REQUIRE(estimate);
    CHECK(std::abs(estimate->offset.skew()) <= 200e-6);
  }
}

TEST_CASE("backward and absurd messages are refused, named, counted, and change nothing") {
  auto messages = send(one_second_in_six_hours, 10, 100, {0.0, 1.0, 0.0}, 74);
  Estimator estimator = feed(messages);
  const auto before = estimator.estimate();
  const TrackerTime stamp = messages.back().stamp;
  const HostTime arrival = messages.back().arrival;
  CHECK(estimator.update(stamp, arrival + 1ms) == ClockSample::backward_stamp);  // a duplicate
  CHECK(estimator.update(stamp - 5ms, arrival + 1ms) == ClockSample::backward_stamp);
  CHECK(estimator.update(stamp + 5ms, arrival - 1ms) == ClockSample::backward_arrival);
  CHECK(estimator.update(stamp + 10s, arrival + 1ms) == ClockSample::jump);
  CHECK(estimator.update(stamp + 5ms, arrival + 10s) == ClockSample::jump);
  CHECK(estimator.update(TrackerTime::max(), arrival + 1ms) == ClockSample::out_of_range);
  CHECK(estimator.update(stamp + 5ms, HostTime::min()) == ClockSample::out_of_range);
  CHECK(estimator.refused() == 7);
  CHECK(estimator.samples() == 1000);
  const auto after = estimator.estimate();
  CHECK(after->offset.convert(stamp) == before->offset.convert(stamp));
  CHECK(after->offset.skew() == before->offset.skew());
  CHECK(estimator.update(stamp + 10ms, arrival + 10ms) == ClockSample::accepted);
}

TEST_CASE("a tracker that restarts its clock is followed after 20 messages that agree") {
  Estimator estimator = feed(send(one_second_in_six_hours, 10, 100, {0.0, 1.0, 0.0}, 75));
  const ClockOffset<TrackerClock, HostClock> reborn(time_at<TrackerClock>(0.0), time_at(20.0), 0.0);
  int refused = 0;
  for (int i = 0; i < 100; ++i) {
    const TrackerTime stamp = time_at<TrackerClock>(0.01 * i);
    const ClockSample verdict = estimator.update(stamp, reborn.convert(stamp) + 1ms);
    if (i < 19) {
      CHECK(verdict == ClockSample::backward_stamp);
    } else {
      CHECK(verdict == (i == 19 ? ClockSample::restarted : ClockSample::accepted));
    }
    refused += verdict == ClockSample::backward_stamp ? 1 : 0;
  }
  CHECK(refused == 19);
  CHECK(estimator.restarts() == 1);
  REQUIRE(estimator.estimate());
  CHECK(error_ms(*estimator.estimate(), reborn, time_at<TrackerClock>(1.0)) == doctest::Approx(1.0).epsilon(1e-6));
}

TEST_CASE("refused messages that contradict each other restart nothing") {
  Estimator estimator = feed(send(one_second_in_six_hours, 10, 100, {0.0, 1.0, 0.0}, 76));
  std::mt19937_64 random(77);
  std::uniform_real_distribution<double> any(0.0, 900.0);
  for (int i = 0; i < 500; ++i) {
    const ClockSample verdict = estimator.update(time_at<TrackerClock>(any(random)), time_at(20.0 + 0.01 * i));
    CHECK(verdict == ClockSample::backward_stamp);
  }
  CHECK(estimator.restarts() == 0);
}

TEST_CASE("a host that slept: one long pause changes nothing, a set clock restarts") {
  auto messages = send(one_second_in_six_hours, 300, 100, {0.0, 1.0, 0.0}, 78);
  // 100 s of silence in the middle: clocks ran on, so the same line continues.
  messages.erase(messages.begin() + 10'000, messages.begin() + 20'000);
  const auto estimate = feed(messages).estimate();
  REQUIRE(estimate);
  CHECK(std::abs(error_ms(*estimate, one_second_in_six_hours, messages.back().stamp)) < 0.03);
}

TEST_CASE("a skew that changes is followed within the window") {
  // The crystal warms up: 20 ppm for 300 s, then 60 ppm for 300 s; the window is 128 s.
  const ClockOffset<TrackerClock, HostClock> cold(time_at<TrackerClock>(1000.0), time_at(3.25), 20e-6);
  const ClockOffset<TrackerClock, HostClock> warm(time_at<TrackerClock>(1300.0),
                                                  cold.convert(time_at<TrackerClock>(1300.0)), 60e-6);
  Estimator estimator;
  std::mt19937_64 random(79);
  std::exponential_distribution<double> jitter(1.0);
  for (int i = 0; i < 60'000; ++i) {
    const TrackerTime stamp = time_at<TrackerClock>(1000.0 + 0.01 * i);
    const HostTime sent = i < 30'000 ? cold.convert(stamp) : warm.convert(stamp);
    estimator.update(stamp, sent + from_milliseconds(jitter(random)));
  }
  const auto estimate = estimator.estimate();
  CHECK(estimate->offset.skew() == doctest::Approx(60e-6).epsilon(0.03));
  CHECK(std::abs(error_ms(*estimate, warm, time_at<TrackerClock>(1600.0))) < 0.05);
}

TEST_CASE("no sequence of messages, however wild, leads to an estimate that is not a number") {
  std::mt19937_64 random(80);
  std::uniform_int_distribution<std::int64_t> any(std::numeric_limits<std::int64_t>::min(),
                                                  std::numeric_limits<std::int64_t>::max());
  std::uniform_int_distribution<int> kind(0, 511);
  int estimates = 0;
  for (int run = 0; run < 20; ++run) {
    Estimator estimator;
    std::int64_t stamp = 0, arrival = 0;
    for (int i = 0; i < 3000; ++i) {
      // Spells of ordinary messages, steps of every size by one clock or both, and single wild numbers.
      const int what = kind(random);
      const auto step = [&] {
        return (any(random) & std::numeric_limits<std::int64_t>::max()) >> (3 + kind(random) % 60);
      };
      const bool is_wild = what < 4;
      if (what < 8) {
        stamp = (stamp + step()) % (std::int64_t{1} << 61);
      } else if (what < 12) {
        arrival = (arrival + step()) % (std::int64_t{1} << 61);
      }
      stamp += 10'000'000;
      arrival += 10'000'000 + (any(random) & 0xfffff);
      estimator.update(TrackerTime(Duration(is_wild ? any(random) : stamp)), HostTime(Duration(arrival)));
      const auto estimate = estimator.estimate();
      if (!estimate) continue;
      CHECK(std::isfinite(estimate->offset.skew()));
      CHECK(std::abs(estimate->offset.skew()) <= 200e-6);
      CHECK(estimate->uncertainty >= Duration{0});
      ++estimates;
    }
  }
  CHECK(estimates > 1000);
}

#include <random>

#include <doctest/doctest.h>

#include <holdfast/timing/vsync_estimator.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

DisplayTiming at(double hz, HostTime first) {
  DisplayTiming timing;
  timing.refresh_hz = hz;
  timing.first_vsync = first;
  return timing;
}

/// Milliseconds by which the estimate errs at the vsync nearest to t.
double phase_error_ms(const DisplayTiming& estimate, const DisplayTiming& truth, HostTime t) {
  const HostTime expected = next_vsync(truth, t);
  const std::int64_t n = next_vsync_number(estimate, expected - frame_period(truth) / 2);
  return to_milliseconds(vsync_at(estimate, n) - expected);
}

}  // namespace

TEST_CASE("phase and refresh are learned from late and missing wake-ups") {
  for (const double hz : {59.94, 60.0, 60.06}) {
    const DisplayTiming truth = at(hz, time_at(7.123));
    VsyncEstimator estimator(at(60.0, {}));
    std::mt19937_64 random(91);
    std::exponential_distribution<double> late_ms(1.0 / 0.3);
    std::uniform_real_distribution<double> uniform;
    HostTime last{};
    for (int n = 0; n < 3600; ++n) {
      if (uniform(random) < 0.1) continue;
      const double ms = late_ms(random) + (uniform(random) < 0.02 ? 16.0 * uniform(random) : 0.0);
      last = std::max(last + 1us, vsync_at(truth, n) + from_milliseconds(ms));
      estimator.update(last);
    }
    const auto timing = estimator.timing();
    REQUIRE(timing);
    INFO("refresh " << hz << " found " << timing->refresh_hz);
    CHECK(timing->refresh_hz == doctest::Approx(hz).epsilon(2e-6));  // 0.3 ms / 30 wake-ups a bin, over a minute
    // A second ahead of the last observation.
    CHECK(std::abs(phase_error_ms(*timing, truth, last + 1s)) < 0.03);
    REQUIRE(estimator.uncertainty());
    CHECK(*estimator.uncertainty() < 100us);
  }
}

TEST_CASE("nothing before ten observations; the rest of the description is kept") {
  DisplayTiming nominal = at(90.0, {});
  nominal.persistence = 2ms;
  VsyncEstimator estimator(nominal);
  for (int n = 0; n < 9; ++n) estimator.update(vsync_at(at(90.0, time_at(3)), n));
  CHECK_FALSE(estimator.timing());
  CHECK_FALSE(estimator.uncertainty());
  estimator.update(vsync_at(at(90.0, time_at(3)), 9));
  REQUIRE(estimator.timing());
  CHECK(estimator.timing()->persistence == 2ms);
  CHECK(std::abs(phase_error_ms(*estimator.timing(), at(90.0, time_at(3)), time_at(3.5))) < 1e-5);
}

TEST_CASE("a very late first wake-up does not fix the phase") {
  const DisplayTiming truth = at(60.0, time_at(7.0));
  VsyncEstimator estimator(at(60.0, {}));
  estimator.update(vsync_at(truth, 0) + 9ms);
  for (int n = 1; n < 200; ++n) estimator.update(vsync_at(truth, n) + 50us);
  REQUIRE(estimator.timing());
  CHECK(phase_error_ms(*estimator.timing(), truth, time_at(10.0)) == doctest::Approx(0.05).epsilon(1e-3));
}

TEST_CASE("a display that changes its phase is followed after 20 vsyncs and 10 more") {
  VsyncEstimator estimator(at(60.0, {}));
  const DisplayTiming before = at(60.0, time_at(7.0));
  const DisplayTiming after = at(60.0, time_at(17.0134));  // 0.8 of a refresh later
  for (int n = 0; n < 300; ++n) estimator.update(vsync_at(before, n) + 50us);
  for (int n = 0; n < 19; ++n) CHECK(estimator.update(vsync_at(after, n) + 50us) == ClockSample::jump);
  for (int n = 19; n < 30; ++n) estimator.update(vsync_at(after, n) + 50us);
  REQUIRE(estimator.timing());
  CHECK(phase_error_ms(*estimator.timing(), after, time_at(18.0)) == doctest::Approx(0.05).epsilon(1e-3));
}

TEST_CASE("observations that run backward are refused") {
  VsyncEstimator estimator(at(60.0, {}));
  CHECK(estimator.update(time_at(1.0)) == ClockSample::accepted);
  CHECK(estimator.update(time_at(1.0)) == ClockSample::backward_arrival);
  CHECK(estimator.update(time_at(0.5)) == ClockSample::backward_arrival);
}

TEST_CASE("two observations of one vsync: the second is refused") {
  VsyncEstimator estimator(at(60.0, {}));
  for (int n = 0; n < 60; ++n) estimator.update(vsync_at(at(60.0, time_at(3)), n));
  CHECK(estimator.update(vsync_at(at(60.0, time_at(3)), 59) + 1ms) == ClockSample::backward_stamp);
}

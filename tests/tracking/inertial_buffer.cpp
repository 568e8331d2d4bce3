#include <cmath>
#include <limits>

#include <doctest/doctest.h>

#include <holdfast/tracking/inertial_buffer.hpp>

#include "allocation_counter.hpp"

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

/// Rate and force are linear in time, so that interpolation has no error of its own.
InertialReading reading(double ms) {
  return {HostTime(from_milliseconds(ms)), Vector3(ms, 2.0 * ms, -ms), Vector3(0.0, 9.8, 0.1 * ms)};
}

}  // namespace

TEST_CASE("a ring keeps the newest, in order, and finds each; nothing allocates") {
  InertialBuffer<16> buffer;
  CHECK_FALSE(buffer.at(time_at(0.0)));
  CHECK_FALSE(buffer.mean(time_at(0.0), time_at(1.0)));
  const std::size_t before = test::allocations();
  for (int i = 0; i < 100; ++i) CHECK(buffer.push(reading(2.0 * i)));
  std::size_t met = 0;
  buffer.for_each(time_at(0.180), time_at(0.190), [&](const InertialReading& r) {
    ++met;
    CHECK(r.t > time_at(0.180));
    CHECK(r.t <= time_at(0.190));
  });
  const auto between = buffer.at(time_at(0.1813));
  const auto mean = buffer.mean(time_at(0.180), time_at(0.190));
  const std::size_t allocated = test::allocations() - before;
  CHECK(allocated == 0);
  CHECK(buffer.size() == 16);
  CHECK(buffer.oldest().t == time_at(0.168));
  CHECK(buffer.newest().t == time_at(0.198));
  CHECK(met == 5);
  REQUIRE(between);
  CHECK((between->rate_B - reading(181.3).rate_B).norm() < 1e-12);
  REQUIRE(mean);
  CHECK(mean->t == time_at(0.186));
  CHECK((mean->rate_B - reading(186.0).rate_B).norm() < 1e-12);
  for (double ms = 168.0; ms <= 198.0; ms += 0.5) {
    REQUIRE(buffer.at(HostTime(from_milliseconds(ms))));
    CHECK((buffer.at(HostTime(from_milliseconds(ms)))->force_B - reading(ms).force_B).norm() < 1e-12);
  }
  CHECK_FALSE(buffer.at(time_at(0.1679)));
  CHECK_FALSE(buffer.at(time_at(0.1981)));
}

TEST_CASE("time that stands still or goes back is refused; gaps are not bridged; a missing number stays missing") {
  InertialBuffer<16> buffer;
  CHECK(buffer.push(reading(10.0)));
  CHECK_FALSE(buffer.push(reading(10.0)));
  CHECK_FALSE(buffer.push(reading(4.0)));
  CHECK(buffer.size() == 1);
  CHECK(buffer.push(reading(50.0)));
  CHECK_FALSE(buffer.at(time_at(0.020)));
  CHECK(buffer.at(time_at(0.050)));
  InertialReading partial = reading(52.0);
  partial.rate_B.y() = std::numeric_limits<double>::quiet_NaN();
  CHECK(buffer.push(partial));
  const auto between = buffer.at(time_at(0.051));
  REQUIRE(between);
  CHECK(std::isnan(between->rate_B.y()));
  CHECK(between->rate_B.x() == doctest::Approx(51.0));
}

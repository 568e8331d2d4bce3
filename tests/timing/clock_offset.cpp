#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/timing/clock_offset.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {
using TrackerTime = TimePoint<TrackerClock>;
using DisplayTime = TimePoint<DisplayClock>;
using TrackerToHost = ClockOffset<TrackerClock, HostClock>;
}  // namespace

TEST_CASE("closed form: a second every six hours is 8.3 ms every three minutes (001 section 5.3)") {
  const TrackerToHost offset(time_at<TrackerClock>(10.0), time_at(500.0), 1.0 / (6 * 3600));
  CHECK(offset.convert(time_at<TrackerClock>(10.0)) == time_at(500.0));
  CHECK((offset.convert(time_at<TrackerClock>(10.0) + 6h) - time_at(500.0)) - 6h == 1s);
  const Duration gained = (offset.convert(time_at<TrackerClock>(10.0) + 180s) - time_at(500.0)) - 180s;
  CHECK(to_milliseconds(gained) == doctest::Approx(8.33).epsilon(1e-3));
  CHECK(offset.offset_at_reference() == 490s);
}

TEST_CASE("there and back is exact to 1 ns over 100 days") {
  std::mt19937_64 random(2);
  std::uniform_int_distribution<std::int64_t> any(-8'640'000'000'000'000, 8'640'000'000'000'000);
  for (const double skew : {0.0, 1e-9, 46.3e-6, -200e-6, 0.01, -0.01}) {
    const TrackerToHost offset(TrackerTime(Duration(1'705'504'375'238'748'312)), time_at(3.0), skew);
    for (int i = 0; i < 300; ++i) {
      const TrackerTime t = TrackerTime(Duration(1'705'504'375'238'748'312) + Duration(any(random)));
      const Duration error = offset.convert(offset.convert(t)) - t;
      CHECK(std::abs(error.count()) <= 1);
      CHECK(std::abs((offset.inverse().convert(offset.convert(t)) - t).count()) <= 1);
    }
  }
}

TEST_CASE("without skew conversion is exact, at any distance") {
  const TrackerToHost offset(TrackerTime(Duration(17)), HostTime(Duration(4)));
  const TrackerTime t(Duration(std::int64_t{1} << 60));
  CHECK(offset.convert(t).time_since_epoch().count() == (std::int64_t{1} << 60) - 13);
}

TEST_CASE("two conversions in a row are one") {
  const ClockOffset<TrackerClock, DisplayClock> first(time_at<TrackerClock>(1), time_at<DisplayClock>(100), 30e-6);
  const ClockOffset<DisplayClock, HostClock> second(time_at<DisplayClock>(40), time_at(7), -80e-6);
  const TrackerToHost both = first.then(second);
  for (const double seconds : {-3600.0, 0.0, 1.0, 86'400.0}) {
    const TrackerTime t = time_at<TrackerClock>(seconds);
    // Three roundings to a nanosecond, and 1e-16 of a day.
    CHECK(std::abs((both.convert(t) - second.convert(first.convert(t))).count()) <= 2);
  }
}

TEST_CASE("make refuses impossible skews") {
  CHECK(TrackerToHost::make({}, {}, 1e-4));
  CHECK_FALSE(TrackerToHost::make({}, {}, std::numeric_limits<double>::quiet_NaN()));
  CHECK_FALSE(TrackerToHost::make({}, {}, std::numeric_limits<double>::infinity()));
  CHECK_FALSE(TrackerToHost::make({}, {}, 0.2));
}

#include <type_traits>

#include <doctest/doctest.h>

#include <holdfast/timing/clock.hpp>

using namespace holdfast;

namespace {
struct OwnClock : ClockTag {};

template <typename A, typename B>
concept Addable = requires(A a, B b) {
  a + b;
};
template <typename A, typename B>
concept Subtractable = requires(A a, B b) {
  a - b;
};
template <typename A, typename B>
concept Comparable = requires(A a, B b) {
  a < b;
};
}  // namespace

using TrackerTime = TimePoint<TrackerClock>;

// Two times cannot be added; a time and a span can.
static_assert(!Addable<HostTime, HostTime>);
static_assert(Addable<HostTime, Duration> && Subtractable<HostTime, Duration>);
static_assert(std::is_same_v<decltype(HostTime{} - HostTime{}), Duration>);
// Times of different clocks mix in no way, own clocks included.
static_assert(!Subtractable<HostTime, TrackerTime> && !Comparable<HostTime, TrackerTime>);
static_assert(!std::is_convertible_v<TrackerTime, HostTime> && !std::is_constructible_v<HostTime, TrackerTime>);
static_assert(!std::is_assignable_v<HostTime&, TrackerTime> && !std::is_assignable_v<HostTime&, TimePoint<OwnClock>>);
static_assert(!Subtractable<TimePoint<DisplayClock>, HostTime> && !Subtractable<TimePoint<OwnClock>, HostTime>);
static_assert(!std::is_constructible_v<HostTime, std::chrono::system_clock::time_point>);
// Bare numbers are neither times nor spans by themselves.
static_assert(!std::is_convertible_v<double, Duration> && !std::is_convertible_v<std::int64_t, HostTime>);
static_assert(!Addable<HostTime, double> && !Addable<HostTime, int>);
static_assert(sizeof(HostTime) == 8 && std::is_trivially_copyable_v<HostTime>);

TEST_CASE("seconds and milliseconds round to the nearest nanosecond, both ways") {
  CHECK(from_seconds(1.5).count() == 1'500'000'000);
  CHECK(from_seconds(-0.6e-9).count() == -1);
  CHECK(from_seconds(0.4e-9).count() == 0);
  CHECK(from_milliseconds(37.3).count() == 37'300'000);
  CHECK(to_seconds(Duration(250'000'000)) == 0.25);
  CHECK(to_milliseconds(Duration(-2'500'000)) == -2.5);
  CHECK(time_at(2.0) - time_at(0.5) == std::chrono::milliseconds(1500));
  CHECK(time_at<TrackerClock>(1.0).time_since_epoch().count() == 1'000'000'000);
}

TEST_CASE("a recording's absolute stamp keeps its nanoseconds") {
  // 1.7e9 s since 1970 as a double is only good to 0.24 us: integer arithmetic must hold what double seconds cannot.
  const HostTime t = HostTime(Duration(1'705'504'375'238'748'312));
  CHECK((t + Duration(1)) - t == Duration(1));
}

/// Clocks as types, so that times of different clocks cannot be mixed.
///
/// TimePoint<Clock> is an int64 count of nanoseconds of one clock. Subtracting two of one clock gives a Duration;
/// mixing two clocks does not compile: converting needs a ClockOffset (clock_offset.hpp). Any tag type of your own may
/// be a clock. Source of the need: monotonic against boot time, tracker against host (see OpenXR's XrTime, and 001
/// section 5 on clock skew).
#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace holdfast {

using Duration = std::chrono::duration<std::int64_t, std::nano>;

/// What std::chrono::time_point asks of a clock that is only a name.
struct ClockTag {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = Duration;
  static constexpr bool is_steady = true;
};

/// The monotonic clock of the computer that runs the application; recordings and simulated motion live on it.
struct HostClock : ClockTag {};
/// The clock inside the tracker, which stamps measurements.
struct TrackerClock : ClockTag {};
/// The clock that the display's scan-out follows.
struct DisplayClock : ClockTag {};

template <typename Clock>
using TimePoint = std::chrono::time_point<Clock, Duration>;
using HostTime = TimePoint<HostClock>;

/// Seconds as a double, for arithmetic with physical quantities. Exact to 1 ns for spans below 52 days.
[[nodiscard]] constexpr double to_seconds(Duration d) {
  return static_cast<double>(d.count()) * 1e-9;
}

/// Nearest whole nanosecond. Precondition: finite and within +-292 years; check input that may be bad before.
[[nodiscard]] inline Duration from_seconds(double seconds) {
  return Duration(static_cast<std::int64_t>(std::llround(seconds * 1e9)));
}
[[nodiscard]] inline Duration from_milliseconds(double milliseconds) {
  return from_seconds(milliseconds * 1e-3);
}
[[nodiscard]] constexpr double to_milliseconds(Duration d) {
  return static_cast<double>(d.count()) * 1e-6;
}

/// Time of a clock at `seconds` after its zero.
template <typename Clock = HostClock>
[[nodiscard]] TimePoint<Clock> time_at(double seconds) {
  return TimePoint<Clock>(from_seconds(seconds));
}

}  // namespace holdfast

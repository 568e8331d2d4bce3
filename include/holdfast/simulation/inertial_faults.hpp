/// What goes wrong with an inertial unit in the field: faults to add to its readings, as many as wanted.
///
/// A channel is one of a reading's six numbers: 0 to 2 the gyros about x, y, z, 3 to 5 the accelerometers.
///   disconnect   no readings at all
///   make_dead    zero
///   make_stuck   what was last said before
///   lose         not a number: a driver that knows that it has no such sensor
///   saturate     no more than +-limit
///   jump_clock   stamps are off from then on, either way
/// Bad input: a channel that does not exist asserts.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <span>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/simulation/time_span.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

inline constexpr std::array gyro_channels{0, 1, 2};
inline constexpr std::array accelerometer_channels{3, 4, 5};
inline constexpr std::array inertial_channels{0, 1, 2, 3, 4, 5};

namespace detail {

[[nodiscard]] inline double& channel_of(InertialReading& reading, int channel) {
  HOLDFAST_ASSERT(channel >= 0 && channel < 6, "a reading has six channels");
  return channel < 3 ? reading.rate_B[channel] : reading.force_B[channel - 3];
}

/// Calls f(number, channel) for the channels of each reading in the span.
template <typename Function>
void for_channels(std::span<InertialReading> readings, const TimeSpan& span, std::span<const int> channels,
                  const Function& f) {
  for (InertialReading& reading : readings) {
    if (!span.contains(reading.t)) continue;
    for (const int channel : channels) f(channel_of(reading, channel), channel);
  }
}

}  // namespace detail

inline void disconnect(std::vector<InertialReading>& readings, const TimeSpan& span) {
  std::erase_if(readings, [&](const InertialReading& reading) { return span.contains(reading.t); });
}

inline void make_dead(std::span<InertialReading> readings, const TimeSpan& span, std::span<const int> channels) {
  detail::for_channels(readings, span, channels, [](double& number, int) { number = 0.0; });
}

inline void lose(std::span<InertialReading> readings, const TimeSpan& span, std::span<const int> channels) {
  detail::for_channels(readings, span, channels,
                       [](double& number, int) { number = std::numeric_limits<double>::quiet_NaN(); });
}

inline void saturate(std::span<InertialReading> readings, const TimeSpan& span, std::span<const int> channels,
                     double limit) {
  HOLDFAST_ASSERT(limit >= 0.0, "a limit is not negative");
  detail::for_channels(readings, span, channels,
                       [&](double& number, int) { number = std::clamp(number, -limit, limit); });
}

/// With nothing before the span, at what its first reading says.
inline void make_stuck(std::span<InertialReading> readings, const TimeSpan& span, std::span<const int> channels) {
  const auto inside = [&](const InertialReading& reading) { return span.contains(reading.t); };
  const auto first = std::ranges::find_if(readings, inside);
  if (first == readings.end()) return;
  InertialReading kept = first == readings.begin() ? *first : *(first - 1);
  detail::for_channels(readings, span, channels,
                       [&](double& number, int channel) { number = detail::channel_of(kept, channel); });
}

inline void jump_clock(std::span<InertialReading> readings, HostTime at, Duration by) {
  for (InertialReading& reading : readings) {
    if (reading.t >= at) reading.t += by;
  }
}

}  // namespace holdfast

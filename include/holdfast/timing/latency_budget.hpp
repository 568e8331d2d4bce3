/// Where the time between motion and light goes, and what it costs in registration error.
///
/// Source: Allen, Bishop & Welch 2001 (000), chapter 5. Table 5.1: the events of a frame. Eq. 5.3: the tracker's mean
/// motion delay. Eqs 5.1, 5.2: error = speed x delay. Eq. 5.4: static + simultaneity + speed x (tracker + graphics
/// delay). All are first-order and add worst cases: true errors are at most about this. Seconds as Duration, angles as
/// Angle, metres. Bad input: `find_problem` names the member at fault; the sums want a description without problem.
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <string_view>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

/// The events of one frame, by their numbers in 000 table 5.1.
struct FrameEvents {
  HostTime measured;     ///< t_0: the tracker measures the user's pose
  HostTime reported;     ///< t_1: the tracker reports the pose
  HostTime received;     ///< t_2: the application receives the reported pose
  HostTime image_ready;  ///< t_3: the updated image is ready in the hidden buffer
  HostTime swapped;      ///< t_4: buffer swap at the vertical interval
  HostTime scanned_out;  ///< t_5: the image is scanned out to the display

  [[nodiscard]] std::array<HostTime, 6> times() const {
    return {measured, reported, received, image_ready, swapped, scanned_out};
  }
  /// t_5 - t_0.
  [[nodiscard]] Duration end_to_end() const { return scanned_out - measured; }
  /// t_(i+1) - t_i: tracking, transport, rendering, waiting for the swap, scan-out.
  [[nodiscard]] std::array<Duration, 5> intervals() const {
    return {reported - measured, received - reported, image_ready - received, swapped - image_ready,
            scanned_out - swapped};
  }
};

inline constexpr std::array<std::string_view, 6> frame_event_names = {"measured",    "reported", "received",
                                                                      "image ready", "swapped",  "scanned out"};
inline constexpr std::array<std::string_view, 5> frame_interval_names = {"tracking", "transport", "rendering",
                                                                         "waiting for the swap", "scan-out"};

/// The number of the first event that precedes its predecessor; nothing when all are in order.
[[nodiscard]] inline std::optional<int> first_event_out_of_order(const FrameEvents& events) {
  const std::array<HostTime, 6> t = events.times();
  for (std::size_t i = 1; i < t.size(); ++i) {
    if (t[i] < t[i - 1]) return static_cast<int>(i);
  }
  return std::nullopt;
}

/// A part of a delay: its mean, and the most it can be. Waiting for something periodic is half a period in the mean, a
/// whole at most.
struct DelayPart {
  std::string_view name;
  Duration mean{0};
  Duration most{0};
};

/// The tracker of 000 figure 5.3. A rate of 0 Hz means that the stage does not exist.
struct TrackerStages {
  double sensor_rate_hz = 0.0;            ///< r_ss
  double estimate_rate_hz = 0.0;          ///< r_e
  std::optional<Duration> estimate_time;  ///< tau_e; 1 / r_e unless given
  double server_read_rate_hz = 0.0;       ///< r_srb
  Duration network_time{0};               ///< tau_net
  double client_read_rate_hz = 0.0;       ///< r_crb
};

/// The rest of the pipeline, as listed in 000 section 5.1.2.
struct GraphicsStages {
  Duration render_time{0};  ///< rendering and image generation
  double refresh_hz = 0.0;  ///< waiting for the buffer swap: half a frame in the mean; 0 when rendering is locked to it
  Duration frame_sync_time{0};  ///< waiting for other channels' frames
  Duration display_time{0};     ///< internal delay of the display, and scan-out up to the middle of the picture
};

struct LatencyBudgetProblem {
  std::string_view member;
  std::string_view expected;
};

[[nodiscard]] inline std::optional<LatencyBudgetProblem> find_problem(const TrackerStages& s) {
  constexpr std::string_view rate = "a rate of 0 (no such stage) or above, in Hz";
  constexpr std::string_view time = "not negative";
  const auto is_rate = [](double hz) { return std::isfinite(hz) && (hz == 0.0 || hz >= 1e-3); };
  if (!is_rate(s.sensor_rate_hz)) return LatencyBudgetProblem{"sensor_rate_hz", rate};
  if (!is_rate(s.estimate_rate_hz)) return LatencyBudgetProblem{"estimate_rate_hz", rate};
  if (s.estimate_time && *s.estimate_time < Duration{0}) return LatencyBudgetProblem{"estimate_time", time};
  if (!is_rate(s.server_read_rate_hz)) return LatencyBudgetProblem{"server_read_rate_hz", rate};
  if (s.network_time < Duration{0}) return LatencyBudgetProblem{"network_time", time};
  if (!is_rate(s.client_read_rate_hz)) return LatencyBudgetProblem{"client_read_rate_hz", rate};
  return std::nullopt;
}

[[nodiscard]] inline std::optional<LatencyBudgetProblem> find_problem(const GraphicsStages& s) {
  constexpr std::string_view time = "not negative";
  if (s.render_time < Duration{0}) return LatencyBudgetProblem{"render_time", time};
  if (!std::isfinite(s.refresh_hz) || (s.refresh_hz != 0.0 && s.refresh_hz < 1e-3)) {
    return LatencyBudgetProblem{"refresh_hz", "a rate of 0 (locked to the refresh) or above, in Hz"};
  }
  if (s.frame_sync_time < Duration{0}) return LatencyBudgetProblem{"frame_sync_time", time};
  if (s.display_time < Duration{0}) return LatencyBudgetProblem{"display_time", time};
  return std::nullopt;
}

namespace budget_detail {
[[nodiscard]] inline Duration period(double rate_hz) {
  return rate_hz > 0.0 ? from_seconds(1.0 / rate_hz) : Duration{0};
}
[[nodiscard]] inline DelayPart waiting(std::string_view name, double rate_hz) {
  return {name, period(rate_hz) / 2, period(rate_hz)};
}
[[nodiscard]] inline DelayPart fixed(std::string_view name, Duration d) {
  return {name, d, d};
}

template <std::size_t N>
[[nodiscard]] DelayPart sum(std::string_view name, const std::array<DelayPart, N>& parts) {
  DelayPart total{name};
  for (const DelayPart& part : parts) {
    total.mean += part.mean;
    total.most += part.most;
  }
  return total;
}
}  // namespace budget_detail

/// The six terms of eq. 5.3, in its order.
[[nodiscard]] inline std::array<DelayPart, 6> motion_delay_parts(const TrackerStages& s) {
  using namespace budget_detail;
  return {waiting("sample synchronisation", s.sensor_rate_hz),
          waiting("estimation synchronisation", s.estimate_rate_hz),
          fixed("estimation", s.estimate_time.value_or(period(s.estimate_rate_hz))),
          waiting("server buffer", s.server_read_rate_hz),
          fixed("network", s.network_time),
          waiting("client buffer", s.client_read_rate_hz)};
}

/// Delta t_m, eq. 5.3. Delay of a filter inside the tracker is not in it.
[[nodiscard]] inline DelayPart motion_delay(const TrackerStages& s) {
  return budget_detail::sum("tracker", motion_delay_parts(s));
}

[[nodiscard]] inline std::array<DelayPart, 4> graphics_delay_parts(const GraphicsStages& s) {
  using namespace budget_detail;
  return {fixed("rendering", s.render_time), waiting("video synchronisation", s.refresh_hz),
          fixed("frame synchronisation", s.frame_sync_time), fixed("display", s.display_time)};
}

/// Delta t_g, section 5.1.2.
[[nodiscard]] inline DelayPart graphics_delay(const GraphicsStages& s) {
  return budget_detail::sum("graphics", graphics_delay_parts(s));
}

/// Eqs 5.1 and 5.2: how far something moving at `speed` (per second) gets during a delay.
[[nodiscard]] inline Angle dynamic_error(Angle speed, Duration delay) {
  return speed * to_seconds(delay);
}
[[nodiscard]] inline double dynamic_error(double speed_m_s, Duration delay) {
  return speed_m_s * to_seconds(delay);
}

/// What an angular error moves at a distance, in metres across the line of sight.
[[nodiscard]] inline double displacement(Angle error, double distance_m) {
  return distance_m * tan(error);
}

/// The terms of eq. 5.4, for Value = Angle (orientation) or double (position, m).
template <typename Value>
struct ErrorBudget {
  Value static_error{};    ///< measured with everything at rest
  Value simultaneity{};    ///< motion during one set of samples that are taken for simultaneous
  Value tracker_delay{};   ///< speed x Delta t_m
  Value graphics_delay{};  ///< speed x Delta t_g

  [[nodiscard]] Value total() const { return static_error + simultaneity + tracker_delay + graphics_delay; }
};

/// Eq. 5.4 at a speed (Angle or metres per second). `sample_time` is the time one set of samples takes: what moves
/// meanwhile bounds the simultaneity error. Delays are the means, unless others are handed in.
template <typename Value>
[[nodiscard]] ErrorBudget<Value> error_budget(Value speed, Value static_error, Duration sample_time,
                                              Duration tracker_delay, Duration graphics_delay) {
  return {static_error, dynamic_error(speed, sample_time), dynamic_error(speed, tracker_delay),
          dynamic_error(speed, graphics_delay)};
}

}  // namespace holdfast

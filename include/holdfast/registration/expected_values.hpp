/// The values that theory demands of an experiment's row, with tolerances, and the verdict.
///
/// Which motion an experiment runs is told by its name (M0-M8 of motion/generators.hpp with their amplitudes); other
/// names have only the demands that hold for any motion. A deflected picture has the orientation of its late pose: its
/// interval of prediction is that pose's age, and its position stays that of the drawing unless it is moved by depth.
/// Tolerances: frames sample a sinusoid's peak, missing it by at
/// most half a frame (1 - cos(pi f / refresh)); ramps by one frame. Of filters theory demands what does not depend on their
/// settings: of P2 no error while the head keeps still, and the skew of lines; of P3 to P6, whose sensors have noise, nothing.
/// Of a wrong interval nothing is demanded but on a still head. Pose columns do not depend on eye and lens. Source:
/// evaluation.md, values 1, 4, 5, 9, 11.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/pipeline_pose.hpp>
#include <holdfast/registration/theory.hpp>

namespace holdfast {

/// A sinusoidal yaw among the default motions.
struct YawSine {
  double hz = 0.0;
  double amplitude_arcmin = 0.0;
};

[[nodiscard]] inline std::optional<YawSine> yaw_sine_of(std::string_view motion) {
  if (motion == "M1") return YawSine{2.0, 180.0};
  if (motion == "M2") return YawSine{1.0, 900.0};
  return std::nullopt;
}

namespace detail {

/// A sine cannot tell a longer shift from a shorter one of the other sign.
[[nodiscard]] inline double half_period_s(const YawSine& sine) {
  return 0.5 / sine.hz;
}

struct Expectations {
  const ExperimentSettings& settings;
  std::vector<ExpectedValue> values;

  void add(std::string name, double expected, double tolerance) {
    values.push_back({std::move(name), expected, tolerance, 0.0});
  }
};

/// Nothing for a filter, whose answer depends on its settings and on what it saw: no closed form is demanded of it.
[[nodiscard]] inline std::optional<theory::Order> order_of(Pipeline pipeline) {
  const std::optional<Predictor> predictor = predictor_of(pipeline);
  if (!predictor) return std::nullopt;
  return *predictor == Predictor::none ? theory::Order::none : theory::Order::constant_velocity;
}

inline void expect_yaw_sine(Expectations& e, const YawSine& sine, double latency_s, double period_s, double span_s) {
  const theory::Order order = *order_of(e.settings.pipeline);
  const double error = sine.amplitude_arcmin * theory::error(order, sine.hz, latency_s);
  const double swim = theory::swim_amplitude(error, sine.hz, period_s) / 60.0;
  const double missed = 1.0 - std::cos(std::numbers::pi * sine.hz * period_s) + 1e-6;
  e.add("pose.peak_yaw_arcmin", error, missed * error + 1e-6);
  e.add("pose.peak_swim_deg_s", swim, missed * swim + 1e-6);
  if (order != theory::Order::none && latency_s > 0.0 && latency_s < half_period_s(sine)) {
    // A gain g above 1 pulls the best shift by up to (g - 1) / (w^2 span) where the frames do not hold whole periods.
    const double lag_ms = 1e3 * theory::lag_s(order, sine.hz, latency_s);
    const double w = 2.0 * std::numbers::pi * sine.hz;
    const double pull_ms = 1e3 * (theory::gain(order, sine.hz, latency_s) - 1.0) / (w * w * span_s);
    e.add("effective_latency_ms", lag_ms, pull_ms + 1e-3);
  }
}

inline void expect_ramp(Expectations& e, double latency_s, double period_s) {
  constexpr double rate_deg_s = 100.0, travel_s = 0.4;
  const DisplayTiming& timing = e.settings.hmd.timing;
  const DeflectionSettings how = deflection_of(e.settings);
  const bool by_line = how.kind != DeflectionKind::none && how.per_scanline;
  if (timing.scan_out == ScanOut::rolling && e.settings.lens == LensMode::none && !by_line) {
    // Exact for a turn about the eye; here the eye moves with the head, and the edge stands 2 m away.
    const double skew = 60.0 * rate_deg_s * to_seconds(timing.scan_duration);
    e.add("scan_skew_arcmin", skew, 0.01 * skew);
  }
  if (!order_of(e.settings.pipeline) || latency_s <= 0.0 || latency_s >= travel_s) return;
  const double error = 60.0 * rate_deg_s * latency_s, one_frame = 60.0 * rate_deg_s * period_s;
  const bool held = predictor_of(e.settings.pipeline) == Predictor::none;
  // A predictor errs only until it knows of the start or the stop: frames catch a time shorter than one by chance.
  if (!held && error < one_frame) return;
  e.add("pose.peak_yaw_arcmin", error, held ? 1e-3 : one_frame);
  if (e.settings.velocity == VelocitySource::exact) e.add("overshoot_arcmin", held ? -error : error, one_frame);
}

[[nodiscard]] inline std::optional<double> measured_value(const ExperimentRow& row, std::string_view name) {
  if (name == "pose.peak_yaw_arcmin") return row.pose.peak_yaw_arcmin;
  if (name == "pose.peak_swim_deg_s") return row.pose.peak_swim_deg_s;
  if (name == "pose.peak_position_mm") return row.pose.peak_position_mm;
  if (name == "overshoot_arcmin") return row.overshoot_arcmin;
  if (name == "scan_skew_arcmin") return row.scan_skew_arcmin;
  if (name == "effective_latency_ms") return row.effective_latency_ms;
  if (name == "registration.peak_px" && row.registration) return row.registration->peak_px;
  return std::nullopt;
}

}  // namespace detail

/// What theory demands of `settings` over frames that span `span_s`; the members `measured` are still zero.
[[nodiscard]] inline std::vector<ExpectedValue> expected_values(const ExperimentSettings& settings, double span_s) {
  detail::Expectations e{settings, {}};
  const bool exact_tracker = settings.X_HT.q().vec().norm() == 0.0 && settings.X_HT.p().norm() == 0.0;
  if (!exact_tracker) return e.values;  // a constant error adds itself to every peak
  if (settings.perfect_late_pose) return e.values;
  const DeflectionKind kind = deflection_of(settings).kind;
  const double latency_s = to_seconds(settings.latency), period_s = 1.0 / settings.hmd.timing.refresh_hz;
  const double interval_s = to_seconds(prediction_interval(settings));
  const std::string_view motion = settings.motion_name;
  const bool held = predictor_of(settings.pipeline) == Predictor::none;
  const bool exact_velocity = held || settings.velocity == VelocitySource::exact;
  const bool good_optics =
      !settings.believed_hmd && (settings.lens == LensMode::none || settings.lens == LensMode::exact);
  const bool at_once = settings.hmd.timing.scan_out == ScanOut::global;

  if (prediction_of(settings.pipeline) == PosePrediction::kalman_inertial) return e.values;
  const bool is_filtered = !detail::order_of(settings.pipeline);  // it smooths what it measured, also at no latency
  if (good_optics && motion == "M0") e.add("registration.peak_px", 0.0, 1e-9);
  if (settings.interval_error != Duration{0} && !held) return e.values;
  if (good_optics && motion != "M0" && latency_s == 0.0 && at_once && !is_filtered)
    e.add("registration.peak_px", 0.0, 1e-9);
  const bool whole = settings.frames == 0;  // a motion cut short need not reach its peaks
  const std::optional<YawSine> sine = whole ? yaw_sine_of(motion) : std::nullopt;
  if (sine && exact_velocity && !is_filtered) detail::expect_yaw_sine(e, *sine, interval_s, period_s, span_s);
  if (motion == "M3" && whole) detail::expect_ramp(e, interval_s, period_s);
  // The fastest stretch is 0.6 s of 0.5 m/s: longer than the latency, the whole of it is at full speed.
  const double moved_s = kind == DeflectionKind::plane || kind == DeflectionKind::depth ? interval_s : latency_s;
  if (motion == "M7" && held && whole && moved_s < 0.5) e.add("pose.peak_position_mm", 500.0 * moved_s, 1e-3);
  const std::optional<YawSine> periodic = yaw_sine_of(motion);
  const bool tells_shift = !periodic || interval_s < detail::half_period_s(*periodic);
  // Turned late but not moved, a picture has two latencies, one for orientation and one for place.
  const bool one_latency = kind == DeflectionKind::none || kind == DeflectionKind::depth || periodic;
  if (held && one_latency && motion != "M0" && tells_shift) e.add("effective_latency_ms", 1e3 * interval_s, 0.1);
  return e.values;
}

/// Fills in the row's expectations from its own columns and judges: fail when one does not hold, none without any.
inline void judge(ExperimentRow& row, const ExperimentSettings& settings) {
  row.expected.clear();
  const double span_s = static_cast<double>(row.frames) / settings.hmd.timing.refresh_hz;
  for (ExpectedValue value : expected_values(settings, span_s)) {
    const std::optional<double> measured = detail::measured_value(row, value.name);
    if (!measured) continue;  // the column has no value here, for example as nothing was in view
    value.measured = *measured;
    row.expected.push_back(value);
  }
  const bool all_hold = std::all_of(row.expected.begin(), row.expected.end(), [](const auto& v) { return v.holds(); });
  row.verdict = row.expected.empty() ? Verdict::none : all_hold ? Verdict::pass : Verdict::fail;
}

}  // namespace holdfast

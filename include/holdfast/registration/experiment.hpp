/// Runs one registration experiment: a motion, a pipeline, an eye, a lens, a latency, a display; answers a row of
/// results.
///
///     ExperimentSettings settings;                      // M1, P0, left eye, no lens, 60 ms, the default headset
///     const auto motion = make_motion("M1", 1);
///     const ExperimentResult result = run_experiment(*motion, settings);
///     result.row.registration->rms_px;  result.row.swim->peak_deg_s;
///
/// Time: frames come at the display's refresh; their time is the middle of scan-out. The first one is 0.2 s after the
/// motion's begin (later only if latency and velocity need it), so that rows of different latency judge the same
/// frames; the last one's scan-out ends before the motion does. "Real" is the scene at the true eye pose of the moment
/// of light, "virtual" the scene as drawn, deflected and predistorted (shown_point.hpp). The observer sees every frame
/// and may render it. Source: evaluation.md "Metrics", "Default experiments". Frames and units: experiment_types.hpp.
/// Bad input: ExperimentResult::status and ::problem; the row is then empty.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <holdfast/registration/detail/experiment_run.hpp>

namespace holdfast {

/// Nothing when the settings can be run; else what is wrong, in words.
[[nodiscard]] inline std::optional<std::string> problem_of(const ExperimentSettings& settings) {
  if (const auto problem = find_problem(settings.hmd.timing)) {
    return "display timing: " + std::string(problem->member) + " must be " + std::string(problem->expected);
  }
  if (settings.latency < Duration{0} || settings.latency > std::chrono::seconds(1)) {
    return std::string("latency: must be 0 to 1000 ms");
  }
  if (settings.late < Duration{0} || settings.late > std::chrono::seconds(1)) {
    return std::string("late pose: must be 0 to 1000 ms before scan-out");
  }
  if (!(settings.plane_distance_m > 0.0) || !std::isfinite(settings.plane_distance_m)) {
    return std::string("plane distance: must be a positive number of metres");
  }
  if (settings.velocity_baseline <= Duration{0} || settings.velocity_baseline > std::chrono::seconds(1)) {
    return std::string("velocity baseline: must be above 0, at most 1000 ms");
  }
  if (settings.tracker_interval <= Duration{0} || settings.tracker_interval > std::chrono::seconds(1)) {
    return std::string("tracker interval: must be above 0, at most 1000 ms");
  }
  if (const auto problem = settings.filter_model.problem()) return "filter model: " + std::string(*problem);
  if (!(settings.filter.noise.position_m > 0.0) || !(settings.filter.noise.orientation_rad > 0.0)) {
    return std::string("filter noise: must be above 0");
  }
  if (settings.inertial.interval <= Duration{0}) return std::string("inertial sensors: need an interval above 0");
  if (settings.interval_error < -std::chrono::seconds(1) || settings.interval_error > std::chrono::seconds(1)) {
    return std::string("interval error: must be -1000 to 1000 ms");
  }
  const EyeModel& eye = settings.hmd.eye(settings.eye);
  if (eye.resolution.width < 1 || eye.resolution.height < 1)
    return std::string("eye resolution: must be 1 x 1 or more");
  if (problem_of(eye.tangents) != FieldProblem::none) {
    return "eye: " + std::string(describe(problem_of(eye.tangents)));
  }
  if (const FieldResult wider = try_overfilled(eye.tangents, settings.overfill); !wider.ok()) {
    return "overfill: " + std::string(describe(wider.problem));
  }
  return std::nullopt;
}

/// Runs `settings` on `motion`, whose poses are X_WH in the scene's world W. `observe` (may be empty) is called once a
/// frame.
[[nodiscard]] inline ExperimentResult run_experiment(const Motion& motion, const ExperimentSettings& settings,
                                                     const RegistrationScene& scene = default_registration_scene(),
                                                     const FrameObserver& observe = {}) {
  ExperimentResult result;
  if (const std::optional<std::string> problem = problem_of(settings)) {
    result.status = ExperimentStatus::bad_settings;
    result.problem = *problem;
    return result;
  }
  const detail::FramePlanOfExperiment plan = detail::plan_frames(motion, settings);
  if (plan.count == 0) {
    result.status = ExperimentStatus::motion_too_short;
    result.problem = "the motion is too short: nothing is left after the start-up of " +
                     std::to_string(to_milliseconds(plan.warm_up)) + " ms";
    return result;
  }
  detail::ExperimentRun run(motion, settings, scene);
  for (std::size_t i = 0; i < plan.count; ++i) run.frame(i, plan.middle_of(i), observe);
  result.row = run.row();
  return result;
}

/// Number of frames that run_experiment would show: for progress bars. 0 when it would refuse.
[[nodiscard]] inline std::size_t frames_of(const Motion& motion, const ExperimentSettings& settings) {
  if (problem_of(settings)) return 0;
  return detail::plan_frames(motion, settings).count;
}

}  // namespace holdfast

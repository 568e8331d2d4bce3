/// The error budget of an experiment: each source alone, then all together, and beside it the bound of 000 eq. 5.4.
///
/// Sources (000 chapter 5; those of Robinett & Holloway's display for the last three):
///   static            the tracker is off by a constant X_HT, nothing is late
///   tracker delay     latency of the tracker alone, Delta t_m
///   graphics delay    latency of the rest alone, Delta t_g
///   interval          the predictor takes the interval for longer than it is (of pipelines that predict, where asked for)
///   scan-out          lines light one after another, the renderer draws for the middle
///   lens              the lens as the application corrects it
///   viewing           the renderer believes in another IPD
/// Simultaneity, eq. 5.4's second term, is zero here: the simulated tracker measures a pose in one moment.
/// Every source is measured by run_experiment with all others switched off; rotations, parallax and where the fiducials
/// stand are therefore in it. The parts do not simply add: their plain sum is the worst case that eq. 5.4 adds up, the
/// root of their squares what independent errors would give, and `all` what really happens. Units: members' names. Bad
/// input: a source whose experiment cannot be run, or that never shows a fiducial, has zero.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include <holdfast/registration/experiment.hpp>
#include <holdfast/timing/latency_budget.hpp>

namespace holdfast {

struct BudgetSettings {
  ExperimentSettings
      experiment;  ///< motion's name, pipeline, eye, lens mode, headset with its scan-out; its latency is not used
  Duration tracker_delay = std::chrono::milliseconds(20);   ///< 001: 15-30 ms of its 50-70 ms
  Duration graphics_delay = std::chrono::milliseconds(40);  ///< up to the middle of scan-out
  Duration interval_error{0};
  Rigid X_HT = Rigid::translation(Vector3(0.002, 0.0, 0.0));  ///< static error; 001 ends at +-4 to 5 mm in all
  double ipd_error_m = 0.002;                                 ///< believed less true
};

struct BudgetPart {
  std::string_view source;
  double rms_arcmin = 0.0, peak_arcmin = 0.0, rms_mm = 0.0, swim_rms_deg_s = 0.0;
};

struct RegistrationBudget {
  std::vector<BudgetPart> parts;  ///< in the order above
  BudgetPart all{"all together"};
  /// Eq. 5.4 at the motion's greatest speeds: what the displayed pose cannot exceed, up to second order.
  ErrorBudget<Angle> orientation_bound;
  ErrorBudget<double> position_bound_m;

  [[nodiscard]] double sum_arcmin() const {
    double sum = 0.0;
    for (const BudgetPart& part : parts) sum += part.rms_arcmin;
    return sum;
  }
  [[nodiscard]] double root_of_squares_arcmin() const {
    double sum = 0.0;
    for (const BudgetPart& part : parts) sum += part.rms_arcmin * part.rms_arcmin;
    return std::sqrt(sum);
  }
};

namespace detail {

[[nodiscard]] inline BudgetPart budget_part(std::string_view source, const Motion& motion,
                                            const ExperimentSettings& settings, const RegistrationScene& scene) {
  BudgetPart part{source};
  const ExperimentRow row = run_experiment(motion, settings, scene).row;
  if (row.registration) {
    part.rms_arcmin = row.registration->rms_arcmin;
    part.peak_arcmin = row.registration->peak_arcmin;
    part.rms_mm = row.registration->rms_mm;
  }
  if (row.swim) part.swim_rms_deg_s = row.swim->rms_deg_s;
  return part;
}

/// Nothing late, nothing wrong, no lens, all lines at once.
[[nodiscard]] inline ExperimentSettings without_errors(const ExperimentSettings& settings) {
  ExperimentSettings clean = settings;
  clean.latency = Duration{0};
  clean.lens = LensMode::none;
  clean.hmd.timing.scan_out = ScanOut::global;
  clean.believed_hmd.reset();
  clean.X_HT = Rigid();
  clean.interval_error = Duration{0};
  clean.known_poses.reset();  // they belong to one X_HT
  return clean;
}

}  // namespace detail

/// Measures the budget on a motion (poses X_WH in the scene's world). Cost: seven experiments or eight.
[[nodiscard]] inline RegistrationBudget registration_budget(
    const Motion& motion, const BudgetSettings& settings,
    const RegistrationScene& scene = default_registration_scene()) {
  const ExperimentSettings clean = detail::without_errors(settings.experiment);
  const HmdModel& hmd = settings.experiment.hmd;
  ExperimentSettings all = clean;
  RegistrationBudget budget;
  // Switches one source on, alone and in the sum of all.
  const auto measure = [&](std::string_view source, const auto& switch_on) {
    ExperimentSettings alone = clean;
    switch_on(alone);
    switch_on(all);
    budget.parts.push_back(detail::budget_part(source, motion, alone, scene));
  };
  measure("static", [&](ExperimentSettings& s) { s.X_HT = settings.X_HT; });
  measure("tracker delay", [&](ExperimentSettings& s) { s.latency += settings.tracker_delay; });
  measure("graphics delay", [&](ExperimentSettings& s) { s.latency += settings.graphics_delay; });
  if (settings.interval_error != Duration{0}) {
    measure("interval", [&](ExperimentSettings& s) { s.interval_error = settings.interval_error; });
  }
  measure("scan-out", [&](ExperimentSettings& s) { s.hmd.timing.scan_out = hmd.timing.scan_out; });
  measure("lens", [&](ExperimentSettings& s) { s.lens = settings.experiment.lens; });
  measure("viewing", [&](ExperimentSettings& s) { s.believed_hmd = with_ipd(hmd, hmd.ipd_m + settings.ipd_error_m); });
  budget.all = detail::budget_part("all together", motion, all, scene);

  if (find_problem(hmd.timing)) return budget;  // no frames, so no speeds at them
  double turning = 0.0, moving = 0.0;
  const Duration step = frame_period(hmd.timing);
  for (HostTime t = motion.begin(); t <= motion.end(); t += step) {
    const MotionState state = motion.at(t);
    turning = std::max(turning, state.w_WB_B.norm());
    moving = std::max(moving, state.v_WB.norm());
  }
  const double static_angle = so3::log<double>(settings.X_HT.q()).norm();
  budget.orientation_bound = error_budget(radians(turning), radians(static_angle), Duration{0}, settings.tracker_delay,
                                          settings.graphics_delay);
  budget.position_bound_m =
      error_budget(moving, settings.X_HT.p().norm(), Duration{0}, settings.tracker_delay, settings.graphics_delay);
  return budget;
}

}  // namespace holdfast

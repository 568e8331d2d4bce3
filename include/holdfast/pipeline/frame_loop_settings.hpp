/// What a frame loop is told: its timing, its pictures, its late correction, and which stages are on.
///
/// Durations are the host's. Bad input: problem_of names the member and what was expected.
#pragma once

#include <cmath>
#include <optional>
#include <string_view>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/optics/overfill.hpp>
#include <holdfast/pipeline/eye_view.hpp>
#include <holdfast/timing/frame_plan.hpp>

namespace holdfast {

/// The stages of a frame. Switching one off leaves the rest as it is: what changes is that stage's work.
struct FrameStages {
  bool prediction = true;    ///< off: poses are as measured, also the late ones
  bool late_latch = true;    ///< off: late_latch leaves the views as begin_frame made them
  bool deflection = true;    ///< off: pictures are shown as drawn
  bool per_scanline = true;  ///< off: all lines are deflected as at the scan's middle
  bool lens = true;          ///< off: no correction for the lens; the mesh must be made anew with lens_mode()
};

struct FrameLoopSettings {
  Duration compute_time{0};        ///< from begin_frame to the renderer's having the matrices (FramePlanSettings: A)
  Duration render_start_phase{0};  ///< the renderer starts this long after a vsync
  int scan_out_refreshes = 1;      ///< what starts in one refresh is scanned out this many vsyncs later
  Duration warp_time{0};           ///< from deflect to the deflected picture being ready for scan-out
  Duration clock_tolerance = std::chrono::milliseconds(1);  ///< how far a measurement's time may lie after now

  Duration stale_after = std::chrono::milliseconds(100);  ///< a measurement that is older at now is reported

  ClipSettings clip;
  LensMode lens = LensMode::exact;
  DeflectionSettings deflection;
  /// What the overfill must take: what a quick head's prediction may err by over 30 ms, with things from 0.5 m on.
  DeflectionBudget budget{degrees(3.0), degrees(3.0), degrees(2.0), 0.005, 0.5};
  FrameStages stages;  ///< at the start; FrameLoop::stages switches them later
};

/// What is wrong with a frame loop's headset or settings: the member's name and what was expected.
struct FrameLoopProblem {
  std::string_view member;
  std::string_view expected;
};

namespace pipeline_detail {

[[nodiscard]] inline std::optional<FrameLoopProblem> problem_of(const EyeModel& eye) {
  if (eye.resolution.width < 1 || eye.resolution.height < 1) return FrameLoopProblem{"eye.resolution", "1 x 1 or more"};
  if (const FieldProblem problem = holdfast::problem_of(eye.tangents); problem != FieldProblem::none) {
    return FrameLoopProblem{"eye.tangents", "a possible field of view"};
  }
  if (!eye.X_HE.is_finite()) return FrameLoopProblem{"eye.X_HE", "finite numbers"};
  return std::nullopt;
}

}  // namespace pipeline_detail

[[nodiscard]] inline std::optional<FrameLoopProblem> problem_of(const HmdModel& hmd,
                                                                const FrameLoopSettings& settings) {
  if (const auto problem = find_problem(hmd.timing)) return FrameLoopProblem{problem->member, problem->expected};
  for (const EyeModel* eye : {&hmd.left, &hmd.right}) {
    if (const auto problem = pipeline_detail::problem_of(*eye)) return problem;
    const FieldOutline outline(*eye, settings.lens, hmd.timing);
    if (outline.points().empty()) {
      return FrameLoopProblem{"eye.lens", "a lens that shows at least the middle of its panel"};
    }
    if (!overfilled_picture(*eye, outline, settings.budget)) {
      return FrameLoopProblem{"budget", "possible angles and lengths that turn no edge of the view 90 degrees away"};
    }
  }
  const auto is_outside = [](Duration d) { return d < Duration{0} || d > std::chrono::seconds(1); };
  constexpr std::string_view up_to_1_s = "0 to 1 s";
  if (is_outside(settings.compute_time)) return FrameLoopProblem{"compute_time", up_to_1_s};
  if (is_outside(settings.render_start_phase)) return FrameLoopProblem{"render_start_phase", up_to_1_s};
  if (is_outside(settings.warp_time)) return FrameLoopProblem{"warp_time", up_to_1_s};
  if (is_outside(settings.clock_tolerance)) return FrameLoopProblem{"clock_tolerance", up_to_1_s};
  if (is_outside(settings.stale_after)) return FrameLoopProblem{"stale_after", up_to_1_s};
  if (settings.scan_out_refreshes < 1 || settings.scan_out_refreshes > 100) {
    return FrameLoopProblem{"scan_out_refreshes", "1 to 100"};
  }
  if (holdfast::problem_of(settings.clip.planes) != ClipProblem::none) {
    return FrameLoopProblem{"clip.planes", "0 < near < far (far may be infinite)"};
  }
  if (settings.deflection.kind == DeflectionKind::plane &&
      !(settings.deflection.plane_distance_m > 0.0 && std::isfinite(settings.deflection.plane_distance_m))) {
    return FrameLoopProblem{"deflection.plane_distance_m", "a positive number of metres"};
  }
  return std::nullopt;
}

}  // namespace holdfast

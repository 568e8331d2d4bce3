/// What a frame loop answers at a frame's stages: Frame at its beginning, LateLatch before it is submitted, and
/// FrameDeflection before its light.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/pipeline/eye_view.hpp>
#include <holdfast/pipeline/frame_issues.hpp>
#include <holdfast/pipeline/frame_log.hpp>
#include <holdfast/timing/frame_plan.hpp>

namespace holdfast {

/// Index of an eye in the arrays below.
[[nodiscard]] constexpr std::size_t index_of(EyeSide side) {
  return side == EyeSide::left ? 0 : 1;
}

/// A frame from its beginning: when it will be seen, from where, and what to draw it with.
struct Frame {
  std::int64_t id = 0;                            ///< 1, 2, ...
  FramePlan plan;                                 ///< `measured` is `now` while there is no measurement
  PredictionResult head;                          ///< X_WH at plan.middle_of_scan_out
  std::array<EyeView, 2> eyes;                    ///< left, right
  Duration refresh{0};                            ///< one, as known at the frame's beginning
  HostTime deadline{};                            ///< deflect must be called before, or the scan-out is missed
  bool has_measurement = false;                   ///< begin_frame had one
  FrameIssues issues;                             ///< of begin_frame
  HostTime when_latched{}, measured_for_latch{};  ///< 0 before late_latch

  [[nodiscard]] const EyeView& eye(EyeSide side) const { return eyes[index_of(side)]; }
  /// The moment of display: the middle of scan-out.
  [[nodiscard]] HostTime t() const { return plan.middle_of_scan_out; }
  /// What the two pictures are drawn with.
  [[nodiscard]] std::array<RenderedView, 2> rendered_views() const {
    return {eyes[0].rendered_view(), eyes[1].rendered_view()};
  }
};

/// What late latching changed.
struct LateLatch {
  Duration fresher{0};  ///< the measurement is newer by this than the one of begin_frame; 0 if that had none
  Angle turned;         ///< of the head's predicted pose
  double moved_m = 0.0;
  FrameIssues issues;  ///< of this stage
};

/// How one eye's finished picture must be moved.
struct EyeDeflection {
  LatePoses late;               ///< where the eye will be at the scan's begin, middle and end
  DeflectionResult deflection;  ///< H_SE, X_SE
  SourceMatrices source;        ///< for shaders: the picture's (u, v, 1) ~ M(s) (t_E, 1)
  double lacking =
      0.0;  ///< tangent by which the view reaches beyond the picture (by depth: of what is far); <= 0: covered
};

/// Both eyes' late correction for one scan-out.
struct FrameDeflection {
  HostTime scan_out_start{};                           ///< the vsync
  HostTime scan_begin{}, scan_middle{}, scan_end{};    ///< light of the first line, of the middle one, of the last
  PredictionResult head_begin, head_middle, head_end;  ///< X_WH at these
  std::array<EyeDeflection, 2> eyes;                   ///< left, right
  HostTime when_delivered{}, measured{};
  Angle turned;          ///< left eye: from the pose drawn with to the scan's middle
  double moved_m = 0.0;  ///< likewise
  FrameIssues issues;    ///< of this stage

  [[nodiscard]] const EyeDeflection& eye(EyeSide side) const { return eyes[index_of(side)]; }
};

/// The frame's record. `deflection` is that of its first scan-out, nothing when there was none.
[[nodiscard]] inline FrameLog frame_log(const Frame& frame, const LateLatch* latch, const FrameDeflection* deflection) {
  FrameLog log;
  log.frame_id = frame.id;
  log.predicted_wake_up_time = frame.plan.render_start;
  log.predicted_gpu_done_time = frame.deadline;
  log.predicted_display_time = frame.plan.middle_of_scan_out;
  log.predicted_display_period = frame.refresh;
  log.when_predicted = frame.plan.now;
  if (frame.has_measurement) log.when_measured = frame.plan.measured;
  log.when_latched = frame.when_latched;
  log.when_measured_for_latch = frame.measured_for_latch;
  log.issues = frame.issues;
  if (latch != nullptr) {
    log.latch_turned_rad = latch->turned.radians();
    log.latch_moved_m = latch->moved_m;
    log.issues.add(latch->issues);
  }
  if (deflection != nullptr) {
    log.display_time = deflection->scan_middle;
    log.when_delivered = deflection->when_delivered;
    log.when_measured_for_deflection = deflection->measured;
    log.deflection_turned_rad = deflection->turned.radians();
    log.deflection_moved_m = deflection->moved_m;
    log.issues.add(deflection->issues);
  }
  return log;
}

}  // namespace holdfast

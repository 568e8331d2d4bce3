/// What an engine calls each frame: plan and predicted views at its beginning, the newest pose before it is submitted,
/// and the late correction before its light.
///
///     FrameLoop loop(hmd, source, settings);
///     Frame frame = loop.begin_frame(now());              // when will these pixels glow, and from where are they seen
///     ... animate, cull, record commands ...
///     loop.late_latch(frame, now());                      // the newest pose replaces the views'
///     ... draw both eyes with frame.eyes, keep each picture with its rendered_view() ...
///     FrameDeflection late = loop.deflect(left, right, now());   // where the eyes will be during the scan
///     ... warp with late.eyes[i].source and the lens's mesh ...
///
/// Poses come from a PoseSource, which alone predicts; all poses of one call come from one measurement. begin_frame and
/// late_latch predict to the middle of the frame's scan-out (timing/frame_plan.hpp), deflect to the light of the first,
/// the middle and the last line of the scan-out that comes next. Each stage can be switched off by `stages`, to find a culprit.
/// Nothing is silent: whatever a call had to make do with is in its FrameIssues. No call but the constructor allocates,
/// locks or throws.
/// Threads: begin_frame, late_latch and observe_vsync belong to one thread. deflect and the other const members may run
/// on another at the same time as long as nobody calls observe_vsync or writes `stages`; a compositor thread that
/// observes vsyncs itself has a FrameLoop of its own.
/// Source of the order of things: 001 appendix E; design.md. Bad input: problem_of(hmd, settings) tells beforehand; the
/// constructor takes it as a programmer's error.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <holdfast/pipeline/frame.hpp>
#include <holdfast/pipeline/frame_loop_settings.hpp>
#include <holdfast/pipeline/pose_source.hpp>
#include <holdfast/timing/vsync_estimator.hpp>

namespace holdfast {

class FrameLoop {
 public:
  /// `source` is not owned and must live as long as the loop.
  FrameLoop(const HmdModel& hmd, const PoseSource& source, const FrameLoopSettings& settings = {})
      : stages(settings.stages), source_(&source), settings_(settings), display_(hmd.timing), vsync_(hmd.timing) {
    HOLDFAST_ASSERT(!problem_of(hmd, settings), "headset or settings of the frame loop are impossible");
    for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
      Eye& eye = eyes_[index_of(side)];
      eye.model = hmd.eye(side);
      eye.outline = FieldOutline(eye.model, settings.lens, hmd.timing);
      eye.uncorrected = FieldOutline(eye.model, LensMode::uncorrected, hmd.timing);
      eye.picture = *overfilled_picture(eye.model, eye.outline, settings.budget);
    }
  }

  FrameStages stages;  ///< may be switched between frames

  /// Tells of a vsync that was seen (late at worst, never early): refresh and phase are learned from them. Without any,
  /// the headset's description is believed.
  ClockSample observe_vsync(HostTime observed) {
    const ClockSample verdict = vsync_.update(observed);
    if (const std::optional<DisplayTiming> learned = vsync_.timing()) display_ = *learned;
    return verdict;
  }
  /// The display's timing as known by now.
  [[nodiscard]] const DisplayTiming& display_timing() const { return display_; }

  /// How the lens is dealt with now: what to make the mesh with.
  [[nodiscard]] LensMode lens_mode() const {
    return stages.lens || settings_.lens == LensMode::none ? settings_.lens : LensMode::uncorrected;
  }
  /// The picture that an eye's renderer fills, the same in every frame.
  [[nodiscard]] const EyePicture& picture(EyeSide side) const { return eyes_[index_of(side)].picture; }
  [[nodiscard]] const EyeModel& eye_model(EyeSide side) const { return eyes_[index_of(side)].model; }
  [[nodiscard]] const FrameLoopSettings& settings() const { return settings_; }

  /// Plans the frame that is about to be computed, and predicts its views.
  [[nodiscard]] Frame begin_frame(HostTime now) {
    Frame frame;
    frame.id = ++frame_id_;
    const std::optional<PoseEstimate> measured = source_->newest(now);
    frame.plan = plan(measured ? measured->t : now, now, frame.issues);
    frame.refresh = frame_period(display_);
    frame.deadline = frame.plan.scan_out_start - settings_.warp_time;
    frame.has_measurement = measured.has_value();
    if (measured) {
      frame.head = predicted(*measured, frame.t(), frame.issues);
      if (!measured->X_WB.is_finite()) frame.head.X_WB = last_X_WH_;
      last_X_WH_ = frame.head.X_WB;
    } else {
      frame.head.t = frame.t();
      frame.head.status = PredictionStatus::not_finite;
      frame.issues.add(FrameIssue::no_pose);
    }
    frame.eyes = eye_views(frame.head.X_WB, frame.t());
    return frame;
  }

  /// Replaces the frame's views by what the newest measurement says now. To be called last before the matrices are
  /// submitted.
  LateLatch late_latch(Frame& frame, HostTime now) const {
    LateLatch latch;
    if (!stages.late_latch) return latch;
    const std::optional<PoseEstimate> measured = source_->newest(now);
    if (!measured) {
      latch.issues.add(FrameIssue::no_pose);
      return latch;
    }
    check_age(measured->t, now, latch.issues);
    const PredictionResult head = predicted(*measured, frame.t(), latch.issues);
    if (!measured->X_WB.is_finite()) return latch;  // the views stay as they are
    const Rigid moved = relative_pose(frame.head.X_WB, head.X_WB);
    if (frame.has_measurement) latch.fresher = time_between(frame.plan.measured, measured->t);
    latch.turned = radians(so3::log<double>(moved.q()).norm());
    latch.moved_m = moved.p().norm();
    frame.head = head;
    frame.eyes = eye_views(head.X_WB, frame.t());
    frame.when_latched = now;
    frame.measured_for_latch = measured->t;
    return latch;
  }

  /// The late correction of two finished pictures, left and right, for the next scan-out that they can reach.
  [[nodiscard]] FrameDeflection deflect(const std::array<RenderedView, 2>& views, HostTime now) const {
    FrameDeflection result;
    result.when_delivered = now;
    set_scan_out(result, views[0].t, now);
    const std::optional<PoseEstimate> measured = source_->newest(now);
    if (!measured) {
      result.issues.add(FrameIssue::no_pose);
    } else {
      result.measured = measured->t;
      check_age(measured->t, now, result.issues);
      result.head_begin = predicted(*measured, result.scan_begin, result.issues);
      result.head_middle = predicted(*measured, result.scan_middle, result.issues);
      result.head_end = predicted(*measured, result.scan_end, result.issues);
    }
    const bool known = measured && measured->X_WB.is_finite();
    for (std::size_t i = 0; i < 2; ++i) {
      const Rigid& X_HE = eyes_[i].model.X_HE;
      LatePoses late = LatePoses::at_once(views[i].X_WS);
      if (known) {
        late = {result.head_begin.X_WB * X_HE, result.head_end.X_WB * X_HE, result.head_middle.X_WB * X_HE};
      }
      result.eyes[i] = deflect_eye(eyes_[i], views[i], late, result.issues);
    }
    if (result.eyes[0].deflection.ok()) {
      const Rigid X_SE = ScanPose(views[0].X_WS, result.eyes[0].late).middle();
      result.turned = radians(so3::log<double>(X_SE.q()).norm());
      result.moved_m = X_SE.p().norm();
    }
    return result;
  }

  /// The same from the pictures: what an application should call, as each brings the view that it was drawn with.
  template <typename Picture>
  [[nodiscard]] FrameDeflection deflect(const RenderedPicture<Picture>& left, const RenderedPicture<Picture>& right,
                                        HostTime now) const {
    return deflect(std::array<RenderedView, 2>{left.view(), right.view()}, now);
  }

 private:
  struct Eye {
    EyeModel model;
    FieldOutline outline;      // of the settings' LensMode
    FieldOutline uncorrected;  // while the lens stage is off
    EyePicture picture;
  };

  /// t - from, at most 100 years either way: times that a tracker made up must not overflow.
  [[nodiscard]] static Duration time_between(HostTime from, HostTime t) {
    constexpr double most_s = 100.0 * 365.25 * 86400.0;
    const double seconds = detail::seconds_between(from, t);
    return std::abs(seconds) < most_s ? t - from : from_seconds(std::copysign(most_s, seconds));
  }

  void check_age(HostTime measured, HostTime now, FrameIssues& issues) const {
    const double age = detail::seconds_between(measured, now);
    if (age > to_seconds(settings_.stale_after)) issues.add(FrameIssue::stale);
    if (-age > to_seconds(settings_.clock_tolerance)) issues.add(FrameIssue::clocks_mixed);
  }

  [[nodiscard]] FramePlan plan(HostTime measured, HostTime now, FrameIssues& issues) const {
    check_age(measured, now, issues);
    FramePlanSettings s;
    s.display = display_;
    s.compute_time = settings_.compute_time;
    s.render_start_phase = settings_.render_start_phase;
    s.scan_out_refreshes = settings_.scan_out_refreshes;
    FramePlan plan = *plan_frame(s, now, now);
    plan.measured = measured;
    return plan;
  }

  [[nodiscard]] PredictionResult predicted(const PoseEstimate& measured, HostTime t, FrameIssues& issues) const {
    PredictionResult result = stages.prediction ? source_->predict(measured, t) : predict_none(measured, t);
    issues.add(result.status);
    return result;
  }

  [[nodiscard]] std::array<EyeView, 2> eye_views(const Rigid& X_WH, HostTime t) const {
    std::array<EyeView, 2> views;
    for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
      const Eye& eye = eyes_[index_of(side)];
      views[index_of(side)] = make_eye_view(side, X_WH * eye.model.X_HE, t, eye.picture, settings_.clip);
    }
    return views;
  }

  /// The scan-out for which the picture was drawn, or, when that has begun, the next one.
  void set_scan_out(FrameDeflection& result, HostTime drawn_for, HostTime now) const {
    const std::int64_t possible = next_vsync_number(display_, now + settings_.warp_time);
    const std::int64_t planned =
        next_vsync_number(display_, drawn_for - vsync_to_middle(display_) - frame_period(display_) / 2);
    if (possible > planned) result.issues.add(FrameIssue::missed_scan_out);
    result.scan_out_start = vsync_at(display_, std::max(possible, planned));
    result.scan_begin = light_of_line(display_, result.scan_out_start, 0.0).middle;
    result.scan_middle = middle_of_scan_out(display_, result.scan_out_start);
    result.scan_end = light_of_line(display_, result.scan_out_start, 1.0).middle;
  }

  [[nodiscard]] EyeDeflection deflect_eye(const Eye& eye, const RenderedView& view, const LatePoses& late,
                                          FrameIssues& issues) const {
    DeflectionSettings settings = settings_.deflection;
    if (!stages.deflection) settings.kind = DeflectionKind::none;
    settings.per_scanline = settings.per_scanline && stages.per_scanline;
    EyeDeflection result;
    result.late = late;
    result.deflection = holdfast::deflect(settings, view, late);
    if (!result.deflection.ok()) issues.add(FrameIssue::deflection_refused);
    result.source = source_matrices(view, result.deflection.H_SE);
    const FieldOutline& outline = lens_mode() == LensMode::uncorrected ? eye.uncorrected : eye.outline;
    result.lacking = outline.lacking(view.tangents, result.deflection.H_SE);
    // What the rounding of the outline's own bounds may do.
    if (result.lacking > 1e-12) issues.add(FrameIssue::not_covered);
    return result;
  }

  const PoseSource* source_;
  FrameLoopSettings settings_;
  DisplayTiming display_;
  VsyncEstimator vsync_;
  std::array<Eye, 2> eyes_;
  Rigid last_X_WH_;  // for a frame whose measurement is no pose
  std::int64_t frame_id_ = 0;
};

}  // namespace holdfast

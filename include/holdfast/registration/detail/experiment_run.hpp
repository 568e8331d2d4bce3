/// The loop body and the bookkeeping of experiment.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <holdfast/prediction/jitter.hpp>
#include <holdfast/registration/effective_latency.hpp>
#include <holdfast/registration/expected_values.hpp>
#include <holdfast/registration/fiducial_error.hpp>
#include <holdfast/registration/overshoot.hpp>
#include <holdfast/registration/pipeline_pose.hpp>
#include <holdfast/registration/scan_skew.hpp>
#include <holdfast/registration/swim.hpp>
#include <holdfast/registration/view_coverage.hpp>

namespace holdfast::detail {

/// Which frames an experiment shows.
struct FramePlanOfExperiment {
  DisplayTiming timing;
  std::int64_t first_vsync = 0;
  std::size_t count = 0;
  Duration warm_up{0};

  [[nodiscard]] HostTime middle_of(std::size_t frame) const {
    return middle_of_scan_out(timing, vsync_at(timing, first_vsync + static_cast<std::int64_t>(frame)));
  }
};

[[nodiscard]] inline FramePlanOfExperiment plan_frames(const Motion& motion, const ExperimentSettings& settings) {
  FramePlanOfExperiment plan;
  plan.timing = settings.hmd.timing;
  const Duration half_scan =
      plan.timing.scan_out == ScanOut::rolling ? plan.timing.scan_duration / 2 + Duration{1} : Duration{0};
  // What the predictor needs before its first measurement that counts.
  const Duration known = predictor_of(settings.pipeline) ? settings.velocity_baseline : std::chrono::milliseconds(100);
  plan.warm_up = std::max<Duration>(std::chrono::milliseconds(200), settings.latency + known + half_scan);
  plan.first_vsync = next_vsync_number(plan.timing, motion.begin() + plan.warm_up - vsync_to_middle(plan.timing));
  const HostTime last = motion.end() - half_scan;
  if (plan.middle_of(0) > last) return plan;
  const double frames = std::floor(to_seconds(last - plan.middle_of(0)) * plan.timing.refresh_hz + 1e-6) + 1.0;
  plan.count = static_cast<std::size_t>(frames);
  while (plan.count > 0 && plan.middle_of(plan.count - 1) > last) --plan.count;
  if (settings.frames > 0) plan.count = std::min(plan.count, settings.frames);
  return plan;
}

/// The field and pixels that a picture is drawn with: the panel's, or, when it will be deflected, as much more as the
/// budget says.
[[nodiscard]] inline RenderedView drawn_view(const EyeModel& eye, const ExperimentSettings& settings) {
  RenderedView view;
  view.tangents = panel_tangents(eye);
  view.size = eye.resolution;
  if (deflection_of(settings).kind == DeflectionKind::none) return view;
  view.tangents = overfilled(eye.tangents, settings.overfill);
  view.size = overfilled_size(eye.resolution, eye.tangents, view.tangents);
  return view;
}

/// Sums of one frame or of all: root mean squares of what was added.
struct MeanSquare {
  double sum = 0.0;
  std::size_t count = 0;

  void add(double x) {
    sum += x * x;
    ++count;
  }
  [[nodiscard]] std::optional<double> rms() const {
    return count == 0 ? std::nullopt : std::optional<double>(std::sqrt(sum / static_cast<double>(count)));
  }
};

struct MeanAndPeak {
  double sum = 0.0, most = 0.0;
  std::size_t count = 0;

  void add(double x) {
    sum += x;
    most = std::max(most, x);
    ++count;
  }
  [[nodiscard]] std::optional<double> mean() const {
    return count == 0 ? std::nullopt : std::optional<double>(sum / static_cast<double>(count));
  }
  [[nodiscard]] std::optional<double> peak() const { return count == 0 ? std::nullopt : std::optional<double>(most); }
};

/// What is measured of each frame: all, or the errors alone, which are the cheaper part.
enum class Measures { all, errors };

class ExperimentRun {
 public:
  ExperimentRun(const Motion& motion, const ExperimentSettings& settings, const RegistrationScene& scene,
                Measures measures = Measures::all)
      : motion_(motion),
        settings_(settings),
        scene_(scene),
        eye_(settings.hmd.eye(settings.eye)),
        believed_(settings.believed_hmd ? settings.believed_hmd->eye(settings.eye) : eye_),
        how_(deflection_of(settings)),
        drawn_(drawn_view(believed_, settings)),
        on_{eye_, believed_, settings.lens, settings.hmd.timing},
        poses_(motion, settings),
        swim_(scene.discs.size()) {
    if (measures == Measures::all) view_.emplace(on_);
  }
  ExperimentRun(const ExperimentRun&) = delete;
  ExperimentRun& operator=(const ExperimentRun&) = delete;

  void frame(std::size_t index, HostTime t_display, const FrameObserver& observe) {
    FrameRecord record;
    record.index = index;
    record.t_display = t_display;
    record.t_measured = t_display - settings_.latency;
    const MotionState truth = motion_.at(t_display);
    record.X_WH_true = truth.X_WB;
    record.X_WE_true = record.X_WH_true * eye_.X_HE;
    show(record);
    add_pose_errors(record, truth);
    add_fiducials(record);
    add_scan_skew(record);
    add_coverage(record);
    if (observe) observe(record);
    ++frames_;
  }

  [[nodiscard]] ExperimentRow row() const {
    ExperimentRow row;
    row.motion = settings_.motion_name;
    row.pipeline = settings_.pipeline;
    row.eye = settings_.eye;
    row.lens = settings_.lens;
    row.latency_ms = to_milliseconds(settings_.latency);
    row.display = settings_.hmd.timing.scan_out;
    row.deflection = how_.kind;
    row.per_scanline = how_.kind != DeflectionKind::none && how_.per_scanline;
    if (how_.kind != DeflectionKind::none) row.late_ms = to_milliseconds(settings_.late);
    if (prediction_of(settings_.pipeline) != PosePrediction::none) {
      row.interval_error_ms = to_milliseconds(settings_.interval_error);
    }
    row.frames = frames_;
    row.pose = pose_summary();
    set_registration(row);
    set_motion_columns(row);
    row.scan_skew_arcmin = worst_skew_;
    set_coverage(row);
    judge(row, settings_);
    return row;
  }

 private:
  /// The picture of the frame, and what the pipeline makes of it.
  void show(FrameRecord& record) {
    const Rigid X_WH_drawn = poses_.drawn(record.t_display);
    ShownPicture& shown = record.shown;
    shown.view = drawn_;
    shown.view.X_WS = X_WH_drawn * believed_.X_HE;
    shown.view.t = record.t_display;
    shown.how = how_;
    shown.late = LatePoses::at_once(shown.view.X_WS);
    shown.t_late = record.t_measured;
    record.X_WH_displayed = X_WH_drawn;
    if (how_.kind != DeflectionKind::none) {
      const LateHeadPoses late = poses_.late(record.t_display);
      shown.late = late.of_eye(believed_.X_HE);
      shown.t_late = late_time(settings_, record.t_display);
      shown.deflection = deflect(how_, shown.view, shown.late);
      if (shown.is_deflected()) record.X_WH_displayed = displayed_pose(how_.kind, X_WH_drawn, late.X_WH_middle);
    }
    record.X_WE_displayed = record.X_WH_displayed * believed_.X_HE;
  }

  void add_pose_errors(FrameRecord& record, const MotionState& truth) {
    const Vector3 error = so3::log<double>(record.X_WH_true.q().conjugate() * record.X_WH_displayed.q());
    record.yaw_error_arcmin = error.y() * arcmin_per_rad;
    record.orientation_error_arcmin = error.norm() * arcmin_per_rad;
    record.position_error_mm = 1e3 * (record.X_WH_displayed.p() - record.X_WH_true.p()).norm();
    pose_.peak_yaw_arcmin = std::max(pose_.peak_yaw_arcmin, std::abs(record.yaw_error_arcmin));
    pose_.peak_position_mm = std::max(pose_.peak_position_mm, record.position_error_mm);
    if (!displayed_.empty()) {
      const double dt = to_seconds(record.t_display - displayed_.back().t);
      const double swim = (error * arcmin_per_rad - orientation_errors_.back()).norm() / 60.0 / dt;
      pose_.peak_swim_deg_s = std::max(pose_.peak_swim_deg_s, swim);
    }
    orientation_errors_.push_back(error * arcmin_per_rad);
    displayed_.push_back({record.t_display, record.X_WH_displayed});
    turns_.push_back({record.t_display, record.X_WH_true.q(), record.X_WH_displayed.q(), truth.w_WB_B});
    is_still_ = is_still_ && truth.w_WB_B.norm() < 1e-6 && truth.v_WB.norm() < 1e-6;
  }

  void add_fiducials(FrameRecord& record) {
    MeanSquare px, arcmin, mm, swim;
    record.fiducials.reserve(scene_.discs.size());
    for (std::size_t i = 0; i < scene_.discs.size(); ++i) {
      const Disc& disc = scene_.discs[i];
      const auto real =
          real_ellipse(motion_, eye_, settings_.hmd.timing, settings_.lens, disc, record.t_display, record.X_WE_true);
      const auto shown = real ? shown_centroid(record.shown, on_, disc) : std::nullopt;
      FiducialRecord f = fiducial_error(eye_, real, shown);
      f.disc = i;
      record.fiducials.push_back(f);
      if (!f.visible) continue;
      ++record.visible;
      errors_px_.push_back(f.error_px.norm());
      px.add(f.error_px.norm());
      arcmin.add(f.error_arcmin);
      mm.add(f.error_mm);
      peak_arcmin_ = std::max(peak_arcmin_, f.error_arcmin);
      const auto velocity = swim_.add(i, record.index, record.t_display, f.error_px, f.error_rad);
      if (velocity) {
        swim.add(velocity->deg_s());
        swim_px_.push_back(velocity->px_s.norm());
        swim_deg_.push_back(velocity->deg_s());
      }
    }
    record.rms_px = px.rms();
    record.rms_arcmin = arcmin.rms();
    record.rms_mm = mm.rms();
    record.swim_rms_deg_s = swim.rms();
    for (const auto& [all, one] : {std::pair{&all_arcmin_, &arcmin}, std::pair{&all_mm_, &mm}}) {
      all->sum += one->sum;
      all->count += one->count;
    }
  }

  void add_scan_skew(FrameRecord& record) {
    const bool straight = settings_.lens == LensMode::none || settings_.lens == LensMode::exact;
    if (settings_.hmd.timing.scan_out == ScanOut::global || !straight || settings_.believed_hmd) return;
    const auto X_WE_true = [&](double seconds) {
      return motion_.at(record.t_display + from_seconds(seconds)).X_WB * eye_.X_HE;
    };
    const std::optional<ScanSkew> skew = scan_skew(scene_.edge, record.shown, on_, X_WE_true);
    if (!skew) return;
    record.scan_skew_arcmin = skew->arcmin;
    worst_skew_ = std::max(worst_skew_.value_or(0.0), std::abs(skew->arcmin));
  }

  void add_coverage(FrameRecord& record) {
    if (!view_) return;
    if (how_.kind == DeflectionKind::none && frames_ > 0) return;  // as in the first frame
    const Coverage coverage = view_->measure(record.shown, scene_);
    missing_pct_.add(coverage.missing_pct());
    if (how_.kind == DeflectionKind::depth) disoccluded_pct_.add(coverage.disocclusion_pct());
  }

  [[nodiscard]] PoseErrorSummary pose_summary() const {
    PoseErrorSummary summary = pose_;
    MeanSquare all;
    for (const Vector3& error : orientation_errors_) {
      all.add(error.norm());
      summary.peak_orientation_arcmin = std::max(summary.peak_orientation_arcmin, error.norm());
    }
    summary.rms_orientation_arcmin = all.rms().value_or(0.0);
    return summary;
  }

  void set_coverage(ExperimentRow& row) const {
    row.coverage_missing_pct = missing_pct_.mean();
    row.coverage_missing_peak_pct = missing_pct_.peak();
    row.disocclusion_pct = disoccluded_pct_.mean();
    row.disocclusion_peak_pct = disoccluded_pct_.peak();
  }

  void set_registration(ExperimentRow& row) const {
    if (errors_px_.empty()) return;
    const ErrorStatistics px = statistics_of(errors_px_);
    row.registration = RegistrationSummary{px.rms,
                                           px.mean,
                                           px.p50,
                                           px.p95,
                                           px.p99,
                                           px.peak,
                                           all_arcmin_.rms().value_or(0.0),
                                           peak_arcmin_,
                                           all_mm_.rms().value_or(0.0)};
    if (swim_deg_.empty()) return;
    const ErrorStatistics px_s = statistics_of(swim_px_), deg_s = statistics_of(swim_deg_);
    row.swim = SwimSummary{px_s.rms, px_s.peak, deg_s.rms, deg_s.peak};
  }

  void set_motion_columns(ExperimentRow& row) const {
    if (is_still_) {
      row.jitter_arcmin = standard_deviation<3>(orientation_errors_);
    } else {
      row.jitter_arcmin = band_rms<3>(orientation_errors_, settings_.hmd.timing.refresh_hz);
    }
    if (const std::optional<Overshoot> over = overshoot(turns_)) {
      row.overshoot_arcmin = over->arcmin;
      row.overshoot_pct = over->pct;
    }
    LatencyOptions options;
    options.frames = FrameRelation::same;
    options.longest = std::max<Duration>(options.longest, settings_.latency * 2);
    const LatencyResult latency = estimate_latency(motion_, displayed_, options);
    if (latency.status != LatencyStatus::ok) return;
    row.effective_latency_ms = latency.effective_latency_ms;
    row.effective_latency_uncertainty_ms = latency.uncertainty_ms;
  }

  const Motion& motion_;
  const ExperimentSettings& settings_;
  const RegistrationScene& scene_;
  const EyeModel& eye_;
  const EyeModel& believed_;  // the true one unless told otherwise
  DeflectionSettings how_;
  RenderedView drawn_;  // without pose and time
  ShownOn on_;
  PipelinePoses poses_;
  SwimMeter swim_;
  std::size_t frames_ = 0;
  bool is_still_ = true;
  PoseErrorSummary pose_;
  std::vector<Vector3> orientation_errors_;  // arcmin
  std::vector<TimedPose> displayed_;
  std::vector<TurnSample> turns_;
  std::vector<double> errors_px_, swim_px_, swim_deg_;
  MeanSquare all_arcmin_, all_mm_;
  double peak_arcmin_ = 0.0;
  std::optional<double> worst_skew_;
  std::optional<ViewCoverageMeter> view_;
  MeanAndPeak missing_pct_, disoccluded_pct_;
};

}  // namespace holdfast::detail

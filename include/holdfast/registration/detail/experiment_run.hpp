/// The loop body and the bookkeeping of experiment.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <holdfast/prediction/jitter.hpp>
#include <holdfast/registration/coverage.hpp>
#include <holdfast/registration/effective_latency.hpp>
#include <holdfast/registration/expected_values.hpp>
#include <holdfast/registration/fiducial_error.hpp>
#include <holdfast/registration/overshoot.hpp>
#include <holdfast/registration/pipeline_pose.hpp>
#include <holdfast/registration/scan_skew.hpp>
#include <holdfast/registration/swim.hpp>

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
  plan.warm_up =
      std::max<Duration>(std::chrono::milliseconds(200), settings.latency + settings.velocity_baseline + half_scan);
  plan.first_vsync = next_vsync_number(plan.timing, motion.begin() + plan.warm_up - vsync_to_middle(plan.timing));
  const HostTime last = motion.end() - half_scan;
  if (plan.middle_of(0) > last) return plan;
  const double frames = std::floor(to_seconds(last - plan.middle_of(0)) * plan.timing.refresh_hz + 1e-6) + 1.0;
  plan.count = static_cast<std::size_t>(frames);
  while (plan.count > 0 && plan.middle_of(plan.count - 1) > last) --plan.count;
  if (settings.frames > 0) plan.count = std::min(plan.count, settings.frames);
  return plan;
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

class ExperimentRun {
 public:
  ExperimentRun(const Motion& motion, const ExperimentSettings& settings, const RegistrationScene& scene)
      : motion_(motion),
        settings_(settings),
        scene_(scene),
        eye_(settings.hmd.eye(settings.eye)),
        believed_(settings.believed_hmd ? &settings.believed_hmd->eye(settings.eye) : nullptr),
        swim_(scene.discs.size()) {}

  void frame(std::size_t index, HostTime t_display, const FrameObserver& observe) {
    FrameRecord record;
    record.index = index;
    record.t_display = t_display;
    record.t_measured = t_display - settings_.latency;
    const MotionState truth = motion_.at(t_display);
    record.X_WH_true = truth.X_WB;
    record.X_WH_displayed = displayed_pose(motion_, settings_, t_display);
    record.X_WE_true = record.X_WH_true * eye_.X_HE;
    record.X_WE_displayed = record.X_WH_displayed * (believed_ ? believed_->X_HE : eye_.X_HE);
    add_pose_errors(record, truth);
    add_fiducials(record);
    add_scan_skew(record);
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
    row.frames = frames_;
    row.pose = pose_summary();
    set_registration(row);
    set_motion_columns(row);
    row.scan_skew_arcmin = worst_skew_;
    row.coverage_missing_pct = coverage_missing_pct(eye_, settings_.lens);
    judge(row, settings_);
    return row;
  }

 private:
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
    const EyeModel& drawing = believed_ ? *believed_ : eye_;
    MeanSquare px, arcmin, mm, swim;
    record.fiducials.reserve(scene_.discs.size());
    for (std::size_t i = 0; i < scene_.discs.size(); ++i) {
      const Disc& disc = scene_.discs[i];
      const auto real =
          real_ellipse(motion_, eye_, settings_.hmd.timing, settings_.lens, disc, record.t_display, record.X_WE_true);
      const auto drawn = real ? project_disc(drawing, record.X_WE_displayed, disc) : std::nullopt;
      FiducialRecord f = fiducial_error(eye_, believed_, settings_.lens, real, drawn);
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
    const DisplayTiming& timing = settings_.hmd.timing;
    if (timing.scan_out == ScanOut::global || settings_.lens != LensMode::none || believed_) return;
    const auto X_WE_true = [&](double seconds) {
      return motion_.at(record.t_display + from_seconds(seconds)).X_WB * eye_.X_HE;
    };
    const std::optional<ScanSkew> skew = scan_skew(scene_.edge, eye_, timing, record.X_WE_displayed, X_WE_true);
    if (!skew) return;
    record.scan_skew_arcmin = skew->arcmin;
    worst_skew_ = std::max(worst_skew_.value_or(0.0), std::abs(skew->arcmin));
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
  const EyeModel* believed_;
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
};

}  // namespace holdfast::detail

/// What a registration experiment is told and what it answers: settings, one record per frame, one row of results.
///
/// Source: evaluation.md, "Metrics" and "Default experiments". Units are in the member names; frames: W world, H head,
/// E eye, S the eye that the picture was drawn for. A number that has no meaning for an experiment (overshoot of a motion that never stops) is an empty optional,
/// in JSON null.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/geometry/rigid.hpp>
#include <holdfast/optics/hmd.hpp>
#include <holdfast/optics/overfill.hpp>
#include <holdfast/registration/inertial_recording.hpp>
#include <holdfast/registration/scene_fiducials.hpp>
#include <holdfast/timing/clock.hpp>
#include <holdfast/tracking/pose_filter.hpp>

namespace holdfast {

/// The pipelines of evaluation.md. P0 shows the newest measured pose, P1 extrapolates it at constant velocity; P2 filters
/// all poses measured so far, and carries its state on by the filter's model; P3 does so with inertial sensors. P4 draws
/// as P3 does, and turns the finished picture to a late pose (rotation); P5 moves each point by its distance too
/// (depth); P6 does so line by line of a rolling scan-out.
enum class Pipeline { p0, p1, p2, p3, p4, p5, p6 };

inline constexpr std::array pipelines{Pipeline::p0, Pipeline::p1, Pipeline::p2, Pipeline::p3,
                                      Pipeline::p4, Pipeline::p5, Pipeline::p6};

[[nodiscard]] constexpr std::string_view name_of(Pipeline pipeline) {
  constexpr std::string_view names[] = {"P0", "P1", "P2", "P3", "P4", "P5", "P6"};
  return names[static_cast<std::size_t>(pipeline)];
}
/// In words, short enough for a legend.
[[nodiscard]] constexpr std::string_view describe(Pipeline pipeline) {
  constexpr std::string_view words[] = {"no prediction",           "constant velocity", "Kalman without inertial",
                                        "Kalman with inertial",    "late rotation",     "late depth warp",
                                        "late depth warp per line"};
  return words[static_cast<std::size_t>(pipeline)];
}
/// Nothing when there is no such pipeline.
[[nodiscard]] constexpr std::optional<Pipeline> parse_pipeline(std::string_view name) {
  for (const Pipeline pipeline : pipelines) {
    if (name == name_of(pipeline)) return pipeline;
  }
  return std::nullopt;
}
/// How a pipeline knows where the head will be.
enum class PosePrediction { none, constant_velocity, kalman, kalman_inertial };

[[nodiscard]] constexpr PosePrediction prediction_of(Pipeline pipeline) {
  return static_cast<PosePrediction>(std::min(static_cast<int>(pipeline), 3));
}
/// What a pipeline does to the finished picture of its own accord.
[[nodiscard]] constexpr DeflectionKind deflection_of(Pipeline pipeline) {
  if (pipeline == Pipeline::p4) return DeflectionKind::rotation;
  if (pipeline == Pipeline::p5 || pipeline == Pipeline::p6) return DeflectionKind::depth;
  return DeflectionKind::none;
}

/// Where P1's velocity comes from: the motion's own derivative, as an ideal rate gyro's (generated
/// motions), or the causal difference of two poses (recordings: their spline looks ahead, so its derivative would be a
/// prophet's).
enum class VelocitySource { exact, backward_difference };

/// What an inertial tracker answered: X_WH at one time as known at another. Experiments share it that ask the same, such
/// as P3 and what P4 to P6 draw, or one pipeline through several lenses.
using KnownPoses = std::map<std::pair<HostTime, HostTime>, Rigid>;

struct ExperimentSettings {
  std::string motion_name = "M1";  ///< "M0".."M8" choose the values that theory demands; any other name has none
  Pipeline pipeline = Pipeline::p0;
  EyeSide eye = EyeSide::left;
  LensMode lens = LensMode::none;
  Duration latency = std::chrono::milliseconds(60);  ///< from the tracker's measurement to the middle of scan-out
  HmdModel hmd = default_hmd();                      ///< its timing says whether scan-out is global or rolling
  std::optional<HmdModel> believed_hmd;              ///< what the renderer believes the HMD to be; nothing: the truth
  Rigid X_HT;                                        ///< static error: the tracker says X_WH * X_HT where X_WH is true
  VelocitySource velocity = VelocitySource::exact;
  Duration velocity_baseline = std::chrono::microseconds(16700);  ///< between the two poses of the backward difference
  /// From P2 on: the tracker measures at least so often, and then when the others' pose is measured.
  Duration tracker_interval = std::chrono::microseconds(8334);
  PvaModel filter_model = head_model();
  PoseFilterSettings filter;
  /// From P3 on: the inertial unit on the head, its errors, and the seed of its noise. Its X_BS is seen from what the
  /// tracker follows, X_HT away from the head.
  InertialUnit inertial = recorded_head_unit();
  std::uint64_t inertial_seed = 1;
  std::shared_ptr<KnownPoses> known_poses;  ///< of experiments that share motion, unit, seed and X_HT; may be none
  Duration interval_error{0};  ///< an ablation: whoever predicts takes the light to come so much later than it does
  std::size_t frames = 0;      ///< 0: as many as the motion lasts

  // Of the pipelines that deflect.
  std::optional<DeflectionKind> deflection;        ///< instead of the pipeline's own (an ablation), with any pipeline
  std::optional<bool> per_scanline;                ///< instead of the pipeline's own
  double plane_distance_m = 2.0;                   ///< of DeflectionKind::plane
  Duration late = std::chrono::milliseconds(3);    ///< the late pose is measured so long before the scan-out starts
  bool perfect_late_pose = false;                  ///< tests: the late poses are the true ones
  DeflectionBudget overfill = default_overfill();  ///< how far the late pose may turn before the picture has no pixels

  /// A tenth of a second of prediction at 60 deg/s: what heads do now and then.
  [[nodiscard]] static DeflectionBudget default_overfill() { return {degrees(6.0), degrees(4.0), degrees(3.0)}; }
};

/// How the finished picture is deflected.
[[nodiscard]] inline DeflectionSettings deflection_of(const ExperimentSettings& settings) {
  return {settings.deflection.value_or(deflection_of(settings.pipeline)), settings.plane_distance_m,
          settings.per_scanline.value_or(settings.pipeline == Pipeline::p6)};
}

/// A finished picture and what was done to it: all that there is to know to draw it, or to say where a point is seen.
struct ShownPicture {
  RenderedView view;  ///< what the picture was drawn with; where it is deflected, wider than the panel's field
  DeflectionSettings how;
  LatePoses late;               ///< of the eye; those of the drawing when the picture is not deflected
  DeflectionResult deflection;  ///< from `view` to `late`
  HostTime t_late;              ///< when the late pose was measured

  [[nodiscard]] bool is_deflected() const { return how.kind != DeflectionKind::none && deflection.ok(); }
};

/// One fiducial in one frame, as the eye sees it. Pixels: origin lower left, pixel centres at half integers.
struct FiducialRecord {
  std::size_t disc = 0;  ///< index into RegistrationScene::discs
  bool visible = false;  ///< both images lie wholly inside the picture; what follows is meaningful only then
  Vector2 c_real = Vector2::Zero();
  Vector2 c_virtual = Vector2::Zero();
  Vector2 error_px = Vector2::Zero();   ///< c_virtual - c_real
  Vector2 error_rad = Vector2::Zero();  ///< right and up, angle between the two rays (metrics.hpp)
  double error_arcmin = 0.0;            ///< length of error_rad
  double error_mm = 0.0;                ///< the same at the fiducial's depth (metrics.hpp)
};

struct FrameRecord {
  std::size_t index = 0;
  HostTime t_display;    ///< middle of scan-out
  HostTime t_measured;   ///< time of the pose that the pipeline started from: t_display - latency
  Rigid X_WH_true;       ///< at t_display
  Rigid X_WH_displayed;  ///< the head for which the picture is right as shown (pipeline_pose.hpp)
  Rigid X_WE_true;       ///< the eye of the settings, with the true HMD
  Rigid X_WE_displayed;
  ShownPicture shown;
  std::vector<FiducialRecord> fiducials;  ///< one per disc of the scene, in its order
  std::size_t visible = 0;
  // Over the visible fiducials; nothing when there are none.
  std::optional<double> rms_px, rms_arcmin, rms_mm;
  std::optional<double> swim_rms_deg_s;  ///< needs fiducials visible in this frame and the one before
  // Of the poses alone, whatever is in view.
  double yaw_error_arcmin = 0.0;  ///< about the head's own up axis, displayed against true, signed (left positive)
  double orientation_error_arcmin = 0.0;  ///< angle between the two orientations
  double position_error_mm = 0.0;
  std::optional<double> scan_skew_arcmin;  ///< tilt of the virtual against the real vertical edge, top to bottom
};

/// Called after each frame; t, poses and errors are complete. The record lives until the callback returns.
using FrameObserver = std::function<void(const FrameRecord&)>;

struct RegistrationSummary {
  double rms_px = 0.0, mean_px = 0.0, p50_px = 0.0, p95_px = 0.0, p99_px = 0.0, peak_px = 0.0;
  double rms_arcmin = 0.0, peak_arcmin = 0.0, rms_mm = 0.0;
};

struct SwimSummary {
  double rms_px_s = 0.0, peak_px_s = 0.0, rms_deg_s = 0.0, peak_deg_s = 0.0;
};

/// Of the head's pose alone: what the values of theory speak of.
struct PoseErrorSummary {
  double peak_yaw_arcmin = 0.0, peak_orientation_arcmin = 0.0, rms_orientation_arcmin = 0.0, peak_position_mm = 0.0;
  double peak_swim_deg_s = 0.0;  ///< largest rate at which the orientation error changes
};

/// A number that theory demands beside what was measured.
struct ExpectedValue {
  std::string name;  ///< of the measured column, for example "peak_yaw_arcmin"
  double expected = 0.0;
  double tolerance = 0.0;  ///< absolute
  double measured = 0.0;

  [[nodiscard]] bool holds() const { return std::abs(measured - expected) <= tolerance; }
};

enum class Verdict { pass, warn, fail, none };

[[nodiscard]] constexpr std::string_view name_of(Verdict verdict) {
  constexpr std::string_view names[] = {"pass", "warn", "fail", "none"};
  return names[static_cast<std::size_t>(verdict)];
}

/// One row of the JSON contract "holdfast/run/1".
struct ExperimentRow {
  std::string motion;
  Pipeline pipeline = Pipeline::p0;
  EyeSide eye = EyeSide::left;
  LensMode lens = LensMode::none;
  double latency_ms = 0.0;
  ScanOut display = ScanOut::global;
  DeflectionKind deflection = DeflectionKind::none;
  bool per_scanline = false;       ///< deflected line by line
  std::optional<double> late_ms;   ///< the late pose's age at the start of scan-out; nothing when not deflected
  double interval_error_ms = 0.0;  ///< predicted so much too far
  std::size_t frames = 0;
  std::optional<RegistrationSummary> registration;  ///< nothing when no fiducial was ever in view
  std::optional<SwimSummary> swim;
  PoseErrorSummary pose;
  std::optional<double> effective_latency_ms, effective_latency_uncertainty_ms;
  std::optional<double> jitter_arcmin;                    ///< head still: standard deviation; moving: 3-12 Hz RMS
  std::optional<double> overshoot_arcmin, overshoot_pct;  ///< motions that stop only; signed, % of the motion
  std::optional<double> scan_skew_arcmin;  ///< rolling scan-out: largest size over the frames that show the edge
  /// Parts of the view without a source pixel, and without a known colour: means over the frames, and the worst frame.
  std::optional<double> coverage_missing_pct, coverage_missing_peak_pct, disocclusion_pct, disocclusion_peak_pct;
  std::optional<double> picture_vs_theory_px;
  std::vector<ExpectedValue> expected;  ///< empty: theory demands nothing of this row
  Verdict verdict = Verdict::none;
};

/// Whether something is done in another way than the pipeline's own.
[[nodiscard]] inline bool is_ablation(const ExperimentRow& row) {
  return row.deflection != deflection_of(row.pipeline) || row.interval_error_ms != 0.0;
}

enum class ExperimentStatus { ok, motion_too_short, bad_settings };

struct ExperimentResult {
  ExperimentStatus status = ExperimentStatus::ok;
  std::string problem;  ///< in words, when the status is not ok
  ExperimentRow row;
};

}  // namespace holdfast

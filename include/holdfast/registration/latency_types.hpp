/// What a comparison of two recordings of one motion answers: effective latency, its uncertainty, and what remains
/// after it.
///
/// Sign: the observed pose lags the reference by `effective_latency`, observed(t) ~ reference(t - L); negative when it
/// leads, as a display that predicts too far does. Units are in the member names.
#pragma once

#include <optional>
#include <string_view>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

/// How the frames of the two recordings are related.
enum class FrameRelation {
  same,   ///< one world, one body: poses are compared as they are
  rigid,  ///< worlds and bodies differ by constant rigid transforms, which are estimated
};

struct LatencyOptions {
  FrameRelation frames = FrameRelation::rigid;
  Duration longest = std::chrono::milliseconds(300);     ///< search within +- this
  Duration widest_gap = std::chrono::milliseconds(100);  ///< between samples that may be interpolated
};

enum class LatencyStatus {
  ok,
  too_few_samples,      ///< fewer than 20 pairs overlap
  no_motion,            ///< nothing moves enough to tell a time
  frames_undetermined,  ///< turns about one axis only: the frames' relation cannot be estimated; compared as they are
};

[[nodiscard]] constexpr std::string_view describe(LatencyStatus status) {
  switch (status) {
    case LatencyStatus::ok:
      return "ok";
    case LatencyStatus::too_few_samples:
      return "the recordings overlap in fewer than 20 samples without a gap";
    case LatencyStatus::no_motion:
      return "the recordings hold too little motion to tell a time from";
    case LatencyStatus::frames_undetermined:
      return "the motion turns about one axis only, so the frames cannot be aligned; the poses were compared as they "
             "are";
  }
  return "unknown status";
}

struct LatencyResult {
  LatencyStatus status = LatencyStatus::ok;
  double effective_latency_ms = 0.0;
  double uncertainty_ms = 0.0;  ///< one standard deviation, from how far separate blocks of the recording disagree
  /// What remains after the shift (and, for FrameRelation::rigid, the alignment): rotation and position, all pairs.
  ErrorStatistics angle_deg, position_mm;
  /// The same without the shift, aligned anew: what latency adds.
  double unshifted_angle_deg_rms = 0.0, unshifted_position_mm_rms = 0.0;
  Rigid X_RO;    ///< pose of the observed world O in the reference's world R
  Rigid X_BoBr;  ///< pose of the reference's body in the observed body: X_R_Br = X_RO X_O_Bo X_BoBr
  std::size_t pairs = 0;
  double overlap_s = 0.0;

  [[nodiscard]] bool has_latency() const {
    return status == LatencyStatus::ok || status == LatencyStatus::frames_undetermined;
  }
};

}  // namespace holdfast

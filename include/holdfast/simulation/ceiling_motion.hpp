/// Any motion as that of a HiBall below its ceiling.
///
/// A recording has a world R and a device D of its own. `place_under_ceiling` turns R so that its up is W's, moves it so
/// that the mean position is `mean_W`, and fixes a HiBall B on the device: X_WB = X_WR X_RD X_DB. 002's "typical" motion
/// (table E.1) has its mean at (2.52, 4.22, 1.45) m, below a ceiling whose middle is at (2.74, 4.27).
/// Which way the device's axes point differs from recording to recording, so by default the HiBall is turned to look up on
/// average (`upright_mount`): its z is the mean of the up direction seen from the device, and the turn that takes the
/// device's z there is the shortest one. On a head (x right, y up, -z forward) B then has x right and y forward.
/// Truth: `hiball_truth` low-passes without phase delay and splines. 002 E.5 took 5 Hz, the HiBall paper 2 Hz (6.2.2);
/// both resampled at 1000 Hz, the spline answers at any time.
/// Bad input: no samples, or up directions of no length (assert). Times must rise, as io's readers return them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <holdfast/motion/low_pass.hpp>
#include <holdfast/motion/spline_trajectory.hpp>

namespace holdfast {

struct CeilingPlacement {
  Vector3 up_R = Vector3::UnitY();  ///< the recording's
  Vector3 up_W = Vector3::UnitZ();
  Vector3 mean_W = Vector3(2.74, 4.27, 1.45);  ///< of the HiBall's positions
  std::optional<Rigid> X_DB;                   ///< where the HiBall sits on the device; empty: upright_mount
};

/// The turn of a HiBall on a device that makes it look up on average.
[[nodiscard]] inline Rigid upright_mount(std::span<const TimedPose> samples, const Vector3& up_R) {
  Vector3 up_D = Vector3::Zero();
  for (const TimedPose& sample : samples) up_D += sample.X_WB.q().conjugate() * up_R;
  return Rigid::rotation(so3::between<double>(Vector3::UnitZ(), up_D));
}

/// The HiBall's poses X_WB; the samples hold X_RD.
[[nodiscard]] inline std::vector<TimedPose> place_under_ceiling(std::span<const TimedPose> samples,
                                                                const CeilingPlacement& placement = {}) {
  HOLDFAST_ASSERT(!samples.empty(), "a motion needs a sample");
  const Rigid X_DB = placement.X_DB ? *placement.X_DB : upright_mount(samples, placement.up_R);
  const Rigid turn = Rigid::rotation(so3::between<double>(placement.up_R, placement.up_W));
  std::vector<TimedPose> placed(samples.begin(), samples.end());
  Vector3 mean = Vector3::Zero();
  for (TimedPose& pose : placed) {
    pose.X_WB = turn * pose.X_WB * X_DB;
    mean += pose.X_WB.p() / static_cast<double>(samples.size());
  }
  const Rigid shift = Rigid::translation(placement.mean_W - mean);
  for (TimedPose& pose : placed) pose.X_WB = shift * pose.X_WB;
  return placed;
}

/// The smooth motion that counts as true.
[[nodiscard]] inline SplineTrajectory hiball_truth(std::span<const TimedPose> poses, double cutoff_hz = 5.0) {
  return SplineTrajectory(zero_phase_low_pass(poses, cutoff_hz));
}

/// A HiBall at rest; by default where 002 put its "still" one (E.1). Below our ceiling its top view looks between four
/// panels there and sees no beacon, the other five do.
[[nodiscard]] inline SplineTrajectory still_hiball(Duration duration,
                                                   const Rigid& X_WB = Rigid::translation(Vector3(2.74, 4.27, 1.60))) {
  const std::vector<TimedPose> ends{{HostTime(Duration(0)), X_WB}, {HostTime(duration), X_WB}};
  return SplineTrajectory(ends);
}

}  // namespace holdfast

// Heads and headsets for the tests of the pipeline.
#pragma once

#include <memory>
#include <optional>

#include <holdfast/motion/motions.hpp>
#include <holdfast/pipeline/frame_loop.hpp>

namespace holdfast::test {

/// The default headset with a rolling display of 11.1 ms.
inline HmdModel rolling_hmd(ScanDirection direction = ScanDirection::top_to_bottom) {
  HmdModel hmd = default_hmd();
  hmd.timing.scan_out = ScanOut::rolling;
  hmd.timing.scan_duration = from_milliseconds(11.1);
  hmd.timing.scan_direction = direction;
  return hmd;
}

/// What an ideal tracker says of a motion at time t.
inline PoseEstimate exact_estimate(const Motion& motion, HostTime t) {
  const MotionState state = motion.at(t);
  PoseEstimate e;
  e.t = t;
  e.X_WB = state.X_WB;
  e.velocity = Twist{state.v_WB, state.w_WB_B};
  return e;
}

/// A head that turns at w_WB_B and moves at v_WB for ever, through X_WB at t.
inline PoseEstimate steady_head(double t, const Vector3& w_WB_B = Vector3(0.3, 1.7, -0.2),
                                const Vector3& v_WB = Vector3(0.4, 0.0, -0.2)) {
  PoseEstimate e;
  e.t = time_at(t);
  const Vector3 turned = t * w_WB_B;
  e.X_WB = Rigid(so3::exp<double>(turned), Vector3(0.1, 1.7, 0.3) + t * v_WB);
  e.velocity = Twist{v_WB, w_WB_B};
  return e;
}

/// The same pose, turning otherwise.
inline PoseEstimate with_turn(PoseEstimate e, const Vector3& w_WB_B) {
  e.velocity->w_WB_B = w_WB_B;
  return e;
}

/// A runtime that knows the motion's truth at any time.
inline auto prophet(const Motion& motion) {
  return RuntimePoseSource([&motion](HostTime t) { return std::optional<PoseEstimate>(exact_estimate(motion, t)); });
}

inline double worst_difference(const Matrix3& a, const Matrix3& b) {
  return (a - b).cwiseAbs().maxCoeff();
}
inline double worst_difference(const Rigid& a, const Rigid& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

}  // namespace holdfast::test

/// The eye's pose against the source picture, line by line of the display's scan.
///
/// X_SE(s) is the pose of the displayed eye E in the eye frame S of the picture, at line fraction s: 0 where the scan
/// begins, 1 where it ends. Between the two late poses the position runs straight and the rotation turns at a constant
/// rate, as in interpolate (geometry/rigid.hpp); s outside [0, 1] extrapolates. The logarithm is taken once, so that a
/// line costs one exponential. Zero motion is exactly the identity, to the last bit.
/// Bad input: nothing is checked here; deflect() checks poses beforehand.
#pragma once

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/geometry/so3.hpp>

namespace holdfast {

/// The eye when the first scanned line lights and when the last one does; equal on a global display.
struct LatePoses {
  Rigid X_WE_begin;
  Rigid X_WE_end;

  /// An eye that does not move during the scan, or a display that lights all at once.
  [[nodiscard]] static LatePoses at_once(const Rigid& X_WE) { return {X_WE, X_WE}; }
};

/// X_AB of two poses in the world: exactly the identity when they are equal, and without loss far from the world's
/// origin, as the positions are subtracted first.
[[nodiscard]] inline Rigid relative_pose(const Rigid& X_WA, const Rigid& X_WB) {
  const Quaternion q_AW = X_WA.q().conjugate();
  const bool same_turn = X_WA.q().coeffs() == X_WB.q().coeffs();
  const Vector3 moved_W = X_WB.p() - X_WA.p();
  return Rigid(same_turn ? Quaternion::Identity() : q_AW * X_WB.q(), q_AW * moved_W);
}

class ScanPose {
 public:
  /// The identity: no motion.
  ScanPose() = default;

  /// From the pose X_WS of the picture and the late poses.
  ScanPose(const Rigid& X_WS, const LatePoses& late)
      : begin_(relative_pose(X_WS, late.X_WE_begin)), end_(relative_pose(X_WS, late.X_WE_end)) {
    turn_ = so3::log<double>(relative_pose(begin_, end_).q());
    moved_ = end_.p() - begin_.p();
  }

  /// X_SE at line fraction s.
  [[nodiscard]] Rigid at(double s) const {
    if (is_constant()) return begin_;
    const Vector3 turned = s * turn_;
    return Rigid(begin_.q() * so3::exp<double>(turned), begin_.p() + s * moved_);
  }
  [[nodiscard]] const Rigid& begin() const { return begin_; }
  [[nodiscard]] const Rigid& end() const { return end_; }
  [[nodiscard]] Rigid middle() const { return at(0.5); }

  /// Whether all lines have one pose.
  [[nodiscard]] bool is_constant() const { return (turn_.array() == 0.0).all() && (moved_.array() == 0.0).all(); }

  /// Every line at the pose of the scan's middle: what a correction does that knows no lines.
  [[nodiscard]] ScanPose without_scan() const {
    ScanPose still;
    still.begin_ = still.end_ = middle();
    return still;
  }

 private:
  Rigid begin_, end_;                // X_SE
  Vector3 turn_ = Vector3::Zero();   // rotation vector from begin to end, in E
  Vector3 moved_ = Vector3::Zero();  // of E from begin to end, in S
};

}  // namespace holdfast

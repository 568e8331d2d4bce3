/// The eye's pose against the source picture, line by line of the display's scan.
///
/// X_SE(s) is the pose of the displayed eye E in the eye frame S of the picture, at line fraction s: 0 where the scan
/// begins, 1 where it ends. With the late poses of begin, middle and end, position and rotation vector (from the pose at
/// the begin) run as parabolas of s through all three:
///
///     p(s) = p_b + s (l + s k),    q(s) = q_b exp(s (m + s n)),
///
/// so that a head that accelerates during the scan is right at three times, and between them to third order: yaw as
/// 3 deg sin(2 pi 2 Hz t) leaves 0.008 (0.14 rad)^3 3 deg = 1.2e-6 rad during 11.1 ms; two poses alone leave 1.3e-4.
/// Without a pose for the middle the position runs straight and the rotation turns at a constant rate, as in interpolate
/// (geometry/rigid.hpp). s outside [0, 1] extrapolates. The logarithms are taken once, so that a line costs one
/// exponential. Zero motion is exactly the identity, to the last bit.
/// Bad input: nothing is checked here; deflect() checks poses beforehand.
#pragma once

#include <algorithm>
#include <optional>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/geometry/so3.hpp>

namespace holdfast {

/// The eye when the first scanned line lights and when the last one does, and half way between; equal on a global display.
struct LatePoses {
  Rigid X_WE_begin;
  Rigid X_WE_end;
  std::optional<Rigid> X_WE_middle{};  ///< nothing: half way, at a constant rate

  /// An eye that does not move during the scan, or a display that lights all at once.
  [[nodiscard]] static LatePoses at_once(const Rigid& X_WE) { return {X_WE, X_WE}; }

  [[nodiscard]] bool is_finite() const {
    return X_WE_begin.is_finite() && X_WE_end.is_finite() && (!X_WE_middle || X_WE_middle->is_finite());
  }
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
    turned_.linear = so3::log<double>(relative_pose(begin_, end_).q());
    moved_.linear = end_.p() - begin_.p();
    if (late.X_WE_middle) {
      middle_ = relative_pose(X_WS, *late.X_WE_middle);
      turned_.bend_to(so3::log<double>(relative_pose(begin_, middle_).q()));
      moved_.bend_to(middle_.p() - begin_.p());
    } else {
      middle_ = at(0.5);
    }
  }

  /// X_SE at line fraction s.
  [[nodiscard]] Rigid at(double s) const {
    if (is_constant()) return begin_;
    return Rigid(begin_.q() * so3::exp<double>(turned_.at(s)), begin_.p() + moved_.at(s));
  }
  [[nodiscard]] const Rigid& begin() const { return begin_; }
  [[nodiscard]] const Rigid& middle() const { return middle_; }
  [[nodiscard]] const Rigid& end() const { return end_; }

  /// The position of E in S is begin().p() + s * moved_linear() + s^2 * moved_quadratic(): for shaders.
  [[nodiscard]] const Vector3& moved_linear() const { return moved_.linear; }
  [[nodiscard]] const Vector3& moved_quadratic() const { return moved_.quadratic; }

  /// The least z of E in S during the scan: how far it comes ahead.
  [[nodiscard]] double least_z() const {
    const double least = std::min({begin_.p().z(), middle_.p().z(), end_.p().z()});
    const double turning = -0.5 * moved_.linear.z() / moved_.quadratic.z();  // a line has none: infinite or no number
    return turning > 0.0 && turning < 1.0 ? std::min(least, begin_.p().z() + moved_.at(turning).z()) : least;
  }

  /// Whether all lines have one pose.
  [[nodiscard]] bool is_constant() const { return turned_.is_zero() && moved_.is_zero(); }

  /// Every line at the pose of the scan's middle: what a correction does that knows no lines.
  [[nodiscard]] ScanPose without_scan() const {
    ScanPose still;
    still.begin_ = still.middle_ = still.end_ = middle_;
    return still;
  }

 private:
  /// A parabola of s that is zero at 0.
  struct Path {
    Vector3 linear = Vector3::Zero(), quadratic = Vector3::Zero();

    /// Keeps the value at 1 and takes `half_way` at 1/2.
    void bend_to(const Vector3& half_way) {
      quadratic = 2.0 * (linear - 2.0 * half_way);
      linear -= quadratic;
    }
    [[nodiscard]] Vector3 at(double s) const { return s * (linear + s * quadratic); }
    [[nodiscard]] bool is_zero() const { return (linear.array() == 0.0).all() && (quadratic.array() == 0.0).all(); }
  };

  Rigid begin_, middle_, end_;  // X_SE
  Path turned_;                 // rotation vector from the begin, in E there
  Path moved_;                  // of E from the begin, in S
};

}  // namespace holdfast

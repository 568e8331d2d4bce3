/// What leaves a tracker: a pose with its time, its covariance and, when known, its velocity.
///
/// Errors are small vectors in this order, 3 numbers each:
///   d = (dp, dphi, dv, dw):  p_true = p + dp (W, m),  R_true = R exp(dphi) (about B's axes, rad),
///                            v_true = v + dv (W, m/s),  w_true = w + dw (B, rad/s).
/// `covariance` is E[d d^T], 12x12, with the cross terms between pose and velocity: without them a prediction's
/// uncertainty would be wrong, for a velocity that comes from poses errs together with them. With no velocity only the
/// upper left 6x6 counts. A zero covariance says "exact" (simulated truth); a tracker never says so.
#pragma once

#include <optional>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

using Matrix12 = MatrixOf<double, 12>;

/// Velocity of body B against W: v_WB of B's origin expressed in W (m/s), w_WB_B expressed in B (rad/s).
struct Twist {
  Vector3 v_WB = Vector3::Zero();
  Vector3 w_WB_B = Vector3::Zero();
};

struct PoseEstimate {
  HostTime t;
  Rigid X_WB;
  std::optional<Twist> velocity;
  Matrix12 covariance = Matrix12::Zero();

  /// Covariance of (dp, dphi).
  [[nodiscard]] Matrix6 pose_covariance() const { return covariance.topLeftCorner<6, 6>(); }

  [[nodiscard]] bool is_finite() const {
    return X_WB.is_finite() && covariance.allFinite() &&
           (!velocity || (velocity->v_WB.allFinite() && velocity->w_WB_B.allFinite()));
  }
};

/// Standard deviations of a measured pose's independent errors: position per axis (m), orientation per axis (rad).
struct PoseNoise {
  double position_m = 0.0;
  double orientation_rad = 0.0;
};

}  // namespace holdfast

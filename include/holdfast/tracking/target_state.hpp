/// What a filter knows about the tracked body: nominal state with an external quaternion, and the covariance of its error.
///
/// 002 section 4.2.2 keeps the orientation outside the filter's state and small turns inside, zeroed after every update
/// (eqs 4.2, 4.3, 4.22). Here the nominal state is outside altogether, and the filter's numbers are the error
///   d = (dp, dphi, dv, dw, da, dalpha), 3 numbers each, the first 6 Order of them:
///   p_true = p + dp (W, m),  R_true = R exp(dphi) (about B's axes, rad),  v_true = v + dv (W, m/s),
///   w_true = w + dw (B, rad/s),  and so on,
/// the order of pose_estimate.hpp: a sensor of the pose alone touches the first six. P = E[d d^T].
/// Bad input: is_finite tells.
#pragma once

#include <holdfast/tracking/pose_estimate.hpp>

namespace holdfast {

/// Acceleration of body B against W: a_WB of B's origin in W (m/s^2), alpha_WB_B expressed in B (rad/s^2).
struct TwistRate {
  Vector3 a_WB = Vector3::Zero();
  Vector3 alpha_WB_B = Vector3::Zero();
};

template <int Order>
struct TargetState {
  static constexpr int order = Order;
  static constexpr int size = 6 * Order;
  using Error = VectorOf<double, size>;
  using Covariance = MatrixOf<double, size>;

  HostTime t;
  Rigid X_WB;
  Twist velocity;          ///< zero for Order 1
  TwistRate acceleration;  ///< zero for Orders 1 and 2
  Covariance P = Covariance::Identity();

  [[nodiscard]] bool is_finite() const {
    return X_WB.is_finite() && velocity.v_WB.allFinite() && velocity.w_WB_B.allFinite() &&
           acceleration.a_WB.allFinite() && acceleration.alpha_WB_B.allFinite() && P.allFinite();
  }

  /// The state that errs from this one by d.
  void add(const Error& d) {
    X_WB = Rigid(X_WB.q() * so3::exp<double>(d.template segment<3>(3)), X_WB.p() + d.template head<3>());
    if constexpr (Order >= 2) {
      velocity.v_WB += d.template segment<3>(6);
      velocity.w_WB_B += d.template segment<3>(9);
    }
    if constexpr (Order >= 3) {
      acceleration.a_WB += d.template segment<3>(12);
      acceleration.alpha_WB_B += d.template segment<3>(15);
    }
  }

  /// The error d with which `truth` differs from this state: truth = this, add(d).
  [[nodiscard]] Error error_of(const TargetState& truth) const {
    Error d;
    d.template head<3>() = truth.X_WB.p() - X_WB.p();
    d.template segment<3>(3) = so3::log<double>(X_WB.q().conjugate() * truth.X_WB.q());
    if constexpr (Order >= 2) {
      d.template segment<3>(6) = truth.velocity.v_WB - velocity.v_WB;
      d.template segment<3>(9) = truth.velocity.w_WB_B - velocity.w_WB_B;
    }
    if constexpr (Order >= 3) {
      d.template segment<3>(12) = truth.acceleration.a_WB - acceleration.a_WB;
      d.template segment<3>(15) = truth.acceleration.alpha_WB_B - acceleration.alpha_WB_B;
    }
    return d;
  }
};

/// What leaves the tracker. Order 1 has no velocity.
template <int Order>
[[nodiscard]] PoseEstimate pose_estimate(const TargetState<Order>& state) {
  PoseEstimate estimate;
  estimate.t = state.t;
  estimate.X_WB = state.X_WB;
  constexpr int known = Order == 1 ? 6 : 12;
  if constexpr (Order >= 2) estimate.velocity = state.velocity;
  estimate.covariance.template topLeftCorner<known, known>() = state.P.template topLeftCorner<known, known>();
  return estimate;
}

}  // namespace holdfast

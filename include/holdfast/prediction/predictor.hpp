/// Predictors: from what the tracker last said to the pose at a display's time, with covariance and a status.
///
///   none               X(t + T) = X(t)
///   constant velocity  p(t + T) = p + v_WB T,  R(t + T) = R exp(w_WB_B T)
///
/// (000 section 5.3; 001 section 5.2 without its acceleration terms).
/// w_WB_B is expressed in B, so turning the whole world leaves the prediction as it is, turned.
///
/// What limits a prediction is stated, never silent: the interval is clamped to PredictionLimits::maximum_interval, and
/// every other departure has its PredictionStatus. The pose of a result is always usable, whatever the status.
///
/// Covariance (6x6 of (dp, dphi), see pose_estimate.hpp): the estimate's own is carried through the prediction with its
/// cross terms; to it comes what the head may do meanwhile (HeadDynamics). For none that is the movement that was
/// ignored, for constant velocity the acceleration that was, a T^2 / 2.
///
/// Nothing here allocates, locks or throws. Bad input: statuses not_finite, backwards, no_velocity.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include <holdfast/tracking/head_dynamics.hpp>
#include <holdfast/tracking/pose_estimate.hpp>

namespace holdfast {

struct PredictionLimits {
  /// Beyond this the pose is held where it was predicted to be by then: an extrapolated velocity is worth little after
  /// 100 ms.
  Duration maximum_interval = std::chrono::milliseconds(100);
};

enum class PredictionStatus {
  ok,
  no_velocity,  ///< constant velocity was asked, but the estimate has none: the pose is held
  clamped,      ///< the interval is longer than the limit: predicted up to it, held from there
  backwards,    ///< the time asked lies before the estimate: the pose is held
  not_finite  ///< the estimate holds a NaN or an infinity: the pose is held, or the identity if it is the pose that is
              ///< bad
};

[[nodiscard]] constexpr std::string_view to_string(PredictionStatus status) {
  switch (status) {
    case PredictionStatus::ok:
      return "ok";
    case PredictionStatus::no_velocity:
      return "no_velocity";
    case PredictionStatus::clamped:
      return "clamped";
    case PredictionStatus::backwards:
      return "backwards";
    case PredictionStatus::not_finite:
      return "not_finite";
  }
  return "unknown";
}

struct PredictionResult {
  HostTime t;  ///< the time that was asked for
  Rigid X_WB;  ///< the predicted pose
  Matrix6 covariance = Matrix6::Zero();
  PredictionStatus status = PredictionStatus::ok;
  Duration interval{0};  ///< what was extrapolated over: 0 when the pose was held
};

enum class Predictor { none, constant_velocity };

inline constexpr std::array predictors{Predictor::none, Predictor::constant_velocity};

[[nodiscard]] constexpr std::string_view to_string(Predictor predictor) {
  return predictor == Predictor::none ? "none" : "constant_velocity";
}

namespace detail {

/// t - from in seconds, without integer overflow for any two times.
[[nodiscard]] inline double seconds_between(HostTime from, HostTime t) {
  const double seconds =
      (static_cast<double>(t.time_since_epoch().count()) - static_cast<double>(from.time_since_epoch().count())) * 1e-9;
  return std::abs(seconds) > 1e6 ? seconds : to_seconds(t - from);
}

inline void add_isotropic(Matrix6& covariance, double sigma_p, double sigma_phi) {
  covariance.diagonal().head<3>().array() += sigma_p * sigma_p;
  covariance.diagonal().tail<3>().array() += sigma_phi * sigma_phi;
}

/// Adds what may happen in `seconds` during which the pose is held: the known movement, as an error, or else the usual
/// speed; and the usual acceleration.
inline void add_held(Matrix6& covariance, const PoseEstimate& estimate, double seconds, const HeadDynamics& head) {
  if (estimate.velocity) {
    Vector6 missed;
    missed << estimate.velocity->v_WB * seconds, estimate.velocity->w_WB_B * seconds;
    covariance += missed * missed.transpose();
    const double half_square = 0.5 * seconds * seconds;
    add_isotropic(covariance, head.acceleration_m_s2 * half_square, head.angular_acceleration_rad_s2 * half_square);
  } else {
    add_isotropic(covariance, head.speed_m_s * seconds, head.angular_speed_rad_s * seconds);
  }
}

[[nodiscard]] inline PredictionResult held(const PoseEstimate& estimate, HostTime t, PredictionStatus status,
                                           const HeadDynamics& head) {
  PredictionResult result;
  result.t = t;
  result.status = status;
  if (!estimate.is_finite()) {
    result.status = PredictionStatus::not_finite;
    if (estimate.X_WB.is_finite()) result.X_WB = estimate.X_WB;
    return result;
  }
  result.X_WB = estimate.X_WB;
  result.covariance = estimate.pose_covariance();
  add_held(result.covariance, estimate, std::abs(seconds_between(estimate.t, t)), head);
  return result;
}

/// F P F^T, the 6x6 of the pose, for p + v T and R exp(w T).
///   dp(T) = dp + T dv,   dphi(T) = R(wT)^T dphi + J_right(wT) T dw.
[[nodiscard]] inline Matrix6 propagate(const PoseEstimate& estimate, double seconds) {
  const Vector3 phi = estimate.velocity->w_WB_B * seconds;
  Eigen::Matrix<double, 6, 12, Eigen::DontAlign> F = Eigen::Matrix<double, 6, 12, Eigen::DontAlign>::Zero();
  F.block<3, 3>(0, 0).setIdentity();
  F.block<3, 3>(0, 6).diagonal().setConstant(seconds);
  F.block<3, 3>(3, 3) = so3::exp<double>(phi).toRotationMatrix().transpose();
  F.block<3, 3>(3, 9) = so3::right_jacobian<double>(phi) * seconds;
  Eigen::Matrix<double, 6, 12, Eigen::DontAlign> FP;
  FP.noalias() = F.lazyProduct(estimate.covariance);
  Matrix6 covariance;
  covariance.noalias() = FP.lazyProduct(F.transpose());
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace detail

/// The newest pose, unchanged.
[[nodiscard]] inline PredictionResult predict_none(const PoseEstimate& estimate, HostTime t,
                                                   const PredictionLimits& = {}, const HeadDynamics& head = {}) {
  const bool backwards = t < estimate.t;
  return detail::held(estimate, t, backwards ? PredictionStatus::backwards : PredictionStatus::ok, head);
}

/// The newest pose carried on at its velocity.
[[nodiscard]] inline PredictionResult predict_constant_velocity(const PoseEstimate& estimate, HostTime t,
                                                                const PredictionLimits& limits = {},
                                                                const HeadDynamics& head = {}) {
  if (!estimate.is_finite()) return detail::held(estimate, t, PredictionStatus::not_finite, head);
  if (!estimate.velocity) return detail::held(estimate, t, PredictionStatus::no_velocity, head);
  if (t < estimate.t) return detail::held(estimate, t, PredictionStatus::backwards, head);

  const double asked = detail::seconds_between(estimate.t, t);
  const double maximum = std::max(0.0, to_seconds(limits.maximum_interval));
  const double seconds = std::min(asked, maximum);
  PredictionResult result;
  result.t = t;
  result.status = asked > maximum ? PredictionStatus::clamped : PredictionStatus::ok;
  result.interval = from_seconds(seconds);
  const Vector3 phi = estimate.velocity->w_WB_B * seconds;
  result.X_WB = Rigid(estimate.X_WB.q() * so3::exp<double>(phi), estimate.X_WB.p() + estimate.velocity->v_WB * seconds);
  result.covariance = detail::propagate(estimate, seconds);
  const double half_square = 0.5 * seconds * seconds;
  detail::add_isotropic(result.covariance, head.acceleration_m_s2 * half_square,
                        head.angular_acceleration_rad_s2 * half_square);
  if (asked > maximum) detail::add_held(result.covariance, estimate, asked - maximum, head);
  return result;
}

[[nodiscard]] inline PredictionResult predict(Predictor predictor, const PoseEstimate& estimate, HostTime t,
                                              const PredictionLimits& limits = {}, const HeadDynamics& head = {}) {
  return predictor == Predictor::none ? predict_none(estimate, t, limits, head)
                                      : predict_constant_velocity(estimate, t, limits, head);
}

}  // namespace holdfast

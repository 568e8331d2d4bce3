/// From a filter's state to the pose at any time: pose, velocity and covariance in closed form.
///
///     StatePrediction r = predict_state(filter.state(), filter.model(), t_display);   // ScaatFilter, PoseFilter, ...
/// The process model that the filter believes in carries its state on (process_model.hpp: P, PV, PVA, damped or not):
///   forwards   the time update of advance.hpp, of which only what the pose needs is computed
///   backwards  its inverse, for the moments just past that a scan-out may still need: x = A^-1 x(t),
///              P = A^-1 (P(t) + Q) A^-T, which forgets what the filter knew of that moment, and so errs on the safe side
/// The covariance needs no HeadDynamics: what the head may do meanwhile is the model's noise.
/// A step is exact for PV, and for PVA about one axis; where w and alpha differ in direction, carrying w on in B leaves out
/// T^3 |w x alpha| / 12 (the next term of Magnus's series): 0.02 deg for 2 rad/s, 10 rad/s^2 and 60 ms.
/// What limits a prediction is stated, as in predictor.hpp: further ahead than StatePredictionLimits the pose is held where
/// it was predicted to be by then (clamped), further back the state's own is (backwards).
/// Nothing here allocates, locks or throws.
/// Bad input: a state that is not finite, or that would leave all numbers behind, gives the status not_finite, and its
/// pose, or the identity if that is bad.
/// Precondition: the model has no problem.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <holdfast/prediction/predictor.hpp>
#include <holdfast/tracking/advance.hpp>

namespace holdfast {

struct StatePredictionLimits {
  Duration future = std::chrono::milliseconds(100);  ///< as PredictionLimits::maximum_interval
  Duration past = std::chrono::milliseconds(20);     ///< a scan-out's duration
};

/// A pose with covariance and status; `interval` is negative when it was carried back.
struct StatePrediction : PredictionResult {
  std::optional<Twist> velocity;  ///< at the time predicted for; nothing for Order 1, or when the pose is held
};

namespace detail {

/// Chains over -dt: A^-1, and A^-1 Q A^-T.
template <int Order>
void reverse(SixChains<Order>& chains) {
  for (int axis = 0; axis < 6; ++axis) {
    MatrixOf<double, Order> A = MatrixOf<double, Order>::Zero(), Q, inverse = MatrixOf<double, Order>::Zero();
    for (std::size_t i = 0; i < Order; ++i) {
      for (std::size_t j = i; j < Order; ++j) {
        A(i, j) = chains.A[i][j][axis];
        Q(i, j) = Q(j, i) = chains.Q[i][j][axis];
      }
    }
    for (int j = 0; j < Order; ++j) {  // columns of the inverse, from the bottom up
      for (int i = j; i >= 0; --i) {
        double sum = i == j ? 1.0 : 0.0;
        for (int k = i + 1; k <= j; ++k) sum -= A(i, k) * inverse(k, j);
        inverse(i, j) = sum / A(i, i);
      }
    }
    Q = (inverse * Q * inverse.transpose()).eval();
    for (std::size_t i = 0; i < Order; ++i) {
      for (std::size_t j = i; j < Order; ++j) {
        chains.A[i][j][axis] = inverse(i, j);
        chains.Q[i][j][axis] = Q(i, j);
      }
    }
  }
}

template <int Order>
[[nodiscard]] SixChains<Order> chains_over(const ProcessModel<Order>& model, double seconds) {
  SixChains<Order> chains = six_chains(model, std::abs(seconds));
  if (seconds < 0.0) reverse(chains);
  return chains;
}

/// The pose's block of F P F^T + Q.
template <int Order>
[[nodiscard]] Matrix6 pose_covariance_after(const TargetState<Order>& state, const SixChains<Order>& chains,
                                            const Vector3& turn) {
  using Rows = Eigen::Matrix<double, 6, 6 * Order, Eigen::DontAlign>;
  const Matrix3 J = so3::right_jacobian<double>(turn);
  Rows F = Rows::Zero();
  F.template block<3, 3>(0, 0).setIdentity();
  F.template block<3, 3>(3, 3) = so3::exp<double>(turn).toRotationMatrix().transpose();
  for (std::size_t j = 1; j < Order; ++j) {
    const int column = 6 * static_cast<int>(j);
    F.template block<3, 3>(0, column).diagonal() = chains.A[0][j].template head<3>();
    F.template block<3, 3>(3, column + 3) = J * chains.A[0][j].template tail<3>().asDiagonal();
  }
  Rows FP;
  FP.noalias() = F.lazyProduct(state.P);
  Matrix6 covariance;
  covariance.noalias() = FP.lazyProduct(F.transpose());
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  covariance.diagonal() += chains.Q[0][0];
  return covariance;
}

}  // namespace detail

template <int Order>
[[nodiscard]] StatePrediction predict_state(const TargetState<Order>& state, const ProcessModel<Order>& model,
                                            HostTime t, const StatePredictionLimits& limits = {}) {
  HOLDFAST_ASSERT(!model.problem(), "bad process model");
  const double asked = detail::seconds_between(state.t, t), future = std::max(0.0, to_seconds(limits.future));
  if (!state.is_finite()) return {detail::held(pose_estimate(state), t, PredictionStatus::not_finite, {}), {}};
  if (asked < 0.0 && asked < -to_seconds(limits.past)) {
    return {detail::held(pose_estimate(state), t, PredictionStatus::backwards, {}), {}};
  }
  const detail::SixChains<Order> chains = detail::chains_over(model, asked);
  std::array<Vector6, Order> movement = detail::nominal_movement(state, chains);
  const Vector6 whole = movement[0];
  if (!(whole.squaredNorm() < std::numeric_limits<double>::max())) {
    PoseEstimate still = pose_estimate(state);
    still.velocity.reset();
    return {detail::held(still, t, PredictionStatus::not_finite, {}), {}};
  }
  StatePrediction result;
  result.t = t;
  result.covariance = detail::pose_covariance_after(state, chains, whole.template tail<3>());
  if (asked > future) {  // held there: what the model says of the rest is an error
    movement = detail::nominal_movement(state, detail::chains_over(model, future));
    const Vector6 missed = whole - movement[0];
    result.covariance += missed * missed.transpose();
    result.status = PredictionStatus::clamped;
  } else if constexpr (Order >= 2) {
    result.velocity = Twist{movement[1].template head<3>(), movement[1].template tail<3>()};
  }
  result.interval = from_seconds(std::min(asked, future));
  result.X_WB = Rigid(state.X_WB.q() * so3::exp<double>(movement[0].template tail<3>()),
                      state.X_WB.p() + movement[0].template head<3>());
  return result;
}

}  // namespace holdfast

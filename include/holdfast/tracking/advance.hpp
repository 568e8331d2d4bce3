/// The time update: carries a state and its covariance on to a later time (002 step a, eq. 4.14).
///
///   p + v dt + a dt^2 / 2,   R exp(w dt + alpha dt^2 / 2),   P <- F P F^T + Q
/// with each axis's chain from process_model.hpp (eqs 4.5, 4.7 for PV). Small turns are about the body's axes, which turn
/// meanwhile: F carries dphi by exp(-w dt), and dw by the right Jacobian, so that the covariance is right at low rates too.
/// Bad input: precondition t >= state.t.
#pragma once

#include <algorithm>
#include <cmath>

#include <holdfast/tracking/process_model.hpp>
#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

namespace detail {

/// A chain whose last number decays, in closed form: e = exp(-decay dt), u = decay dt.
template <int Order>
[[nodiscard]] ChainStep<Order> decaying_chain_step(double intensity, double decay, double dt) {
  // Response of the chain's numbers at time s to a unit kick of the last one; Q integrates its outer product.
  const auto response = [&](double s) {
    VectorOf<double, Order> r;
    const double u = decay * s;
    r[Order - 1] = std::exp(-u);
    if constexpr (Order >= 2) r[Order - 2] = -std::expm1(-u) / decay;
    if constexpr (Order >= 3) {
      r[0] = (u < 1e-3 ? 0.5 * s * s * (1.0 - u / 3.0 * (1.0 - u / 4.0)) : (u + std::expm1(-u)) / (decay * decay));
    }
    return r;
  };
  ChainStep<Order> step;
  for (int i = 0; i + 1 < Order; ++i) {
    for (int j = i + 1; j + 1 < Order; ++j) step.A(i, j) = dt;
  }
  step.A.col(Order - 1) = response(dt);
  // Gauss and Legendre's five points on pieces of at most one decay time: exact to 1e-12 there.
  static constexpr double nodes[5] = {-0.906179845938664, -0.538469310105683, 0.0, 0.538469310105683,
                                      0.906179845938664};
  static constexpr double weights[5] = {0.236926885056189, 0.478628670499366, 0.568888888888889, 0.478628670499366,
                                        0.236926885056189};
  const int pieces = static_cast<int>(std::min(64.0, std::ceil(decay * dt)));
  const double width = dt / std::max(pieces, 1);
  for (int piece = 0; piece < pieces; ++piece) {
    for (int k = 0; k < 5; ++k) {
      const VectorOf<double, Order> r = response((piece + 0.5 * (1.0 + nodes[k])) * width);
      step.Q += 0.5 * width * weights[k] * intensity * r * r.transpose();
    }
  }
  return step;
}

}  // namespace detail

/// One axis's chain over dt >= 0 seconds.
template <int Order>
[[nodiscard]] ChainStep<Order> chain_step(double intensity, double decay, double dt) {
  ChainStep<Order> step;
  if (decay > 0.0) return detail::decaying_chain_step<Order>(intensity, decay, dt);
  const double q = intensity * dt;
  if constexpr (Order == 1) {
    step.Q << q;
  } else if constexpr (Order == 2) {
    step.A << 1.0, dt, 0.0, 1.0;
    step.Q << q * dt * dt / 3.0, q * dt / 2.0, q * dt / 2.0, q;
  } else {
    const double dt2 = dt * dt;
    step.A << 1.0, dt, 0.5 * dt2, 0.0, 1.0, dt, 0.0, 0.0, 1.0;
    step.Q << q * dt2 * dt2 / 20.0, q * dt2 * dt / 8.0, q * dt2 / 6.0,  //
        q * dt2 * dt / 8.0, q * dt2 / 3.0, q * dt / 2.0,                //
        q * dt2 / 6.0, q * dt / 2.0, q;
  }
  return step;
}

template <int Order>
void advance(TargetState<Order>& state, const ProcessModel<Order>& model, HostTime t) {
  const double dt = to_seconds(t - state.t);
  HOLDFAST_ASSERT(dt >= 0.0, "a state is carried forward only");
  using Covariance = typename TargetState<Order>::Covariance;
  Covariance F = Covariance::Identity();
  Covariance Q = Covariance::Zero();
  for (int axis = 0; axis < 6; ++axis) {
    const ChainStep<Order> step = chain_step<Order>(model.intensity[axis], model.decay[axis], dt);
    for (int i = 0; i < Order; ++i) {
      for (int j = 0; j < Order; ++j) {
        F(axis + 6 * i, axis + 6 * j) = step.A(i, j);
        Q(axis + 6 * i, axis + 6 * j) = step.Q(i, j);
      }
    }
  }
  typename TargetState<Order>::Error movement = TargetState<Order>::Error::Zero();  // by the chains, from rest at zero
  if constexpr (Order >= 2) movement.template segment<6>(6) << state.velocity.v_WB, state.velocity.w_WB_B;
  if constexpr (Order >= 3) movement.template segment<6>(12) << state.acceleration.a_WB, state.acceleration.alpha_WB_B;
  movement = F * movement;
  const Vector3 turn = movement.template segment<3>(3);
  F.template middleRows<3>(3) = so3::right_jacobian<double>(turn) * F.template middleRows<3>(3);
  F.template block<3, 3>(3, 3) = so3::exp<double>(-turn).toRotationMatrix();

  state.P = F * state.P * F.transpose() + Q;
  state.P = (0.5 * (state.P + state.P.transpose())).eval();
  state.X_WB = Rigid(state.X_WB.q() * so3::exp<double>(turn), state.X_WB.p() + movement.template head<3>());
  if constexpr (Order >= 2) {
    state.velocity.v_WB = movement.template segment<3>(6);
    state.velocity.w_WB_B = movement.template segment<3>(9);
  }
  if constexpr (Order >= 3) {
    state.acceleration.a_WB = movement.template segment<3>(12);
    state.acceleration.alpha_WB_B = movement.template segment<3>(15);
  }
  state.t = t;
}

}  // namespace holdfast

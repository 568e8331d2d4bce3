/// One axis's chain of integrators over a time step dt: x(t + dt) = A x(t) + noise of covariance Q.
///
/// Without decay these are 002's eqs 4.5 and 4.7, and their counterparts of orders 1 and 3. With decay, the closed forms
/// of a damped velocity and of Singer's model (R. Singer, Estimating optimal tracking filter performance for manned
/// maneuvering targets, 1970, appendix), which tend to the former for small steps, and for long ones to a last number that
/// has forgotten where it began: variance intensity / (2 decay).
/// Accuracy: relative 1e-11 in every number, for any dt >= 0 and any decay >= 0.
#pragma once

#include <array>
#include <cmath>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

template <int Order>
struct ChainStep {
  MatrixOf<double, Order> A = MatrixOf<double, Order>::Identity();
  MatrixOf<double, Order> Q = MatrixOf<double, Order>::Zero();
};

namespace detail {

/// n! times the n-fold integral of exp(-s) over [0, u], divided by u^n: 1 at u = 0.
[[nodiscard]] inline double decayed_power(int n, double u) {
  if (u < 1.0) {  // 1 - u/(n+1) (1 - u/(n+2) (1 - ...)), where the closed forms cancel
    double sum = 1.0;
    for (int k = n + 18; k > n; --k) sum = 1.0 - u / k * sum;
    return sum;
  }
  if (n == 0) return std::exp(-u);
  if (n == 1) return -std::expm1(-u) / u;
  return 2.0 * (u + std::expm1(-u)) / (u * u);
}

/// The chain's numbers at time s after a unit kick of the last one.
template <int Order>
[[nodiscard]] VectorOf<double, Order> kick_response(double decay, double s) {
  VectorOf<double, Order> response;
  const double u = decay * s;
  response[Order - 1] = decayed_power(0, u);
  if constexpr (Order >= 2) response[Order - 2] = s * decayed_power(1, u);
  if constexpr (Order >= 3) response[Order - 3] = 0.5 * s * s * decayed_power(2, u);
  return response;
}

/// Q of unit intensity: the integral of the kick response's outer product. Gauss and Legendre's seven points while
/// decay dt <= 1, where they are exact to rounding.
template <int Order>
[[nodiscard]] MatrixOf<double, Order> decaying_noise_by_points(double decay, double dt) {
  constexpr std::array<double, 7> nodes{-0.949107912342758525, -0.741531185599394440, -0.405845151377397167, 0.0,
                                        0.405845151377397167,  0.741531185599394440,  0.949107912342758525};
  constexpr std::array<double, 7> weights{0.129484966168869693, 0.279705391489276668, 0.381830050505118945,
                                          0.417959183673469388, 0.381830050505118945, 0.279705391489276668,
                                          0.129484966168869693};
  MatrixOf<double, Order> Q = MatrixOf<double, Order>::Zero();
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const VectorOf<double, Order> response = kick_response<Order>(decay, 0.5 * dt * (1.0 + nodes[k]));
    Q += 0.5 * dt * weights[k] * response * response.transpose();
  }
  return Q;
}

/// The same in closed form, for decay dt > 1, where nothing cancels.
template <int Order>
[[nodiscard]] MatrixOf<double, Order> decaying_noise_closed(double decay, double dt) {
  const double u = decay * dt;
  const double e = std::exp(-u);
  const double e2 = e * e;
  const double to_2 = decay * decay;
  MatrixOf<double, Order> Q;
  Q(Order - 1, Order - 1) = (1.0 - e2) / (2.0 * decay);
  if constexpr (Order >= 2) {
    Q(Order - 2, Order - 1) = Q(Order - 1, Order - 2) = (1.0 - e) * (1.0 - e) / (2.0 * to_2);
    Q(Order - 2, Order - 2) = (2.0 * u - 3.0 + 4.0 * e - e2) / (2.0 * to_2 * decay);
  }
  if constexpr (Order >= 3) {
    Q(0, 2) = Q(2, 0) = (1.0 - e2 - 2.0 * u * e) / (2.0 * to_2 * decay);
    Q(0, 1) = Q(1, 0) = (1.0 - u - e) * (1.0 - u - e) / (2.0 * to_2 * to_2);
    Q(0, 0) = (1.0 - e2 + 2.0 * u - 2.0 * u * u + u * u * u / 1.5 - 4.0 * u * e) / (2.0 * to_2 * to_2 * decay);
  }
  return Q;
}

}  // namespace detail

/// A chain of the given noise intensity and decay (process_model.hpp) over dt >= 0 seconds.
template <int Order>
[[nodiscard]] ChainStep<Order> chain_step(double intensity, double decay, double dt) {
  ChainStep<Order> step;
  const double q = intensity * dt;
  if (Order >= 2 && decay > 0.0) {
    if constexpr (Order >= 3) step.A(0, 1) = dt;
    step.A.col(Order - 1) = detail::kick_response<Order>(decay, dt);
    step.Q = intensity * (decay * dt <= 1.0 ? detail::decaying_noise_by_points<Order>(decay, dt)
                                            : detail::decaying_noise_closed<Order>(decay, dt));
  } else if constexpr (Order == 1) {
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

}  // namespace holdfast

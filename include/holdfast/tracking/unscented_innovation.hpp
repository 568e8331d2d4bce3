/// The same innovation as innovation.hpp's, found by sigma points in place of Jacobians (002 section 7.4; Julier and
/// Uhlmann 1997; scaled, Julier 2002). `correct` takes it unchanged.
///
/// The augmented error is x = (d of the target, d_b of the source, d_c of the sensor), of n numbers that the measurement
/// depends on, with covariance L L^T. Its mean and the 2 n points +- s L_j go through the measurement; with e_i the change
/// of the residual at point i against that at the mean, and w = 1 / (2 s^2),
///   m = w sum e_i,   y = y_0 + m,   S = w sum e_i e_i^T + c m m^T + R,   C = -w sum x_i e_i^T
/// In the names of the scaled transform alpha = s / sqrt(n), kappa = 0, c = beta - alpha^2: written like this no weight is
/// negative, and S is positive definite for all c >= 0 and n. s = sqrt(2) with c = 0 gives a parabola along any of the axes
/// its right mean and variance. (The usual s = sqrt(3) is right for its fourth moment, but needs a c that depends on how
/// many axes are curved, and may be negative.) What a measurement does not depend on (velocities, of a pose) moves along
/// with the points by its covariance, and costs none.
/// Equal to extended_innovation when the measurement is linear.
/// Bad input: nothing is answered when the measurement is none at any one of the points (a beacon that they put
/// behind the camera), a covariance is not positive semidefinite, or a number is not finite.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include <holdfast/tracking/innovation.hpp>

namespace holdfast {

struct SigmaPoints {
  double spread = 1.4142135623730951;  ///< s, in standard deviations
  double centre = 0.0;                 ///< c = beta - alpha^2, not negative
};

namespace detail {

/// The first `Columns` columns of the lower triangle L with L L^T = P, for a positive semidefinite P: what is known exactly
/// gives a column of zeros. False when P is not that, or not finite.
template <int Size, int Columns>
[[nodiscard]] bool semidefinite_root(const MatrixOf<double, Size>& P, MatrixOf<double, Size, Columns>& L) {
  L.setZero();
  for (int j = 0; j < Columns; ++j) {
    const double rest = P(j, j) - L.row(j).head(j).squaredNorm();
    const double rounding = 1e-13 * P(j, j);  // of a sum of up to 18 squares
    if (!std::isfinite(P(j, j)) || !(rest >= -rounding)) return false;
    if (rest <= rounding) continue;
    L(j, j) = std::sqrt(rest);
    for (int i = j + 1; i < Size; ++i) {
      L(i, j) = (P(i, j) - L.row(i).head(j).dot(L.row(j).head(j))) / L(j, j);
    }
  }
  return L.allFinite();
}

/// Sums over the sigma points of one part of the augmented error.
template <int Size>
struct SigmaSums {
  VectorOf<double, Size> first = VectorOf<double, Size>::Zero();
  MatrixOf<double, Size> second = MatrixOf<double, Size>::Zero();

  void add(const VectorOf<double, Size>& e) {
    first += e;
    second.noalias() += e * e.transpose();
  }
};

/// Sends +- s root.col(j) through `residual_at(x, y)` for all columns but those of zeros; false when one of them has no
/// residual. The cross-covariance -w sum x e^T goes to C.
template <int Rows, int Columns, int Size, typename ResidualAt>
[[nodiscard]] bool send_sigma_points(const MatrixOf<double, Rows, Columns>& root, const SigmaPoints& points,
                                     const VectorOf<double, Size>& centre, const ResidualAt& residual_at,
                                     SigmaSums<Size>& sums, MatrixOf<double, Rows, Size>& C) {
  C.setZero();
  for (int j = 0; j < Columns; ++j) {
    const VectorOf<double, Rows> x = points.spread * root.col(j);
    if (x.isZero(0.0)) continue;
    VectorOf<double, Size> above, below;
    if (!residual_at(x, above) || !residual_at(VectorOf<double, Rows>(-x), below)) return false;
    above -= centre;
    below -= centre;
    sums.add(above);
    sums.add(below);
    C.noalias() += x * (below - above).transpose();
  }
  C *= 0.5 / (points.spread * points.spread);
  return true;
}

/// The same for a device; what of its variance is never learnt widens S alone.
template <int Rows, int Size, typename ResidualAt>
[[nodiscard]] bool send_device(const DeviceEstimate<Rows>& device, const SigmaPoints& points,
                               const VectorOf<double, Size>& centre, const ResidualAt& residual_at,
                               SigmaSums<Size>& sums, MatrixOf<double, Rows, Size>& C) {
  if constexpr (Rows > 0) {
    MatrixOf<double, Rows> root;
    if (!semidefinite_root(device.P, root)) return false;
    const VectorOf<double, Rows> unlearnt = device.residual_variance.cwiseSqrt();
    const MatrixOf<double, Rows> unlearnt_root = unlearnt.asDiagonal();
    return send_sigma_points(unlearnt_root, points, centre, residual_at, sums, C) &&
           send_sigma_points(root, points, centre, residual_at, sums, C);  // C anew
  }
  return true;
}

}  // namespace detail

template <int Order, Measurement M>
[[nodiscard]] std::optional<Innovation<Order, M>> unscented_innovation(
    const TargetState<Order>& state, const M& measurement, const DeviceEstimate<M::source_size>& source,
    const DeviceEstimate<M::sensor_size>& sensor = {}, const SigmaPoints& points = {}) {
  static_assert(M::state_size <= 6 * Order, "the filter keeps too few derivatives for this measurement");
  using Residual = VectorOf<double, M::size>;
  std::optional<Innovation<Order, M>> answer;
  Linearization<M> linear;
  const auto measure = [&](const TargetState<Order>& at, const auto& source_x, const auto& sensor_x, Residual& y) {
    if (!measurement.linearize(at, source_x, sensor_x, linear)) return false;
    y = linear.residual;
    return true;
  };
  Residual centre;
  if (!measure(state, source.x, sensor.x, centre) || !detail::is_noise<M::size>(linear.R)) return answer;
  Innovation<Order, M>& innovation = answer.emplace();
  innovation.S = linear.R;

  TargetState<Order> moved = state;
  const auto by_state = [&](const typename TargetState<Order>::Error& d, Residual& y) {
    moved.X_WB = state.X_WB;
    moved.velocity = state.velocity;
    moved.acceleration = state.acceleration;
    moved.add(d);
    return measure(moved, source.x, sensor.x, y);
  };
  const auto by_source = [&](const DeviceParameters<M::source_size>& d, Residual& y) {
    return measure(state, DeviceParameters<M::source_size>(source.x + d), sensor.x, y);
  };
  const auto by_sensor = [&](const DeviceParameters<M::sensor_size>& d, Residual& y) {
    return measure(state, source.x, DeviceParameters<M::sensor_size>(sensor.x + d), y);
  };
  detail::SigmaSums<M::size> sums;
  MatrixOf<double, 6 * Order, M::state_size> root;
  if (!detail::semidefinite_root(state.P, root) ||
      !detail::send_sigma_points(root, points, centre, by_state, sums, innovation.C) ||
      !detail::send_device(source, points, centre, by_source, sums, innovation.C_source) ||
      !detail::send_device(sensor, points, centre, by_sensor, sums, innovation.C_sensor)) {
    answer.reset();
    return answer;
  }
  const double weight = 0.5 / (points.spread * points.spread);
  const Residual shift = weight * sums.first;
  innovation.residual = centre + shift;
  innovation.S += weight * sums.second + points.centre * shift * shift.transpose();
  innovation.S.diagonal() += rounding_floor * weight * sums.second.diagonal();
  if (!innovation.factorise()) answer.reset();
  return answer;
}

}  // namespace holdfast

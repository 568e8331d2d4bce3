/// One measurement against what the filter expects: the step between predicting and correcting, where gates decide.
///
///   extended_innovation   linearises the measurement at the state (002 steps b to d, eqs 4.15, 4.16, 4.19)
///   correct               corrects state and devices by it (steps e to g, eqs 4.20 to 4.22, 4.28)
/// With y the residual, S its covariance, C the covariance of the error with the predicted measurement:
///   S = H P H^T + H_b P_b H_b^T + H_c P_c H_c^T + R,   C = P H^T,   K = C S^-1,   d = K y,   P <- P - K S K^T,
/// and alike for each device with C_b = P_b H_b^T. Errors of the target and of devices are taken for uncorrelated, as in
/// 002 eq. 4.25: what the augmented filter would learn of their correlation is dropped after each step. A device's
/// residual_variance is part of P_b in S, but not in C_b.
/// An unscented filter differs only in how y, S and C are found (unscented_innovation.hpp): it fills them and calls
/// `factorise`.
///
/// Numerics: with S = L L^T and G = C L^-T, found by substitution, P loses G G^T. The computed P, C and S belong to a
/// covariance of state and measurement together that is off by rounding, about 1e-14 of the terms that were summed; so
/// each variance in P and S is raised by 1e-12 of those (rounding_floor). What is left of P is then a Schur complement of
/// something positive definite: P stays positive definite, and it is exactly symmetric, whatever is measured, in any
/// order, however exact it claims to be.
/// Bad input: nothing is answered when the state cannot give such a measurement, a number is not finite, or R is no
/// covariance; `correct` then has nothing to work on, and state and devices stay as they were.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/tracking/advance.hpp>
#include <holdfast/tracking/device_estimate.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

namespace detail {

/// X L^-T, each row by forward substitution.
template <int Rows, int Size>
[[nodiscard]] MatrixOf<double, Rows, Size> substituted(const MatrixOf<double, Rows, Size>& X,
                                                       const MatrixOf<double, Size>& L) {
  MatrixOf<double, Rows, Size> G;
  for (int k = 0; k < Size; ++k) {
    const double scale = 1.0 / L(k, k);
    G.col(k) = scale * X.col(k);
    for (int j = 0; j < k; ++j) G.col(k) -= (scale * L(k, j)) * G.col(j);
  }
  return G;
}

/// P - G G^T with the floor, from P's lower triangle, exactly symmetric.
template <int Rows, int Size>
void downdate(MatrixOf<double, Rows>& P, const MatrixOf<double, Rows, Size>& G) {
  P.diagonal() *= 1.0 + rounding_floor;
  unrolled<Rows>([&]<int j>(std::integral_constant<int, j>) {
    constexpr int height = Rows - j / 2 * 2;  // pairs of rows
    const VectorOf<double, Size> g = G.row(j).transpose();
    P.col(j).template tail<height>() -= G.template bottomRows<height>().lazyProduct(g);
  });
  mirror_lower<Rows>(P);
}

/// Whether R may be a covariance: no variance below zero, no covariance above what variances allow.
template <int Size>
[[nodiscard]] bool is_noise(const MatrixOf<double, Size>& R) {
  bool coupled = false;
  for (int i = 0; i < Size; ++i) {
    if (!(R(i, i) >= 0.0)) return false;
    for (int j = 0; j < i; ++j) {
      if (!(R(i, j) * R(i, j) <= R(i, i) * R(j, j))) return false;
      coupled = coupled || R(i, j) != 0.0;
    }
  }
  if (Size <= 2 || !coupled) return true;
  MatrixOf<double, Size> raised = R;  // may be singular: by a little more than rounding
  for (int i = 0; i < Size; ++i) raised(i, i) = R(i, i) > 0.0 ? R(i, i) * (1.0 + rounding_floor) : 1.0;
  MatrixOf<double, Size> L;
  return cholesky<Size>(raised, L);
}

/// Adds H C, where C = P H^T, to S; and the floor of what its diagonal is summed from.
template <int Size, typename Jacobian, typename Covariances, typename Variances>
void add_to_innovation(MatrixOf<double, Size>& S, const Jacobian& H, const Covariances& C, const Variances& variances) {
  MatrixOf<double, Size> sum = S;
  VectorOf<double, Size> floor = VectorOf<double, Size>::Zero();
  unrolled<Jacobian::ColsAtCompileTime>([&]<int j>(std::integral_constant<int, j>) {
    const VectorOf<double, Size> h = H.col(j);
    for (int k = 0; k < Size; ++k) sum.col(k) += C(j, k) * h;
    floor += variances[j] * h.cwiseAbs2();
  });
  S = sum;
  S.diagonal() += rounding_floor * floor;
}

}  // namespace detail

template <int Order, typename M>
struct Innovation {
  VectorOf<double, M::size> residual;      ///< y
  MatrixOf<double, M::size> S;             ///< covariance of y
  MatrixOf<double, M::size> L;             ///< its Cholesky factor, by `factorise`
  MatrixOf<double, 6 * Order, M::size> C;  ///< covariance of the target's error with the measurement
  MatrixOf<double, M::source_size, M::size> C_source;
  MatrixOf<double, M::sensor_size, M::size> C_sensor;
  VectorOf<double, M::size> whitened_residual;  ///< L^-1 y, by `factorise`

  Innovation() {}  // numbers are filled in, not zeroed first

  /// Makes L of S's lower triangle, and S symmetric; false when S is no covariance or the residual not finite.
  [[nodiscard]] bool factorise() {
    if (!cholesky<M::size>(S, L)) return false;
    for (int j = 0; j < M::size; ++j) {
      for (int i = j + 1; i < M::size; ++i) S(j, i) = S(i, j);
    }
    whitened_residual = detail::substituted<1, M::size>(residual.transpose(), L).transpose();
    return nis() < std::numeric_limits<double>::max();
  }

  /// L^-1 y: independent, each of variance 1 when all is as modelled.
  [[nodiscard]] const VectorOf<double, M::size>& whitened() const { return whitened_residual; }

  /// Normalised innovation squared, y^T S^-1 y: chi-square with `size` degrees of freedom when all is as modelled.
  [[nodiscard]] double nis() const { return whitened().squaredNorm(); }

  /// Logarithm of the measurement's probability density at what was measured.
  [[nodiscard]] double log_likelihood() const {
    return -0.5 * (nis() + M::size * std::log(2.0 * std::numbers::pi)) - L.diagonal().array().log().sum();
  }
};

namespace detail {

/// A device whose error has nothing to do with the others': its C, and its share of S.
template <int DeviceSize, int Size>
void add_device(const DeviceEstimate<DeviceSize>& device, const MatrixOf<double, Size, DeviceSize>& H,
                MatrixOf<double, DeviceSize, Size>& C, MatrixOf<double, Size>& S) {
  if constexpr (DeviceSize > 0) {
    C = device.P.lazyProduct(H.transpose());
    const MatrixOf<double, DeviceSize, Size> C_with_rest = C + device.residual_variance.asDiagonal() * H.transpose();
    add_to_innovation(S, H, C_with_rest, device.P.diagonal());
  }
}

/// extended_innovation in place; false when there is none.
template <int Order, Measurement M>
[[nodiscard]] bool fill_innovation(const TargetState<Order>& state, const M& measurement,
                                   const DeviceEstimate<M::source_size>& source,
                                   const DeviceEstimate<M::sensor_size>& sensor, Innovation<Order, M>& innovation) {
  Linearization<M> linear;
  if (!measurement.linearize(state, source.x, sensor.x, linear) || !is_noise<M::size>(linear.R)) return false;
  innovation.residual = linear.residual;
  innovation.S = linear.R;
  unrolled<M::size>([&]<int k>(std::integral_constant<int, k>) {
    const VectorOf<double, M::state_size> h = linear.H.row(k).transpose();
    innovation.C.col(k) = state.P.template leftCols<M::state_size>().lazyProduct(h);
  });
  add_to_innovation(innovation.S, linear.H, innovation.C.template topRows<M::state_size>(),
                    state.P.diagonal().template head<M::state_size>());
  add_device(source, linear.H_source, innovation.C_source, innovation.S);
  add_device(sensor, linear.H_sensor, innovation.C_sensor, innovation.S);
  return innovation.factorise();
}

}  // namespace detail

template <int Order, Measurement M>
[[nodiscard]] std::optional<Innovation<Order, M>> extended_innovation(
    const TargetState<Order>& state, const M& measurement, const DeviceEstimate<M::source_size>& source,
    const DeviceEstimate<M::sensor_size>& sensor = {}) {
  static_assert(M::state_size <= 6 * Order, "the filter keeps too few derivatives for this measurement");
  std::optional<Innovation<Order, M>> answer(std::in_place);
  if (!detail::fill_innovation(state, measurement, source, sensor, *answer)) answer.reset();
  return answer;
}

namespace detail {

/// Corrects a device unless it is locked. Devices of size 0 are left alone.
template <int DeviceSize, typename Innovation>
void correct_device(DeviceEstimate<DeviceSize>& device, const auto& C, const Innovation& innovation) {
  if constexpr (DeviceSize > 0) {
    if (device.locked) return;
    constexpr int size = std::decay_t<decltype(C)>::ColsAtCompileTime;
    const MatrixOf<double, DeviceSize, size> G = substituted<DeviceSize, size>(C, innovation.L);
    device.x.noalias() += G * innovation.whitened();
    downdate<DeviceSize, size>(device.P, G);
  }
}

}  // namespace detail

/// Corrects the state, and the devices that are not locked. Devices of size 0 are left alone. False, and nothing is
/// changed, when a correction is so large that numbers would soon overflow: `largest_correction` in the state's units.
inline constexpr double largest_correction = 1e12;

template <int Order, typename M>
bool correct(TargetState<Order>& state, const Innovation<Order, M>& innovation, DeviceEstimate<M::source_size>& source,
             DeviceEstimate<M::sensor_size>& sensor) {
  const MatrixOf<double, 6 * Order, M::size> G = detail::substituted<6 * Order, M::size>(innovation.C, innovation.L);
  const VectorOf<double, M::size> whitened = innovation.whitened();
  const typename TargetState<Order>::Error d = G.lazyProduct(whitened);
  if (!(d.squaredNorm() < largest_correction * largest_correction)) return false;
  detail::downdate<6 * Order, M::size>(state.P, G);
  state.add(d);
  detail::correct_device(source, innovation.C_source, innovation);
  detail::correct_device(sensor, innovation.C_sensor, innovation);
  return true;
}

}  // namespace holdfast

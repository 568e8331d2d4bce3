/// One measurement against what the filter expects: the step between predicting and correcting, where gates decide.
///
///   extended_innovation   linearises the measurement at the state (002 steps b to d, eqs 4.15, 4.16, 4.19)
///   correct               corrects state and devices by it (steps e to g, eqs 4.20 to 4.22, 4.28)
/// With y the residual, S its covariance, C the covariance of the error with the predicted measurement:
///   S = H P H^T + H_b P_b H_b^T + H_c P_c H_c^T + R,   C = P H^T,   K = C S^-1,   d = K y,   P <- P - K S K^T,
/// and alike for each device with C_b = P_b H_b^T. Errors of the target and of devices are taken for uncorrelated, as in
/// 002 eq. 4.25: what the augmented filter would learn of their correlation is dropped after each step.
/// An unscented filter differs only in how y, S and C are found (unscented_innovation.hpp).
/// Numerics: P stays exactly symmetric. S is refused when it has no positive inverse.
/// Bad input: nothing is answered when the state cannot give such a measurement, or a number is not finite; `correct`
/// then has nothing to work on, and state and devices stay as they were.
#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include <holdfast/tracking/device_estimate.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

namespace detail {

/// S^-1 of a symmetric positive definite S, in closed form for sizes 1 and 2; false when it is none.
template <int Size>
[[nodiscard]] bool invert_positive(const MatrixOf<double, Size>& S, MatrixOf<double, Size>& S_inverse) {
  if constexpr (Size == 1) {
    if (!(S(0, 0) > 0.0)) return false;
    S_inverse(0, 0) = 1.0 / S(0, 0);
  } else if constexpr (Size == 2) {
    const double determinant = S(0, 0) * S(1, 1) - S(1, 0) * S(1, 0);
    if (!(S(0, 0) > 0.0 && determinant > 0.0)) return false;
    const double k = 1.0 / determinant;
    S_inverse << k * S(1, 1), -k * S(1, 0), -k * S(1, 0), k * S(0, 0);
  } else {
    const Eigen::LLT<MatrixOf<double, Size>> cholesky(S);
    if (cholesky.info() != Eigen::Success) return false;
    S_inverse = cholesky.solve(MatrixOf<double, Size>::Identity());
  }
  return S_inverse.allFinite();
}

/// P - C S^-1 C^T, exactly symmetric.
template <int Rows, int Size>
void downdate(MatrixOf<double, Rows>& P, const MatrixOf<double, Rows, Size>& C,
              const MatrixOf<double, Size>& S_inverse) {
  const MatrixOf<double, Rows, Size> K = C * S_inverse;
  for (int j = 0; j < Rows; ++j) {
    for (int i = j; i < Rows; ++i) {
      double sum = 0.0;
      for (int k = 0; k < Size; ++k) sum += K(i, k) * C(j, k);
      P(i, j) -= sum;
      P(j, i) = P(i, j);
    }
  }
}

}  // namespace detail

template <int Order, typename M>
struct Innovation {
  VectorOf<double, M::size> residual;  ///< y
  MatrixOf<double, M::size> S;         ///< covariance of y
  MatrixOf<double, M::size> S_inverse;
  MatrixOf<double, 6 * Order, M::size> C;  ///< covariance of the target's error with the measurement
  MatrixOf<double, M::source_size, M::size> C_source;
  MatrixOf<double, M::sensor_size, M::size> C_sensor;

  /// Normalised innovation squared, y^T S^-1 y: chi-square with `size` degrees of freedom when all is as modelled.
  [[nodiscard]] double nis() const { return residual.dot(S_inverse * residual); }
};

template <int Order, Measurement M>
[[nodiscard]] std::optional<Innovation<Order, M>> extended_innovation(
    const TargetState<Order>& state, const M& measurement, const DeviceEstimate<M::source_size>& source,
    const DeviceEstimate<M::sensor_size>& sensor = {}) {
  static_assert(M::state_size <= 6 * Order, "the filter keeps too few derivatives for this measurement");
  Linearization<M> linear;
  if (!measurement.linearize(state, source.x, sensor.x, linear)) return std::nullopt;
  Innovation<Order, M> innovation;
  innovation.residual = linear.residual;
  innovation.C.noalias() = state.P.template leftCols<M::state_size>() * linear.H.transpose();
  innovation.S = linear.R;
  innovation.S.noalias() += linear.H * innovation.C.template topRows<M::state_size>();
  if constexpr (M::source_size > 0) {
    innovation.C_source.noalias() = source.P * linear.H_source.transpose();
    innovation.S.noalias() += linear.H_source * innovation.C_source;
  }
  if constexpr (M::sensor_size > 0) {
    innovation.C_sensor.noalias() = sensor.P * linear.H_sensor.transpose();
    innovation.S.noalias() += linear.H_sensor * innovation.C_sensor;
  }
  if (!detail::invert_positive<M::size>(innovation.S, innovation.S_inverse)) return std::nullopt;
  if (!innovation.residual.allFinite()) return std::nullopt;
  return innovation;
}

/// Corrects the state, and the devices that are not locked. Devices of size 0 are left alone.
template <int Order, typename M>
void correct(TargetState<Order>& state, const Innovation<Order, M>& innovation, DeviceEstimate<M::source_size>& source,
             DeviceEstimate<M::sensor_size>& sensor) {
  const VectorOf<double, M::size> weighted = innovation.S_inverse * innovation.residual;
  const typename TargetState<Order>::Error d = innovation.C * weighted;
  detail::downdate<6 * Order, M::size>(state.P, innovation.C, innovation.S_inverse);
  state.add(d);
  const auto correct_device = [&](auto& device, const auto& C) {
    constexpr int size = std::decay_t<decltype(device)>::size;
    if constexpr (size > 0) {
      if (device.locked) return;
      device.x.noalias() += C * weighted;
      detail::downdate<size, M::size>(device.P, C, innovation.S_inverse);
    }
  };
  correct_device(source, innovation.C_source);
  correct_device(sensor, innovation.C_sensor);
}

}  // namespace holdfast

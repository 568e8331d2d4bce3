/// What a filter asks of a measurement: its residual, its Jacobians and its noise at a state.
///
/// A measurement is a small type that holds what was measured and the geometry of the sensor. It satisfies
/// `Measurement`:
///   size          m, how many numbers were measured (002's m_sigma)
///   state_size    how many leading numbers of the error state it depends on: 6 pose, 12 with velocities, 18 with
///                 accelerations (target_state.hpp); a filter of lower order cannot take it
///   source_size   parameters of the source (002's b: a beacon's position, a range's bias) that can be calibrated, or 0
///   sensor_size   the same of the sensor (002's c)
///   linearize     fills a Linearization at a state and parameters; false when the state cannot give such a measurement (a
///                 beacon behind the camera, two points that coincide, numbers that are not finite)
/// In the residual z - h(x), angles are wrapped and rotations are logarithms, so it is a plain vector. Jacobians are
/// derivatives of h by the error: z - h(x + d) = residual - H d - H_source d_b - H_sensor d_c (002 eqs 4.10-4.12).
#pragma once

#include <concepts>

#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

template <int Size, int StateSize, int SourceSize, int SensorSize>
struct LinearizationOf {
  VectorOf<double, Size> residual;
  MatrixOf<double, Size, StateSize> H;
  MatrixOf<double, Size, SourceSize> H_source;
  MatrixOf<double, Size, SensorSize> H_sensor;
  MatrixOf<double, Size> R;  ///< covariance of the measurement's own noise (002's R_sigma)
};

template <typename M>
using Linearization = LinearizationOf<M::size, M::state_size, M::source_size, M::sensor_size>;

/// Parameters of a source or sensor, as a measurement takes them.
template <int Size>
using DeviceParameters = VectorOf<double, Size>;

template <typename M>
concept Measurement = requires(const M& measurement, const TargetState<M::state_size / 6>& state,
                               const DeviceParameters<M::source_size>& source,
                               const DeviceParameters<M::sensor_size>& sensor, Linearization<M>& linear) {
  { M::size } -> std::convertible_to<int>;
  { measurement.linearize(state, source, sensor, linear) } -> std::same_as<bool>;
};

}  // namespace holdfast

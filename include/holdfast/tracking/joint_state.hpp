/// A target and some of its devices in one state, with what their errors have to do with one another.
///
/// 002 keeps a filter for each device and drops its correlation with the target after every step (4.4.2, eq. 4.25). That
/// is small and quick, but a device just learnt from a pose then vouches for that same pose: both wander off together, and
/// are sure of it (the gauge freedom of 5.1.4). Here the error is that of the target (target_state.hpp) followed by those
/// of `Devices` devices with `Size` numbers each, and all of its covariance is kept:
///   P = [ target.P   P_dt^T ]
///       [ P_dt       P_dd   ]
/// An empty slot has zeros. Simultaneous localisation and mapping does so for all devices (Smith, Self and Cheeseman 1990);
/// a few are enough, as correlation fades with the devices that leave (joint_filter.hpp).
///   advance_lower        carries target and P_dt on to a later time; devices stand still
///   joint_innovation     one measurement against what is expected, of a device in a slot or of none there
///   correct              corrects everything by it
///   moment_matched       mean and covariance of a mixture
/// Numerics and bad input: as in innovation.hpp, whose pieces these are.
#pragma once

#include <holdfast/tracking/innovation.hpp>
#include <holdfast/tracking/multiple_models.hpp>

namespace holdfast {

template <int Order, int Size, int Devices>
struct JointState {
  static_assert(Size >= 1 && Devices >= 1);
  static constexpr int target_size = 6 * Order;
  static constexpr int device_numbers = Size * Devices;

  TargetState<Order> target;
  VectorOf<double, device_numbers> x = VectorOf<double, device_numbers>::Zero();
  MatrixOf<double, device_numbers, target_size> P_dt = MatrixOf<double, device_numbers, target_size>::Zero();
  MatrixOf<double, device_numbers> P_dd = MatrixOf<double, device_numbers>::Zero();

  /// What is known of the device in a slot when nothing else is asked.
  [[nodiscard]] DeviceEstimate<Size> device(int slot) const {
    DeviceEstimate<Size> device;
    device.x = x.template segment<Size>(Size * slot);
    device.P = P_dd.template block<Size, Size>(Size * slot, Size * slot);
    return device;
  }

  /// A device that has nothing to do with target and other devices takes a slot.
  void put(int slot, const DeviceEstimate<Size>& device) {
    const int first = Size * slot;
    x.template segment<Size>(first) = device.x;
    P_dt.template middleRows<Size>(first).setZero();
    P_dd.template middleRows<Size>(first).setZero();
    P_dd.template middleCols<Size>(first).setZero();
    P_dd.template block<Size, Size>(first, first) = device.P;
  }
};

template <int Order, int Size, int Devices, typename M>
struct JointInnovation : Innovation<Order, M> {
  MatrixOf<double, Size * Devices, M::size> C_devices;  ///< covariance of the slots' errors with the measurement
};

namespace detail {

/// As downdate (innovation.hpp), for sizes that are too large to unroll. Both triangles are computed, as that is quicker
/// than mirroring one: with fused multiply-add they may differ by rounding.
template <int Rows, int Size>
void downdate_many(MatrixOf<double, Rows>& P, const MatrixOf<double, Rows, Size>& G) {
  P.diagonal() *= 1.0 + rounding_floor;
  for (int j = 0; j < Rows; ++j) {
    const VectorOf<double, Size> g = G.row(j).transpose();
    P.col(j) -= G.lazyProduct(g);
  }
}

template <int Order, int Size, int Devices>
bool advance_lower(const JointState<Order, Size, Devices>& from, const ProcessModel<Order>& model, HostTime t,
                   JointState<Order, Size, Devices>& to) {
  to.x = from.x;
  to.P_dd = from.P_dd;
  return advance_lower(from.target, model, t, to.target, [&](const auto& chains, const auto& turn) {
    carry_rows<Order, Size * Devices>(from.P_dt, chains, turn, to.P_dt);
  });
}

}  // namespace detail

/// Of a source in `slot`, which counts at x and P_dd there, plus its residual variance; or with slot -1 of any source. The
/// sensor is one that has nothing to do with the rest.
template <int Order, int Size, int Devices, Measurement M>
[[nodiscard]] std::optional<JointInnovation<Order, Size, Devices, M>> joint_innovation(
    const JointState<Order, Size, Devices>& state, const M& measurement, int slot,
    const DeviceEstimate<M::source_size>& source, const DeviceEstimate<M::sensor_size>& sensor = {}) {
  static_assert(M::state_size <= 6 * Order, "the filter keeps too few derivatives for this measurement");
  constexpr int pose_or_more = M::state_size;
  Linearization<M> linear;
  if (!measurement.linearize(state.target, source.x, sensor.x, linear)) return std::nullopt;
  if (!detail::is_noise<M::size>(linear.R)) return std::nullopt;
  std::optional<JointInnovation<Order, Size, Devices, M>> answer(std::in_place);
  JointInnovation<Order, Size, Devices, M>& innovation = *answer;
  innovation.residual = linear.residual;
  innovation.S = linear.R;
  const auto H_t = linear.H.transpose();
  innovation.C = state.target.P.template leftCols<pose_or_more>().lazyProduct(H_t);
  innovation.C_devices = state.P_dt.template leftCols<pose_or_more>().lazyProduct(H_t);
  if constexpr (M::source_size == Size) {
    if (slot >= 0) {
      const int first = Size * slot;
      const auto& H_source = linear.H_source;
      innovation.C += state.P_dt.template middleRows<Size>(first).transpose().lazyProduct(H_source.transpose());
      innovation.C_devices += state.P_dd.template middleCols<Size>(first).lazyProduct(H_source.transpose());
      innovation.C_source = innovation.C_devices.template middleRows<Size>(first);
      const MatrixOf<double, Size, M::size> C_with_rest =
          innovation.C_source + source.residual_variance.asDiagonal() * H_source.transpose();
      detail::add_to_innovation(innovation.S, H_source, C_with_rest,
                                state.P_dd.diagonal().template segment<Size>(first));
    }
  }
  if (slot < 0) detail::add_device(source, linear.H_source, innovation.C_source, innovation.S);
  detail::add_device(sensor, linear.H_sensor, innovation.C_sensor, innovation.S);
  detail::add_to_innovation(innovation.S, linear.H, innovation.C.template topRows<pose_or_more>(),
                            state.target.P.diagonal().template head<pose_or_more>());
  if (!innovation.factorise()) answer.reset();
  return answer;
}

/// Corrects target, slots, and devices outside of these that are not locked. False, and nothing is changed, when a
/// correction is larger than `largest_correction`.
template <int Order, int Size, int Devices, typename M>
bool correct(JointState<Order, Size, Devices>& state, const JointInnovation<Order, Size, Devices, M>& innovation,
             DeviceEstimate<M::source_size>& source, DeviceEstimate<M::sensor_size>& sensor) {
  constexpr int numbers = Size * Devices;
  const MatrixOf<double, numbers, M::size> G =
      detail::substituted<numbers, M::size>(innovation.C_devices, innovation.L);
  const VectorOf<double, numbers> d = G.lazyProduct(innovation.whitened());
  if (!(d.squaredNorm() < largest_correction * largest_correction)) return false;
  const Innovation<Order, M>& of_target = innovation;
  if (!correct(state.target, of_target, source, sensor)) return false;
  const MatrixOf<double, 6 * Order, M::size> G_target =
      detail::substituted<6 * Order, M::size>(innovation.C, innovation.L);
  state.x += d;
  state.P_dt -= G.lazyProduct(G_target.transpose());
  detail::downdate_many(state.P_dd, G);
  return true;
}

/// Mean and covariance of a mixture of states of one time, with the same devices in the same slots.
template <int Order, int Size, int Devices, std::size_t Count>
[[nodiscard]] JointState<Order, Size, Devices> moment_matched(
    const std::array<JointState<Order, Size, Devices>, Count>& states, const std::array<double, Count>& weights) {
  using State = JointState<Order, Size, Devices>;
  const std::size_t reference = detail::heaviest(weights);
  State matched = states[reference];
  if (weights[reference] == 1.0) return matched;
  std::array<typename TargetState<Order>::Error, Count> offsets;
  typename TargetState<Order>::Error mean = TargetState<Order>::Error::Zero();
  for (std::size_t i = 0; i < Count; ++i) {
    offsets[i] = matched.target.error_of(states[i].target);
    mean += weights[i] * offsets[i];
    matched.x += weights[i] * (states[i].x - states[reference].x);
  }
  matched.target.P.setZero();
  matched.P_dt.setZero();
  matched.P_dd.setZero();
  for (std::size_t i = 0; i < Count; ++i) {
    const typename TargetState<Order>::Error d = offsets[i] - mean;
    const VectorOf<double, State::device_numbers> d_devices = states[i].x - matched.x;
    matched.target.P += weights[i] * (states[i].target.P + d.lazyProduct(d.transpose()));
    matched.P_dt += weights[i] * (states[i].P_dt + d_devices.lazyProduct(d.transpose()));
    matched.P_dd += weights[i] * (states[i].P_dd + d_devices.lazyProduct(d_devices.transpose()));
  }
  matched.target.add(mean);
  return matched;
}

}  // namespace holdfast

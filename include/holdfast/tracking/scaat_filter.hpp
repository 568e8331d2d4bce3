/// SCAAT, assembled: one measurement at a time corrects pose, velocities and devices (002 sections 4.3 and 4.4).
///
///     ScaatFilter<2> filter(start, PvModel::hiball(0.14, 0.17, Vector3::Constant(1.7)));
///     UpdateStatus status = filter.update(t, CameraSighting{uv, &camera, variance}, {beacons, index});
///     PoseEstimate head = filter.pose_estimate();           // at the last measurement's time; predict from there
/// A source or sensor is an entry of a DeviceTable, as above: its filter is swapped in, corrected, and put back; or one
/// DeviceEstimate of yours, corrected in place; or nothing, when the measurement has none.
/// Each update either happens as a whole or not at all, and says why not (measurement_intake.hpp).
/// The state is finite, its covariance symmetric and positive definite, whatever is measured (innovation.hpp): a
/// correction that would take it out of `largest_correction` is refused.
/// Hot path: `update` allocates nothing, takes no lock and throws nothing.
/// Bad input: a measurement that cannot be is a status. `problem` of model and gate settings names bad ones.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <type_traits>

#include <holdfast/tracking/measurement_intake.hpp>

namespace holdfast {

/// How a filter finds its innovations: here by linearising (innovation.hpp).
struct ExtendedInnovation {
  template <int Order, Measurement M>
  [[nodiscard]] std::optional<Innovation<Order, M>> operator()(const TargetState<Order>& state, const M& measurement,
                                                               const DeviceEstimate<M::source_size>& source,
                                                               const DeviceEstimate<M::sensor_size>& sensor) const {
    return extended_innovation(state, measurement, source, sensor);
  }
};

namespace detail {

/// Why there is no innovation. Off the hot path, so the measurement is asked again.
template <int Order, Measurement M>
[[nodiscard]] UpdateStatus cause_of_no_innovation(const TargetState<Order>& state, const M& measurement,
                                                  const DeviceEstimate<M::source_size>& source,
                                                  const DeviceEstimate<M::sensor_size>& sensor) {
  Linearization<M> linear;
  if (!measurement.linearize(state, source.x, sensor.x, linear)) return UpdateStatus::cannot_be_seen;
  const bool finite = linear.residual.allFinite() && linear.H.allFinite() && linear.H_source.allFinite() &&
                      linear.H_sensor.allFinite() && linear.R.allFinite();
  return finite && !is_noise<M::size>(linear.R) ? UpdateStatus::not_positive : UpdateStatus::not_finite;
}

}  // namespace detail

template <int Order, typename Innovate = ExtendedInnovation>
class ScaatFilter : public MeasurementIntake<ScaatFilter<Order, Innovate>> {
  using Intake = MeasurementIntake<ScaatFilter>;
  friend Intake;

 public:
  using State = TargetState<Order>;

  /// Preconditions: the state is finite, model and gate settings have no problem.
  ScaatFilter(const State& start, const ProcessModel<Order>& model, const ScaatSettings& settings = {},
              const Innovate& innovate = {})
      : Intake(settings), model_(model), innovate_(innovate) {
    HOLDFAST_ASSERT(!model.problem(), "bad process model");
    restart(start);
  }

  /// Begins anew at a state, as after losing track. Counters go on.
  void restart(const State& start) {
    HOLDFAST_ASSERT(start.is_finite(), "a filter starts from finite numbers");
    states_[current_] = start;
    this->forget();
  }

  [[nodiscard]] const State& state() const { return states_[current_]; }
  /// What leaves the tracker, at the time of the last measurement that counted.
  [[nodiscard]] PoseEstimate pose_estimate() const { return holdfast::pose_estimate(state()); }

  /// A measurement against what would be expected at its time: what it would teach (measurement_ordering.hpp). Nothing
  /// changes. Nothing when an update would refuse it, but for the gate.
  template <Measurement M>
  requires(std::is_same_v<Innovate, ExtendedInnovation>) [[nodiscard]] std::optional<Innovation<Order, M>> expectation(
      HostTime t, const M& measurement, std::type_identity_t<DeviceSlot<M::source_size>> source) const {
    static_assert(M::sensor_size == 0 && M::state_size <= 6);
    State next;
    if (this->refusal(state().t, t, source, DeviceSlot<0>()) ||
        !detail::advance_lower(state(), this->roused(model_), t, next)) {
      return std::nullopt;
    }
    return innovate_(next, measurement, source.load(), {});
  }

  [[nodiscard]] const ProcessModel<Order>& model() const { return model_; }
  void set_model(const ProcessModel<Order>& model) { model_ = model; }

 private:
  template <Measurement M>
  UpdateStatus try_update(HostTime t, const M& measurement, const DeviceSlot<M::source_size>& source,
                          const DeviceSlot<M::sensor_size>& sensor) {
    if (const auto refusal = this->refusal(state().t, t, source, sensor)) return *refusal;

    State& next = states_[1 - current_];
    if (!detail::advance_lower(state(), this->roused(model_), t, next)) return UpdateStatus::not_finite;
    if constexpr (M::state_size > 6) detail::mirror_lower<6 * Order>(next.P);  // C takes more than the pose's columns
    DeviceEstimate<M::source_size> source_estimate = source.load();
    DeviceEstimate<M::sensor_size> sensor_estimate = sensor.load();
    const auto innovation = innovate_(next, measurement, source_estimate, sensor_estimate);
    if (!innovation) return detail::cause_of_no_innovation(next, measurement, source_estimate, sensor_estimate);

    if (const auto gated = this->template gated<M::size>(innovation->whitened(), source, sensor)) return *gated;
    if (!correct(next, *innovation, source_estimate, sensor_estimate)) return UpdateStatus::not_finite;
    source.store(source_estimate, t);
    sensor.store(sensor_estimate, t);
    current_ = 1 - current_;
    return UpdateStatus::updated;
  }

  std::array<State, 2> states_;  ///< the one that counts, and where the next is tried
  std::size_t current_ = 0;
  ProcessModel<Order> model_;
  Innovate innovate_;
};

}  // namespace holdfast

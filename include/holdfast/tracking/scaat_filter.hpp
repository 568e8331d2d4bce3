/// SCAAT, assembled: one measurement at a time corrects pose, velocities and devices (002 sections 4.3 and 4.4).
///
///     ScaatFilter<2> filter(start, PvModel::hiball(0.14, 0.17, Vector3::Constant(1.7)));
///     UpdateStatus status = filter.update(t, CameraSighting{uv, &camera, variance}, {beacons, index});
///     PoseEstimate head = filter.pose_estimate();           // at the last measurement's time; predict from there
/// A source or sensor is an entry of a DeviceTable, as above: its filter is swapped in, corrected, and put back; or one
/// DeviceEstimate of yours, corrected in place; or nothing, when the measurement has none.
/// Each update either happens as a whole or not at all: on any status but `updated`, state and devices stay, and time
/// stands still (a measurement with a wrong time stamp must not carry the filter past those that follow). Statuses are
/// counted, so that a field report says why measurements did not count.
/// The state is finite, its covariance symmetric and positive definite, whatever is measured (innovation.hpp): a
/// correction that would take it out of `largest_correction` is refused.
/// Hot path: `update` allocates nothing, takes no lock and throws nothing.
/// Bad input: a measurement that cannot be is a status. `problem` of model and gate settings names bad ones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include <holdfast/tracking/device_table.hpp>
#include <holdfast/tracking/innovation.hpp>
#include <holdfast/tracking/innovation_gate.hpp>

namespace holdfast {

enum class UpdateStatus {
  updated,
  gated,           ///< too unlikely for the gate
  on_probation,    ///< likely, of a device that has to prove itself (innovation_gate.hpp)
  cannot_be_seen,  ///< the measurement model says that the state does not allow it: a beacon behind the camera
  not_finite,      ///< a number of the measurement, or what comes of it, is not finite or absurdly large
  not_positive,    ///< the measurement's noise is no covariance
  time_backwards,  ///< earlier than the state; late data are for delayed filters
  gap_too_long,    ///< later than the state by more than longest_gap: no model carries a pose that far
  no_such_device
};
inline constexpr std::size_t update_statuses = 9;

[[nodiscard]] constexpr std::string_view name_of(UpdateStatus status) {
  constexpr std::array<std::string_view, update_statuses> names{"updated",        "gated",        "on probation",
                                                                "cannot be seen", "not finite",   "not positive",
                                                                "time backwards", "gap too long", "no such device"};
  return names[static_cast<std::size_t>(status)];
}

/// How many measurements ended in each status.
class UpdateCounters {
 public:
  void count(UpdateStatus status) { ++counts_[static_cast<std::size_t>(status)]; }
  [[nodiscard]] std::uint64_t operator[](UpdateStatus status) const {
    return counts_[static_cast<std::size_t>(status)];
  }
  [[nodiscard]] std::uint64_t total() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t n : counts_) sum += n;
    return sum;
  }

 private:
  std::array<std::uint64_t, update_statuses> counts_{};
};

/// Where a measurement's source or sensor is kept. Not owned.
template <int Size>
class DeviceSlot {
 public:
  DeviceSlot(DeviceEstimate<Size>& device) : own_(&device) {}
  DeviceSlot(DeviceTable<Size>& table, int index) : table_(&table), index_(index) {}

  [[nodiscard]] bool exists() const { return own_ != nullptr || table_->contains(index_); }
  /// Null for a device of your own.
  [[nodiscard]] DeviceTable<Size>* table() const { return table_; }
  [[nodiscard]] int index() const { return index_; }
  [[nodiscard]] DeviceEstimate<Size> load() const { return own_ != nullptr ? *own_ : table_->for_sighting(index_); }
  void store(const DeviceEstimate<Size>& device, HostTime t) const {
    if (own_ != nullptr) {
      *own_ = device;
    } else {
      table_->store(index_, device);
      table_->count_sighting(index_, t);
    }
  }
  [[nodiscard]] std::uint8_t* probation() const {
    return own_ != nullptr ? nullptr : &table_->record(index_).probation;
  }

  /// What stands there, for those who take an update back (delayed_measurements.hpp). Locks stay as they are then.
  struct Kept {
    DeviceEstimate<Size> own;
    DeviceRecord<Size> record;
  };
  /// Precondition of both: it exists.
  [[nodiscard]] Kept keep() const {
    Kept kept;
    if (own_ != nullptr) {
      kept.own = *own_;
    } else {
      kept.record = table_->record(index_);
    }
    return kept;
  }
  void put_back(const Kept& kept) const {
    if (own_ != nullptr) {
      own_->x = kept.own.x;
      own_->P = kept.own.P;
    } else {
      DeviceRecord<Size>& record = table_->record(index_);
      const bool locked = record.locked;
      record = kept.record;
      record.locked = locked;
    }
  }

 private:
  DeviceEstimate<Size>* own_ = nullptr;
  DeviceTable<Size>* table_ = nullptr;
  int index_ = 0;
};

/// No source, or no sensor.
template <>
class DeviceSlot<0> {
 public:
  DeviceSlot() = default;
  DeviceSlot(NoDevice& /*device*/) {}
  [[nodiscard]] bool exists() const { return true; }
  [[nodiscard]] NoDevice load() const { return {}; }
  void store(const NoDevice& /*device*/, HostTime /*t*/) const {}
  [[nodiscard]] std::uint8_t* probation() const { return nullptr; }

  struct Kept {};
  [[nodiscard]] Kept keep() const { return {}; }
  void put_back(const Kept& /*kept*/) const {}
};

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

/// Whether t is later than `from` by more than `longest`; t >= from. Without overflow, however far apart.
[[nodiscard]] inline bool is_gap_too_long(HostTime from, HostTime t, Duration longest) {
  const auto ticks = [](HostTime time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); };
  return ticks(t) - ticks(from) > static_cast<std::uint64_t>(longest.count());
}

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

/// Room for the residual of any measurement that filters take.
inline constexpr int largest_measurement = 6;
using WhitenedResidual = VectorOf<double, largest_measurement>;

struct ScaatSettings {
  GateSettings gate;
  Duration longest_gap = from_seconds(5.0);
};

/// What all filters share about taking a measurement in: they refuse what cannot be used, gate what is unlikely, and count.
/// `Filter` derives from it and has try_update(t, measurement, source, sensor), which answers a status.
template <typename Filter>
class MeasurementIntake {
 public:
  template <Measurement M>
  UpdateStatus update(HostTime t, const M& measurement, std::type_identity_t<DeviceSlot<M::source_size>> source,
                      std::type_identity_t<DeviceSlot<M::sensor_size>> sensor) {
    const UpdateStatus status = static_cast<Filter&>(*this).try_update(t, measurement, source, sensor);
    counters_.count(status);
    return status;
  }
  template <Measurement M>
  requires(M::sensor_size == 0) UpdateStatus
      update(HostTime t, const M& measurement, std::type_identity_t<DeviceSlot<M::source_size>> source) {
    return update(t, measurement, source, DeviceSlot<0>());
  }
  template <Measurement M>
  requires(M::source_size == 0 && M::sensor_size == 0) UpdateStatus update(HostTime t, const M& measurement) {
    return update(t, measurement, DeviceSlot<0>(), DeviceSlot<0>());
  }

  /// Normalised innovation squared of the last measurement that reached the gate, and its degrees of freedom.
  [[nodiscard]] double nis() const { return nis_; }
  [[nodiscard]] int nis_size() const { return nis_size_; }
  /// Its whitened residual (Innovation::whitened), for a ResidualMonitor; numbers beyond nis_size() mean nothing.
  [[nodiscard]] const WhitenedResidual& whitened() const { return whitened_; }

  [[nodiscard]] const UpdateCounters& counters() const { return counters_; }
  [[nodiscard]] const InnovationGate& gate() const { return gate_; }

 protected:
  explicit MeasurementIntake(const ScaatSettings& settings) : settings_(settings), gate_(settings.gate) {
    HOLDFAST_ASSERT(!settings.gate.problem(), "bad settings");
  }

  void reset_gate() { gate_ = InnovationGate(settings_.gate); }

  /// Why a measurement of time t cannot be used after one of time `newest`; nothing when it can.
  template <typename Source, typename Sensor>
  [[nodiscard]] std::optional<UpdateStatus> refusal(HostTime newest, HostTime t, const Source& source,
                                                    const Sensor& sensor) const {
    if (t < newest) return UpdateStatus::time_backwards;
    if (detail::is_gap_too_long(newest, t, settings_.longest_gap)) return UpdateStatus::gap_too_long;
    if (!source.exists() || !sensor.exists()) return UpdateStatus::no_such_device;
    return std::nullopt;
  }

  /// Why the gate keeps a measurement from correcting; nothing when it may.
  template <int Size, typename Source, typename Sensor>
  [[nodiscard]] std::optional<UpdateStatus> gated(const VectorOf<double, Size>& whitened, const Source& source,
                                                  const Sensor& sensor) {
    nis_ = whitened.squaredNorm();
    nis_size_ = Size;
    whitened_.template head<Size>() = whitened;
    std::uint8_t* probation = source.probation() != nullptr ? source.probation() : sensor.probation();
    const GateVerdict verdict = gate_.judge(nis_, Size, probation);
    if (verdict == GateVerdict::rejected) return UpdateStatus::gated;
    if (verdict == GateVerdict::on_probation) return UpdateStatus::on_probation;
    return std::nullopt;
  }

 private:
  ScaatSettings settings_;
  InnovationGate gate_;
  UpdateCounters counters_;
  double nis_ = 0.0;
  int nis_size_ = 0;
  WhitenedResidual whitened_ = WhitenedResidual::Zero();
};

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
    this->reset_gate();
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
    if (this->refusal(state().t, t, source, DeviceSlot<0>()) || !detail::advance_lower(state(), model_, t, next)) {
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
    if (!detail::advance_lower(state(), model_, t, next)) return UpdateStatus::not_finite;
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

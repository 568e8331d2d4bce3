/// SCAAT that keeps what the newest devices' errors have to do with the target's, and with one another's.
///
///     JointFilter<2, 3> filter(start, PvModel::hiball(0.14, 0.17, Vector3::Constant(1.7)));
///     UpdateStatus status = filter.update(t, CameraSighting{uv, &camera, variance}, {beacons, index});
///     ...
///     filter.settle();                     // before the table is saved: what was learnt since each device's last sighting
/// For devices that are learnt while they are tracked by. One measurement still is one update, but it corrects target and
/// `Devices` devices together (joint_state.hpp); the device that was seen longest ago leaves for the next one, and only then
/// its correlation is dropped. So the pose no longer takes for news what it taught a device itself: errors are two thirds to
/// a half of ScaatFilter's, a body at rest does not drift, and the covariance means what it says (docs/tracking.md). The
/// price is six to seven times the instructions (scripts/count-instructions), and goes with the square of `Devices`. Give it
/// as many places as devices are in view at a time: seen in turn, one of more would always have left before it is seen
/// again, with all that was known of it.
/// Several process models at once, as in multiple_models.hpp, when `Count` is more than 1: each has its own view of devices
/// too. (There the shared device filters would let a still model's certainty and a moving one's doubt spoil each other.)
/// Devices: those of a table whose numbers have this Size, and that are not locked, take a slot. All others count as in
/// scaat_filter.hpp. While in a slot a device is the filter's: its record in the table is that of its last sighting.
/// `settle` writes all of them, `restart` too. One that is locked while it has a slot stays there unseen until others need it.
/// Statuses, gate, counters, numerics, hot path and bad input: as in scaat_filter.hpp. Tables must outlive the filter.
#pragma once

#include <holdfast/tracking/joint_state.hpp>

namespace holdfast {

template <int Order, int Size, int Devices = 12, int Count = 1>
class JointFilter : public MeasurementIntake<JointFilter<Order, Size, Devices, Count>> {
  using Intake = MeasurementIntake<JointFilter>;
  friend Intake;

 public:
  using State = TargetState<Order>;
  using Joint = JointState<Order, Size, Devices>;
  using Weights = std::array<double, Count>;

  /// Preconditions: the state is finite, models and gate settings have no problem.
  JointFilter(const State& start, const ModelSet<Order, Count>& set, const ScaatSettings& settings = {})
      : Intake(settings), set_(set) {
    HOLDFAST_ASSERT(!set.problem(), "bad models");
    restart(start);
  }
  JointFilter(const State& start, const ProcessModel<Order>& model,
              const ScaatSettings& settings = {}) requires(Count == 1)
      : JointFilter(start, ModelSet<Order, 1>{{model}, {1.0}}, settings) {}

  /// Begins anew at a state, all models equally likely and all slots empty. Counters go on.
  void restart(const State& start) {
    HOLDFAST_ASSERT(start.is_finite(), "a filter starts from finite numbers");
    settle();
    slots_ = {};
    Joint joint;
    joint.target = start;
    states_[current_].fill(joint);
    combined_ = start;
    chain_ = {};
    this->forget();
  }

  /// Writes all devices in slots to their tables, as they are known now. They stay in their slots.
  void settle() {
    for (int slot = 0; slot < Devices; ++slot) write(slot);
  }

  [[nodiscard]] const State& state() const { return combined_; }
  [[nodiscard]] PoseEstimate pose_estimate() const { return holdfast::pose_estimate(combined_); }
  /// What each model takes itself to be worth; they sum to 1.
  [[nodiscard]] const Weights& probabilities() const { return chain_.probabilities(); }
  [[nodiscard]] const ModelSet<Order, Count>& models() const { return set_; }
  /// One model's target and devices.
  [[nodiscard]] const Joint& joint_of(std::size_t model) const { return states_[current_][model]; }
  /// A measurement against what would be expected at its time, as ScaatFilter answers it; of several models, by the
  /// likeliest.
  template <Measurement M>
  [[nodiscard]] std::optional<Innovation<Order, M>> expectation(
      HostTime t, const M& measurement, std::type_identity_t<DeviceSlot<M::source_size>> source) const {
    static_assert(M::sensor_size == 0 && M::state_size <= 6);
    if (this->refusal(combined_.t, t, source, DeviceSlot<0>())) return std::nullopt;
    const std::size_t model = detail::heaviest(probabilities());
    Joint next;
    if (!detail::advance_lower(joint_of(model), this->roused(set_.models[model]), t, next)) return std::nullopt;
    const Seat seat = seat_for(source);
    DeviceEstimate<M::source_size> estimate = source.load();
    prepare(seat, source, next, estimate);
    return joint_innovation(next, measurement, seat.slot, estimate);
  }

  /// Where a table's device is; nothing when it is in no slot.
  [[nodiscard]] std::optional<int> slot_of(const DeviceTable<Size>& table, int index) const {
    for (int slot = 0; slot < Devices; ++slot) {
      const Slot& s = slots_[static_cast<std::size_t>(slot)];
      if (s.table == &table && s.index == index) return slot;
    }
    return std::nullopt;
  }

 private:
  using Joints = std::array<Joint, Count>;
  struct Slot {
    DeviceTable<Size>* table = nullptr;  ///< null: empty
    int index = 0;
    std::uint64_t last_use = 0;
  };

  /// What models say of a device together.
  [[nodiscard]] DeviceEstimate<Size> device(int slot) const {
    std::array<DeviceEstimate<Size>, Count> devices;
    for (std::size_t j = 0; j < Count; ++j) devices[j] = states_[current_][j].device(slot);
    return moment_matched(devices, probabilities());
  }

  void write(int slot) const {
    const Slot& s = slots_[static_cast<std::size_t>(slot)];
    if (s.table != nullptr && !s.table->is_locked(s.index)) s.table->store(s.index, device(slot));
  }

  /// Where a source is, or is to be, among the slots.
  struct Seat {
    int slot = -1;  ///< none
    bool enters = false;
  };
  template <int SourceSize>
  [[nodiscard]] Seat seat_for(const DeviceSlot<SourceSize>& source) const {
    if constexpr (SourceSize == Size) {
      if (source.table() == nullptr || source.table()->is_locked(source.index())) return {};
      if (const auto slot = slot_of(*source.table(), source.index())) return {*slot, false};
      const auto oldest = std::min_element(slots_.begin(), slots_.end(),
                                           [](const Slot& a, const Slot& b) { return a.last_use < b.last_use; });
      return {static_cast<int>(oldest - slots_.begin()), true};
    } else {
      return {};
    }
  }

  /// Makes a source that has a seat ready to be seen: in the state, and as the measurement takes it.
  template <int SourceSize>
  static void prepare(const Seat& seat, const DeviceSlot<SourceSize>& source, Joint& joint,
                      DeviceEstimate<SourceSize>& estimate) {
    if constexpr (SourceSize == Size) {
      if (seat.slot < 0) return;
      if (seat.enters) {
        joint.put(seat.slot, estimate);
      } else {
        joint.P_dd.diagonal().template segment<Size>(Size * seat.slot) += source.table()->settings().wander;
        const DeviceEstimate<Size> seated = joint.device(seat.slot);
        estimate.x = seated.x;
        estimate.P = seated.P;
      }
    }
  }

  /// After its update: who had the seat leaves.
  template <int SourceSize>
  void take(const Seat& seat, const DeviceSlot<SourceSize>& source) {
    if constexpr (SourceSize == Size) {
      if (seat.slot < 0) return;
      if (seat.enters) write(seat.slot);
      slots_[static_cast<std::size_t>(seat.slot)] = {source.table(), source.index(), ++uses_};
    }
  }

  template <Measurement M>
  UpdateStatus try_update(HostTime t, const M& measurement, const DeviceSlot<M::source_size>& source,
                          const DeviceSlot<M::sensor_size>& sensor) {
    if (const auto refusal = this->refusal(combined_.t, t, source, sensor)) return *refusal;

    Joints& next = states_[1 - current_];
    Weights arriving;
    const auto carry = [&](const Joint& from, const ProcessModel<Order>& model, Joint& to) {
      return detail::advance_lower(from, this->roused(model), t, to);
    };
    if (!chain_.mix(set_, to_seconds(t - combined_.t), states_[current_], next, arriving, carry)) {
      return UpdateStatus::not_finite;
    }
    if constexpr (M::state_size > 6) {  // C takes more than the pose's columns
      for (Joint& joint : next) detail::mirror_lower<6 * Order>(joint.target.P);
    }
    const Seat seat = seat_for(source);
    std::array<DeviceEstimate<M::source_size>, Count> sources;
    std::array<DeviceEstimate<M::sensor_size>, Count> sensors;
    sources.fill(source.load());
    sensors.fill(sensor.load());
    std::array<JointInnovation<Order, Size, Devices, M>, Count> innovations;
    Weights log_likelihoods;
    std::size_t likeliest = 0;
    for (std::size_t j = 0; j < Count; ++j) {
      prepare(seat, source, next[j], sources[j]);
      const auto innovation = joint_innovation(next[j], measurement, seat.slot, sources[j], sensors[j]);
      if (!innovation) return detail::cause_of_no_innovation(next[j].target, measurement, sources[j], sensors[j]);
      innovations[j] = *innovation;
      if constexpr (Count > 1) log_likelihoods[j] = innovation->log_likelihood();
      if (innovation->nis() < innovations[likeliest].nis()) likeliest = j;
    }
    const auto gated = this->template gated<M::size>(innovations[likeliest].whitened(), source, sensor);
    if (gated) return *gated;

    for (std::size_t j = 0; j < Count; ++j) {
      if (!correct(next[j], innovations[j], sources[j], sensors[j])) return UpdateStatus::not_finite;
    }
    take(seat, source);
    chain_.weigh(arriving, log_likelihoods);
    source.store(moment_matched(sources, probabilities()), t);
    sensor.store(moment_matched(sensors, probabilities()), t);
    current_ = 1 - current_;
    combine();
    return UpdateStatus::updated;
  }

  void combine() {
    const Joints& now = states_[current_];
    if constexpr (Count == 1) {
      combined_ = now[0].target;
    } else {
      std::array<State, Count> targets;
      for (std::size_t j = 0; j < Count; ++j) targets[j] = now[j].target;
      combined_ = moment_matched(targets, probabilities());
    }
  }

  std::array<Joints, 2> states_;  ///< those that count, and where the next are tried
  std::size_t current_ = 0;
  State combined_;
  std::array<Slot, Devices> slots_;
  std::uint64_t uses_ = 0;
  ModelChain<Count> chain_;
  ModelSet<Order, Count> set_;
};

}  // namespace holdfast

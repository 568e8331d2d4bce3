/// What all filters share about taking a measurement in: they refuse what cannot be used, gate what is unlikely, notice a
/// manoeuvre, and count.
///
/// Each update either happens as a whole or not at all: on any status but `updated`, state and devices stay, and time
/// stands still (a measurement with a wrong time stamp must not carry the filter past those that follow). Statuses are
/// counted, so that a field report says why measurements did not count.
/// Filters: ScaatFilter (scaat_filter.hpp), MultipleModelFilter (multiple_models.hpp), JointFilter (joint_filter.hpp).
/// Hot path: nothing is allocated, locked or thrown. Bad input: a measurement that cannot be is a status.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include <holdfast/tracking/device_slot.hpp>
#include <holdfast/tracking/innovation.hpp>
#include <holdfast/tracking/innovation_gate.hpp>
#include <holdfast/tracking/manoeuvre.hpp>

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

namespace detail {

/// Whether t is later than `from` by more than `longest`; t >= from. Without overflow, however far apart.
[[nodiscard]] inline bool is_gap_too_long(HostTime from, HostTime t, Duration longest) {
  const auto ticks = [](HostTime time) { return static_cast<std::uint64_t>(time.time_since_epoch().count()); };
  return ticks(t) - ticks(from) > static_cast<std::uint64_t>(longest.count());
}

}  // namespace detail

/// Room for the residual of any measurement that filters take.
inline constexpr int largest_measurement = 6;
using WhitenedResidual = VectorOf<double, largest_measurement>;

struct ScaatSettings {
  GateSettings gate{};
  ManoeuvreSettings manoeuvre{};  ///< off
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
  [[nodiscard]] const ManoeuvreDetector& manoeuvre() const { return manoeuvre_; }

 protected:
  explicit MeasurementIntake(const ScaatSettings& settings)
      : settings_(settings), gate_(settings.gate), manoeuvre_(settings.manoeuvre) {
    HOLDFAST_ASSERT(!settings.gate.problem() && !settings.manoeuvre.problem(), "bad settings");
  }

  /// What was noticed so far says nothing of a new start.
  void forget() {
    gate_ = InnovationGate(settings_.gate);
    manoeuvre_ = ManoeuvreDetector(settings_.manoeuvre);
  }

  /// A process model as vigorous as the body seems to be now.
  template <int Order>
  [[nodiscard]] ProcessModel<Order> roused(ProcessModel<Order> model) const {
    model.intensity *= manoeuvre_.noise_scale();
    return model;
  }

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
    if (gate_.is_near(nis_, Size)) manoeuvre_.add(nis_, Size);
    if (verdict == GateVerdict::rejected) return UpdateStatus::gated;
    if (verdict == GateVerdict::on_probation) return UpdateStatus::on_probation;
    return std::nullopt;
  }

 private:
  ScaatSettings settings_;
  InnovationGate gate_;
  ManoeuvreDetector manoeuvre_;
  UpdateCounters counters_;
  double nis_ = 0.0;
  int nis_size_ = 0;
  WhitenedResidual whitened_ = WhitenedResidual::Zero();
};

}  // namespace holdfast

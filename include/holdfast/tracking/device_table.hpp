/// The device filters of many sources or sensors of one kind (002 section 4.4.2), kept small: a beacon takes 88 bytes.
///
/// A tracker swaps one device in and out with each measurement (002 figure 4.12):
///     DeviceEstimate<3> beacon = beacons.for_sighting(i);    // its covariance grown by what it may have wandered
///     ...                                                    // innovation.hpp corrects it
///     beacons.store(i, beacon);
///     beacons.count_sighting(i, t);
/// or hands the table to a filter that does so (scaat_filter.hpp). Settings are shared by all devices of a table. The
/// table lives on between runs (io/device_file.hpp): what was learnt is not learnt twice. Keep P when you do: a second
/// run that starts from the initial variance is worse than the first.
/// Only `add` allocates. Bad input: an index outside [0, size) is the caller's mistake; `contains` tells.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/timing/clock.hpp>
#include <holdfast/tracking/device_estimate.hpp>

namespace holdfast {

/// What the devices of a table share. Units are squares of the parameters' own, m^2 for a beacon's position.
template <int Size>
struct DeviceSettings {
  /// Of each parameter before the first sighting: 002's P_b, confidence in the design.
  VectorOf<double, Size> initial_variance = VectorOf<double, Size>::Zero();
  /// Gained by each parameter at every sighting: 002's Q_b, a random walk that lets devices be moved.
  VectorOf<double, Size> wander = VectorOf<double, Size>::Zero();
  /// What calibration never takes away (device_estimate.hpp).
  VectorOf<double, Size> residual_variance = VectorOf<double, Size>::Zero();
};

/// One device as the table keeps it. P is symmetric: its lower triangle by rows.
template <int Size>
struct DeviceRecord {
  static constexpr int packed_size = Size * (Size + 1) / 2;
  VectorOf<double, Size> x = VectorOf<double, Size>::Zero();
  std::array<double, packed_size> P{};
  HostTime last_sighting = HostTime::min();  ///< of this run; min: none yet
  std::uint32_t sightings = 0;               ///< of all runs
  std::uint8_t probation = 0;  ///< consistent sightings that are still wanted from it (innovation_gate.hpp)
  bool locked = false;
};
static_assert(sizeof(DeviceRecord<3>) <= 96, "thousands of beacons must stay small");

template <int Size>
class DeviceTable {
  static_assert(Size >= 1);

 public:
  using Parameters = VectorOf<double, Size>;
  using Covariance = MatrixOf<double, Size>;

  DeviceTable() = default;
  explicit DeviceTable(const DeviceSettings<Size>& settings) : settings_(settings) {}

  [[nodiscard]] const DeviceSettings<Size>& settings() const { return settings_; }
  void set_settings(const DeviceSettings<Size>& settings) { settings_ = settings; }

  void reserve(int devices) { records_.reserve(static_cast<std::size_t>(devices)); }

  /// A device at its designed parameters; answers its index.
  int add(const Parameters& x) {
    DeviceEstimate<Size> device;
    device.x = x;
    device.P.diagonal() = settings_.initial_variance;
    return add(device);
  }
  /// A device of which more is known.
  int add(const DeviceEstimate<Size>& device) {
    records_.emplace_back();
    records_.back().locked = device.locked;
    store(size() - 1, device);
    return size() - 1;
  }

  [[nodiscard]] int size() const { return static_cast<int>(records_.size()); }
  [[nodiscard]] bool contains(int i) const { return i >= 0 && i < size(); }

  /// What is known of a device now.
  [[nodiscard]] DeviceEstimate<Size> at(int i) const {
    const DeviceRecord<Size>& record = this->record(i);
    DeviceEstimate<Size> device;
    device.x = record.x;
    for (int row = 0, k = 0; row < Size; ++row) {
      for (int column = 0; column <= row; ++column, ++k) {
        device.P(row, column) = device.P(column, row) = record.P[static_cast<std::size_t>(k)];
      }
    }
    device.residual_variance = settings_.residual_variance;
    device.locked = record.locked;
    return device;
  }

  /// The same when it is seen again: unless locked, it may have wandered.
  [[nodiscard]] DeviceEstimate<Size> for_sighting(int i) const {
    DeviceEstimate<Size> device = at(i);
    if (!device.locked) device.P.diagonal() += settings_.wander;
    return device;
  }

  /// Keeps parameters and covariance. Whether the device is locked is for `lock` to say.
  void store(int i, const DeviceEstimate<Size>& device) {
    DeviceRecord<Size>& record = this->record(i);
    record.x = device.x;
    for (int row = 0, k = 0; row < Size; ++row) {
      for (int column = 0; column <= row; ++column, ++k) record.P[static_cast<std::size_t>(k)] = device.P(row, column);
    }
  }

  void count_sighting(int i, HostTime t) {
    DeviceRecord<Size>& record = this->record(i);
    ++record.sightings;
    record.last_sighting = t;
  }
  [[nodiscard]] std::uint32_t sightings(int i) const { return record(i).sightings; }
  [[nodiscard]] std::optional<HostTime> last_sighting(int i) const {
    if (record(i).last_sighting == HostTime::min()) return std::nullopt;
    return record(i).last_sighting;
  }

  /// A locked device is not corrected any more (002 section 5.1.4).
  void lock(int i, bool locked = true) { record(i).locked = locked; }
  void unlock(int i) { lock(i, false); }
  void lock_all(bool locked = true) {
    for (DeviceRecord<Size>& record : records_) record.locked = locked;
  }
  [[nodiscard]] bool is_locked(int i) const { return record(i).locked; }

  [[nodiscard]] const DeviceRecord<Size>& record(int i) const {
    HOLDFAST_ASSERT(contains(i), "no such device");
    return records_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] DeviceRecord<Size>& record(int i) {
    HOLDFAST_ASSERT(contains(i), "no such device");
    return records_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] std::span<const DeviceRecord<Size>> records() const { return records_; }

 private:
  DeviceSettings<Size> settings_;
  std::vector<DeviceRecord<Size>> records_;
};

}  // namespace holdfast

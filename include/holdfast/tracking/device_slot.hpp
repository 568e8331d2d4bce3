/// Where the source or sensor of a measurement is kept, for filters that learn devices while they track.
///
///     filter.update(t, sighting, {beacons, index});    // an entry of a DeviceTable
///     filter.update(t, range, anchor, bias);           // DeviceEstimates of yours, corrected in place
/// An entry's filter is swapped in, corrected, and put back (002 section 4.4). `DeviceSlot<0>`: there is none.
/// Not owned: tables and estimates must outlive the update, and what was kept for taking it back.
/// Bad input: `exists` says whether there is such a device; all else asks for one that exists.
#pragma once

#include <cstdint>

#include <holdfast/tracking/device_table.hpp>

namespace holdfast {

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

}  // namespace holdfast

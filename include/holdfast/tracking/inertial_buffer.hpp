/// The last inertial readings, for filters whose poses come slower and later than they do.
///
/// A ring of fixed size. A pose that tells of a moment past finds the readings round that moment (`at`), or all those since
/// the pose before (`for_each`); averaged over a while they are less noisy (`mean`), but half of it older.
/// Nothing here allocates, locks or throws; one thread.
/// Bad input: a reading not later than the newest is refused. One with numbers that are not finite is kept, for its others
/// may be good: what is made of a missing number is missing.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

template <std::size_t Capacity = 1024>
class InertialBuffer {
 public:
  /// `longest_gap`: between readings farther apart nothing is interpolated.
  explicit InertialBuffer(Duration longest_gap = std::chrono::milliseconds(20)) : longest_gap_(longest_gap) {}

  /// False when refused.
  bool push(const InertialReading& reading) {
    if (size_ > 0 && reading.t <= newest().t) return false;
    readings_[(first_ + size_) % Capacity] = reading;
    if (size_ < Capacity) {
      ++size_;
    } else {
      first_ = (first_ + 1) % Capacity;
    }
    return true;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  /// Precondition of these: i < size(); the oldest is number 0.
  [[nodiscard]] const InertialReading& operator[](std::size_t i) const {
    HOLDFAST_ASSERT(i < size_, "no such reading");
    return readings_[(first_ + i) % Capacity];
  }
  [[nodiscard]] const InertialReading& oldest() const { return (*this)[0]; }
  [[nodiscard]] const InertialReading& newest() const { return (*this)[size_ - 1]; }

  /// Number of the first reading after t; size() when there is none.
  [[nodiscard]] std::size_t first_after(HostTime t) const {
    std::size_t low = 0, high = size_;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      (*this)[middle].t <= t ? low = middle + 1 : high = middle;
    }
    return low;
  }

  /// Calls f(reading) for all with begin < t <= end, in their order.
  template <typename Function>
  void for_each(HostTime begin, HostTime end, const Function& f) const {
    for (std::size_t i = first_after(begin); i < size_ && (*this)[i].t <= end; ++i) f((*this)[i]);
  }

  /// Between the two neighbours of t, linearly; nothing outside of what is kept and in gaps.
  [[nodiscard]] std::optional<InertialReading> at(HostTime t) const {
    const std::size_t next = first_after(t);
    if (next == 0) return std::nullopt;
    const InertialReading& a = (*this)[next - 1];
    if (a.t == t) return a;
    if (next == size_) return std::nullopt;
    const InertialReading& b = (*this)[next];
    if (b.t - a.t > longest_gap_) return std::nullopt;
    const double s = to_seconds(t - a.t) / to_seconds(b.t - a.t);
    return InertialReading{t, a.rate_B + s * (b.rate_B - a.rate_B), a.force_B + s * (b.force_B - a.force_B)};
  }

  /// Mean of all with begin < t <= end, stamped with their mean time; nothing when there are none.
  [[nodiscard]] std::optional<InertialReading> mean(HostTime begin, HostTime end) const {
    InertialReading sum;
    std::int64_t count = 0;
    Duration since{0};
    for_each(begin, end, [&](const InertialReading& reading) {
      sum.rate_B += reading.rate_B;
      sum.force_B += reading.force_B;
      since += reading.t - begin;
      ++count;
    });
    if (count == 0) return std::nullopt;
    const double share = 1.0 / static_cast<double>(count);
    return InertialReading{begin + since / count, share * sum.rate_B, share * sum.force_B};
  }

 private:
  Duration longest_gap_;
  std::array<InertialReading, Capacity> readings_{};
  std::size_t first_ = 0, size_ = 0;
};

}  // namespace holdfast

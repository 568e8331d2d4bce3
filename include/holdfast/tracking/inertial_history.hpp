/// The newest readings of inertial sensors, and what they say of a stretch of time: the strapdown integral.
///
/// A ring of fixed size: pushing allocates nothing. Between readings the signals are straight lines; after the newest,
/// the angular velocity goes on at a rate of change that the caller knows, the force stays; before the oldest both
/// stay.
/// Source: strapdown integration by the midpoint rule, exact to second order in the interval between readings.
/// Frames: B is the body; increments are expressed in B at the stretch's begin. Units: rad/s, m/s^2, s.
/// Bad input: a reading that is not later than the newest is refused: false. `integrate` of an empty history is at
/// rest.
#pragma once

#include <algorithm>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/so3.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

/// Motion over a stretch of time as the sensors felt it: gravity is still in it.
struct StrapdownIncrement {
  double seconds = 0.0;
  Quaternion q = Quaternion::Identity();  ///< B at the end, seen from B at the begin
  Vector3 velocity_B = Vector3::Zero();   ///< integral of the force
  Vector3 position_B = Vector3::Zero();   ///< double integral of the force
  Vector3 rate_begin_B = Vector3::Zero(), rate_end_B = Vector3::Zero();
  Vector3 force_begin_B = Vector3::Zero(), force_end_B = Vector3::Zero();
  bool has_force = true;  ///< false: a force that nobody measured is in it
};

struct InertialBias {
  Vector3 rate_B = Vector3::Zero();
  Vector3 force_B = Vector3::Zero();
};

class InertialHistory {
 public:
  static constexpr double longest_extrapolation_s = 0.02;  ///< of the angular velocity; then it stays

  /// Precondition: capacity >= 2.
  explicit InertialHistory(int capacity = 1024) : ring_(static_cast<std::size_t>(capacity)) {
    HOLDFAST_ASSERT(capacity >= 2, "a history holds at least two readings");
  }

  /// `has_force` false: the reading's force stands in for one that is missing.
  bool push(const InertialReading& reading, bool has_force = true) {
    if (size_ > 0 && reading.t <= newest().t) return false;
    ring_[(first_ + size_) % ring_.size()] = {reading, has_force};
    if (size_ < ring_.size()) {
      ++size_;
    } else {
      first_ = (first_ + 1) % ring_.size();
    }
    return true;
  }
  void clear() { size_ = 0; }

  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  /// The k-th oldest.
  [[nodiscard]] const InertialReading& operator[](std::size_t k) const { return kept(k).reading; }
  [[nodiscard]] const InertialReading& newest() const { return (*this)[size_ - 1]; }
  /// Whether the newest reading has one of its own.
  [[nodiscard]] bool has_force() const { return !empty() && kept(size_ - 1).has_force; }

  /// How many readings are not later than t.
  [[nodiscard]] std::size_t count_until(HostTime t) const {
    std::size_t k = size_;  // most questions are about the newest ones
    while (k > 0 && (*this)[k - 1].t > t) --k;
    return k;
  }

  /// From `from` to `to` by the sensors' clock, less the bias. Precondition: from <= to.
  [[nodiscard]] StrapdownIncrement integrate(HostTime from, HostTime to, const InertialBias& bias,
                                             const Vector3& rate_slope) const {
    StrapdownIncrement sum;
    sum.seconds = to_seconds(to - from);
    sum.has_force = !empty();
    if (empty()) return sum;
    std::size_t next = count_until(from);
    sum.has_force = kept(next == 0 ? 0 : next - 1).has_force;
    InertialReading begin = at(from, next, rate_slope);
    sum.rate_begin_B = begin.rate_B - bias.rate_B;
    sum.force_begin_B = begin.force_B - bias.force_B;
    while (begin.t < to) {
      const HostTime until = next < size_ ? std::min(to, (*this)[next].t) : to;
      const InertialReading end = at(until, next, rate_slope);
      if (next < size_ && !kept(next).has_force) sum.has_force = false;
      add(sum, to_seconds(until - begin.t), 0.5 * (begin.rate_B + end.rate_B) - bias.rate_B,
          0.5 * (begin.force_B + end.force_B) - bias.force_B);
      begin = end;
      if (next < size_ && (*this)[next].t <= until) ++next;
    }
    sum.rate_end_B = begin.rate_B - bias.rate_B;
    sum.force_end_B = begin.force_B - bias.force_B;
    return sum;
  }

 private:
  struct Kept {
    InertialReading reading;
    bool has_force = true;
  };
  [[nodiscard]] const Kept& kept(std::size_t k) const { return ring_[(first_ + k) % ring_.size()]; }

  /// The signals at t, of which `next` readings are not later.
  [[nodiscard]] InertialReading at(HostTime t, std::size_t next, const Vector3& rate_slope) const {
    InertialReading result = (*this)[next == 0 ? 0 : next - 1];
    const double since = to_seconds(t - result.t);
    result.t = t;
    if (next == 0) return result;
    if (next == size_) {
      result.rate_B += std::min(since, longest_extrapolation_s) * rate_slope;
      return result;
    }
    const InertialReading &a = (*this)[next - 1], &b = (*this)[next];
    const double part = since / to_seconds(b.t - a.t);
    result.rate_B += part * (b.rate_B - a.rate_B);
    result.force_B += part * (b.force_B - a.force_B);
    return result;
  }

  static void add(StrapdownIncrement& sum, double dt, const Vector3& rate, const Vector3& force) {
    const Quaternion middle = sum.q * so3::exp<double>(0.5 * dt * rate);
    const Vector3 dv = dt * (middle * force);
    sum.position_B += dt * (sum.velocity_B + 0.5 * dv);
    sum.velocity_B += dv;
    sum.q = (sum.q * so3::exp<double>(dt * rate)).normalized();
  }

  std::vector<Kept> ring_;
  std::size_t first_ = 0, size_ = 0;
};

}  // namespace holdfast

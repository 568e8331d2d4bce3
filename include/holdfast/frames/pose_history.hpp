/// The recent past of one dynamic transform T_AB: a ring of timed VQS transforms that can be asked for any time.
///
/// Between two samples the transform is interpolated: vector linearly, rotation at a constant rate by the shorter way,
/// scale at a constant ratio (the same as `interpolate` of vqs.hpp). Beyond the newest sample the newest is held and
/// its age is reported, up to `max_age`; before the oldest nothing is known. It never extrapolates: that is a
/// predictor's work (prediction/). Capacity is fixed when the history is made; `push` and `at` allocate nothing, lock
/// nothing and throw nothing. One thread. Source of the need: dynamic transforms of Robinett & Holloway 1994, section 5
/// (course 11), and times of measurement against times of display (course 11, section 5). Bad input: a sample that is
/// not finite, not newer than the last, or in the future is refused by name and counted; the history stays as it was.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/vqs.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

enum class PushStatus : std::uint8_t {
  accepted,
  out_of_order,  ///< older than the newest sample
  duplicate,     ///< the newest sample has this very time
  future,        ///< later than `now`
  not_finite,    ///< a number of the transform is NaN or infinite, or the scale is not positive
  not_dynamic,   ///< (graph) the edge is static, or is not there any more
};

enum class SampleStatus : std::uint8_t {
  interpolated,    ///< inside the history
  held,            ///< beyond the newest sample: that sample, `age` old
  too_old,         ///< beyond the newest sample by more than `max_age`
  before_history,  ///< before the oldest sample kept
  gap,             ///< between two samples further apart than `max_gap`
  empty,           ///< no sample yet
};

/// For HistoryOptions::max_age: hold the newest sample however old, or refuse every time beyond it.
inline constexpr Duration hold_for_ever = Duration::max();
inline constexpr Duration never_hold = Duration::zero();

struct HistoryOptions {
  std::size_t capacity = 256;          ///< samples kept, at least; rounded up to a power of two
  Duration max_age = hold_for_ever;    ///< how old the newest sample may be and still be held
  Duration max_gap = Duration::max();  ///< widest interval that is interpolated
};

class PoseHistory {
 public:
  struct Sample {
    Vqs T_AB;         ///< the identity unless usable()
    Duration age{0};  ///< time asked for minus time of the newest sample; 0 inside the history
    SampleStatus status = SampleStatus::empty;

    [[nodiscard]] bool usable() const { return status == SampleStatus::interpolated || status == SampleStatus::held; }
  };

  explicit PoseHistory(const HistoryOptions& options = {}) : options_(options) {
    HOLDFAST_ASSERT(options.capacity > 0, "a history holds at least one sample");
    ring_.resize(std::bit_ceil(options.capacity));
    mask_ = ring_.size() - 1;
  }

  /// Appends T_AB at time t, which must be later than the newest sample's.
  PushStatus push(HostTime t, const Vqs& T_AB) { return count(try_push(t, T_AB)); }

  /// The same, and refuses a sample from the future: t > now.
  PushStatus push(HostTime t, const Vqs& T_AB, HostTime now) {
    return count(t > now ? PushStatus::future : try_push(t, T_AB));
  }

  /// T_AB at time t. Nearly always near the newest sample, so the search gallops back from there: O(log(samples since
  /// t)).
  [[nodiscard]] Sample at(HostTime t) const {
    if (size_ == 0) return {};
    const Slot& newest = slot(size_ - 1);
    if (t >= newest.t) return beyond(newest, t - newest.t);
    if (t < slot(0).t) return {Vqs(), Duration(0), SampleStatus::before_history};
    const std::size_t i = first_later_than(t);
    return between(slot(i - 1), slot(i), t);
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return ring_.size(); }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] const HistoryOptions& options() const { return options_; }

  /// Preconditions of these: not empty.
  [[nodiscard]] HostTime oldest_time() const { return checked(0).t; }
  [[nodiscard]] HostTime newest_time() const { return checked(size_ - 1).t; }
  [[nodiscard]] const Vqs& newest() const { return checked(size_ - 1).T_AB; }

  /// How many pushes ended this way since the history was made.
  [[nodiscard]] std::uint64_t pushes(PushStatus status) const { return counts_[static_cast<std::size_t>(status)]; }

  /// Forgets the samples, not the counts.
  void clear() {
    size_ = 0;
    begin_ = 0;
  }

 private:
  /// A sample and the step that led to it, taken once at the push so that a lookup needs no logarithm.
  struct Slot {
    HostTime t;
    Vqs T_AB;
    Vector3 turn = Vector3::Zero();  // rotation vector of q_previous^-1 q
    double log_growth = 0;           // log(s / s_previous)
    double per_nanosecond = 0;       // 1 / (t - t_previous)
  };

  PushStatus try_push(HostTime t, const Vqs& T_AB) {
    if (!T_AB.is_finite() || !(T_AB.s() > 0)) return PushStatus::not_finite;
    Slot next{t, T_AB};
    if (size_ > 0) {
      const Slot& last = slot(size_ - 1);
      if (t == last.t) return PushStatus::duplicate;
      if (t < last.t) return PushStatus::out_of_order;
      next.turn = so3::log<double>(last.T_AB.q().conjugate() * T_AB.q());
      next.log_growth = T_AB.s() == last.T_AB.s() ? 0.0 : std::log(T_AB.s() / last.T_AB.s());
      next.per_nanosecond = 1.0 / static_cast<double>((t - last.t).count());
    }
    if (size_ == ring_.size()) {
      begin_ = (begin_ + 1) & mask_;
      --size_;
    }
    ring_[(begin_ + size_) & mask_] = next;
    ++size_;
    return PushStatus::accepted;
  }

  PushStatus count(PushStatus status) {
    ++counts_[static_cast<std::size_t>(status)];
    return status;
  }

  [[nodiscard]] Sample beyond(const Slot& newest, Duration age) const {
    if (age.count() == 0) return {newest.T_AB, age, SampleStatus::interpolated};
    if (age > options_.max_age) return {Vqs(), age, SampleStatus::too_old};
    return {newest.T_AB, age, SampleStatus::held};
  }

  [[nodiscard]] Sample between(const Slot& a, const Slot& b, HostTime t) const {
    if (b.t - a.t > options_.max_gap) return {Vqs(), Duration(0), SampleStatus::gap};
    const double u = static_cast<double>((t - a.t).count()) * b.per_nanosecond;
    const Vector3 v = a.T_AB.v() + u * (b.T_AB.v() - a.T_AB.v());
    const Vector3 turn = u * b.turn;
    const Quaternion q = a.T_AB.q() * so3::exp<double>(turn);
    const double s = b.log_growth == 0 ? a.T_AB.s() : a.T_AB.s() * std::exp(u * b.log_growth);
    return {Vqs(v, q, s), Duration(0), SampleStatus::interpolated};
  }

  /// Index of the first sample with time > t. Precondition: oldest <= t < newest.
  [[nodiscard]] std::size_t first_later_than(HostTime t) const {
    std::size_t later = size_ - 1;
    std::size_t step = 1;
    while (step <= later && slot(later - step).t > t) {
      later -= step;
      step *= 2;
    }
    std::size_t not_later = step <= later ? later - step : 0;
    while (later - not_later > 1) {
      const std::size_t middle = not_later + (later - not_later) / 2;
      (slot(middle).t > t ? later : not_later) = middle;
    }
    return later;
  }

  [[nodiscard]] const Slot& slot(std::size_t i) const { return ring_[(begin_ + i) & mask_]; }
  [[nodiscard]] const Slot& checked(std::size_t i) const {
    HOLDFAST_ASSERT(size_ > 0, "the history is empty");
    return slot(i);
  }

  HistoryOptions options_;
  std::vector<Slot> ring_;
  std::size_t mask_ = 0;
  std::size_t begin_ = 0;
  std::size_t size_ = 0;
  std::array<std::uint64_t, 6> counts_{};
};

}  // namespace holdfast

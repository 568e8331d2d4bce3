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

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/frames/detail/raw_vqs.hpp>
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
  /// The same for the inside of a lookup; T_AB is written only when the sample is usable.
  struct RawSample {
    Duration age{0};
    SampleStatus status = SampleStatus::empty;
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

  /// T_AB at time t. Samples that come at an even rate are found in one step, others by bisection.
  [[nodiscard]] Sample at(HostTime t) const {
    detail::RawVqs T_AB;
    const RawSample raw = at(t, T_AB);
    return {detail::to_vqs(T_AB), raw.age, raw.status};
  }

  [[nodiscard]] RawSample at(HostTime t, detail::RawVqs& T_AB) const {
    if (size_ == 0) return {};
    const Slot& newest = slot(size_ - 1);
    if (t >= newest.t) return beyond(newest, t - newest.t, T_AB);
    if (t < slot(0).t) return {Duration(0), SampleStatus::before_history};
    const std::size_t i = first_later_than(t);
    const Slot& b = slot(i);
    if (b.too_wide) return {Duration(0), SampleStatus::gap};
    interpolate(slot(i - 1), b, t, T_AB);
    return {Duration(0), SampleStatus::interpolated};
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return ring_.size(); }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] const HistoryOptions& options() const { return options_; }

  /// Preconditions of these: not empty.
  [[nodiscard]] HostTime oldest_time() const { return checked(0).t; }
  [[nodiscard]] HostTime newest_time() const { return checked(size_ - 1).t; }
  [[nodiscard]] Vqs newest() const { return detail::to_vqs(checked(size_ - 1).T_AB); }

  /// How many pushes ended this way since the history was made.
  [[nodiscard]] std::uint64_t pushes(PushStatus status) const { return counts_[static_cast<std::size_t>(status)]; }

  /// Forgets the samples, not the counts.
  void clear() {
    size_ = 0;
    begin_ = 0;
  }

 private:
  /// A sample, and what interpolating the step that led to it needs, taken once at the push: a lookup evaluates no
  /// trigonometric function for steps below 23 degrees. Half angle h of the step; the rotation between is
  /// q(u) = sin((1 - u) h) / sin h  q_previous + sin(u h) / sin h  (+-q).
  struct Slot {
    HostTime t;
    detail::RawVqs T_AB;            // q on the previous one's side
    double per_nanosecond = 0;      // 1 / (t - t_previous)
    double half_angle_squared = 0;  // h^2
    double per_sinc = 1;            // h / sin h
    double log_growth = 0;          // log(s / s_previous)
    bool too_wide = false;          // wider than max_gap
  };

  PushStatus try_push(HostTime t, const Vqs& T_AB) {
    if (!T_AB.is_finite() || !(T_AB.s() > 0)) return PushStatus::not_finite;
    Slot next{t, T_AB};
    if (size_ > 0) {
      const Slot& last = slot(size_ - 1);
      if (t == last.t) return PushStatus::duplicate;
      if (t < last.t) return PushStatus::out_of_order;
      measure_step(last, next);
    }
    if (size_ == ring_.size()) {
      begin_ = (begin_ + 1) & mask_;
      --size_;
    }
    ring_[(begin_ + size_) & mask_] = next;
    ++size_;
    const double span = static_cast<double>((t - slot(0).t).count());
    samples_per_nanosecond_ = size_ > 1 ? static_cast<double>(size_ - 1) / span : 0;
    return PushStatus::accepted;
  }

  void measure_step(const Slot& last, Slot& next) const {
    if (last.T_AB.q.dot(next.T_AB.q) < 0) next.T_AB.q.coeffs() = -next.T_AB.q.coeffs();
    const double h = 0.5 * so3::angle_between<double>(last.T_AB.q, next.T_AB.q);
    next.half_angle_squared = h * h;
    next.per_sinc = h < 1e-8 ? 1 : h / std::sin(h);
    next.log_growth = next.T_AB.s == last.T_AB.s ? 0 : std::log(next.T_AB.s / last.T_AB.s);
    next.per_nanosecond = 1 / static_cast<double>((next.t - last.t).count());
    next.too_wide = next.t - last.t > options_.max_gap;
  }

  PushStatus count(PushStatus status) {
    ++counts_[static_cast<std::size_t>(status)];
    return status;
  }

  [[nodiscard]] RawSample beyond(const Slot& newest, Duration age, detail::RawVqs& T_AB) const {
    if (age > options_.max_age) return {age, SampleStatus::too_old};
    T_AB = newest.T_AB;
    return {age, age.count() == 0 ? SampleStatus::interpolated : SampleStatus::held};
  }

  /// sin(x) / x from x^2, for x^2 < 0.04: the first dropped term is x^10 / 11! < 3e-15.
  static double sinc(double x2) {
    return 1 - x2 * (1.0 / 6 - x2 * (1.0 / 120 - x2 * (1.0 / 5040 - x2 * (1.0 / 362880))));
  }

  static void interpolate(const Slot& a, const Slot& b, HostTime t, detail::RawVqs& T_AB) {
    const double u = static_cast<double>((t - a.t).count()) * b.per_nanosecond;
    const double r = 1 - u;
    const double h2 = b.half_angle_squared;
    double weight_a = r, weight_b = u;
    if (h2 < 0.04) {
      weight_a *= b.per_sinc * sinc(r * r * h2);
      weight_b *= b.per_sinc * sinc(u * u * h2);
    } else {
      const double h = std::sqrt(h2);
      weight_a = std::sin(r * h) * b.per_sinc / h;
      weight_b = std::sin(u * h) * b.per_sinc / h;
    }
    T_AB.q.coeffs() = weight_a * a.T_AB.q.coeffs() + weight_b * b.T_AB.q.coeffs();
    T_AB.v = r * a.T_AB.v + u * b.T_AB.v;
    T_AB.s = b.log_growth == 0 ? a.T_AB.s : a.T_AB.s * std::exp(u * b.log_growth);
  }

  /// Index of the first sample with time > t. Precondition: oldest <= t < newest.
  [[nodiscard]] std::size_t first_later_than(HostTime t) const {
    const double since_oldest = static_cast<double>((t - slot(0).t).count());
    const std::size_t guess =
        static_cast<std::size_t>(static_cast<std::int64_t>(since_oldest * samples_per_nanosecond_));
    const std::size_t i = std::min(guess + 1, size_ - 1);
    if (slot(i).t > t && slot(i - 1).t <= t) return i;
    return bisect(t, i);
  }

  /// Gallops away from sample i, then bisects.
  [[nodiscard]] std::size_t bisect(HostTime t, std::size_t i) const {
    std::size_t not_later = 0, later = size_ - 1;
    std::size_t step = 1;
    if (slot(i).t > t) {
      for (later = i; step <= later && slot(later - step).t > t; step *= 2) later -= step;
      if (step <= later) not_later = later - step;
    } else {
      for (not_later = i; not_later + step < size_ && slot(not_later + step).t <= t; step *= 2) not_later += step;
      later = std::min(later, not_later + step);
    }
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
  double samples_per_nanosecond_ = 0;  // on average over the ring
  std::array<std::uint64_t, 6> counts_{};
};

}  // namespace holdfast

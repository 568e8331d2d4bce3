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
#include <cstddef>
#include <cstdint>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/frames/detail/pose_segment.hpp>
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
    detail::RawVqs T_AB = Vqs();
    const RawSample raw = at(t, T_AB);
    return {detail::to_vqs(T_AB), raw.age, raw.status};
  }

  [[nodiscard]] EIGEN_ALWAYS_INLINE RawSample at(HostTime t, detail::RawVqs& T_AB) const {
    if (t < oldest_t_ || t >= newest_t_) return outside(t, T_AB);
    const Segment& guess = ring_[guess_slot(t)];
    if (!guess.covers(t) || !guess.simple) return between(t, T_AB);
    guess.interpolate_simple(t, T_AB);
    return {Duration(0), SampleStatus::interpolated};
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t capacity() const { return ring_.size(); }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] const HistoryOptions& options() const { return options_; }

  /// Preconditions of these: not empty.
  [[nodiscard]] HostTime oldest_time() const { return require_a_sample(), oldest_t_; }
  [[nodiscard]] HostTime newest_time() const { return require_a_sample(), newest_t_; }
  [[nodiscard]] const Vqs& newest() const { return require_a_sample(), newest_; }

  /// How many pushes ended this way since the history was made.
  [[nodiscard]] std::uint64_t pushes(PushStatus status) const { return counts_[static_cast<std::size_t>(status)]; }

  /// Forgets the samples, not the counts.
  void clear() {
    size_ = 0;
    oldest_t_ = newest_t_ = HostTime();
  }

 private:
  using Segment = detail::PoseSegment;

  PushStatus try_push(HostTime t, const Vqs& T_AB) {
    if (!T_AB.is_finite() || !(T_AB.s() > 0)) return PushStatus::not_finite;
    if (size_ > 0 && t == newest_t_) return PushStatus::duplicate;
    if (size_ > 0 && t < newest_t_) return PushStatus::out_of_order;
    newest_slot_ = (newest_slot_ + 1) & mask_;
    Segment& next = ring_[newest_slot_];
    next = size_ > 0 ? detail::pose_segment(newest_t_, newest_, t, T_AB, options_.max_gap) : Segment{t, t};
    size_ = std::min(size_ + 1, ring_.size());
    newest_t_ = t;
    newest_ = T_AB;
    oldest_t_ = ring_[slot(0)].end;
    const double span = static_cast<double>((newest_t_ - oldest_t_).count());
    samples_per_nanosecond_ = size_ > 1 ? static_cast<double>(size_ - 1) / span : 0;
    return PushStatus::accepted;
  }

  PushStatus count(PushStatus status) {
    ++counts_[static_cast<std::size_t>(status)];
    return status;
  }

  /// The answer for a time before the oldest sample, or not before the newest.
  [[nodiscard]] EIGEN_DONT_INLINE RawSample outside(HostTime t, detail::RawVqs& T_AB) const {
    if (size_ == 0) return {};
    if (t < oldest_t_) return {Duration(0), SampleStatus::before_history};
    const Duration age = t - newest_t_;
    if (age > options_.max_age) return {age, SampleStatus::too_old};
    T_AB = newest_;
    return {age, age.count() == 0 ? SampleStatus::interpolated : SampleStatus::held};
  }

  /// The answer for a time inside the history, with every case. Precondition: oldest <= t < newest.
  [[nodiscard]] EIGEN_DONT_INLINE RawSample between(HostTime t, detail::RawVqs& T_AB) const {
    const Segment& segment = ring_[ring_[guess_slot(t)].covers(t) ? guess_slot(t) : bisect(t)];
    if (segment.too_wide) return {Duration(0), SampleStatus::gap};
    segment.simple ? segment.interpolate_simple(t, T_AB) : segment.interpolate(t, T_AB);
    return {Duration(0), SampleStatus::interpolated};
  }

  /// Slot of the segment that t is in if samples come at an even rate. Precondition: oldest <= t < newest.
  [[nodiscard]] std::size_t guess_slot(HostTime t) const {
    const double back = static_cast<double>((newest_t_ - t).count()) * samples_per_nanosecond_;
    return (newest_slot_ - static_cast<std::size_t>(static_cast<std::int64_t>(back))) & mask_;
  }

  /// Slot of the segment that t is in. Precondition: oldest <= t < newest.
  [[nodiscard]] std::size_t bisect(HostTime t) const {
    std::size_t not_later = 0, later = size_ - 1;
    while (later - not_later > 1) {
      const std::size_t middle = not_later + (later - not_later) / 2;
      (ring_[slot(middle)].end > t ? later : not_later) = middle;
    }
    return slot(later);
  }

  /// Slot of sample i, 0 the oldest, and of the segment that leads to it.
  [[nodiscard]] std::size_t slot(std::size_t i) const { return (newest_slot_ + 1 + i - size_) & mask_; }
  void require_a_sample() const { HOLDFAST_ASSERT(size_ > 0, "the history is empty"); }

  // What a lookup needs comes first. Without samples every time is outside.
  HostTime oldest_t_, newest_t_;
  double samples_per_nanosecond_ = 0;  // on average over the ring
  std::size_t newest_slot_ = 0;
  std::size_t mask_ = 0;
  std::vector<Segment> ring_;  // each the segment that leads to a sample
  std::size_t size_ = 0;
  Vqs newest_;
  HistoryOptions options_;
  std::array<std::uint64_t, 6> counts_{};
};

}  // namespace holdfast

/// Conversion between the times of two clocks that differ by an offset and a constant skew.
///
///   t_To = to_reference + (1 + skew) (t_From - from_reference)
/// skew is a plain ratio: 46e-6 is a second every six hours, 8.3 ms every three minutes (001 section 5.3). There and
/// back is exact to 1 ns for times within 100 days of the reference and skews below 1 %. To estimate one see
/// clock_offset_estimator.hpp. Bad input: `make` gives nothing for a skew that is not finite or not within +-10 %.
#pragma once

#include <cmath>
#include <optional>
#include <type_traits>

#include <holdfast/assert.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

template <typename From, typename To>
class ClockOffset {
  static_assert(!std::is_same_v<From, To>, "one clock needs no conversion");

 public:
  /// Both clocks show the same count.
  ClockOffset() = default;

  /// Preconditions: |skew| <= 0.1.
  ClockOffset(TimePoint<From> from_reference, TimePoint<To> to_reference, double skew = 0.0)
      : from_reference_(from_reference), to_reference_(to_reference), skew_(skew) {
    HOLDFAST_ASSERT(std::abs(skew) <= 0.1, "skew is not finite or beyond 10 %");
  }

  [[nodiscard]] static std::optional<ClockOffset> make(TimePoint<From> from_reference, TimePoint<To> to_reference,
                                                       double skew = 0.0) {
    if (!(std::abs(skew) <= 0.1)) return std::nullopt;
    return ClockOffset(from_reference, to_reference, skew);
  }

  [[nodiscard]] double skew() const { return skew_; }
  /// to_reference - from_reference as bare counts: what the To clock shows more than the From clock at the reference.
  [[nodiscard]] Duration offset_at_reference() const {
    return to_reference_.time_since_epoch() - from_reference_.time_since_epoch();
  }

  [[nodiscard]] TimePoint<To> convert(TimePoint<From> t) const {
    const Duration elapsed = t - from_reference_;
    // The whole nanoseconds stay whole; only the small correction is a floating-point number.
    return to_reference_ + elapsed + scaled(elapsed, skew_);
  }
  [[nodiscard]] TimePoint<From> convert(TimePoint<To> t) const {
    const Duration elapsed = t - to_reference_;
    return from_reference_ + elapsed - scaled(elapsed, skew_ / (1.0 + skew_));
  }

  [[nodiscard]] ClockOffset<To, From> inverse() const {
    return ClockOffset<To, From>(to_reference_, from_reference_, -skew_ / (1.0 + skew_));
  }

  /// The conversion From -> Third, by way of To.
  template <typename Third>
  [[nodiscard]] ClockOffset<From, Third> then(const ClockOffset<To, Third>& next) const {
    return ClockOffset<From, Third>(from_reference_, next.convert(to_reference_),
                                    skew_ + next.skew() + skew_ * next.skew());
  }

 private:
  [[nodiscard]] static Duration scaled(Duration d, double factor) {
    return Duration(std::llround(static_cast<double>(d.count()) * factor));
  }

  TimePoint<From> from_reference_{};
  TimePoint<To> to_reference_{};
  double skew_ = 0.0;
};

}  // namespace holdfast

/// Learns the offset and skew between a sender's clock and the receiver's from one-way messages, while they arrive.
///
/// A message stamped t_From arrives at t_To = offset(t_From) + delay with delay >= 0, and the delay is often far from
/// the least (a pause of 60-200 ms on a busy host, 001 section 5.3). So the offset is the line below all points
/// (t_From, t_To - t_From) that comes nearest to them: the edge of their lower convex hull over their mean time (Moon,
/// Skelly & Towsley 1999, Estimation and removal of clock skew from network delay measurements). Kept are the earliest
/// arrivals of `bins` intervals of `bin_length`. What one-way messages cannot show is the least delay itself: give it
/// as `least_delay`, or the estimate is late by it.
///
/// Bad input never harms the estimate: stamps or arrivals that run backward, or jump by more than `jump`, are refused
/// and counted. When 20 refused messages in a row agree among themselves, a clock was set or restarted, and the
/// estimate starts afresh. No allocation, lock or throw; update takes constant time, estimate() a pass over the bins.
/// Not thread-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/timing/clock_offset.hpp>

namespace holdfast {

/// What became of a message.
enum class ClockSample {
  accepted,
  backward_stamp,    ///< not later than the one before
  backward_arrival,  ///< earlier than the one before
  jump,              ///< its delay differs from the newest kept one by more than `jump`
  out_of_range,      ///< a count beyond +-73 years
  restarted,         ///< accepted, as the first message of a clock that was set or restarted
};

struct ClockOffsetOptions {
  Duration bin_length = std::chrono::milliseconds(500);
  double max_skew = 200e-6;                 ///< the sum of two ordinary crystals' tolerances
  Duration jump = std::chrono::seconds(1);  ///< longer than any delay that may happen
  Duration least_delay{0};                  ///< of the fastest message
};

template <typename From, typename To>
struct ClockEstimate {
  ClockOffset<From, To> offset;
  Duration uncertainty{0};  ///< at the newest message: the error is below it in about 95 % of cases (least_delay apart)
  double skew_uncertainty = 0;  ///< likewise
};

template <typename From, typename To, std::size_t Bins = 256>
class ClockOffsetEstimator {
 public:
  explicit ClockOffsetEstimator(const ClockOffsetOptions& options = {}) : options_(options) {
    HOLDFAST_ASSERT(options.bin_length > Duration{0} && options.jump > Duration{0}, "lengths must be positive");
    HOLDFAST_ASSERT(options.max_skew >= 0.0 && options.max_skew <= 0.1, "max_skew must be within 0 and 0.1");
  }

  ClockSample update(TimePoint<From> stamp, TimePoint<To> arrival) {
    const ClockSample verdict = judge(stamp, arrival);
    if (verdict == ClockSample::accepted) {
      refused_in_a_row_ = 0;
      keep(stamp, arrival);
      return verdict;
    }
    ++refused_;
    if (verdict == ClockSample::out_of_range) return verdict;
    const bool agrees = refused_in_a_row_ > 0 && stamp > refused_stamp_ && arrival >= refused_arrival_ &&
                        abs(difference(stamp, arrival) - difference(refused_stamp_, refused_arrival_)) <= options_.jump;
    refused_in_a_row_ = agrees ? refused_in_a_row_ + 1 : 1;
    refused_stamp_ = stamp;
    refused_arrival_ = arrival;
    if (refused_in_a_row_ < messages_to_restart) return verdict;
    size_ = 0;
    samples_ = 0;
    refused_in_a_row_ = 0;
    ++restarts_;
    keep(stamp, arrival);
    return ClockSample::restarted;
  }

  /// Nothing before 10 messages.
  [[nodiscard]] std::optional<ClockEstimate<From, To>> estimate() const;

  [[nodiscard]] std::int64_t samples() const { return samples_; }    ///< accepted since the (re)start
  [[nodiscard]] std::int64_t refused() const { return refused_; }    ///< ever
  [[nodiscard]] std::int64_t restarts() const { return restarts_; }  ///< ever

 private:
  static constexpr int messages_to_restart = 20;
  static constexpr std::int64_t least_samples = 10;

  /// The earliest arrival of one interval.
  struct Bin {
    TimePoint<From> stamp;
    std::int64_t difference;  ///< arrival - stamp, ns
    std::int64_t number;
    double excess;  ///< sum over the interval's messages of their difference, less the first one's, ns
    std::int64_t messages;
    std::int64_t first_difference;
  };
  struct Point {
    double x, y;  ///< ns after the newest stamp; ns of difference above the newest bin's
  };

  [[nodiscard]] static Duration difference(TimePoint<From> stamp, TimePoint<To> arrival) {
    return arrival.time_since_epoch() - stamp.time_since_epoch();
  }
  [[nodiscard]] static Duration abs(Duration d) { return d < Duration{0} ? -d : d; }

  [[nodiscard]] const Bin& bin(std::size_t i) const { return bins_[(oldest_ + i) % Bins]; }
  [[nodiscard]] Bin& newest_bin() { return bins_[(oldest_ + size_ - 1) % Bins]; }

  [[nodiscard]] ClockSample judge(TimePoint<From> stamp, TimePoint<To> arrival) const {
    // Within it, no sum or difference below overflows.
    constexpr std::int64_t limit = (std::int64_t{1} << 61) - 1;
    const auto is_out = [](std::int64_t count) { return count > limit || count < -limit; };
    if (is_out(stamp.time_since_epoch().count()) || is_out(arrival.time_since_epoch().count())) {
      return ClockSample::out_of_range;
    }
    if (size_ == 0) return ClockSample::accepted;
    if (stamp <= last_stamp_) return ClockSample::backward_stamp;
    if (arrival < last_arrival_) return ClockSample::backward_arrival;
    // In a long silence skew alone may change the difference.
    const auto by_skew = Duration(std::llround(options_.max_skew * static_cast<double>((stamp - last_stamp_).count())));
    const Duration change = difference(stamp, arrival) - Duration(bin(size_ - 1).difference);
    return abs(change) > options_.jump + by_skew ? ClockSample::jump : ClockSample::accepted;
  }

  void keep(TimePoint<From> stamp, TimePoint<To> arrival) {
    last_stamp_ = stamp;
    last_arrival_ = arrival;
    ++samples_;
    const std::int64_t d = difference(stamp, arrival).count();
    const std::int64_t number = stamp.time_since_epoch() / options_.bin_length;
    if (size_ > 0 && newest_bin().number == number) {
      Bin& b = newest_bin();
      b.excess += static_cast<double>(d - b.first_difference);
      ++b.messages;
      if (d < b.difference) {
        b.stamp = stamp;
        b.difference = d;
      }
      return;
    }
    const Duration window = options_.bin_length * static_cast<std::int64_t>(Bins);
    while (size_ > 0 && (size_ == Bins || stamp - bin(0).stamp > window)) {
      oldest_ = (oldest_ + 1) % Bins;
      --size_;
    }
    ++size_;
    newest_bin() = {stamp, d, number, 0.0, 1, d};
  }

  [[nodiscard]] double slope_below(const std::array<Point, Bins>& points, double mean_x) const;

  ClockOffsetOptions options_;
  std::array<Bin, Bins> bins_{};
  std::size_t oldest_ = 0;
  std::size_t size_ = 0;
  TimePoint<From> last_stamp_{}, refused_stamp_{};
  TimePoint<To> last_arrival_{}, refused_arrival_{};
  std::int64_t samples_ = 0, refused_ = 0, restarts_ = 0;
  int refused_in_a_row_ = 0;
};

/// Slope of the lower convex hull's edge over mean_x, within +-max_skew. Points run in rising x.
template <typename From, typename To, std::size_t Bins>
double ClockOffsetEstimator<From, To, Bins>::slope_below(const std::array<Point, Bins>& points, double mean_x) const {
  std::array<Point, Bins> hull{};
  std::size_t corners = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    const Point& c = points[i];
    while (corners >= 2) {
      const Point& a = hull[corners - 2];
      const Point& b = hull[corners - 1];
      if ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0.0) break;
      --corners;
    }
    hull[corners++] = c;
  }
  for (std::size_t i = 1; i < corners; ++i) {
    if (hull[i].x < mean_x) continue;
    const double slope = (hull[i].y - hull[i - 1].y) / (hull[i].x - hull[i - 1].x);
    return std::clamp(slope, -options_.max_skew, options_.max_skew);
  }
  return 0.0;
}

template <typename From, typename To, std::size_t Bins>
std::optional<ClockEstimate<From, To>> ClockOffsetEstimator<From, To, Bins>::estimate() const {
  if (samples_ < least_samples) return std::nullopt;
  const Bin& newest = bin(size_ - 1);
  const double n = static_cast<double>(size_);
  std::array<Point, Bins> points;
  double mean_x = 0.0;
  double scatter = 0.0;  // mean delay above the earliest arrivals, ns
  for (std::size_t i = 0; i < size_; ++i) {
    const Bin& b = bin(i);
    points[i] = {static_cast<double>((b.stamp - newest.stamp).count()),
                 static_cast<double>(b.difference - newest.difference)};
    mean_x += points[i].x / n;
    const double mean =
        b.excess / static_cast<double>(b.messages) + static_cast<double>(b.first_difference - b.difference);
    scatter += mean / n;
  }
  const double skew = size_ < 2 ? 0.0 : slope_below(points, mean_x);
  double height = 0.0;  // of the line at the newest bin's stamp; that bin itself lies at 0
  for (std::size_t i = 0; i < size_; ++i) height = std::min(height, points[i].y - skew * points[i].x);
  double excess = 0.0;  // mean height of the bins above the line
  for (std::size_t i = 0; i < size_; ++i) excess += (points[i].y - skew * points[i].x - height) / n;

  // With n bins whose earliest arrivals lie `excess` above the line on average, the line's own error is a few excess /
  // n. The first two bins say nothing about that; the scatter of single messages then stands in, which is too much
  // rather than too little.
  const double touch = size_ < 3 ? scatter : 12.0 * excess / (n - 2.0);
  const double span = std::max(-points[0].x, 1.0);
  const double skew_uncertainty =
      std::min(2.0 * options_.max_skew, size_ < 3 ? 2.0 * options_.max_skew : 1.5 * touch / span);
  const auto whole = [](double ns) { return Duration(std::llround(ns)); };
  ClockEstimate<From, To> answer;
  const TimePoint<To> reference(newest.stamp.time_since_epoch() + Duration(newest.difference) + whole(height));
  answer.offset = ClockOffset<From, To>(newest.stamp, reference - options_.least_delay, skew);
  answer.uncertainty = whole(touch) + Duration{1};
  answer.skew_uncertainty = skew_uncertainty;
  return answer;
}

}  // namespace holdfast

/// The exchange between the tracker's thread and the renderers': one thread publishes estimates, any number of threads
/// read the newest.
///
/// Nobody waits: publishing never waits for a reader, and reading never waits for the tracker's thread, not even when
/// it is paused in the middle of publishing (detail/newest_words.hpp says exactly what is guaranteed). Nothing
/// allocates, locks or throws. A reader gets one estimate as a whole, never parts of two.
///
/// Bad input: an estimate that is not finite, not later than the one before, or later than `now` is refused and
/// counted by its reason; what was there stays. A tracker that starts anew with earlier times (after the computer
/// slept, for one) is believed after `restart_after` such estimates in a row whose own times increase: without that, one
/// stamp from the far future would shut the tracker out for ever.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include <holdfast/pipeline/detail/newest_words.hpp>
#include <holdfast/prediction/predictor.hpp>
#include <holdfast/tracking/pose_estimate.hpp>

namespace holdfast {

/// What became of a published estimate.
enum class PublishResult {
  published,
  restarted,   ///< published, as the first of a tracker whose times started anew
  not_finite,  ///< refused: a NaN or an infinity in pose, velocity or covariance
  not_newer,   ///< refused: its time is not later than the newest estimate's
  from_future  ///< refused: its time is later than the `now` handed in, by more than the tolerance
};

[[nodiscard]] constexpr std::string_view to_string(PublishResult result) {
  constexpr std::string_view names[] = {"published", "restarted", "not_finite", "not_newer", "from_future"};
  return names[static_cast<std::size_t>(result)];
}

struct LatestPoseCounters {
  std::uint64_t published = 0;  ///< restarts included
  std::uint64_t restarts = 0;
  std::uint64_t not_finite = 0, not_newer = 0, from_future = 0;  ///< refused
  std::uint64_t overtaken_reads = 0;                             ///< reads that gave up; expected to stay 0

  [[nodiscard]] std::uint64_t refused() const { return not_finite + not_newer + from_future; }
};

class LatestPose {
 public:
  static constexpr int restart_after = 20;
  static constexpr Duration future_tolerance = std::chrono::milliseconds(1);

  /// From one thread at a time.
  PublishResult publish(const PoseEstimate& estimate) {
    const PublishResult result = judge(estimate);
    if (result == PublishResult::published || result == PublishResult::restarted) {
      newest_t_ = estimate.t;
      refused_in_a_row_ = 0;
      slots_.write(pack(estimate));
      if (result == PublishResult::restarted) count(restarts_);
    } else {
      count(result == PublishResult::not_finite ? not_finite_ : not_newer_);
    }
    return result;
  }

  /// The same, with the time at which it happens: also refuses stamps from the future, which no tracker has unless
  /// clocks are mixed up.
  PublishResult publish(const PoseEstimate& estimate, HostTime now) {
    if (detail::seconds_between(now, estimate.t) > to_seconds(future_tolerance)) {
      count(from_future_);
      return PublishResult::from_future;
    }
    return publish(estimate);
  }

  /// From any thread. Nothing before the first was published (and, should a read give up, see the counters).
  [[nodiscard]] std::optional<PoseEstimate> newest() const {
    Words::Record record;
    switch (slots_.read(record)) {
      case detail::WordsRead::ok:
        return unpack(record);
      case detail::WordsRead::nothing_yet:
        return std::nullopt;
      case detail::WordsRead::overtaken:
        count(overtaken_reads_);
        return std::nullopt;
    }
    return std::nullopt;
  }

  /// From any thread; the numbers may be of slightly different moments.
  [[nodiscard]] LatestPoseCounters counters() const {
    const auto get = [](const Counter& c) { return c.load(std::memory_order_relaxed); };
    return {slots_.count(),  get(restarts_),    get(not_finite_),
            get(not_newer_), get(from_future_), get(overtaken_reads_)};
  }

 private:
  // Time, quaternion, position, whether there is a velocity, velocity, covariance.
  static constexpr std::size_t word_count = 1 + 4 + 3 + 1 + 6 + 144;
  static constexpr std::size_t slot_count = 8;
  using Words = detail::NewestWords<word_count, slot_count>;
  using Counter = std::atomic<std::uint64_t>;

  static void count(Counter& counter) { counter.fetch_add(1, std::memory_order_relaxed); }

  [[nodiscard]] PublishResult judge(const PoseEstimate& estimate) {
    if (!estimate.is_finite()) return PublishResult::not_finite;
    if (slots_.count() == 0 || estimate.t > newest_t_) return PublishResult::published;
    const bool continues = refused_in_a_row_ > 0 && estimate.t > refused_t_;
    refused_in_a_row_ = continues ? refused_in_a_row_ + 1 : 1;
    refused_t_ = estimate.t;
    return refused_in_a_row_ < restart_after ? PublishResult::not_newer : PublishResult::restarted;
  }

  [[nodiscard]] static Words::Record pack(const PoseEstimate& estimate) {
    Words::Record words;
    std::size_t i = 0;
    const auto put = [&](double x) { words[i++] = std::bit_cast<std::uint64_t>(x); };
    const auto put_all = [&](const auto& matrix) {
      for (Eigen::Index k = 0; k < matrix.size(); ++k) put(matrix.data()[k]);
    };
    words[i++] = static_cast<std::uint64_t>(estimate.t.time_since_epoch().count());
    put_all(estimate.X_WB.q().coeffs());
    put_all(estimate.X_WB.p());
    words[i++] = estimate.velocity ? 1 : 0;
    const Twist twist = estimate.velocity.value_or(Twist{});
    put_all(twist.v_WB);
    put_all(twist.w_WB_B);
    put_all(estimate.covariance);
    return words;
  }

  [[nodiscard]] static PoseEstimate unpack(const Words::Record& words) {
    std::size_t i = 0;
    const auto get_all = [&](auto& matrix) {
      for (Eigen::Index k = 0; k < matrix.size(); ++k) matrix.data()[k] = std::bit_cast<double>(words[i++]);
    };
    PoseEstimate estimate;
    estimate.t = HostTime(Duration(static_cast<std::int64_t>(words[i++])));
    Vector4 xyzw;
    Vector3 p;
    get_all(xyzw);
    get_all(p);
    estimate.X_WB = Rigid(Quaternion(xyzw[3], xyzw[0], xyzw[1], xyzw[2]), p);
    const bool has_velocity = words[i++] != 0;
    Twist twist;
    get_all(twist.v_WB);
    get_all(twist.w_WB_B);
    if (has_velocity) estimate.velocity = twist;
    get_all(estimate.covariance);
    return estimate;
  }

  Words slots_;
  HostTime newest_t_{}, refused_t_{};  // the writer's own
  int refused_in_a_row_ = 0;
  Counter restarts_{0}, not_finite_{0}, not_newer_{0}, from_future_{0};
  mutable Counter overtaken_reads_{0};
};

}  // namespace holdfast

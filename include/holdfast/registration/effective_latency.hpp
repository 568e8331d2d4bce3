/// Effective latency: the shift in time that best lays what was displayed over what was true, with its uncertainty.
///
/// The two recordings may have different rates, gaps, and frames that differ by rigid transforms of world and body.
///  1. Coarse, where frames differ: cross-correlation of the angular speeds |w|, which no choice of frames changes
///     (for motions that do not turn: of the speeds |v|), each taken over the same 60 ms baseline. Where frames agree:
///     the mean squared difference of poses over a grid of shifts, whose minimum is the maximum of the poses' own
///     cross-correlation.
///  2. Fine: the recording with the higher rate is splined (C2) and compared at the other's times; the shift is
///     improved by Gauss-Newton on the pose differences (rotation and position in units of their medians; outliers
///     lose weight), by turns with the relation of the frames (align_poses), until it stands still. Periodic motions
///     fit at several shifts: among equals the smallest in size wins.
///  3. Uncertainty: the overlap is cut into K blocks; each gives its own shift d_k with information w_k, and
///     u^2 = sum w_k^2 (d_k - d)^2 / (sum w_k)^2 * K / (K - 1). Errors of neighbouring samples hang together, so blocks
///     of 2, 4, 8 ... s are tried, down to five blocks, and the largest u counts. What is wrong in the whole recording,
///     as a clock's offset, does not show in it.
/// Source: evaluation.md (effective latency; value 4). Allocates: for evaluation, not for the frame loop.
/// Bad input: see LatencyStatus. Preconditions: times of samples strictly increase, options are not negative.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/motion/spline_trajectory.hpp>
#include <holdfast/registration/detail/latency_match.hpp>
#include <holdfast/registration/latency_types.hpp>

namespace holdfast {

namespace detail {

inline constexpr double coarse_step_s = 0.005;

/// Local minima of `cost` over the grid of shifts, best first, at most five; those equally good ordered by size of
/// shift.
[[nodiscard]] inline std::vector<double> minima(const std::vector<double>& shifts, const std::vector<double>& cost,
                                                double tolerance) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < cost.size(); ++i) {
    if (!std::isfinite(cost[i])) continue;
    const bool left = i == 0 || !(cost[i - 1] < cost[i]);
    const bool right = i + 1 == cost.size() || !(cost[i + 1] < cost[i]);
    if (left && right) order.push_back(i);
  }
  if (order.empty()) return {};
  double lowest = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) lowest = std::min(lowest, cost[i]);
  std::erase_if(order, [&](std::size_t i) { return cost[i] > lowest + tolerance; });
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return std::abs(shifts[a]) < std::abs(shifts[b]); });
  std::vector<double> result;
  for (std::size_t i = 0; i < std::min<std::size_t>(5, order.size()); ++i) result.push_back(shifts[order[i]]);
  return result;
}

[[nodiscard]] inline std::vector<double> shift_grid(Duration longest) {
  HOLDFAST_ASSERT(longest >= Duration{0}, "the longest shift is negative");
  const int n = std::max(1, static_cast<int>(std::ceil(to_seconds(longest) / coarse_step_s)));
  std::vector<double> shifts;
  for (int i = -n; i <= n; ++i) shifts.push_back(i * coarse_step_s);
  return shifts;
}

/// Angular and linear speed over a baseline of 60 ms, whatever the frames.
struct Speeds {
  double turning = 0.0, moving = 0.0;
};
inline constexpr Duration half_baseline = std::chrono::milliseconds(30);

[[nodiscard]] inline Speeds speeds_at(const Motion& motion, HostTime t) {
  const Rigid before = motion.at(t - half_baseline).X_WB, after = motion.at(t + half_baseline).X_WB;
  const double dt = 2.0 * to_seconds(half_baseline);
  return {so3::angle_between<double>(before.q(), after.q()) / dt, (after.p() - before.p()).norm() / dt};
}

/// Root mean squares of a recording's speeds.
[[nodiscard]] inline Speeds typical_speeds(const ContinuousMotion& c, std::span<const TimedPose> samples) {
  Speeds sum;
  std::size_t n = 0;
  for (const TimedPose& sample : samples) {
    if (!c.covers(sample.t, half_baseline)) continue;
    const Speeds s = speeds_at(*c.motion, sample.t);
    sum.turning += s.turning * s.turning;
    sum.moving += s.moving * s.moving;
    ++n;
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, n));
  return {std::sqrt(sum.turning / count), std::sqrt(sum.moving / count)};
}

/// Below these nothing is said about time: rad/s and m/s.
inline constexpr Speeds least_speeds{0.005, 0.002};

/// 1 - correlation coefficient of the two speeds, for every shift of the grid.
[[nodiscard]] inline std::vector<double> speed_mismatch(const ContinuousMotion& c, const ContinuousMotion& d,
                                                        std::span<const TimedPose> samples, bool turning,
                                                        const std::vector<double>& shifts) {
  const auto pick = [turning](const Speeds& s) { return turning ? s.turning : s.moving; };
  std::vector<std::pair<HostTime, double>> speed_D;
  for (const TimedPose& sample : samples) {
    if (d.covers(sample.t, half_baseline)) speed_D.emplace_back(sample.t, pick(speeds_at(*d.motion, sample.t)));
  }
  std::vector<double> mismatch;
  for (const double shift_s : shifts) {
    const Duration shift = from_seconds(shift_s);
    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    for (const auto& [t, value_D] : speed_D) {
      if (!c.covers(t + shift, half_baseline)) continue;
      const double value_C = pick(speeds_at(*c.motion, t + shift));
      n += 1;
      a += value_C;
      b += value_D;
      aa += value_C * value_C;
      bb += value_D * value_D;
      ab += value_C * value_D;
    }
    const double variance = (aa - a * a / n) * (bb - b * b / n);
    mismatch.push_back(n >= 20 && variance > 0.0 ? 1.0 - (ab - a * b / n) / std::sqrt(variance)
                                                 : std::numeric_limits<double>::infinity());
  }
  return mismatch;
}

/// Standard deviation of the shift from `blocks` blocks of the overlap; 0 when fewer than two tell anything.
[[nodiscard]] inline double deviation_of_blocks(const std::vector<ShiftedPair>& pairs, const ResidualScale& scale,
                                                std::size_t blocks) {
  double information = 0.0, squares = 0.0, used = 0.0;
  for (std::size_t k = 0; k < blocks; ++k) {
    ShiftNormal normal;
    const std::size_t end = (k + 1) * pairs.size() / blocks;
    for (std::size_t i = k * pairs.size() / blocks; i < end; ++i) normal.add(pairs[i], scale);
    // At the optimum the steps' weighted mean is zero; w_k d_k is the block's gradient.
    information += normal.information;
    squares += normal.gradient * normal.gradient;
    used += normal.information > 0.0 ? 1.0 : 0.0;
  }
  return information > 0.0 && used > 1.0 ? std::sqrt(squares * used / (used - 1.0)) / information : 0.0;
}

/// The largest of these deviations over block lengths of 2, 4, 8 ... s, as long as there are five blocks.
[[nodiscard]] inline double block_uncertainty(const std::vector<ShiftedPair>& pairs) {
  const ResidualScale scale = scale_of(pairs);
  const double overlap_s = to_seconds(pairs.back().t - pairs.front().t);
  double largest = 0.0;
  for (double blocks = std::max(5.0, overlap_s / 2.0); blocks >= 5.0; blocks /= 2.0) {
    largest = std::max(largest, deviation_of_blocks(pairs, scale, static_cast<std::size_t>(blocks)));
  }
  return largest;
}

/// The best shift for X_C(t + s) ~ X_CD X_D(t) X_QP, and whether the frames could be aligned.
struct MatchResult {
  LatencyStatus status = LatencyStatus::ok;
  Match match;
};

[[nodiscard]] inline std::vector<double> coarse_shifts(const ContinuousMotion& c, const ContinuousMotion& d,
                                                       std::span<const TimedPose> samples, bool align,
                                                       const Speeds& typical, const LatencyOptions& options) {
  const std::vector<double> shifts = shift_grid(options.longest);
  const std::vector<TimedPose> few = detail::thinned(samples, align ? 3000 : 300);
  if (align) {
    const bool turning = typical.turning > least_speeds.turning;
    return minima(shifts, speed_mismatch(c, d, few, turning, shifts), 0.05);
  }
  const ResidualScale scale{std::max(typical.turning, least_speeds.turning),
                            std::max(typical.moving, least_speeds.moving)};
  std::vector<double> cost;
  for (const double shift_s : shifts) {
    const std::vector<ShiftedPair> pairs = pairs_at(c, few, shift_s, {});
    cost.push_back(pairs.size() < 10 ? std::numeric_limits<double>::infinity() : mean_cost(pairs, scale));
  }
  // A minimum narrower than the grid is missed by at most half a step: what that step costs is the tolerance.
  return minima(shifts, cost, 2.0 * coarse_step_s * coarse_step_s);
}

[[nodiscard]] inline MatchResult match_recordings(const ContinuousMotion& c, const ContinuousMotion& d,
                                                  std::span<const TimedPose> samples, const LatencyOptions& options) {
  MatchResult result;
  const Speeds typical = typical_speeds(c, detail::thinned(samples, 1000));
  if (typical.turning < least_speeds.turning && typical.moving < least_speeds.moving) {
    result.status = LatencyStatus::no_motion;
    return result;
  }
  const double longest_s = to_seconds(options.longest);
  const std::vector<TimedPose> many = detail::thinned(samples, 2000);
  const std::vector<TimedPose> few = detail::thinned(samples, 400);
  bool align = options.frames == FrameRelation::rigid;
  if (align && !relation_at(c, few, 0.0)) {
    align = false;
    result.status = LatencyStatus::frames_undetermined;
  }
  const ResidualScale scale{std::max(typical.turning, least_speeds.turning),
                            std::max(typical.moving, least_speeds.moving)};
  std::optional<Match> best;
  for (const double shift_s : coarse_shifts(c, d, samples, align, typical, options)) {
    std::optional<Match> match = refine(c, few, shift_s, align, longest_s);
    if (!match) continue;
    match->cost = mean_cost(pairs_at(c, few, match->shift_s, match->relation), scale);
    // Candidates come smallest shift first: a later one must be better by more than rounding.
    if (!best || match->cost < 0.999 * best->cost - 1e-12) best = match;
  }
  if (best) best = refine(c, many, best->shift_s, align, longest_s);
  if (!best) {
    result.status = LatencyStatus::too_few_samples;
    return result;
  }
  result.match = *best;
  return result;
}

/// Angle (deg) and position (mm) errors of the observed poses against the reference, in the reference's frames.
inline void set_errors(LatencyResult& result, const ContinuousMotion& c, std::span<const TimedPose> samples,
                       double shift_s, const Relation& relation, bool observed_is_continuous) {
  std::vector<double> angle, position;
  const Rigid X_RO = observed_is_continuous ? relation.X_CD.inverse() : relation.X_CD;
  const Rigid X_BoBr = observed_is_continuous ? relation.X_QP.inverse() : relation.X_QP;
  for (const TimedPose& sample : samples) {
    const HostTime t = sample.t + from_seconds(shift_s);
    if (!c.covers(t)) continue;
    const Rigid at_shift = c.motion->at(t).X_WB;
    const Rigid& reference = observed_is_continuous ? sample.X_WB : at_shift;
    const Rigid expected = X_RO * (observed_is_continuous ? at_shift : sample.X_WB) * X_BoBr;
    angle.push_back(so3::angle_between<double>(reference.q(), expected.q()) * degrees_per_rad);
    position.push_back((reference.p() - expected.p()).norm() * 1e3);
  }
  result.angle_deg = statistics_of(std::move(angle));
  result.position_mm = statistics_of(std::move(position));
  result.X_RO = X_RO;
  result.X_BoBr = X_BoBr;
}

[[nodiscard]] inline LatencyResult estimate_latency(const ContinuousMotion& c, const ContinuousMotion& d,
                                                    std::span<const TimedPose> samples, bool observed_is_continuous,
                                                    const LatencyOptions& options) {
  LatencyResult result;
  const MatchResult found = match_recordings(c, d, samples, options);
  result.status = found.status;
  if (!result.has_latency()) return result;
  const Match& match = found.match;
  const std::vector<ShiftedPair> pairs = pairs_at(c, samples, match.shift_s, match.relation);
  if (pairs.size() < 20) {
    result.status = LatencyStatus::too_few_samples;
    return result;
  }
  const bool aligned = options.frames == FrameRelation::rigid && found.status == LatencyStatus::ok;
  const Relation unshifted =
      aligned ? relation_at(c, detail::thinned(samples, 2000), 0.0).value_or(Relation{}) : Relation{};
  set_errors(result, c, samples, 0.0, unshifted, observed_is_continuous);
  result.unshifted_angle_deg_rms = result.angle_deg.rms;
  result.unshifted_position_mm_rms = result.position_mm.rms;
  set_errors(result, c, samples, match.shift_s, match.relation, observed_is_continuous);
  // X_C(t + s) ~ X_D(t): with C the observed one, it shows at t + s what was true at t.
  result.effective_latency_ms = 1e3 * (observed_is_continuous ? match.shift_s : -match.shift_s);
  result.uncertainty_ms = 1e3 * block_uncertainty(pairs);
  result.pairs = pairs.size();
  result.overlap_s = to_seconds(pairs.back().t - pairs.front().t);
  return result;
}

[[nodiscard]] inline double mean_rate_hz(std::span<const TimedPose> samples) {
  const double span_s = to_seconds(samples.back().t - samples.front().t);
  return span_s > 0.0 ? static_cast<double>(samples.size() - 1) / span_s : 0.0;
}

}  // namespace detail

/// Effective latency of `observed` against `reference`, both recorded.
[[nodiscard]] inline LatencyResult estimate_latency(std::span<const TimedPose> reference,
                                                    std::span<const TimedPose> observed,
                                                    const LatencyOptions& options = {}) {
  if (reference.size() < 20 || observed.size() < 20) {
    LatencyResult result;
    result.status = LatencyStatus::too_few_samples;
    return result;
  }
  const SplineTrajectory spline_R(reference);
  const SplineTrajectory spline_O(observed);
  const detail::ContinuousMotion r{&spline_R, reference, options.widest_gap},
      o{&spline_O, observed, options.widest_gap};
  const bool observed_is_continuous = detail::mean_rate_hz(observed) > detail::mean_rate_hz(reference);
  return observed_is_continuous ? detail::estimate_latency(o, r, reference, true, options)
                                : detail::estimate_latency(r, o, observed, false, options);
}

/// Effective latency of `observed` against a motion known at any time.
[[nodiscard]] inline LatencyResult estimate_latency(const Motion& reference, std::span<const TimedPose> observed,
                                                    const LatencyOptions& options = {}) {
  if (observed.size() < 20) {
    LatencyResult result;
    result.status = LatencyStatus::too_few_samples;
    return result;
  }
  const SplineTrajectory spline_O(observed);
  const detail::ContinuousMotion r{&reference, {}, options.widest_gap}, o{&spline_O, observed, options.widest_gap};
  return detail::estimate_latency(r, o, observed, false, options);
}

}  // namespace holdfast

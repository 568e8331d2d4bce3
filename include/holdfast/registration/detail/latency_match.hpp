/// The arithmetic of effective_latency.hpp: pairs of poses at a shift, their residuals, and the shift's Gauss-Newton
/// step.
///
/// One recording is taken as continuous (C), the other as samples (D). The model is X_C(t_i + s) = X_CD X_D(t_i) X_QP
/// with the worlds' relation X_CD and the bodies' relation X_QP (Q: D's body, P: C's body). Seconds, metres, radians.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/geometry/align_poses.hpp>
#include <holdfast/motion/motion.hpp>
#include <holdfast/motion/timed_pose.hpp>

namespace holdfast::detail {

/// A recording as a function of time that knows its gaps.
struct ContinuousMotion {
  const Motion* motion = nullptr;
  std::span<const TimedPose> knots;  ///< empty: defined everywhere between begin and end
  Duration widest_gap{0};

  /// Time t and a margin round it lie inside, and not in a gap.
  [[nodiscard]] bool covers(HostTime t, Duration margin = Duration{0}) const {
    if (t - margin < motion->begin() || t + margin > motion->end()) return false;
    if (knots.empty()) return true;
    const auto after = std::upper_bound(knots.begin(), knots.end(), t - margin,
                                        [](HostTime value, const TimedPose& knot) { return value < knot.t; });
    for (auto it = after; it != knots.end(); ++it) {
      if (it != knots.begin() && it->t - std::prev(it)->t > widest_gap) return false;
      if (it->t >= t + margin) break;
    }
    return true;
  }
};

/// How worlds and bodies of C and D are related.
struct Relation {
  Rigid X_CD;
  Rigid X_QP;
};

/// One pair at a shift: residuals and their derivative by the shift.
struct ShiftedPair {
  HostTime t;                            ///< of the sample
  Vector3 rotation, position;            ///< model less C: rotation vector in C's body, position in C's world
  Vector3 rotation_rate, position_rate;  ///< derivative by s
};

[[nodiscard]] inline std::vector<ShiftedPair> pairs_at(const ContinuousMotion& c, std::span<const TimedPose> samples,
                                                       double shift_s, const Relation& relation) {
  std::vector<ShiftedPair> pairs;
  pairs.reserve(samples.size());
  const Duration shift = from_seconds(shift_s);
  const double rest_s = shift_s - to_seconds(shift);  // below a nanosecond: by the velocity
  for (const TimedPose& sample : samples) {
    if (!c.covers(sample.t + shift)) continue;
    const MotionState state = c.motion->at(sample.t + shift);
    const Rigid model = relation.X_CD * sample.X_WB * relation.X_QP;
    const Vector3 phi = so3::log<double>(state.X_WB.q().conjugate() * model.q());
    ShiftedPair pair;
    pair.t = sample.t;
    pair.rotation_rate = -(so3::left_jacobian_inverse<double>(phi) * state.w_WB_B);
    pair.position_rate = -state.v_WB;
    pair.rotation = phi + rest_s * pair.rotation_rate;
    pair.position = model.p() - state.X_WB.p() + rest_s * pair.position_rate;
    pairs.push_back(pair);
  }
  return pairs;
}

/// Units in which a rotation and a position residual count the same.
struct ResidualScale {
  double rotation = 1.0;
  double position = 1.0;
};

/// The median sizes; the floors keep exact data finite.
[[nodiscard]] inline ResidualScale scale_of(const std::vector<ShiftedPair>& pairs) {
  std::vector<double> rotation, position;
  for (const ShiftedPair& pair : pairs) {
    rotation.push_back(pair.rotation.norm());
    position.push_back(pair.position.norm());
  }
  return {std::max(align_detail::median(rotation), 1e-10), std::max(align_detail::median(position), 1e-10)};
}

/// Normal equation of the shift, J^T W J and J^T W r; pairs far from the rest (beyond three times the median) lose
/// weight.
struct ShiftNormal {
  double information = 0.0;
  double gradient = 0.0;

  void add(const ShiftedPair& pair, const ResidualScale& scale) {
    const double size = std::max(pair.rotation.norm() / scale.rotation, pair.position.norm() / scale.position);
    const double weight = size > 3.0 ? 3.0 / size : 1.0;
    const double r2 = 1.0 / (scale.rotation * scale.rotation), p2 = 1.0 / (scale.position * scale.position);
    information += weight * (r2 * pair.rotation_rate.squaredNorm() + p2 * pair.position_rate.squaredNorm());
    gradient += weight * (r2 * pair.rotation_rate.dot(pair.rotation) + p2 * pair.position_rate.dot(pair.position));
  }
  [[nodiscard]] double step() const { return information > 0.0 ? -gradient / information : 0.0; }
};

/// Mean squared residual, in units of `scale`; infinite without pairs.
[[nodiscard]] inline double mean_cost(const std::vector<ShiftedPair>& pairs, const ResidualScale& scale) {
  if (pairs.empty()) return std::numeric_limits<double>::infinity();
  double sum = 0.0;
  for (const ShiftedPair& pair : pairs) {
    sum += pair.rotation.squaredNorm() / (scale.rotation * scale.rotation) +
           pair.position.squaredNorm() / (scale.position * scale.position);
  }
  return sum / static_cast<double>(pairs.size());
}

/// The relation that fits best at a shift; nothing when the motion does not determine it.
[[nodiscard]] inline std::optional<Relation> relation_at(const ContinuousMotion& c, std::span<const TimedPose> samples,
                                                         double shift_s) {
  std::vector<Rigid> X_C, X_D;
  const Duration shift = from_seconds(shift_s);
  for (const TimedPose& sample : samples) {
    if (!c.covers(sample.t + shift)) continue;
    X_C.push_back(c.motion->at(sample.t + shift).X_WB);
    X_D.push_back(sample.X_WB);
  }
  const std::optional<PoseAlignment> alignment = align_poses(X_C, X_D);
  if (!alignment) return std::nullopt;
  return Relation{alignment->X_AB, alignment->X_QP};
}

/// Shift and relation that fit best.
struct Match {
  double shift_s = 0.0;
  Relation relation;
  double cost = std::numeric_limits<double>::infinity();
};

/// Improves a shift (and, if `align`, the relation with it) by turns until it moves by less than a nanosecond.
[[nodiscard]] inline std::optional<Match> refine(const ContinuousMotion& c, std::span<const TimedPose> samples,
                                                 double shift_s, bool align, double longest_s) {
  Match match;
  match.shift_s = shift_s;
  for (int round = 0; round < 25; ++round) {
    if (align) {
      const std::optional<Relation> relation = relation_at(c, samples, match.shift_s);
      if (!relation) return std::nullopt;
      match.relation = *relation;
    }
    double moved = 0.0;
    for (int i = 0; i < 3; ++i) {
      const std::vector<ShiftedPair> pairs = pairs_at(c, samples, match.shift_s, match.relation);
      if (pairs.size() < 20) return std::nullopt;
      const ResidualScale scale = scale_of(pairs);
      ShiftNormal normal;
      for (const ShiftedPair& pair : pairs) normal.add(pair, scale);
      const double step = std::clamp(normal.step(), -0.02, 0.02);  // s; keeps within the basin of the coarse search
      match.shift_s = std::clamp(match.shift_s + step, -longest_s, longest_s);
      moved += std::abs(step);
      if (std::abs(step) < 1e-9) break;
    }
    if (moved < 1e-9) break;
  }
  return match;
}

/// Every n-th sample, at most `most` of them.
[[nodiscard]] inline std::vector<TimedPose> thinned(std::span<const TimedPose> samples, std::size_t most) {
  const std::size_t step = std::max<std::size_t>(1, (samples.size() + most - 1) / most);
  std::vector<TimedPose> result;
  for (std::size_t i = 0; i < samples.size(); i += step) result.push_back(samples[i]);
  return result;
}

}  // namespace holdfast::detail

/// Velocities and accelerations of sampled poses by finite differences over three neighbours.
///
/// Position: the parabola through three samples. Orientation: the parabola through the rotation vectors
/// phi(t) = log(~q_i q(t)) of the neighbours as seen from the middle sample, where w_WB_B = phi' and alpha_WB_B = phi''
/// hold exactly (phi = 0 there). The error falls with interval^2 for velocities; the intervals may differ. The two end
/// samples take the derivatives of their neighbour's parabola at their own time (first order in alpha and a). It is not
/// causal: sample i uses sample i + 1. Causal velocity: tracking/backward_difference.hpp. Precondition: times strictly
/// increase. Fewer than three samples: a constant rate, no acceleration.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <holdfast/motion/motion.hpp>
#include <holdfast/motion/timed_pose.hpp>

namespace holdfast {

namespace detail {

/// First and second derivative, at `at`, of the parabola through (0, 0), (t1, y1), (t2, y2).
struct Parabola {
  Vector3 slope, curvature;

  Parabola(double t1, const Vector3& y1, double t2, const Vector3& y2) {
    const Vector3 d1 = y1 / t1, d2 = y2 / t2;
    curvature = 2.0 * (d2 - d1) / (t2 - t1);
    slope = d1 - 0.5 * t1 * curvature;
  }
  [[nodiscard]] Vector3 slope_at(double t) const { return slope + t * curvature; }
};

/// State at samples[which], from the parabola round samples[middle].
[[nodiscard]] inline MotionState differentiate_at(std::span<const TimedPose> samples, std::size_t middle,
                                                  std::size_t which) {
  const TimedPose &before = samples[middle - 1], &centre = samples[middle], &after = samples[middle + 1];
  const double t_before = to_seconds(before.t - centre.t), t_after = to_seconds(after.t - centre.t);
  const auto phi = [&](const TimedPose& pose) { return so3::log<double>(centre.X_WB.q().conjugate() * pose.X_WB.q()); };
  const Parabola position(t_before, before.X_WB.p() - centre.X_WB.p(), t_after, after.X_WB.p() - centre.X_WB.p());
  const Parabola rotation(t_before, phi(before), t_after, phi(after));

  MotionState state;
  state.t = samples[which].t;
  state.X_WB = samples[which].X_WB;
  const double t = to_seconds(state.t - centre.t);
  state.v_WB = position.slope_at(t);
  state.a_WB = position.curvature;
  // Away from phi = 0 the rate is J_right(phi) phi'.
  const Vector3 phi_here = phi(samples[which]);
  state.w_WB_B = so3::right_jacobian<double>(phi_here) * rotation.slope_at(t);
  state.alpha_WB_B = rotation.curvature;
  return state;
}

}  // namespace detail

[[nodiscard]] inline std::vector<MotionState> differentiate(std::span<const TimedPose> samples) {
  std::vector<MotionState> states(samples.size());
  if (samples.size() < 3) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      states[i].t = samples[i].t;
      states[i].X_WB = samples[i].X_WB;
      if (samples.size() < 2) continue;
      const double dt = to_seconds(samples[1].t - samples[0].t);
      states[i].v_WB = (samples[1].X_WB.p() - samples[0].X_WB.p()) / dt;
      states[i].w_WB_B = so3::log<double>(samples[0].X_WB.q().conjugate() * samples[1].X_WB.q()) / dt;
    }
    return states;
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::size_t middle = std::clamp<std::size_t>(i, 1, samples.size() - 2);
    states[i] = detail::differentiate_at(samples, middle, i);
  }
  return states;
}

}  // namespace holdfast

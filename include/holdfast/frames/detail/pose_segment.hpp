/// The step between two neighbouring samples of a PoseHistory, measured once when the newer one is pushed.
///
/// With h half the step's angle (the angle between the quaternions a and b), u in [0, 1) the fraction of the step and
/// x = (u - 1/2) h, the rotation at a constant rate is
///   q(u) = cos(x) q_middle + (u - 1/2) sin(x) / x q_turn,
///   q_middle = (a + b) / (2 cos(h/2)),  q_turn = (b - a) h / (2 sin(h/2)).
/// Measured from the middle, x is a quarter of the step's angle at most. So for steps below 23 degrees, |x| < 0.1, a
/// few terms of a series are exact to rounding, and a lookup evaluates no trigonometric function and takes no root.
#pragma once

#include <cmath>

#include <holdfast/frames/detail/raw_vqs.hpp>
#include <holdfast/geometry/vqs.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast::detail {

struct PoseSegment {
  HostTime begin, end;  // from the older sample's time up to the newer one's, exclusive
  double per_nanosecond = 0;
  double h_squared = 0;
  Vector4 q_middle = Vector4::Zero(), q_turn = Vector4::Zero();  // (x, y, z, w)
  Vector3 v_begin = Vector3::Zero(), v_step = Vector3::Zero();
  double s_begin = 1;
  double log_growth = 0;  // log(s_end / s_begin)
  bool simple = false;    // a small step at one scale that is not too wide
  bool too_wide = false;  // wider than max_gap

  [[nodiscard]] bool covers(HostTime t) const { return begin <= t && t < end; }

  /// The transform at time t of a simple segment.
  EIGEN_ALWAYS_INLINE void interpolate_simple(HostTime t, RawVqs& T_AB) const {
    const double u = fraction(t), w = u - 0.5;
    const double x2 = w * w * h_squared;
    // The first terms dropped are x^10 / 10! < 3e-17 and x^9 / 9! < 3e-15.
    const double cosine = 1 + x2 * (-1.0 / 2 + x2 * (1.0 / 24 + x2 * (-1.0 / 720 + x2 * (1.0 / 40320))));
    const double sinc = 1 + x2 * (-1.0 / 6 + x2 * (1.0 / 120 + x2 * (-1.0 / 5040)));
    combine(u, cosine, w * sinc, T_AB);
    T_AB.s = s_begin;
  }

  /// The transform at time t of any segment.
  void interpolate(HostTime t, RawVqs& T_AB) const {
    const double u = fraction(t), w = u - 0.5;
    const double x = w * std::sqrt(h_squared);
    const double sinc = std::abs(x) < 1e-8 ? 1 : std::sin(x) / x;
    combine(u, std::cos(x), w * sinc, T_AB);
    T_AB.s = s_begin * std::exp(u * log_growth);
  }

 private:
  EIGEN_ALWAYS_INLINE void combine(double u, double middle, double turn, RawVqs& T_AB) const {
    T_AB.vx = v_begin.x() + u * v_step.x();
    T_AB.vy = v_begin.y() + u * v_step.y();
    T_AB.vz = v_begin.z() + u * v_step.z();
    T_AB.q.coeffs() = middle * q_middle + turn * q_turn;
  }
  [[nodiscard]] double fraction(HostTime t) const { return static_cast<double>((t - begin).count()) * per_nanosecond; }
};

/// The segment between a and b. Preconditions: t_a < t_b, unit quaternions, positive scales.
[[nodiscard]] inline PoseSegment pose_segment(HostTime t_a, const Vqs& a, HostTime t_b, const Vqs& b,
                                              Duration max_gap) {
  PoseSegment segment;
  segment.begin = t_a;
  segment.end = t_b;
  segment.per_nanosecond = 1 / static_cast<double>((t_b - t_a).count());
  const double side = a.q().dot(b.q()) < 0 ? -1 : 1;  // the shorter way
  const double h = 0.5 * so3::angle_between<double>(a.q(), b.q());
  segment.h_squared = h * h;
  segment.q_middle = (a.q().coeffs() + side * b.q().coeffs()) / (2 * std::cos(h / 2));
  segment.q_turn = (side * b.q().coeffs() - a.q().coeffs()) * (h < 1e-8 ? 1 : h / 2 / std::sin(h / 2));
  segment.v_begin = a.v();
  segment.v_step = b.v() - a.v();
  segment.s_begin = a.s();
  segment.log_growth = a.s() == b.s() ? 0 : std::log(b.s() / a.s());
  segment.too_wide = t_b - t_a > max_gap;
  segment.simple = h < 0.2 && segment.log_growth == 0 && !segment.too_wide;
  return segment;
}

}  // namespace holdfast::detail

/// A smooth motion through samples: twice continuously differentiable in position and orientation, with exact
/// derivatives.
///
/// Position p(t) is a cubic spline; so is s(t), four numbers through the samples' quaternions (their signs chosen so
/// that neighbours agree), and q_WB = s / |s|. From that, exactly, with Im the vector part and ~ the conjugate:
///   w_WB_B     = 2 Im(~s s') / |s|^2
///   alpha_WB_B = 2 Im(~s s'') / |s|^2 - 2 (s . s') / |s|^2 w_WB_B.
/// Knots need not be evenly spaced. Ends are "not-a-knot" (third derivative continuous at the second knot), or natural
/// where the end interval is much longer than its neighbour or there are fewer than four knots. Interpolation error
/// falls with interval^4.
///
/// Gaps: a cubic across a long gap would swing far out on the speed it had at the edge. An interval longer than five
/// medians and than 50 ms, and one in which the head turns more than 30 deg, therefore gets additional knots on the
/// straight constant-rate path. Source: de Boor, A Practical Guide to Splines, chapter IV. Precondition: at least one
/// sample, times strictly increasing. One sample is a still head, two a constant rate.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>

namespace holdfast {

namespace detail {

using Vector7 = VectorOf<double, 7>;  // p_WB, then s = (x, y, z, w)

/// Second derivatives at the knots of the interpolating cubic spline (tridiagonal system, Thomas's algorithm).
[[nodiscard]] inline std::vector<Vector7> spline_curvatures(std::span<const double> t, std::span<const Vector7> y) {
  const std::size_t n = t.size();
  std::vector<Vector7> m(n, Vector7::Zero());
  if (n < 3) return m;
  const auto h = [&](std::size_t i) { return t[i + 1] - t[i]; };
  // An end's curvature is r times its neighbour's plus (1 - r) times the next one's; natural: no curvature at all.
  constexpr double longest_ratio = 2.0;
  const double first_ratio = h(0) / h(1), last_ratio = h(n - 2) / h(n - 3);
  const bool first_smooth = n > 3 && first_ratio<longest_ratio, last_smooth = n> 3 && last_ratio < longest_ratio;

  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    double below = h(i - 1), diagonal = 2.0 * (h(i - 1) + h(i)), above = h(i);
    if (i == 1) {
      if (first_smooth) diagonal += below * (1.0 + first_ratio), above -= below * first_ratio;
      below = 0.0;
    }
    if (i == n - 2) {
      if (last_smooth) diagonal += h(i) * (1.0 + last_ratio), below -= h(i) * last_ratio;
      above = 0.0;
    }
    const Vector7 bend = 6.0 * ((y[i + 1] - y[i]) / h(i) - (y[i] - y[i - 1]) / h(i - 1));
    const double pivot = diagonal - below * upper[i - 1];
    upper[i] = above / pivot;
    m[i] = (bend - below * m[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i-- > 1;) m[i] -= upper[i] * m[i + 1];
  if (first_smooth) m[0] = m[1] + first_ratio * (m[1] - m[2]);
  if (last_smooth) m[n - 1] = m[n - 2] + last_ratio * (m[n - 2] - m[n - 3]);
  return m;
}

}  // namespace detail

class SplineTrajectory : public Motion {
 public:
  explicit SplineTrajectory(std::span<const TimedPose> samples) {
    HOLDFAST_ASSERT(!samples.empty(), "a trajectory needs a sample");
    begin_ = samples.front().t;
    end_ = samples.back().t;
    add_knots(samples);
    curvatures_ = detail::spline_curvatures(seconds_, values_);
  }

  [[nodiscard]] MotionState at(HostTime t) const override {
    MotionState state;
    state.t = clamped(t);
    Vector7 y = values_.front(), dy = Vector7::Zero(), ddy = Vector7::Zero();
    if (seconds_.size() > 1) evaluate(to_seconds(state.t - begin_), y, dy, ddy);

    const Quaternion s(y[6], y[3], y[4], y[5]), ds(dy[6], dy[3], dy[4], dy[5]), dds(ddy[6], ddy[3], ddy[4], ddy[5]);
    const double n2 = s.squaredNorm();
    const Quaternion rate = s.conjugate() * ds, curvature = s.conjugate() * dds;
    state.X_WB = Rigid(s, y.head<3>());
    state.v_WB = dy.head<3>();
    state.a_WB = ddy.head<3>();
    state.w_WB_B = 2.0 / n2 * rate.vec();
    state.alpha_WB_B = 2.0 / n2 * (curvature.vec() - rate.w() * state.w_WB_B);
    return state;
  }
  [[nodiscard]] HostTime begin() const override { return begin_; }
  [[nodiscard]] HostTime end() const override { return end_; }

 private:
  using Vector7 = detail::Vector7;

  void add_knots(std::span<const TimedPose> samples) {
    const Duration usual = std::max<Duration>(5 * median_interval(samples), std::chrono::milliseconds(50));
    add_knot(samples.front());
    for (std::size_t i = 1; i < samples.size(); ++i) {
      const TimedPose& a = samples[i - 1];
      const TimedPose& b = samples[i];
      HOLDFAST_ASSERT(b.t > a.t, "times of a trajectory must strictly increase");
      const double turns = so3::angle_between<double>(a.X_WB.q(), b.X_WB.q()) / (std::numbers::pi / 6.0);
      const double lengths = static_cast<double>((b.t - a.t).count()) / static_cast<double>(usual.count());
      const double pieces = std::clamp(std::ceil(std::max(turns, lengths)), 1.0, 10000.0);
      for (double k = 1.0; k < pieces; k += 1.0) {
        const double s = k / pieces;
        const Duration step(static_cast<std::int64_t>(s * static_cast<double>((b.t - a.t).count())));
        if (step <= Duration(0) || a.t + step <= last_knot_) continue;  // samples a few nanoseconds apart
        add_knot({a.t + step, interpolate(a.X_WB, b.X_WB, s)});
      }
      add_knot(b);
    }
  }

  void add_knot(const TimedPose& pose) {
    const Quaternion& q = pose.X_WB.q();
    Vector7 y;
    y << pose.X_WB.p(), q.x(), q.y(), q.z(), q.w();
    if (!values_.empty() && y.tail<4>().dot(values_.back().tail<4>()) < 0.0) y.tail<4>() = -y.tail<4>();
    seconds_.push_back(to_seconds(pose.t - begin_));
    values_.push_back(y);
    last_knot_ = pose.t;
  }

  void evaluate(double t, Vector7& y, Vector7& dy, Vector7& ddy) const {
    const auto after = std::ranges::upper_bound(seconds_, t);
    const auto last = static_cast<std::size_t>(seconds_.size() - 2);
    const std::size_t i =
        std::min(last, static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - seconds_.begin() - 1, 0)));
    const double h = seconds_[i + 1] - seconds_[i];
    const double b = (t - seconds_[i]) / h, a = 1.0 - b;
    const Vector7 &m0 = curvatures_[i], &m1 = curvatures_[i + 1];
    y = a * values_[i] + b * values_[i + 1] + h * h / 6.0 * ((a * a * a - a) * m0 + (b * b * b - b) * m1);
    dy = (values_[i + 1] - values_[i]) / h + h / 6.0 * ((1.0 - 3.0 * a * a) * m0 + (3.0 * b * b - 1.0) * m1);
    ddy = a * m0 + b * m1;
  }

  HostTime begin_, end_, last_knot_;
  std::vector<double> seconds_;  // since begin_
  std::vector<Vector7> values_, curvatures_;
};

}  // namespace holdfast

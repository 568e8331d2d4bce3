/// A sensor's readings as a signal of continuous time, with its derivative and its integral, and a recording's poses as arrays.
///
/// Between readings the signal is a cubic that has at each reading the slope of the parabola through it and its neighbours: the
/// integral errs with interval^4. (With straight lines, gyros at 100 Hz would seem to have a scale of 0.992 for motion at 5 Hz.)
/// Time is in seconds since an origin that both share. Beyond its ends the signal stays.
/// Precondition: at least two readings, times strictly increasing, all finite.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/so3.hpp>
#include <holdfast/motion/timed_pose.hpp>

namespace holdfast {

class SensorSignal {
 public:
  /// An interval above `longest` is a gap: what lies in it is not known.
  SensorSignal(std::vector<double> t, std::vector<Vector3> z, double longest)
      : t_(std::move(t)), z_(std::move(z)), slopes_(z_.size()), sums_(z_.size()), gaps_(z_.size(), 0) {
    HOLDFAST_ASSERT(t_.size() >= 2 && t_.size() == z_.size(), "a signal needs two readings");
    const std::size_t n = t_.size();
    for (std::size_t k = 1; k < n; ++k) {
      HOLDFAST_ASSERT(t_[k] > t_[k - 1], "a signal's times must increase");
      gaps_[k] = gaps_[k - 1] + (t_[k] - t_[k - 1] > longest ? 1 : 0);
    }
    for (std::size_t k = 0; k < n; ++k) slopes_[k] = slope_at(k);
    sums_[0].setZero();
    for (std::size_t k = 1; k < n; ++k) {
      const double h = t_[k] - t_[k - 1];
      sums_[k] = sums_[k - 1] + 0.5 * h * (z_[k - 1] + z_[k]) + h * h / 12.0 * (slopes_[k - 1] - slopes_[k]);
    }
  }

  [[nodiscard]] double begin() const { return t_.front(); }
  [[nodiscard]] double end() const { return t_.back(); }
  [[nodiscard]] const std::vector<double>& times() const { return t_; }

  /// Whether all of [from, to] is known.
  [[nodiscard]] bool covers(double from, double to) const {
    if (!(from >= t_.front() && to <= t_.back() && from <= to)) return false;
    return gaps_[piece(from)] == gaps_[piece(to) + 1];
  }

  [[nodiscard]] Vector3 at(double t) const {
    const Place p = place(t);
    const double u = p.u, u2 = u * u, u3 = u2 * u;
    return (1.0 - 3.0 * u2 + 2.0 * u3) * z_[p.k] + (3.0 * u2 - 2.0 * u3) * z_[p.k + 1] +
           p.h * ((u - 2.0 * u2 + u3) * slopes_[p.k] + (u3 - u2) * slopes_[p.k + 1]);
  }
  [[nodiscard]] Vector3 derivative(double t) const {
    const Place p = place(t);
    const double u = p.u, u2 = u * u;
    return 6.0 * (u - u2) / p.h * (z_[p.k + 1] - z_[p.k]) + (1.0 - 4.0 * u + 3.0 * u2) * slopes_[p.k] +
           (3.0 * u2 - 2.0 * u) * slopes_[p.k + 1];
  }
  /// Since the first reading.
  [[nodiscard]] Vector3 integral(double t) const {
    const Place p = place(t);
    const double u = p.u, u2 = u * u, u3 = u2 * u, u4 = u2 * u2;
    const Vector3 within =
        (u - u3 + 0.5 * u4) * z_[p.k] + (u3 - 0.5 * u4) * z_[p.k + 1] +
        p.h * ((0.5 * u2 - 2.0 / 3.0 * u3 + 0.25 * u4) * slopes_[p.k] + (0.25 * u4 - u3 / 3.0) * slopes_[p.k + 1]);
    return sums_[p.k] + p.h * within;
  }

  /// Calls f(from, to) for each piece of [from, to] between neighbouring readings.
  template <typename Function>
  void for_pieces(double from, double to, const Function& f) const {
    auto next = std::ranges::upper_bound(t_, from);
    while (from < to) {
      const double until = next == t_.end() ? to : std::min(to, *next++);
      f(from, until);
      from = until;
    }
  }

 private:
  struct Place {
    std::size_t k;
    double u, h;
  };

  [[nodiscard]] std::size_t piece(double t) const {
    const auto after = std::ranges::upper_bound(t_, t) - t_.begin();
    return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 1, 0, std::ssize(t_) - 2));
  }
  [[nodiscard]] Place place(double t) const {
    const std::size_t k = piece(t);
    const double h = t_[k + 1] - t_[k];
    return {k, std::clamp((t - t_[k]) / h, 0.0, 1.0), h};
  }
  /// Of the parabola through a reading and its neighbours; across a gap there is none.
  [[nodiscard]] Vector3 slope_at(std::size_t k) const {
    const bool has_before = k > 0 && gaps_[k] == gaps_[k - 1];
    const bool has_after = k + 1 < t_.size() && gaps_[k + 1] == gaps_[k];
    Vector3 before = Vector3::Zero(), after = Vector3::Zero();
    if (has_before) before = (z_[k] - z_[k - 1]) / (t_[k] - t_[k - 1]);
    if (has_after) after = (z_[k + 1] - z_[k]) / (t_[k + 1] - t_[k]);
    if (!has_before) return after;
    if (!has_after) return before;
    const double h0 = t_[k] - t_[k - 1], h1 = t_[k + 1] - t_[k];
    return (h1 * before + h0 * after) / (h0 + h1);
  }

  std::vector<double> t_;
  std::vector<Vector3> z_, slopes_, sums_;
  std::vector<int> gaps_;  // before and at each reading
};

/// The tracker's poses, and the sum of the turns between them: the integral of w_WB_B but for interval^2.
struct PoseArrays {
  std::vector<double> t;
  std::vector<Quaternion> q_WB;
  std::vector<Vector3> p_WB, turned_B;

  /// Precondition: times strictly increasing.
  PoseArrays(std::span<const TimedPose> poses, HostTime origin) {
    Vector3 turned = Vector3::Zero();
    for (const TimedPose& pose : poses) {
      if (!q_WB.empty()) turned += so3::log<double>(q_WB.back().conjugate() * pose.X_WB.q());
      t.push_back(to_seconds(pose.t - origin));
      q_WB.push_back(pose.X_WB.q());
      p_WB.push_back(pose.X_WB.p());
      turned_B.push_back(turned);
    }
  }
  [[nodiscard]] std::size_t size() const { return t.size(); }

  /// Every pose, or those at least `spacing` apart. Comparisons begin and end at these: where one's end is another's begin, the
  /// pose's noise cancels.
  [[nodiscard]] std::vector<std::size_t> spaced(double spacing) const {
    std::vector<std::size_t> taken;
    for (std::size_t i = 0; i < size(); ++i) {
      if (taken.empty() || t[i] - t[taken.back()] >= 0.999 * spacing) taken.push_back(i);
    }
    return taken;
  }
};

/// A straight-line combination of the poses first, first + 1, ...: the part of a comparison that the poses' noise enters by.
struct PoseWindow {
  std::size_t first = 0;
  std::vector<double> weights;

  [[nodiscard]] std::size_t last() const { return first + weights.size() - 1; }
};

}  // namespace holdfast

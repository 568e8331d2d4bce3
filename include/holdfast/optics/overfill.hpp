/// Overfill: how much wider than the view a picture must be drawn, so that a late deflection still finds pixels at the
/// edges.
///
/// E is the displayed eye, S the eye that the source picture was drawn by. A point seen at the tangents t_E, at depth d
/// or farther, has in S the direction
///
///     w = R_SE (t_E, -1) + p_SE / d        R_SE = R_y(yaw) R_x(pitch) R_z(roll)
///
/// with each angle anywhere within its budget, either way, and p_SE of any direction and at most translation_m long.
/// The answer is the smallest field of tangents that holds every such w. It is found to rounding: for a line of slope X
/// that bounds the field on one side, the farthest w maximises the linear (1, 0, X) . w, over each angle in closed form
/// and over t_E at a corner; X then moves to that w until none is beyond (Dinkelbach's method, quadratic convergence).
/// Per-scanline: a budget that grows from the first to the last lit line needs less, if each line asks for its own.
/// Units: radians in Angle, metres, tangents. Bad input: problem_of names it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include <holdfast/optics/eye.hpp>
#include <holdfast/timing/clock.hpp>
#include <holdfast/tracking/head_dynamics.hpp>

namespace holdfast {

/// The most that the eye turns and moves between the pose drawn with and the light, either way.
struct DeflectionBudget {
  Angle yaw, pitch, roll;                                      ///< about E's Y, X and Z, each 0 to 90 degrees
  double translation_m = 0.0;                                  ///< of the eye, in any direction
  double nearest_m = std::numeric_limits<double>::infinity();  ///< depth of the nearest thing drawn
};

/// The budget of a head that moves as `dynamics` says (root mean squares per axis), for a picture that is `age` old
/// when the last line lights: `sigmas` times sqrt((w t)^2 + (a t^2 / 2)^2) about and along each axis. With
/// angular_speed_rad_s = 0 and speed_m_s = 0 it is what prediction at constant velocity leaves.
[[nodiscard]] inline DeflectionBudget budget_of(const HeadDynamics& dynamics, Duration age,
                                                double nearest_m = std::numeric_limits<double>::infinity(),
                                                double sigmas = 3.0) {
  const double t = to_seconds(age);
  const Angle angle = radians(
      sigmas * std::hypot(dynamics.angular_speed_rad_s * t, dynamics.angular_acceleration_rad_s2 * t * t / 2.0));
  const double along = sigmas * std::hypot(dynamics.speed_m_s * t, dynamics.acceleration_m_s2 * t * t / 2.0);
  return {angle, angle, angle, std::sqrt(3.0) * along, nearest_m};
}

namespace detail {

/// Points (x, y, -1) of an outline as the deflection may move them, and the farthest of them.
class Overfill {
 public:
  explicit Overfill(const DeflectionBudget& budget)
      : most_{budget.yaw.radians(), budget.pitch.radians(), budget.roll.radians()},
        shift_(std::isinf(budget.nearest_m) ? 0.0 : budget.translation_m / budget.nearest_m) {}

  /// The largest tangent along `axis` (0: x, 1: y) that any of the points reaches; nothing when that is 90 degrees or
  /// more from the axis, or behind.
  [[nodiscard]] std::optional<double> largest(std::span<const Vector2> points, int axis) const {
    double slope = -std::numeric_limits<double>::infinity();
    for (const Vector2& p : points) {
      const std::optional<double> own = tangent_of(Vector3(p.x(), p.y(), -1.0), axis);
      if (!own) return std::nullopt;
      slope = std::max(slope, *own);
    }
    constexpr int most_steps = 60;
    for (int i = 0; i < most_steps; ++i) {
      Vector3 n = Vector3::UnitZ() * slope;
      n[axis] = 1.0;
      const std::optional<double> farther = tangent_of(farthest(points, n), axis);
      if (!farther) return std::nullopt;
      if (!(*farther > slope)) break;
      slope = *farther;
    }
    return slope;
  }

 private:
  /// The tangent along `axis` at which direction w is seen once it is moved outward by the shift.
  [[nodiscard]] std::optional<double> tangent_of(const Vector3& w, int axis) const {
    const double along = w[axis], ahead = -w.z();
    const double length = std::hypot(along, ahead);
    if (!(ahead > 0.0) || !(shift_ < length)) return std::nullopt;
    if (shift_ == 0.0) return along / ahead;
    const double angle = std::atan2(along, ahead) + std::asin(shift_ / length);
    return angle < std::numbers::pi / 2.0 ? std::optional(std::tan(angle)) : std::nullopt;
  }

  /// R (x, y, -1) that maximises n . R (x, y, -1).
  [[nodiscard]] Vector3 farthest(std::span<const Vector2> points, const Vector3& n) const {
    Vector3 best = Vector3::Zero();
    double most = -std::numeric_limits<double>::infinity();
    for (const Vector2& p : points) {
      const Vector3 v(p.x(), p.y(), -1.0);
      for (int start = 0; start < 8; ++start) {
        const Vector3 w = climbed(v, n, start);
        if (!(n.dot(w) > most)) continue;
        most = n.dot(w);
        best = w;
      }
    }
    return best;
  }

  /// From one corner of the budget, each angle in turn goes where n . w is largest, until none moves.
  [[nodiscard]] Vector3 climbed(const Vector3& v, const Vector3& n, int start) const {
    std::array<double, 3> angle;
    for (std::size_t k = 0; k < 3; ++k) angle[k] = (start >> k) & 1 ? most_[k] : -most_[k];
    constexpr int most_rounds = 30;
    for (int round = 0; round < most_rounds; ++round) {
      bool moved = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const double best = best_angle(v, n, angle, k);
        moved = moved || std::abs(best - angle[k]) > 1e-12;
        angle[k] = best;
      }
      if (!moved) break;
    }
    return turned(v, angle, 0, 3);
  }

  /// n . R(angles) v as a function of one angle is A cos + B sin + C: largest at atan2(B, A), or at an end.
  [[nodiscard]] double best_angle(const Vector3& v, const Vector3& n, const std::array<double, 3>& angle,
                                  std::size_t k) const {
    const Vector3 u = turned(v, angle, k + 1, 3);
    Vector3 m = n;
    for (std::size_t i = 0; i < k; ++i) m = rotation(i, -angle[i]) * m;
    const Vector3 axis = axis_of(k);
    const double A = m.dot(u) - m.dot(axis) * u.dot(axis);
    const double B = m.dot(axis.cross(u));
    const double best = std::atan2(B, A);
    if (std::abs(best) <= most_[k]) return best;
    const double at_end = A * std::cos(most_[k]);
    const double swing = B * std::sin(most_[k]);
    return at_end + swing >= at_end - swing ? most_[k] : -most_[k];
  }

  [[nodiscard]] static Vector3 axis_of(std::size_t k) {
    return k == 0 ? Vector3::UnitY() : k == 1 ? Vector3::UnitX() : Vector3::UnitZ();
  }
  [[nodiscard]] static Matrix3 rotation(std::size_t k, double angle) {
    return Eigen::AngleAxisd(angle, Eigen::Vector3d(axis_of(k))).toRotationMatrix();
  }
  /// The rotations first to last - 1 of yaw, pitch, roll applied to v, the last one first.
  [[nodiscard]] static Vector3 turned(Vector3 v, const std::array<double, 3>& angle, std::size_t first,
                                      std::size_t last) {
    for (std::size_t i = last; i-- > first;) v = rotation(i, angle[i]) * v;
    return v;
  }

  std::array<double, 3> most_;
  double shift_;
};

}  // namespace detail

[[nodiscard]] inline FieldProblem problem_of(const DeflectionBudget& budget) {
  for (const Angle angle : {budget.yaw, budget.pitch, budget.roll}) {
    if (!std::isfinite(angle.radians())) return FieldProblem::not_finite;
    if (!(angle.radians() >= 0.0 && angle.radians() <= std::numbers::pi / 2.0)) return FieldProblem::angle_beyond_90;
  }
  if (!std::isfinite(budget.translation_m) || std::isnan(budget.nearest_m)) return FieldProblem::not_finite;
  if (budget.translation_m < 0.0 || !(budget.nearest_m > 0.0)) return FieldProblem::extent_not_positive;
  return FieldProblem::none;
}

/// The smallest field that holds all of `points` (tangents in E) wherever the budget takes them. Empty points: no width.
[[nodiscard]] inline FieldResult overfilled_points(std::span<const Vector2> points, const DeflectionBudget& budget) {
  FieldResult result;
  result.problem = points.empty() ? FieldProblem::zero_width : problem_of(budget);
  if (!result.ok()) return result;
  const detail::Overfill overfill(budget);
  // Left and down are right and up of the mirrored outline: the budget is the same either way.
  std::vector<Vector2> mirrored_x, mirrored_y;
  for (const Vector2& p : points) {
    mirrored_x.emplace_back(-p.x(), p.y());
    mirrored_y.emplace_back(p.x(), -p.y());
  }
  const auto left = overfill.largest(mirrored_x, 0), right = overfill.largest(points, 0);
  const auto down = overfill.largest(mirrored_y, 1), up = overfill.largest(points, 1);
  if (!left || !right || !down || !up) {
    result.problem = FieldProblem::angle_beyond_90;
    return result;
  }
  result.tangents = {-*left, *right, -*down, *up};
  return result;
}

/// The same for the whole of a field; edges in swapped order stay so.
[[nodiscard]] inline FieldResult try_overfilled(const FieldTangents& field, const DeflectionBudget& budget) {
  if (const FieldProblem problem = problem_of(field); problem != FieldProblem::none) return {field, problem};
  const std::array<Vector2, 4> corners{Vector2(field.left, field.down), Vector2(field.right, field.down),
                                       Vector2(field.left, field.up), Vector2(field.right, field.up)};
  FieldResult result = overfilled_points(corners, budget);
  if (is_mirrored_x(field)) std::swap(result.tangents.left, result.tangents.right);
  if (is_mirrored_y(field)) std::swap(result.tangents.down, result.tangents.up);
  return result;
}

/// Precondition: the field and budget are possible and no part of the field is turned 90 degrees from the axis;
/// try_overfilled tells.
[[nodiscard]] inline FieldTangents overfilled(const FieldTangents& field, const DeflectionBudget& budget) {
  return try_overfilled(field, budget).value();
}

/// Pixels for the field `wider` that are as dense as `size` pixels for `field`, rounded up.
[[nodiscard]] inline PixelSize overfilled_size(const PixelSize& size, const FieldTangents& field,
                                               const FieldTangents& wider) {
  const auto pixels = [](int count, double own, double wide) {
    // Less by what rounding to float may do: an unchanged field keeps its pixels.
    const double most = std::numeric_limits<int>::max();  // of a field that nears 90 degrees
    return static_cast<int>(std::min(most, std::ceil(count * std::abs(wide / own) - 1e-6 * count)));
  };
  return {pixels(size.width, field.right - field.left, wider.right - wider.left),
          pixels(size.height, field.up - field.down, wider.up - wider.down)};
}

[[nodiscard]] inline PixelSize overfilled_size(const EyeModel& eye, const FieldTangents& wider) {
  return overfilled_size(eye.resolution, eye.tangents, wider);
}

/// The picture that one eye's renderer fills.
struct EyePicture {
  FieldTangents tangents;  ///< of the picture's edges
  PixelSize size;
};

/// `wider`, moved outward to whole pixels of the eye's own picture: each of its pixels is then exactly one of the wider
/// picture. Precondition: `wider` holds the eye's tangents, edges in the same order.
[[nodiscard]] inline EyePicture whole_pixels(const EyeModel& eye, const FieldTangents& wider) {
  const FieldTangents& t = eye.tangents;
  const double dx = (t.right - t.left) / eye.resolution.width, dy = (t.up - t.down) / eye.resolution.height;
  const auto count = [](double more, double pixel) { return static_cast<int>(std::ceil(more / pixel - 1e-9)); };
  const int left = count(t.left - wider.left, dx), right = count(wider.right - t.right, dx);
  const int down = count(t.down - wider.down, dy), up = count(wider.up - t.up, dy);
  return {{t.left - left * dx, t.right + right * dx, t.down - down * dy, t.up + up * dy},
          {eye.resolution.width + left + right, eye.resolution.height + down + up}};
}

}  // namespace holdfast

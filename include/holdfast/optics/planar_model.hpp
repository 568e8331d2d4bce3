/// The part that lenses without rotational symmetry share: any smooth map f of the plane, inverted exactly on a disc.
///
/// The domain is the largest disc round the origin inside which the symmetric part of P f' is positive definite, with
/// P = f'(0)^-1. On a convex set that proves f one-to-one: for a, b in it (a - b) . P (f(a) - f(b)) > 0. It is found
/// numerically: the smaller eigenvalue on rings of 96 points, outward to the map's own limit, must stay above 1 % of its
/// value at the centre (which is 1), and then on four rings of 720 points. So a fold is found short of where it is, by
/// about 0.5 %.
///
/// undistort is Newton's iteration, guarded so that it always ends with the answer: steps are cut off at the disc's
/// edge and halved until they come nearer; where none does, the step is a projected one of u + (m / L^2) (v' - g(u)), g
/// = P f, v' = P v, which on a disc always does (m and L bound the eigenvalues of the symmetric part of g' from below and
/// its norm from above). A point u of the edge proves that v has no origin in the disc when |v' - g(u)| is larger than any origin
/// near u would allow (proves_outside). The residual is a few roundings of v; elsewhere: nothing. Nothing allocates.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens_model.hpp>
#include <holdfast/optics/radial_model.hpp>

namespace holdfast {

/// f(u) and f'(u).
struct PlanarValue {
  Vector2 seen = Vector2::Zero();
  Matrix2 J = Matrix2::Identity();
};

template <typename M>
concept PlanarMap = requires(const M& map, const Vector2& u) {
  { map.at(u) } -> std::same_as<PlanarValue>;
  { map.limit() } -> std::same_as<double>;  ///< the map is smooth, and of interest, up to this radius
};

namespace detail {

/// The disc in which a map is proven one-to-one, in units of the map, and the bounds that its inverse needs.
struct PlanarDomain {
  double radius = 0.0;
  double image_radius = 0.0;    ///< a disc round the origin that f surely covers
  double smallest_slope = 0.0;  ///< m: of the symmetric part of P f'
  double largest_slope = 0.0;   ///< L: of |P f'|
};

/// The smaller eigenvalue of A's symmetric part.
[[nodiscard]] inline double smaller_symmetric_eigenvalue(const Matrix2& A) {
  return (A(0, 0) + A(1, 1)) / 2.0 - std::hypot((A(0, 0) - A(1, 1)) / 2.0, (A(0, 1) + A(1, 0)) / 2.0);
}

[[nodiscard]] inline Vector2 on_circle(double radius, int i, int count) {
  const double angle = 2.0 * std::numbers::pi * i / count;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

template <PlanarMap M>
[[nodiscard]] double worst_slope_on_ring(const M& map, const Matrix2& P, double radius, int count) {
  double worst = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count; ++i) {
    const double slope = smaller_symmetric_eigenvalue(P * map.at(on_circle(radius, i, count)).J);
    if (!(slope > 0.0)) return -1.0;
    worst = std::min(worst, slope);
  }
  return worst;
}

inline constexpr double least_planar_slope = 0.01;

/// Where the rings first fall below least_planar_slope.
template <PlanarMap M>
[[nodiscard]] double proven_radius(const M& map, const Matrix2& P) {
  constexpr int points = 96;
  constexpr int rings = 192;
  const auto good = [&](double radius, int count) {
    return worst_slope_on_ring(map, P, radius, count) >= least_planar_slope;
  };
  double inner = 0.0;
  double outer = map.limit();
  for (int i = 1; i <= rings && inner < outer; ++i) {
    const double radius = map.limit() * i * i / (double(rings) * rings);  // closer rings near the centre
    if (good(radius, points)) {
      inner = radius;
    } else {
      outer = radius;
    }
    if (outer < map.limit()) break;
  }
  if (inner < outer) {
    for (int i = 0; i < 30; ++i) {
      const double middle = (inner + outer) / 2.0;
      (good(middle, points) ? inner : outer) = middle;
    }
  }
  for (const double part : {0.25, 0.5, 0.75, 1.0}) {
    while (inner > 0.0 && !good(part * inner, 720)) inner *= 0.995;
  }
  return inner;
}

template <PlanarMap M>
[[nodiscard]] PlanarDomain planar_domain(const M& map, const Matrix2& P, const Vector2& f0) {
  PlanarDomain domain;
  domain.radius = proven_radius(map, P);
  if (!(domain.radius > 0.0)) return domain;
  constexpr int points = 256;
  constexpr int rings = 16;
  domain.smallest_slope = 1.0;
  for (int ring = 0; ring <= rings; ++ring) {
    for (int i = 0; i < points; ++i) {
      const Matrix2 J = P * map.at(on_circle(domain.radius * ring / rings, i, points)).J;
      domain.smallest_slope = std::min(domain.smallest_slope, smaller_symmetric_eigenvalue(J));
      domain.largest_slope = std::max(domain.largest_slope, J.norm());
    }
  }
  domain.smallest_slope *= 0.9;  // what lies between the samples
  domain.largest_slope *= 1.1;
  // The edge's image encloses what is covered. Between samples it comes nearer by at most half a step's way.
  constexpr int edge_points = 2048;
  const double half_step = 1.2 * std::numbers::pi * domain.radius / edge_points;
  double from_centre = std::numeric_limits<double>::infinity();
  double from_origin = from_centre;
  for (int i = 0; i < edge_points; ++i) {
    const Vector2 edge = on_circle(domain.radius, i, edge_points);
    const PlanarValue f = map.at(edge);
    const double between = half_step * (f.J * Vector2(-edge.y(), edge.x())).norm() / domain.radius;
    from_centre = std::min(from_centre, (f.seen - f0).norm() - between);
    from_origin = std::min(from_origin, f.seen.norm() - between);
  }
  domain.image_radius = f0.norm() < from_centre ? std::max(0.0, from_origin) : 0.0;
  return domain;
}

}  // namespace detail

template <PlanarMap M>
class PlanarModel {
 public:
  /// Precondition: det f'(0) > 0.
  explicit PlanarModel(M map = M()) : map_(std::move(map)) {
    const PlanarValue centre = map_.at(Vector2::Zero());
    f0_ = centre.seen;
    P_ = centre.J.inverse();
    domain_ = detail::planar_domain(map_, P_, f0_);
  }

  [[nodiscard]] const M& map() const { return map_; }
  [[nodiscard]] double valid_radius() const { return domain_.radius; }
  [[nodiscard]] double valid_image_radius() const { return domain_.image_radius; }

  [[nodiscard]] std::optional<Vector2> distort(const Vector2& u) const {
    if (!(u.squaredNorm() <= domain_.radius * domain_.radius * detail::fold_slack)) return std::nullopt;
    return map_.at(u).seen;
  }
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& u) const { return map_.at(u).J; }
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& v) const {
    return inverted_jacobian(*this, v);
  }

  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const {
    if (!v.allFinite() || !(domain_.radius > 0.0)) return std::nullopt;
    const double rounding = 4e-16 * (v.norm() + f0_.norm());
    Vector2 u = inside(P_ * (v - f0_));
    PlanarValue f = map_.at(u);
    for (int i = 0; i < newton_steps; ++i) {
      const Vector2 missing = v - f.seen;
      const double error = missing.norm();
      if (error <= rounding) return u;
      if (proves_outside(u, P_ * missing)) return std::nullopt;
      const Vector2 step = f.J.inverse() * missing;
      Vector2 next = inside(u + step);
      // Newton's error is quadratic: after a step this small it is far below rounding.
      if (step.squaredNorm() <= 1e-18 * next.squaredNorm()) return next;
      PlanarValue next_f = map_.at(next);
      for (double part = 0.5; !((v - next_f.seen).norm() < (1.0 - 0.1 * part) * error) && part > 0.01; part *= 0.5) {
        next = inside(u + part * step);
        next_f = map_.at(next);
      }
      if (!((v - next_f.seen).norm() < error)) {
        next = contracted(u, missing);
        next_f = map_.at(next);
      }
      u = next;
      f = next_f;
    }
    return slow_undistort(v, u, 1e-13 * (1.0 + v.norm()));
  }

  friend bool operator==(const PlanarModel& a, const PlanarModel& b) { return a.map_ == b.map_; }

 private:
  static constexpr int newton_steps = 60;

  [[nodiscard]] Vector2 inside(const Vector2& u) const {
    const double r = u.norm();
    return r <= domain_.radius ? u : Vector2(u * (domain_.radius / r));
  }
  /// The projected step that comes nearer to the one solution whatever the map, if slowly.
  [[nodiscard]] Vector2 contracted(const Vector2& u, const Vector2& missing) const {
    const double gain = domain_.smallest_slope / (domain_.largest_slope * domain_.largest_slope);
    return inside(u + gain * (P_ * missing));
  }
  /// With d = v' - g(u) at an edge point u, and w the origin of v at distance s from u inside the disc: d . (w - u) >=
  /// m s^2, and (w - u) . n <= -s^2 / 2R for the outward normal n. So s is at most |d_t| / (m + d_n / 2R), with d_t and
  /// d_n the tangential and the normal part of d, and |d| at most L s.
  [[nodiscard]] bool proves_outside(const Vector2& u, const Vector2& d) const {
    const double R = domain_.radius;
    const double r = u.norm();
    if (!(r > 0.999999999 * R)) return false;
    const Vector2 n = u / r;
    const double normal = d.dot(n);
    if (!(normal > 0.0)) return false;
    const double tangential = std::abs(n.x() * d.y() - n.y() * d.x());
    return d.norm() * (domain_.smallest_slope + normal / (2.0 * R)) > 1.01 * domain_.largest_slope * tangential;
  }
  /// What is left when Newton's steps were all cut off: points within a hair of the edge's image.
  [[nodiscard]] std::optional<Vector2> slow_undistort(const Vector2& v, Vector2 u, double tolerance) const {
    for (int i = 0; i < 2000; ++i) {
      const Vector2 missing = v - map_.at(u).seen;
      if (missing.norm() <= tolerance) return u;
      if (proves_outside(u, P_ * missing)) return std::nullopt;
      u = contracted(u, missing);
    }
    return std::nullopt;
  }

  M map_;
  Vector2 f0_ = Vector2::Zero();
  Matrix2 P_ = Matrix2::Identity();
  detail::PlanarDomain domain_;
};

}  // namespace holdfast

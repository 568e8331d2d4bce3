/// The part that all rotationally symmetric lenses share: a function f of the radius, inverted exactly.
///
///     distort(p) = p f(r) / r,   r = |p|          undistort(v) = v r / |v|,   f(r) = |v|
///     d distort / d p = s I + (f' - s) p p^T / r^2,   s = f / r
///
/// A profile says what f is. It must rise from f(0) = 0 with f'(0) > 0, and tells how far it does (fold): the domain is
/// that disc, and the seen domain the disc of radius f(fold). The inverse is Newton's iteration kept inside a bracket;
/// it is right to rounding. Units: one for all radii, the profile's.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens_model.hpp>

namespace holdfast {

/// f(r) and its derivative.
struct RadialValue {
  double seen = 0.0;
  double slope = 1.0;
};

template <typename P>
concept RadialProfile = requires(const P& profile, double r) {
  { profile.scale(r) } -> std::same_as<double>;    ///< f(r) / r, of r^2 (so that even polynomials need no root)
  { profile.at(r) } -> std::same_as<RadialValue>;  ///< of r
  { profile.fold() } -> std::same_as<double>;      ///< up to which f rises; may be infinite
};

/// Profiles whose slope jumps at one radius say where. All others are smooth, or nearly: their slope is continuous.
template <typename P>
concept KinkedProfile = requires(const P& profile) {
  { profile.kink() } -> std::same_as<double>;
};

namespace detail {

/// Radii this much beyond the fold still count as on it: the rounding of a point scaled to the fold's radius.
inline constexpr double fold_slack = 1.0 + 1e-14;

[[nodiscard]] inline Matrix2 radial_jacobian(const Vector2& p, double scale, double slope) {
  const double r2 = p.squaredNorm();
  Matrix2 J = scale * Matrix2::Identity();
  if (r2 > 0.0) J += ((slope - scale) / r2) * p * p.transpose();
  return J;
}

/// The r of [0, fold] with f(r) = seen, for seen in (0, f(fold)].
template <RadialProfile P>
[[nodiscard]] double inverted_radius(const P& profile, double seen, double fold) {
  double low = 0.0;
  double high = fold;
  double r = std::min(seen, fold);
  double last_step = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 200; ++i) {
    const RadialValue f = profile.at(r);
    const double error = f.seen - seen;
    if (error == 0.0) return r;
    (error > 0.0 ? high : low) = r;
    const double step = error / f.slope;
    // Newton's error is quadratic: after a step this small f misses `seen` by f'' step^2 / 2, far below rounding.
    if (std::abs(step) <= 1e-9 * r) return std::clamp(r - step, low, high);
    double next = r - step;
    // A step that leaves the bracket, or is not half the last one (high powers far out), is one of bisection instead.
    if (!(next > low && next < high) || !(std::abs(step) < 0.5 * last_step)) {
      next = std::isfinite(high) ? low + (high - low) / 2.0 : 2.0 * r;
    }
    if (next == r) return r;
    last_step = std::abs(next - r);
    r = next;
  }
  return r;
}

}  // namespace detail

/// Lenses that are a function of the radius alone, with its profile at hand.
template <typename M>
concept RadiallySymmetric = requires(const M& model) {
  requires RadialProfile<std::remove_cvref_t<decltype(model.profile())>>;
};

template <RadialProfile P>
class RadialModel {
 public:
  explicit RadialModel(P profile = P())
      : profile_(std::move(profile)),
        fold_(profile_.fold()),
        image_fold_(std::isfinite(fold_) ? profile_.at(fold_).seen : std::numeric_limits<double>::infinity()) {}

  [[nodiscard]] const P& profile() const { return profile_; }
  [[nodiscard]] double valid_radius() const { return fold_; }
  [[nodiscard]] double valid_image_radius() const { return image_fold_; }

  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const {
    const double r2 = p.squaredNorm();
    if (!(r2 <= fold_ * fold_ * detail::fold_slack) || !std::isfinite(r2)) return std::nullopt;
    return Vector2(p * profile_.scale(r2));
  }
  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const {
    const double seen = v.norm();
    if (!(seen <= image_fold_ * detail::fold_slack) || !std::isfinite(seen)) return std::nullopt;
    if (!(seen > 0.0)) return v;
    return Vector2(v * (detail::inverted_radius(profile_, std::min(seen, image_fold_), fold_) / seen));
  }
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& p) const {
    const double r2 = p.squaredNorm();
    return detail::radial_jacobian(p, profile_.scale(r2), profile_.at(std::sqrt(r2)).slope);
  }
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& v) const {
    return inverted_jacobian(*this, v);
  }

  friend bool operator==(const RadialModel&, const RadialModel&) = default;

 private:
  P profile_;
  double fold_ = 0.0;
  double image_fold_ = 0.0;
};

}  // namespace holdfast

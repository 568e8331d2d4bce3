/// Kannala-Brandt fisheye lens, OpenCV's cv::fisheye.
///
/// Its formula goes from the direction that is seen to the panel (for a camera: to the image), so here undistort is the
/// closed form and distort the one that iterates. With the seen angle theta = atan |v|:
///
///     undistort(v) = v / |v| (theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9)
///
///     distort(p) = p / |p| tan(theta),     theta + k1 theta^3 + ... = |p|
///
/// Source: Kannala & Brandt 2006, eq. 6 with the first coefficient taken into the focal length; cv::fisheye and
/// Kalibr's `equi` name the rest k1 to k4, camodocal k2 to k5. Unit of p: radians near the axis, that is pixels from the
/// principal point over the focal length. The domain ends where the polynomial folds over, or where the seen tangent
/// is 100 (89.4 degrees): no flat picture shows more. Bad input: KannalaBrandtLens::problem_of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens_model.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/polynomial_lens.hpp>
#include <holdfast/optics/radial_model.hpp>

namespace holdfast {

class KannalaBrandtLens {
 public:
  using Coefficients = std::array<double, 4>;  ///< k1 ... k4

  KannalaBrandtLens() : KannalaBrandtLens(Coefficients{}) {}
  explicit KannalaBrandtLens(const Coefficients& k) : k_(k), polynomial_(k, 1.0) {
    HOLDFAST_ASSERT(problem_of(k) == LensProblem::none, "unusable lens coefficients");
    theta_max_ = std::min(polynomial_.fold(), std::atan(100.0));
    panel_max_ = polynomial_.at(theta_max_).seen;
    tangent_max_ = std::tan(theta_max_);
  }

  [[nodiscard]] static LensProblem problem_of(const Coefficients& k) {
    return detail::all_finite(k) ? LensProblem::none : LensProblem::not_finite;
  }

  [[nodiscard]] const Coefficients& coefficients() const { return k_; }
  [[nodiscard]] double valid_radius() const { return panel_max_; }
  [[nodiscard]] double valid_image_radius() const { return tangent_max_; }

  [[nodiscard]] std::optional<Vector2> distort(const Vector2& p) const {
    const double r = p.norm();
    if (!(r <= panel_max_ * detail::fold_slack)) return std::nullopt;
    if (!(r > 0.0)) return p;
    return Vector2(p * (std::tan(seen_angle(r)) / r));
  }
  [[nodiscard]] std::optional<Vector2> undistort(const Vector2& v) const {
    const double tangent = v.norm();
    if (!(tangent <= tangent_max_ * detail::fold_slack)) return std::nullopt;
    if (!(tangent > 0.0)) return v;
    return Vector2(v * (polynomial_.at(std::atan(tangent)).seen / tangent));
  }
  [[nodiscard]] Matrix2 distort_jacobian(const Vector2& p) const {
    const double r = p.norm();
    if (!(r > 0.0)) return Matrix2::Identity();
    const double theta = seen_angle(std::min(r, panel_max_));
    const double tangent = std::tan(theta);
    return detail::radial_jacobian(p, tangent / r, (1.0 + tangent * tangent) / polynomial_.at(theta).slope);
  }
  [[nodiscard]] std::optional<Matrix2> undistort_jacobian(const Vector2& v) const {
    const double tangent = v.norm();
    if (!(tangent <= tangent_max_ * detail::fold_slack)) return std::nullopt;
    if (!(tangent > 0.0)) return Matrix2::Identity();
    const RadialValue panel = polynomial_.at(std::atan(tangent));
    return detail::radial_jacobian(v, panel.seen / tangent, panel.slope / (1.0 + tangent * tangent));
  }

  friend bool operator==(const KannalaBrandtLens&, const KannalaBrandtLens&) = default;

 private:
  [[nodiscard]] double seen_angle(double r) const {
    return detail::inverted_radius(polynomial_, std::min(r, panel_max_), theta_max_);
  }

  Coefficients k_;
  EvenPolynomial polynomial_;
  double theta_max_ = 0.0;
  double panel_max_ = 0.0;
  double tangent_max_ = 0.0;
};

}  // namespace holdfast

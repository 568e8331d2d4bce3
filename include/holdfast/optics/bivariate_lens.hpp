/// Lens by two bivariate polynomials of third degree in each variable: Project North Star's and other combiners without
/// an axis.
///
///     distort(p) = (sum x_ij p_x^i p_y^j,  sum y_ij p_x^i p_y^j),     i, j = 0 ... 3,   x_ij = x[4 i + j]
///
/// The origin need not stay in place, nor the slopes there be 1. Domain (a disc round the origin, up to `limit`) and
/// inverse as in PlanarModel; unit: tangents. Bad input: BivariateLens::problem_of.
/// north_star_eye turns the calibration of North Star's second generation into such a lens and the panel's tangents.
/// Source: Project North Star, calibration v2 (calibrateGraycodes.py: `polyval2d`, `*_uv_to_rect_x|y`): the ray is
/// (rect_x, rect_y, 1) with y down, for v^i u^j, where u runs 0 to 1 to the right over the eye's picture and v down.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/planar_model.hpp>
#include <holdfast/optics/tangents.hpp>

namespace holdfast {

struct BivariateCoefficients {
  std::array<double, 16> x{0, 0, 0, 0, 1};  ///< x[4 i + j] of p_x^i p_y^j
  std::array<double, 16> y{0, 1};
  double limit = 10.0;  ///< how far from the origin the polynomials are meant to hold, > 0

  friend bool operator==(const BivariateCoefficients&, const BivariateCoefficients&) = default;
};

namespace detail {

/// Value and derivatives by a and b of sum c[4 i + j] a^i b^j.
[[nodiscard]] inline Vector3 bicubic(const std::array<double, 16>& c, double a, double b) {
  double value = 0.0;
  double by_a = 0.0;
  double by_b = 0.0;
  for (std::size_t i = 4; i-- > 0;) {
    const double* row = &c[4 * i];
    const double in_b = row[0] + b * (row[1] + b * (row[2] + b * row[3]));
    by_a = by_a * a + value;
    value = value * a + in_b;
    by_b = by_b * a + row[1] + b * (2.0 * row[2] + b * 3.0 * row[3]);
  }
  return {value, by_a, by_b};
}

/// The same polynomial in a', b' with a = a0 + a_step a', b = b0 + b_step b'.
[[nodiscard]] inline std::array<double, 16> bicubic_moved(const std::array<double, 16>& c, double a0, double a_step,
                                                          double b0, double b_step) {
  constexpr double choose[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
  std::array<double, 16> moved{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t k = 0; k <= i; ++k) {
        for (std::size_t l = 0; l <= j; ++l) {
          moved[4 * k + l] += c[4 * i + j] * choose[i][k] * std::pow(a0, double(i - k)) * std::pow(a_step, double(k)) *
                              choose[j][l] * std::pow(b0, double(j - l)) * std::pow(b_step, double(l));
        }
      }
    }
  }
  return moved;
}

}  // namespace detail

class BivariateMap {
 public:
  BivariateMap() = default;
  explicit BivariateMap(const BivariateCoefficients& c) : c_(c) {}

  [[nodiscard]] const BivariateCoefficients& coefficients() const { return c_; }
  [[nodiscard]] PlanarValue at(const Vector2& p) const {
    const Vector3 x = detail::bicubic(c_.x, p.x(), p.y());
    const Vector3 y = detail::bicubic(c_.y, p.x(), p.y());
    PlanarValue f;
    f.seen = {x[0], y[0]};
    f.J << x[1], x[2], y[1], y[2];
    return f;
  }
  [[nodiscard]] double limit() const { return c_.limit; }

  friend bool operator==(const BivariateMap&, const BivariateMap&) = default;

 private:
  BivariateCoefficients c_;
};

class BivariateLens : public PlanarModel<BivariateMap> {
 public:
  BivariateLens() = default;
  explicit BivariateLens(const BivariateCoefficients& c) : PlanarModel(BivariateMap(c)) {
    HOLDFAST_ASSERT(problem_of(c) == LensProblem::none, "unusable lens coefficients");
  }

  [[nodiscard]] static LensProblem problem_of(const BivariateCoefficients& c) {
    if (!detail::all_finite(c.x) || !detail::all_finite(c.y) || !std::isfinite(c.limit)) return LensProblem::not_finite;
    if (!(c.limit > 0.0)) return LensProblem::radius_not_positive;
    const double determinant = c.x[4] * c.y[1] - c.x[1] * c.y[4];
    return determinant > 0.0 ? LensProblem::none : LensProblem::folds_at_centre;
  }

  [[nodiscard]] const BivariateCoefficients& coefficients() const { return map().coefficients(); }
};

/// One eye of a North Star headset: what field its panel fills near the axis, and the lens in those tangents.
struct NorthStarEye {
  FieldTangents tangents;
  BivariateCoefficients lens;
};

/// From `left_uv_to_rect_x` and `left_uv_to_rect_y` (or the right's), 16 numbers each, v^i u^j at [4 i + j]. The panel's
/// tangents are those of the map's slopes where the eye looks straight ahead. Nothing when no point of the panel is
/// seen there, or the map folds over at it; not finite numbers likewise.
[[nodiscard]] inline std::optional<NorthStarEye> north_star_eye(const std::array<double, 16>& rect_x,
                                                                const std::array<double, 16>& rect_y) {
  // With h to the right and up: h = u, up = 1 - v; and the seen y is -rect_y. Coefficients become h^i up^j.
  std::array<double, 16> x{};
  std::array<double, 16> y{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      x[4 * j + i] = rect_x[4 * i + j];
      y[4 * j + i] = -rect_y[4 * i + j];
    }
  }
  x = detail::bicubic_moved(x, 0.0, 1.0, 1.0, -1.0);
  y = detail::bicubic_moved(y, 0.0, 1.0, 1.0, -1.0);
  Vector2 ahead(0.5, 0.5);
  for (int i = 0; i < 50; ++i) {
    const Vector3 fx = detail::bicubic(x, ahead.x(), ahead.y());
    const Vector3 fy = detail::bicubic(y, ahead.x(), ahead.y());
    Matrix2 J;
    J << fx[1], fx[2], fy[1], fy[2];
    const Vector2 step = J.inverse() * Vector2(fx[0], fy[0]);
    ahead -= step / std::max(1.0, 4.0 * step.norm());  // at most a quarter of the panel at a time
    if (step.norm() < 1e-15) break;
  }
  const double right = detail::bicubic(x, ahead.x(), ahead.y())[1];
  const double up = detail::bicubic(y, ahead.x(), ahead.y())[2];
  const bool on_panel = ahead.x() >= 0.0 && ahead.x() <= 1.0 && ahead.y() >= 0.0 && ahead.y() <= 1.0;
  if (!on_panel || !(right > 0.0) || !(up > 0.0)) return std::nullopt;
  NorthStarEye eye;
  eye.tangents = {-right * ahead.x(), right * (1.0 - ahead.x()), -up * ahead.y(), up * (1.0 - ahead.y())};
  eye.lens.x = detail::bicubic_moved(x, ahead.x(), 1.0 / right, ahead.y(), 1.0 / up);
  eye.lens.y = detail::bicubic_moved(y, ahead.x(), 1.0 / right, ahead.y(), 1.0 / up);
  const FieldTangents& t = eye.tangents;
  eye.lens.limit = std::hypot(std::max(-t.left, t.right), std::max(-t.down, t.up));
  if (BivariateLens::problem_of(eye.lens) != LensProblem::none) return std::nullopt;
  return eye;
}

}  // namespace holdfast

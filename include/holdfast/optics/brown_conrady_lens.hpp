/// Brown-Conrady lens, radial and tangential, with OpenCV's names and its rational extension.
///
/// With p = (x, y) from the optical axis and r = |p|:
///
///     s = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
///     distort(p) = (x s + 2 p1 x y + p2 (r^2 + 2 x^2),
///                   y s + p1 (r^2 + 2 y^2) + 2 p2 x y)
///
/// Sources: Brown 1966; OpenCV calib3d (CALIB_RATIONAL_MODEL for k4 to k6). Units: tangents. OpenCV's formula takes the
/// undistorted direction and gives the image point: as a calibration of a display it is a
/// ReversedLens<BrownConradyLens>. Its y points down: place it with a negative scale in y (LensPlacement), which leaves
/// k and p as they are. Domain and inverse as in PlanarModel, up to tangents of 10 and to where the denominator has
/// fallen to 1/1000.
/// Bad input: BrownConradyLens::problem_of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/detail/polynomial.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/planar_model.hpp>

namespace holdfast {

struct BrownConradyCoefficients {
  double k1 = 0.0;
  double k2 = 0.0;
  double p1 = 0.0;
  double p2 = 0.0;
  double k3 = 0.0;
  double k4 = 0.0;
  double k5 = 0.0;
  double k6 = 0.0;

  friend bool operator==(const BrownConradyCoefficients&, const BrownConradyCoefficients&) = default;
};

class BrownConradyMap {
 public:
  BrownConradyMap() = default;
  explicit BrownConradyMap(const BrownConradyCoefficients& c) : c_(c) {}

  [[nodiscard]] const BrownConradyCoefficients& coefficients() const { return c_; }

  [[nodiscard]] PlanarValue at(const Vector2& p) const {
    const double x = p.x();
    const double y = p.y();
    const double r2 = x * x + y * y;
    const double inverse = 1.0 / (1.0 + r2 * (c_.k4 + r2 * (c_.k5 + r2 * c_.k6)));
    const double s = (1.0 + r2 * (c_.k1 + r2 * (c_.k2 + r2 * c_.k3))) * inverse;
    const double ds =
        (c_.k1 + r2 * (2.0 * c_.k2 + r2 * 3.0 * c_.k3) - s * (c_.k4 + r2 * (2.0 * c_.k5 + r2 * 3.0 * c_.k6))) *
        inverse;  // by r^2
    PlanarValue f;
    f.seen = {x * s + 2.0 * c_.p1 * x * y + c_.p2 * (r2 + 2.0 * x * x),
              y * s + c_.p1 * (r2 + 2.0 * y * y) + 2.0 * c_.p2 * x * y};
    const double mixed = 2.0 * x * y * ds + 2.0 * (c_.p1 * x + c_.p2 * y);
    f.J << s + 2.0 * x * x * ds + 2.0 * c_.p1 * y + 6.0 * c_.p2 * x, mixed,  //
        mixed, s + 2.0 * y * y * ds + 6.0 * c_.p1 * y + 2.0 * c_.p2 * x;
    return f;
  }
  /// Where the radial part r A / B alone folds over, (A + 2 x A') B = 2 x A B' with x = r^2, or B comes near zero.
  [[nodiscard]] double limit() const {
    constexpr double widest_tangent = 10.0;
    using Polynomial = std::array<double, 7>;
    const Polynomial A{1.0, c_.k1, c_.k2, c_.k3};
    const Polynomial B{1.0, c_.k4, c_.k5, c_.k6};
    const Polynomial x{0.0, 2.0};
    Polynomial near_pole = B;
    near_pole[0] -= 1e-3;
    Polynomial slope = detail::polynomial_product(A, B);
    const Polynomial rising =
        detail::polynomial_product(x, detail::polynomial_product(detail::polynomial_derivative(A), B));
    const Polynomial falling =
        detail::polynomial_product(x, detail::polynomial_product(A, detail::polynomial_derivative(B)));
    for (std::size_t i = 0; i < slope.size(); ++i) slope[i] += rising[i] - falling[i];
    constexpr double widest = widest_tangent * widest_tangent;
    return std::sqrt(
        std::min({widest, detail::first_sign_change(near_pole, widest), detail::first_sign_change(slope, widest)}));
  }

  friend bool operator==(const BrownConradyMap&, const BrownConradyMap&) = default;

 private:
  BrownConradyCoefficients c_;
};

class BrownConradyLens : public PlanarModel<BrownConradyMap> {
 public:
  BrownConradyLens() = default;
  explicit BrownConradyLens(const BrownConradyCoefficients& c) : PlanarModel(BrownConradyMap(c)) {
    HOLDFAST_ASSERT(problem_of(c) == LensProblem::none, "unusable lens coefficients");
  }

  [[nodiscard]] static LensProblem problem_of(const BrownConradyCoefficients& c) {
    const bool finite = detail::all_finite(std::array{c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6});
    return finite ? LensProblem::none : LensProblem::not_finite;
  }

  [[nodiscard]] const BrownConradyCoefficients& coefficients() const { return map().coefficients(); }
};

}  // namespace holdfast

/// Radial polynomial lens of all powers: Panotools', OpenHMD's and OSVR's.
///
/// A point of the panel at `p` is seen at distort(p), both from the lens's centre and in the coefficients' unit. With
/// r = |p|:
///
///     distort(p) = p (c0 + c1 r + c2 r^2 + ... + cn r^n)          n <= 16, c0 > 0
///
/// Panotools' five numbers (Monado's u_panotools_values) are c0 to c4; OpenHMD prints them in reverse, its fourth is
/// c0. OSVR's polynomial_coeffs_* a0, a1, ... are (a0 + a1 r + a2 r^2 + ...) p / r, so c0 = a1, c1 = a2 and so on; an a0
/// that is not zero tears the picture at its centre and is no lens. A colour's magnification multiplies all.
/// The map is smooth but at the centre, where c1 leaves a cone's tip in the second derivative. Domain and inverse as in
/// RadialModel. Bad input: PowerSeriesLens::problem_of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include <holdfast/assert.hpp>
#include <holdfast/optics/detail/polynomial.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/radial_model.hpp>

namespace holdfast {

/// f(r) = r (c0 + c1 r + c2 r^2 + ...).
class PowerSeries {
 public:
  static constexpr std::size_t max_coefficients = 17;

  PowerSeries() = default;
  explicit PowerSeries(std::span<const double> c) : count_(std::min(c.size(), max_coefficients)) {
    std::copy_n(c.begin(), count_, c_.begin());
  }

  [[nodiscard]] std::span<const double> coefficients() const { return {c_.data(), count_}; }

  [[nodiscard]] double scale(double r2) const {
    const double r = std::sqrt(r2);
    double sum = 0.0;
    for (std::size_t i = count_; i-- > 0;) sum = sum * r + c_[i];
    return sum;
  }
  [[nodiscard]] RadialValue at(double r) const {
    double sum = 0.0;
    double slope = 0.0;  // of the sum
    for (std::size_t i = count_; i-- > 0;) {
      slope = slope * r + sum;
      sum = sum * r + c_[i];
    }
    return {r * sum, sum + r * slope};
  }
  /// Smallest r > 0 where c0 + 2 c1 r + 3 c2 r^2 + ... changes sign.
  [[nodiscard]] double fold() const {
    std::array<double, max_coefficients> slope{};
    for (std::size_t i = 0; i < count_; ++i) slope[i] = static_cast<double>(i + 1) * c_[i];
    constexpr double beyond_all_use = 1e6;
    return detail::first_sign_change(slope, beyond_all_use);
  }

  friend bool operator==(const PowerSeries&, const PowerSeries&) = default;

 private:
  std::array<double, max_coefficients> c_{1.0};
  std::size_t count_ = 1;
};

class PowerSeriesLens : public RadialModel<PowerSeries> {
 public:
  static constexpr std::size_t max_coefficients = PowerSeries::max_coefficients;

  PowerSeriesLens() = default;
  /// Coefficients c0, c1, ...: 1 to 17, finite; c0 > 0.
  explicit PowerSeriesLens(std::span<const double> c) : RadialModel(checked(c)) {}

  [[nodiscard]] static LensProblem problem_of(std::span<const double> c) {
    if (c.size() > max_coefficients) return LensProblem::too_many_coefficients;
    if (!detail::all_finite(c)) return LensProblem::not_finite;
    return !c.empty() && c[0] > 0.0 ? LensProblem::none : LensProblem::folds_at_centre;
  }

  [[nodiscard]] std::span<const double> coefficients() const { return profile().coefficients(); }

 private:
  [[nodiscard]] static PowerSeries checked(std::span<const double> c) {
    HOLDFAST_ASSERT(problem_of(c) == LensProblem::none, "unusable lens coefficients");
    return PowerSeries(c);
  }
};

}  // namespace holdfast

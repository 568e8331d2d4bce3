/// Radial polynomial lens of even powers, as Cardboard's viewers and the Rifts' first kits are described by.
///
/// A point of the panel at `p` is seen at distort(p), both from the optical axis and in the unit in which the
/// coefficients are given (a Lens places it: LensPlacement). With r = |p|:
///
///     distort(p) = p (k0 + k1 r^2 + k2 r^4 + ... + kn r^2n)          n <= 16
///
/// k0 is 1 but where a colour is magnified differently from the one that the panel's tangents are given for.
/// distort is one-to-one up to valid_radius, the smallest r where the derivative of r (k0 + k1 r^2 + ...) changes sign
/// (infinite when it never does); undistort inverts it there to rounding. Elsewhere: nothing. Sources: Google
/// Cardboard's viewer profile (K1, K2 in tangents, "screen to texture"); Oculus SDK 0.2 (distortionK, r in quarters of
/// the screen's width). Bad input: PolynomialLens::problem_of.
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

/// f(r) = r (k0 + k1 r^2 + k2 r^4 + ...).
class EvenPolynomial {
 public:
  static constexpr std::size_t max_coefficients = 16;

  EvenPolynomial() = default;
  EvenPolynomial(std::span<const double> k, double k0) : count_(std::min(k.size(), max_coefficients)), k0_(k0) {
    std::copy_n(k.begin(), count_, k_.begin());
  }

  [[nodiscard]] std::span<const double> coefficients() const { return {k_.data(), count_}; }
  [[nodiscard]] double k0() const { return k0_; }

  [[nodiscard]] double scale(double r2) const {
    double sum = 0.0;
    for (std::size_t i = count_; i-- > 0;) sum = (sum + k_[i]) * r2;
    return k0_ + sum;
  }
  /// The same for many: r2 becomes its scale.
  template <std::size_t N>
  void scale(std::array<double, N>& r2) const {
    std::array<double, N> sum{};
    for (std::size_t k = count_; k-- > 0;) {
      for (std::size_t i = 0; i < N; ++i) sum[i] = (sum[i] + k_[k]) * r2[i];
    }
    for (std::size_t i = 0; i < N; ++i) r2[i] = k0_ + sum[i];
  }
  [[nodiscard]] RadialValue at(double r) const {
    const double r2 = r * r;
    double sum = 0.0;    // k1 r^2 + k2 r^4 + ...
    double slope = 0.0;  // its derivative by r^2
    for (std::size_t i = count_; i-- > 0;) {
      const double inner = sum + k_[i];
      slope = slope * r2 + inner;
      sum = inner * r2;
    }
    return {r * (k0_ + sum), k0_ + sum + 2.0 * r2 * slope};
  }
  /// Smallest r > 0 where k0 + 3 k1 r^2 + 5 k2 r^4 + ... changes sign.
  [[nodiscard]] double fold() const {
    std::array<double, max_coefficients + 1> slope{k0_};
    for (std::size_t i = 0; i < count_; ++i) slope[i + 1] = static_cast<double>(2 * i + 3) * k_[i];
    constexpr double beyond_all_use = 1e12;  // of r^2
    return std::sqrt(detail::first_sign_change(slope, beyond_all_use));
  }

  friend bool operator==(const EvenPolynomial&, const EvenPolynomial&) = default;

 private:
  std::array<double, max_coefficients> k_{};
  std::size_t count_ = 0;
  double k0_ = 1.0;
};

class PolynomialLens : public RadialModel<EvenPolynomial> {
 public:
  static constexpr std::size_t max_coefficients = EvenPolynomial::max_coefficients;

  PolynomialLens() = default;
  /// Coefficients k1, k2, ...: at most 16, finite; k0 > 0.
  explicit PolynomialLens(std::span<const double> k, double k0 = 1.0) : RadialModel(checked(k, k0)) {}

  [[nodiscard]] static LensProblem problem_of(std::span<const double> k, double k0 = 1.0) {
    if (k.size() > max_coefficients) return LensProblem::too_many_coefficients;
    if (!detail::all_finite(k) || !std::isfinite(k0)) return LensProblem::not_finite;
    return k0 > 0.0 ? LensProblem::none : LensProblem::folds_at_centre;
  }

  [[nodiscard]] std::span<const double> coefficients() const { return profile().coefficients(); }
  [[nodiscard]] double k0() const { return profile().k0(); }

 private:
  [[nodiscard]] static EvenPolynomial checked(std::span<const double> k, double k0) {
    HOLDFAST_ASSERT(problem_of(k, k0) == LensProblem::none, "unusable lens coefficients");
    return {k, k0};
  }
};

}  // namespace holdfast

/// Valve's rational radial lens: HTC Vive, Vive Pro, Valve Index and other SteamVR headsets.
///
///     distort(p) = p (1 / (1 + k1 r^2 + k2 r^4 + k3 r^6) + k4),   r = |p|
///
/// Source: the headset's own JSON, `tracking_to_eye_transform[].distortion*`: `coeffs` are k1, k2, k3 (type
/// DISTORT_DPOLY3) and k4 (DISTORT_DPOLY3_SCALED, Valve Index); each colour has its own, and its own centre. Direction:
/// panel to seen. Unit of p: half of the eye's picture width from `center_x`, `center_y`.
/// The domain ends where the map folds over, or where the denominator has fallen to 1/1000: short of its zero, where
/// the lens would show infinity. Inverse as in RadialModel. Bad input: ViveLens::problem_of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <holdfast/assert.hpp>
#include <holdfast/optics/detail/polynomial.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/radial_model.hpp>

namespace holdfast {

struct ViveCoefficients {
  double k1 = 0.0;
  double k2 = 0.0;
  double k3 = 0.0;
  double k4 = 0.0;

  friend bool operator==(const ViveCoefficients&, const ViveCoefficients&) = default;
};

/// f(r) = r (1 / D(r^2) + k4).
class ViveProfile {
 public:
  ViveProfile() = default;
  explicit ViveProfile(const ViveCoefficients& k) : k_(k) {}

  [[nodiscard]] const ViveCoefficients& coefficients() const { return k_; }
  [[nodiscard]] double scale(double r2) const { return 1.0 / denominator(r2) + k_.k4; }
  [[nodiscard]] RadialValue at(double r) const {
    const double x = r * r;
    const double inverse = 1.0 / denominator(x);
    const double slope = k_.k1 + x * (2.0 * k_.k2 + x * 3.0 * k_.k3);  // dD / dx
    return {r * (inverse + k_.k4), k_.k4 + inverse * (1.0 - 2.0 * x * slope * inverse)};
  }
  /// f' = (D - 2 x D' + k4 D^2) / D^2.
  [[nodiscard]] double fold() const {
    using Polynomial = std::array<double, 7>;
    const Polynomial D{1.0, k_.k1, k_.k2, k_.k3};
    Polynomial numerator = detail::polynomial_product(D, D);
    for (std::size_t i = 0; i < numerator.size(); ++i) {
      numerator[i] = k_.k4 * numerator[i] + D[i] * (1.0 - 2.0 * static_cast<double>(i));
    }
    Polynomial near_pole = D;
    near_pole[0] -= 1e-3;
    constexpr double beyond_all_use = 1e12;  // of r^2
    return std::sqrt(std::min(detail::first_sign_change(numerator, beyond_all_use),
                              detail::first_sign_change(near_pole, beyond_all_use)));
  }

  friend bool operator==(const ViveProfile&, const ViveProfile&) = default;

 private:
  [[nodiscard]] double denominator(double x) const { return 1.0 + x * (k_.k1 + x * (k_.k2 + x * k_.k3)); }

  ViveCoefficients k_;
};

class ViveLens : public RadialModel<ViveProfile> {
 public:
  ViveLens() = default;
  explicit ViveLens(const ViveCoefficients& k) : RadialModel(ViveProfile(k)) {
    HOLDFAST_ASSERT(problem_of(k) == LensProblem::none, "unusable lens coefficients");
  }

  [[nodiscard]] static LensProblem problem_of(const ViveCoefficients& k) {
    if (!detail::all_finite(std::array{k.k1, k.k2, k.k3, k.k4})) return LensProblem::not_finite;
    return 1.0 + k.k4 > 0.0 ? LensProblem::none : LensProblem::folds_at_centre;
  }

  [[nodiscard]] const ViveCoefficients& coefficients() const { return profile().coefficients(); }
};

}  // namespace holdfast

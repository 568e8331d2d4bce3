/// Radial lens by a Catmull-Rom spline in the squared radius: Oculus SDK 0.4 (DK1, DK2) and ILLIXR.
///
///     distort(p) = p S(x) (1 + chroma[0] + chroma[1] r^2),     r = |p|,   x = 10 r^2 / r_max^2
///
/// S is the cubic Hermite spline through 1 at x = 0 and knots[k] at x = k = 1 ... 10. Its slopes are Catmull-Rom's,
/// (knots[k+1] - knots[k-1]) / 2, but for knots[1] - knots[0] at the start (knots[0] sets that slope only) and, in the
/// last stretch, half of the last difference at x = 9 and the whole one at 10; beyond, S goes on straight. So its
/// derivative has one small jump, at x = 9, as in the source. Green's chroma is 0, 0. Source: LibOVR 0.4,
/// OVR_Stereo.cpp (EvalCatmullRom10Spline, Distortion_CatmullRom10, ChromaticAberration[0..1] for red and [2..3] for
/// blue). Unit: tangents at the lens's centre, that is metres on the panel over MetersPerTanAngleAtCenter; direction:
/// panel to seen. Domain and inverse as in RadialModel. Bad input: CatmullRomLens::problem_of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include <holdfast/assert.hpp>
#include <holdfast/optics/detail/polynomial.hpp>
#include <holdfast/optics/lens_problem.hpp>
#include <holdfast/optics/radial_model.hpp>

namespace holdfast {

struct CatmullRomCoefficients {
  std::array<double, 11> knots{1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  double r_max = 1.0;                      ///< radius of the last knot
  std::array<double, 2> chroma{0.0, 0.0};  ///< of this colour

  friend bool operator==(const CatmullRomCoefficients&, const CatmullRomCoefficients&) = default;
};

/// f(r) = r S (1 + chroma[0] + chroma[1] r^2).
class CatmullRomProfile {
 public:
  CatmullRomProfile() : CatmullRomProfile(CatmullRomCoefficients{}) {}
  explicit CatmullRomProfile(const CatmullRomCoefficients& c) : c_(c), x_per_r2_(10.0 / (c.r_max * c.r_max)) {
    const auto& K = c.knots;
    std::array<double, 11> slope{};
    for (std::size_t k = 1; k < 10; ++k) slope[k] = (K[k + 1] - K[k - 1]) / 2.0;
    slope[0] = K[1] - K[0];
    slope[10] = K[10] - K[9];
    for (std::size_t k = 0; k < 10; ++k) {
      const double start = k == 0 ? 1.0 : K[k];
      const double m0 = k == 9 ? slope[10] / 2.0 : slope[k];
      const double rise = K[k + 1] - start;
      pieces_[k] = {start, m0, 3.0 * rise - 2.0 * m0 - slope[k + 1], m0 + slope[k + 1] - 2.0 * rise};
    }
    pieces_[10] = {K[10], slope[10], 0.0, 0.0};
  }

  [[nodiscard]] const CatmullRomCoefficients& coefficients() const { return c_; }
  /// Where the slope jumps: x = 9.
  [[nodiscard]] double kink() const { return std::sqrt(0.9) * c_.r_max; }

  [[nodiscard]] double scale(double r2) const {
    const double x = r2 * x_per_r2_;
    const std::size_t k = piece(x);
    return spline(k, x - static_cast<double>(k)) * colour(r2);
  }
  [[nodiscard]] RadialValue at(double r) const {
    const double r2 = r * r;
    const double x = r2 * x_per_r2_;
    const std::size_t k = piece(x);
    const double t = x - static_cast<double>(k);
    const std::array<double, 4>& c = pieces_[k];
    const double S = spline(k, t);
    const double dS = (c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])) * x_per_r2_;  // by r^2
    const double C = colour(r2);
    return {r * S * C, S * C + 2.0 * r2 * (dS * C + S * c_.chroma[1])};
  }
  /// In each stretch, with t = x - k, f' is a polynomial of fourth degree; the first stretch where it changes sign, or
  /// starts below zero, holds the fold.
  [[nodiscard]] double fold() const {
    using Polynomial = std::array<double, 6>;
    const double r2_per_x = 1.0 / x_per_r2_;
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
      const double x0 = static_cast<double>(k);
      const Polynomial S{pieces_[k][0], pieces_[k][1], pieces_[k][2], pieces_[k][3]};
      const Polynomial C{1.0 + c_.chroma[0] + c_.chroma[1] * x0 * r2_per_x, c_.chroma[1] * r2_per_x};
      const Polynomial SC = detail::polynomial_product(S, C);
      // f' = S C + 2 x d(S C)/dx.
      const Polynomial x{x0, 1.0};
      Polynomial slope = detail::polynomial_product(x, detail::polynomial_derivative(SC));
      for (std::size_t i = 0; i < slope.size(); ++i) slope[i] = SC[i] + 2.0 * slope[i];
      if (!(slope[0] > 0.0)) return std::sqrt(x0 * r2_per_x);
      const bool last = k == 10;
      constexpr double beyond_all_use = 1e12;
      const double t = detail::first_sign_change(slope, last ? beyond_all_use : 1.0);
      if (t < 1.0 || last) return std::sqrt((x0 + t) * r2_per_x);
    }
    return std::numeric_limits<double>::infinity();
  }

  friend bool operator==(const CatmullRomProfile&, const CatmullRomProfile&) = default;

 private:
  [[nodiscard]] static std::size_t piece(double x) { return x < 10.0 ? static_cast<std::size_t>(x) : 10; }
  [[nodiscard]] double spline(std::size_t k, double t) const {
    const std::array<double, 4>& c = pieces_[k];
    return c[0] + t * (c[1] + t * (c[2] + t * c[3]));
  }
  [[nodiscard]] double colour(double r2) const { return 1.0 + c_.chroma[0] + c_.chroma[1] * r2; }

  CatmullRomCoefficients c_;
  double x_per_r2_;
  std::array<std::array<double, 4>, 11> pieces_{};  ///< S of t = x - k
};

class CatmullRomLens : public RadialModel<CatmullRomProfile> {
 public:
  CatmullRomLens() = default;
  explicit CatmullRomLens(const CatmullRomCoefficients& c) : RadialModel(CatmullRomProfile(c)) {
    HOLDFAST_ASSERT(problem_of(c) == LensProblem::none, "unusable lens coefficients");
  }

  [[nodiscard]] static LensProblem problem_of(const CatmullRomCoefficients& c) {
    if (!detail::all_finite(c.knots) || !detail::all_finite(c.chroma) || !std::isfinite(c.r_max)) {
      return LensProblem::not_finite;
    }
    if (!(c.r_max > 0.0)) return LensProblem::radius_not_positive;
    return 1.0 + c.chroma[0] > 0.0 ? LensProblem::none : LensProblem::folds_at_centre;
  }

  [[nodiscard]] const CatmullRomCoefficients& coefficients() const { return profile().coefficients(); }
};

}  // namespace holdfast

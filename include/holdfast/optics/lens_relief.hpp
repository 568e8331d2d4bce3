/// How an eye's lens depends on the eye relief (the distance from lens to eye), for headsets that were measured at
/// several.
///
/// A lens bends more where the eye looks through its rim, so its map changes with the eye's distance. A descriptor may
/// give the lenses of an eye at several reliefs, rising; in JSON
///
///     "lenses_at_relief": [{"eye_relief_m": 0.008, "lens": {...}, "lens_red": {...}, "lens_blue": {...}}, ...]
///
/// Between two of them the coefficients and the placement change linearly, as LibOVR 0.4 has it for the DK1 (whose
/// splines of different r_max are sampled anew); outside, the nearest holds, also as there. Lenses of different models,
/// and point meshes, have nothing between them. Units: metres.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <type_traits>
#include <variant>
#include <vector>

#include <holdfast/optics/lens.hpp>

namespace holdfast {

/// The lenses of one eye at one eye relief; a colour that is not given is as `lens`.
struct LensesAtRelief {
  double eye_relief_m = 0.0;
  Lens lens;
  std::optional<Lens> lens_red;
  std::optional<Lens> lens_blue;
};

namespace detail {

/// a at t = 0, b at t = 1, to the last bit.
[[nodiscard]] inline double between(double a, double b, double t) {
  return (1.0 - t) * a + t * b;
}
template <std::size_t N>
[[nodiscard]] std::array<double, N> between(const std::array<double, N>& a, const std::array<double, N>& b, double t) {
  std::array<double, N> c{};
  for (std::size_t i = 0; i < N; ++i) c[i] = between(a[i], b[i], t);
  return c;
}
/// Missing coefficients are zero.
[[nodiscard]] inline std::vector<double> between(std::span<const double> a, std::span<const double> b, double t) {
  std::vector<double> c(std::max(a.size(), b.size()));
  for (std::size_t i = 0; i < c.size(); ++i) c[i] = between(i < a.size() ? a[i] : 0.0, i < b.size() ? b[i] : 0.0, t);
  return c;
}

[[nodiscard]] inline std::optional<NoLens> between(const NoLens&, const NoLens&, double) {
  return NoLens{};
}
[[nodiscard]] inline std::optional<RadialLens> between(const RadialLens& a, const RadialLens& b, double t) {
  return RadialLens{between(a.k, b.k, t)};
}
[[nodiscard]] inline std::optional<PolynomialLens> between(const PolynomialLens& a, const PolynomialLens& b, double t) {
  return PolynomialLens(between(a.coefficients(), b.coefficients(), t), between(a.k0(), b.k0(), t));
}
[[nodiscard]] inline std::optional<PowerSeriesLens> between(const PowerSeriesLens& a, const PowerSeriesLens& b,
                                                            double t) {
  return PowerSeriesLens(between(a.coefficients(), b.coefficients(), t));
}
[[nodiscard]] inline std::optional<ViveLens> between(const ViveLens& a, const ViveLens& b, double t) {
  const ViveCoefficients& p = a.coefficients();
  const ViveCoefficients& q = b.coefficients();
  return ViveLens({between(p.k1, q.k1, t), between(p.k2, q.k2, t), between(p.k3, q.k3, t), between(p.k4, q.k4, t)});
}
/// The splines' values are mixed at the knots of the mixed r_max; chroma by itself.
[[nodiscard]] inline std::optional<CatmullRomLens> between(const CatmullRomLens& a, const CatmullRomLens& b, double t) {
  const CatmullRomCoefficients& p = a.coefficients();
  const CatmullRomCoefficients& q = b.coefficients();
  CatmullRomCoefficients c{between(p.knots, q.knots, t), between(p.r_max, q.r_max, t), between(p.chroma, q.chroma, t)};
  if (p.r_max != q.r_max) {
    const CatmullRomProfile p_green({p.knots, p.r_max, {0.0, 0.0}});
    const CatmullRomProfile q_green({q.knots, q.r_max, {0.0, 0.0}});
    for (std::size_t k = 1; k < c.knots.size(); ++k) {
      const double r2 = static_cast<double>(k) / 10.0 * c.r_max * c.r_max;
      c.knots[k] = between(p_green.scale(r2), q_green.scale(r2), t);
    }
  }
  return CatmullRomLens(c);
}
[[nodiscard]] inline std::optional<KannalaBrandtLens> between(const KannalaBrandtLens& a, const KannalaBrandtLens& b,
                                                              double t) {
  return KannalaBrandtLens(between(a.coefficients(), b.coefficients(), t));
}
[[nodiscard]] inline std::optional<BrownConradyLens> between(const BrownConradyLens& a, const BrownConradyLens& b,
                                                             double t) {
  const BrownConradyCoefficients& p = a.coefficients();
  const BrownConradyCoefficients& q = b.coefficients();
  return BrownConradyLens({between(p.k1, q.k1, t), between(p.k2, q.k2, t), between(p.p1, q.p1, t),
                           between(p.p2, q.p2, t), between(p.k3, q.k3, t), between(p.k4, q.k4, t),
                           between(p.k5, q.k5, t), between(p.k6, q.k6, t)});
}
[[nodiscard]] inline std::optional<BivariateLens> between(const BivariateLens& a, const BivariateLens& b, double t) {
  const BivariateCoefficients& p = a.coefficients();
  const BivariateCoefficients& q = b.coefficients();
  const BivariateCoefficients c{between(p.x, q.x, t), between(p.y, q.y, t), between(p.limit, q.limit, t)};
  if (BivariateLens::problem_of(c) != LensProblem::none) return std::nullopt;  // two rotations may cancel
  return BivariateLens(c);
}
[[nodiscard]] inline std::optional<PointMeshLens> between(const PointMeshLens&, const PointMeshLens&, double) {
  return std::nullopt;
}
template <LensModel M>
[[nodiscard]] std::optional<ReversedLens<M>> between(const ReversedLens<M>& a, const ReversedLens<M>& b, double t) {
  const std::optional<M> model = between(a.model(), b.model(), t);
  return model ? std::optional<ReversedLens<M>>(ReversedLens<M>(*model)) : std::nullopt;
}

}  // namespace detail

/// The lens at the fraction t in [0, 1] of the way from a to b; a and b themselves at the ends. Nothing where their
/// models differ or cannot be mixed.
[[nodiscard]] inline std::optional<Lens> lens_between(const Lens& a, const Lens& b, double t) {
  if (t == 0.0) return a;
  if (t == 1.0) return b;
  const LensPlacement placement{Vector2((1.0 - t) * a.centre() + t * b.centre()),
                                Vector2((1.0 - t) * a.placement().scale + t * b.placement().scale)};
  if (problem_of(placement) != LensProblem::none) return std::nullopt;  // one is the other mirrored
  return std::visit(
      [&](const auto& first) -> std::optional<Lens> {
        const auto* second = b.model_if<std::decay_t<decltype(first)>>();
        if (!second) return std::nullopt;
        const auto model = detail::between(first, *second, t);
        if (!model) return std::nullopt;
        return Lens(*model, placement, detail::between(a.k_pd(), b.k_pd(), t));
      },
      a.model());
}

/// The lenses at an eye relief, from a table that rises in eye_relief_m. Nothing where the table is empty or the two
/// neighbours cannot be mixed.
[[nodiscard]] inline std::optional<LensesAtRelief> lenses_at(std::span<const LensesAtRelief> table,
                                                             double eye_relief_m) {
  if (table.empty()) return std::nullopt;
  std::size_t upper = 0;
  while (upper < table.size() && table[upper].eye_relief_m < eye_relief_m) ++upper;
  const LensesAtRelief& b = table[std::min(upper, table.size() - 1)];
  const LensesAtRelief& a = upper > 0 && upper < table.size() ? table[upper - 1] : b;
  const double span = b.eye_relief_m - a.eye_relief_m;
  const double t = span > 0.0 ? (eye_relief_m - a.eye_relief_m) / span : 0.0;
  const auto colour = [&](const std::optional<Lens> LensesAtRelief::*c) {
    return lens_between((a.*c).value_or(a.lens), (b.*c).value_or(b.lens), t);
  };
  const std::optional<Lens> green = lens_between(a.lens, b.lens, t);
  const std::optional<Lens> red = colour(&LensesAtRelief::lens_red);
  const std::optional<Lens> blue = colour(&LensesAtRelief::lens_blue);
  if (!green || !red || !blue) return std::nullopt;
  LensesAtRelief lenses{eye_relief_m, *green, std::nullopt, std::nullopt};
  if (a.lens_red || b.lens_red) lenses.lens_red = red;
  if (a.lens_blue || b.lens_blue) lenses.lens_blue = blue;
  return lenses;
}

}  // namespace holdfast

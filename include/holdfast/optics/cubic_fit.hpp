/// The best cubic predistortion r + k_pd r^3 for a lens, for those who want the paper's cheap inverse at its best.
///
/// Robinett & Holloway's own k_pd = -0.1 for the Flight Helmet is a poor one (see docs/optics.md). Radii are in the
/// model's unit, up to 1.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include <holdfast/optics/lens.hpp>

namespace holdfast {

/// Largest |seen - ideal| over ideal radii up to 1 (to the right of the centre, the model's unit), when a lens is
/// predistorted with k_pd. Infinite where the drawn point leaves the lens's domain.
template <LensModel L>
[[nodiscard]] double cubic_residual(const L& model, double k_pd) {
  constexpr int samples = 200;
  double worst = 0.0;
  for (int i = 1; i <= samples; ++i) {
    const double r = static_cast<double>(i) / samples;
    const double drawn = r + k_pd * r * r * r;
    const auto seen = model.distort(Vector2(drawn, 0.0));
    if (!seen) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, std::abs(seen->x() - r));
  }
  return worst;
}

/// The k_pd in [-1/3, 1/3] (where r + k_pd r^3 does not fold within r = 1) with the smallest cubic_residual, to about
/// 1e-9, by golden section (the residual is the largest of functions that first fall and then rise with k_pd). 0 when
/// no cubic keeps r <= 1 inside the lens's domain.
template <LensModel L>
[[nodiscard]] double best_cubic_inverse(const L& model) {
  const double ratio = (std::sqrt(5.0) - 1.0) / 2.0;
  double low = -1.0 / 3.0;
  double high = 1.0 / 3.0;
  for (int i = 0; i < 44; ++i) {
    const double a = high - ratio * (high - low);
    const double b = low + ratio * (high - low);
    // Where both leave the lens's domain, the weaker one leaves it less.
    const bool left_is_better = !(cubic_residual(model, b) < cubic_residual(model, a));
    (left_is_better ? high : low) = left_is_better ? b : a;
  }
  // The best may stand at the domain's very edge; then its weaker side counts.
  for (const double best : {(low + high) / 2.0, low}) {
    if (std::isfinite(cubic_residual(model, best))) return best;
  }
  return 0.0;
}

/// The lens with the best cubic of its model.
[[nodiscard]] inline Lens with_best_cubic(const Lens& lens) {
  return lens.with_k_pd(std::visit([](const auto& model) { return best_cubic_inverse(model); }, lens.model()));
}

}  // namespace holdfast

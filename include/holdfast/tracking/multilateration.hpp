/// Position from ranges to any number of anchors, each weighed by how well it is known: iterated least squares (Foy,
/// Position-Location Solutions by Taylor Series Estimation, 1976), which 003 section 3 takes for its simulations as it ends
/// where an extended Kalman filter of a body at rest would.
///
///     minimise  sum ((r_i - |p - a_i|) / sigma_i)^2,   covariance of p  (sum u_i u_i^T / sigma_i^2)^-1
/// with u_i the unit vector from anchor i to p. Gauss and Newton's steps, damped where they would make things worse. It
/// ends in the minimum next to where it starts: anchors in a plane have a mirrored one on their other side. Without a start the
/// closed form (trilateration.hpp) gives it, of two mirrored ones that on the given side.
/// Nothing here allocates; the closed form takes no more than the first 64 ranges.
/// Bad input: MultilaterationStatus names it. Metres.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/tracking/trilateration.hpp>

namespace holdfast {

struct WeightedRange {
  Vector3 anchor_W = Vector3::Zero();
  double range_m = 0.0;
  double sigma_m = 1.0;  ///< one standard deviation
};

enum class MultilaterationStatus {
  converged,
  too_few,     ///< fewer than three ranges
  not_finite,  ///< a number is not finite, a range is negative, or a deviation not above zero
  degenerate,  ///< anchors in one line, or a position in their plane: some direction is not told by any range
  not_converged
};

[[nodiscard]] constexpr std::string_view to_string(MultilaterationStatus status) {
  constexpr std::array<std::string_view, 5> names{"converged", "too_few", "not_finite", "degenerate", "not_converged"};
  return names[static_cast<std::size_t>(status)];
}

struct Multilateration {
  MultilaterationStatus status = MultilaterationStatus::too_few;
  Vector3 p_W = Vector3::Zero();
  Matrix3 covariance = Matrix3::Zero();
  double cost = 0.0;  ///< what was minimised: chi-square of n - 3 if deviations are right
  int iterations = 0;

  [[nodiscard]] bool ok() const { return status == MultilaterationStatus::converged; }
};

namespace detail {

struct RangeEquations {
  Matrix3 A = Matrix3::Zero();  ///< sum u u^T / sigma^2
  Vector3 g = Vector3::Zero();  ///< sum u residual / sigma^2
  double cost = 0.0;

  RangeEquations(std::span<const WeightedRange> ranges, const Vector3& p_W) {
    for (const WeightedRange& r : ranges) {
      const Vector3 apart = p_W - r.anchor_W;
      const double distance = apart.norm(), weight = 1.0 / (r.sigma_m * r.sigma_m);
      const double residual = r.range_m - distance;
      cost += weight * residual * residual;
      if (!(distance > 0.0)) continue;  // an anchor at p has no direction
      const Vector3 unit = apart / distance;
      A += weight * unit * unit.transpose();
      g += weight * residual * unit;
    }
  }
};

/// The inverse of a symmetric matrix that tells of all directions; nothing when one has less than `least` of the others'
/// share.
[[nodiscard]] inline std::optional<Matrix3> inverse_of_information(const Matrix3& A, double least = 1e-9) {
  const double scale = A.trace();
  if (!(scale > 0.0) || !std::isfinite(scale)) return std::nullopt;
  Matrix3 L;
  if (!cholesky<3>(Matrix3(A / scale), L)) return std::nullopt;
  const double least_pivot = L.diagonal().minCoeff();
  if (!(least_pivot * least_pivot > least)) return std::nullopt;
  return Matrix3(inverse_by<3>(L) / scale);
}

[[nodiscard]] inline bool are_usable(std::span<const WeightedRange> ranges) {
  return std::all_of(ranges.begin(), ranges.end(), [](const WeightedRange& r) {
    return r.anchor_W.allFinite() && std::isfinite(r.range_m) && r.range_m >= 0.0 && std::isfinite(r.sigma_m) &&
           r.sigma_m > 0.0;
  });
}

}  // namespace detail

/// The least squares next to `start_W`.
[[nodiscard]] inline Multilateration multilaterate(std::span<const WeightedRange> ranges, const Vector3& start_W) {
  Multilateration result;
  result.p_W = start_W;
  if (ranges.size() < 3) return result;
  result.status = MultilaterationStatus::not_finite;
  if (!detail::are_usable(ranges) || !start_W.allFinite()) return result;
  detail::RangeEquations here(ranges, start_W);
  double damping = 0.0;
  result.status = MultilaterationStatus::not_converged;
  for (; result.iterations < 50; ++result.iterations) {
    Matrix3 damped = here.A, L;
    damped.diagonal().array() += damping * here.A.trace();
    if (!cholesky<3>(damped, L)) {
      damping = std::max(1e-6, 10.0 * damping);
      continue;
    }
    const Vector3 step = solved_by<3, 1>(L, here.g);
    const bool small = !(step.cwiseAbs().maxCoeff() > 1e-10);
    const detail::RangeEquations there(ranges, result.p_W + step);
    if (step.allFinite() && there.cost <= here.cost * (1.0 + 1e-12)) {
      result.p_W += step;
      here = there;
      damping = damping < 1e-8 ? 0.0 : 0.1 * damping;
    } else if (!small) {
      damping = std::max(1e-6, 10.0 * damping);
      continue;
    }
    if (small) break;
  }
  result.cost = here.cost;
  const std::optional<Matrix3> covariance = detail::inverse_of_information(here.A);
  if (!covariance) {
    result.status = MultilaterationStatus::degenerate;
    return result;
  }
  result.covariance = *covariance;
  if (result.iterations < 50) result.status = MultilaterationStatus::converged;
  return result;
}

/// The same from nothing; `side_W` is a direction from the anchors to where the body can be, zero when both sides may be: then
/// the better, or the upper one (trilateration.hpp).
[[nodiscard]] inline Multilateration multilaterate_anywhere(std::span<const WeightedRange> ranges,
                                                            const Vector3& side_W = Vector3::Zero()) {
  Multilateration result;
  if (ranges.size() < 3) return result;
  result.status = MultilaterationStatus::not_finite;
  if (!detail::are_usable(ranges) || !side_W.allFinite()) return result;
  std::array<AnchorRange, 64> plain;
  const std::size_t count = std::min(ranges.size(), plain.size());
  for (std::size_t i = 0; i < count; ++i) plain[i] = {ranges[i].anchor_W, ranges[i].range_m};
  const std::optional<Trilateration> closed = trilaterate(std::span(plain).first(count));
  if (!closed) {
    result.status = MultilaterationStatus::degenerate;
    return result;
  }
  const double above = (closed->above_W - closed->below_W).dot(side_W);
  return multilaterate(ranges, above > 0.0 ? closed->above_W : above < 0.0 ? closed->below_W : closed->best_W());
}

}  // namespace holdfast

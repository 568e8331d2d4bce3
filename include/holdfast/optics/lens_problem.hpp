/// What makes the numbers of a lens unusable, named for the reader of a descriptor.
///
/// Every model has a static `problem_of(...)` that takes what its constructor takes; the constructor asserts that it
/// answers none. A lens that folds over farther out is no problem: its domain ends there.
#pragma once

#include <cmath>
#include <span>
#include <string_view>

namespace holdfast {

enum class LensProblem {
  none,
  not_finite,             ///< a coefficient is NaN or infinite
  too_many_coefficients,  ///< more than the model holds
  folds_at_centre,        ///< the slope, or the Jacobian's determinant, is not positive at the very centre
  zero_scale,             ///< the placement's scale is zero in x or y
  radius_not_positive,    ///< a radius that must be positive is not
};

[[nodiscard]] constexpr std::string_view describe(LensProblem problem) {
  switch (problem) {
    case LensProblem::none:
      return "the lens is usable";
    case LensProblem::not_finite:
      return "a coefficient is not a finite number";
    case LensProblem::too_many_coefficients:
      return "the lens has more coefficients than its model holds";
    case LensProblem::folds_at_centre:
      return "the lens folds over at its very centre: its slope there is not positive";
    case LensProblem::zero_scale:
      return "the lens's scale is zero";
    case LensProblem::radius_not_positive:
      return "a radius of the lens is not positive";
  }
  return "unknown problem";
}

namespace detail {

[[nodiscard]] inline bool all_finite(std::span<const double> numbers) {
  for (const double number : numbers) {
    if (!std::isfinite(number)) return false;
  }
  return true;
}

}  // namespace detail

}  // namespace holdfast

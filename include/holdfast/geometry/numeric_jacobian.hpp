/// Jacobian of any function by central differences, for checking analytic ones and where speed does not matter.
///
/// Column j is (f(x + h e_j) - f(x - h e_j)) / 2h with h = step * max(1, |x_j|). The error is h^2 f'''/6 from
/// truncation plus epsilon |f| / h from rounding; the default step, the cube root of epsilon, balances the two (about
/// 1e-10 in double for functions of ordinary size). Rows are outputs, columns inputs; units are those of f over those
/// of x. Bad input: nothing is checked; a function that is not finite within h of x gives a Jacobian that is not
/// finite.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

/// Default relative step of numeric_jacobian.
template <typename Scalar>
[[nodiscard]] Scalar central_difference_step() {
  return std::cbrt(std::numeric_limits<Scalar>::epsilon());
}

/// J with f(x + d) = f(x) + J d to first order. f maps VectorOf<Scalar, N> to VectorOf<Scalar, M> or to a Scalar (M =
/// 1).
template <typename Function, typename Scalar, int N>
[[nodiscard]] auto numeric_jacobian(const Function& f, const VectorOf<Scalar, N>& x,
                                    std::type_identity_t<Scalar> step = central_difference_step<Scalar>()) {
  using Output = std::decay_t<std::invoke_result_t<const Function&, const VectorOf<Scalar, N>&>>;
  constexpr int rows = [] {
    if constexpr (std::is_arithmetic_v<Output>) {
      return 1;
    } else {
      return static_cast<int>(Output::RowsAtCompileTime);
    }
  }();
  MatrixOf<Scalar, rows, N> J;
  for (int j = 0; j < N; ++j) {
    const Scalar h = step * std::max(Scalar(1), std::abs(x[j]));
    VectorOf<Scalar, N> above = x;
    VectorOf<Scalar, N> below = x;
    above[j] += h;
    below[j] -= h;
    // x + h rounds: divide by the step that was really taken.
    const Scalar width = above[j] - below[j];
    if constexpr (std::is_arithmetic_v<Output>) {
      J(0, j) = (f(above) - f(below)) / width;
    } else {
      J.col(j) = (f(above) - f(below)) / width;
    }
  }
  return J;
}

}  // namespace holdfast

/// The chi-square distribution: what a normalised innovation squared follows, so what gates and consistency tests ask.
///
/// With k degrees of freedom the probability of a value up to x is P(k/2, x/2), the regularised incomplete gamma function,
/// by its series below x = k + 2 and by Legendre's continued fraction above (Press et al., Numerical Recipes, 6.2).
/// Accuracy: relative 1e-12 in the smaller of the two tails, 1e-10 in the quantile.
/// Bad input: no degrees of freedom, or a probability outside [0, 1], gives NaN.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace holdfast {

/// Both tails of a distribution at one value; the smaller one is accurate, however small.
struct Tails {
  double below = 0.0;
  double above = 1.0;
};

namespace detail {

/// sum over n of x^n / ((a + 1) ... (a + n)).
[[nodiscard]] inline double gamma_series(double a, double x) {
  double term = 1.0;
  double sum = 1.0;
  for (double n = a + 1.0; term > 1e-17 * sum; n += 1.0) {
    term *= x / n;
    sum += term;
  }
  return sum;
}

/// 1 / (x + 1 - a - 1 (1 - a) / (x + 3 - a - 2 (2 - a) / (x + 5 - a - ...))), by Lentz's method.
[[nodiscard]] inline double gamma_fraction(double a, double x) {
  constexpr double tiny = 1e-300;
  const auto away_from_zero = [](double value) { return std::abs(value) < tiny ? tiny : value; };
  double b = x + 1.0 - a;
  double c = 1.0 / tiny;
  double d = 1.0 / away_from_zero(b);
  double fraction = d;
  for (int i = 1; i < 100000; ++i) {
    const double an = -i * (i - a);
    b += 2.0;
    d = 1.0 / away_from_zero(an * d + b);
    c = away_from_zero(b + an / c);
    fraction *= d * c;
    if (std::abs(d * c - 1.0) < 1e-16) break;
  }
  return fraction;
}

}  // namespace detail

/// Probabilities of a chi-square number below and above x >= 0.
[[nodiscard]] inline Tails chi_square_tails(double x, int degrees_of_freedom) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (degrees_of_freedom < 1 || !(x >= 0.0)) return {nan, nan};
  if (x == 0.0) return {0.0, 1.0};
  if (std::isinf(x)) return {1.0, 0.0};
  const double a = 0.5 * degrees_of_freedom;
  const double half = 0.5 * x;
  const double log_factor = a * std::log(half) - half - std::lgamma(a);  // of x^a e^-x / Gamma(a)
  if (half < a + 1.0) {
    const double below = std::exp(log_factor) / a * detail::gamma_series(a, half);
    return {below, 1.0 - below};
  }
  const double above = std::exp(log_factor) * detail::gamma_fraction(a, half);
  return {1.0 - above, above};
}

/// The value below which a chi-square number stays with this probability: 9.21 for 0.99 and 2 degrees of freedom.
[[nodiscard]] inline double chi_square_quantile(double probability, int degrees_of_freedom) {
  if (degrees_of_freedom < 1 || !(probability >= 0.0 && probability <= 1.0)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  if (probability == 0.0) return 0.0;
  if (probability == 1.0) return std::numeric_limits<double>::infinity();
  // Halving brackets, by whichever tail is the smaller one; then each step gains one bit.
  const double wanted_above = 1.0 - probability;
  const auto is_below = [&](double x) {
    const Tails tails = chi_square_tails(x, degrees_of_freedom);
    return probability < 0.5 ? tails.below < probability : tails.above > wanted_above;
  };
  double low = 0.0;
  double high = degrees_of_freedom;
  while (is_below(high)) {
    low = high;
    high *= 2.0;
  }
  while (!is_below(0.5 * high) && high > 1e-290) high *= 0.5;
  low = std::max(low, 0.5 * high);
  for (int i = 0; i < 60 && high - low > 1e-14 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (is_below(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace holdfast

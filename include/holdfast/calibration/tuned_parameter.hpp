/// A number that may be tuned: where the search starts, how far it may go, and on what scale it is searched.
///
/// Noise intensities and variances are unknown by powers of ten (002 tables 6.4 to 6.8 span eleven), so they are searched
/// by their logarithm: a step multiplies. What may be zero or negative is searched linearly. Search coordinates run from 0
/// at `lower` to 1 at `upper` on either scale, so one step size suits all parameters of a filter.
/// Bad input: `problem` names it; the two conversions need a parameter without one.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

namespace holdfast {

enum class SearchScale { logarithmic, linear };

struct TunedParameter {
  std::string name, unit;
  double start = 1.0, lower = 0.1, upper = 10.0;
  SearchScale scale = SearchScale::logarithmic;

  /// What is wrong with it; nothing when it can be searched.
  [[nodiscard]] std::optional<std::string_view> problem() const {
    if (!std::isfinite(start) || !std::isfinite(lower) || !std::isfinite(upper))
      return "start or bounds are not finite";
    if (!(lower < upper)) return "the lower bound is not below the upper one";
    if (start < lower || start > upper) return "the start lies outside its bounds";
    if (scale == SearchScale::logarithmic && lower <= 0.0) return "a logarithmic scale needs bounds above zero";
    return std::nullopt;
  }

  [[nodiscard]] double to_search(double value) const {
    if (scale == SearchScale::linear) return (value - lower) / (upper - lower);
    return std::log(value / lower) / std::log(upper / lower);
  }
  /// Clamped: rounding never leaves the bounds.
  [[nodiscard]] double from_search(double s) const {
    const double value =
        scale == SearchScale::linear ? lower + s * (upper - lower) : lower * std::pow(upper / lower, s);
    return std::clamp(value, lower, upper);
  }
};

}  // namespace holdfast

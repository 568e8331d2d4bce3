/// What prediction does to a sinusoid, in closed form: gain, error and the frequency at which it starts to do harm.
///
/// For the motion A sin(2 pi f t) predicted over T from its exact value and derivatives, with x = 2 pi f T, the
/// predicted signal is A times the truncated Taylor series of e^(ix) on the present state, so, against the truth
/// e^(ix):
///   none                   1                    gain 1                 error 2 sin(x/2)
///   constant velocity      1 + ix               gain sqrt(1 + x^2)     error ~ x^2/2
///   constant acceleration  1 + ix - x^2/2       gain sqrt(1 + x^4/4)   error ~ x^3/6
/// Prediction is worse than none above f T = 0.302 (constant velocity) and 0.365 (constant acceleration).
/// Source: Azuma & Bishop 1995, A frequency-domain analysis of head-motion prediction; 000 section 5.3 (doubling the
/// interval quadruples the error); evaluation.md. Arguments in Hz and seconds, results relative to the amplitude. Bad
/// input: nothing is checked; negative frequencies or intervals act as their magnitudes.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>

namespace holdfast::theory {

/// Terms of the Taylor series that the predictor extrapolates with.
enum class Order { none, constant_velocity, constant_acceleration };

/// Predicted over present signal: a complex number whose modulus is the gain and whose argument the phase lead (rad).
[[nodiscard]] inline std::complex<double> response(Order order, double hz, double interval_s) {
  const double x = 2.0 * std::numbers::pi * hz * interval_s;
  switch (order) {
    case Order::none:
      return {1.0, 0.0};
    case Order::constant_velocity:
      return {1.0, x};
    case Order::constant_acceleration:
      return {1.0 - 0.5 * x * x, x};
  }
  return {1.0, 0.0};
}

/// Amplitude of the predicted signal over that of the motion.
[[nodiscard]] inline double gain(Order order, double hz, double interval_s) {
  return std::abs(response(order, hz, interval_s));
}

/// Predicted against true signal at the time predicted for (rad): negative when it lags.
[[nodiscard]] inline double phase_error(Order order, double hz, double interval_s) {
  const double x = 2.0 * std::numbers::pi * hz * interval_s;
  return std::arg(response(order, hz, interval_s) * std::polar(1.0, -x));
}

/// Amplitude of the prediction error over that of the motion.
[[nodiscard]] inline double error(Order order, double hz, double interval_s) {
  const double x = 2.0 * std::numbers::pi * hz * interval_s;
  // 1 - cos x written as 2 sin^2(x/2): exact for small x, where the error is a difference of nearly equal numbers.
  const double s = std::sin(0.5 * x);
  const double one_minus_cos = 2.0 * s * s;
  switch (order) {
    case Order::none:
      return 2.0 * std::abs(s);
    case Order::constant_velocity:
      return std::hypot(one_minus_cos, x - std::sin(x));
    case Order::constant_acceleration:
      return std::hypot(one_minus_cos - 0.5 * x * x, x - std::sin(x));
  }
  return 0.0;
}

/// f T above which predicting errs more than not predicting: the least positive root of error(order) = error(none).
[[nodiscard]] inline double crossover(Order order) {
  if (order == Order::none) return 0.0;
  double low = 0.1, high = 0.45;  // below, every order helps; above, each one shown here harms
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (error(order, middle, 1.0) < error(Order::none, middle, 1.0) ? low : high) = middle;
  }
  return low;
}

}  // namespace holdfast::theory

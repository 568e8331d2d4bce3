/// What theory demands of an experiment: closed forms for sinusoids, ramps and steady motion, with x = 2 pi f T.
///
/// A head that moves as A sin(2 pi f t) is shown as it was T ago, carried on by a predictor of order n (none 0,
/// constant velocity 1, constant acceleration 2). In phasors the displayed motion is A e^{-ix} P_n(ix) with P_n the
/// Taylor polynomial of e^{ix}, so
///     gain = |P_n(ix)|: 1, sqrt(1 + x^2), sqrt(1 + x^4 / 4);
///     error / A = |e^{-ix} P_n(ix) - 1|: 2 |sin(x/2)|, ~ x^2 / 2, ~ x^3 / 6 for small x;
///     lag = (x - arg P_n(ix)) / (2 pi f): the effective latency.
/// Source: evaluation.md, "Values that theory demands"; Azuma & Bishop 1995. Frequencies Hz, times s.
#pragma once

#include <cmath>
#include <complex>
#include <numbers>

#include <holdfast/assert.hpp>

namespace holdfast::theory {

/// 2 pi f T.
[[nodiscard]] inline double phase_of(double hz, double interval_s) {
  return 2.0 * std::numbers::pi * hz * interval_s;
}

/// P_n(ix). Precondition: order 0, 1 or 2.
[[nodiscard]] inline std::complex<double> taylor_polynomial(int order, double x) {
  HOLDFAST_ASSERT(order >= 0 && order <= 2, "predictors of order 0, 1 or 2");
  std::complex<double> sum = 1.0;
  if (order >= 1) sum += std::complex<double>(0.0, x);
  if (order >= 2) sum -= 0.5 * x * x;
  return sum;
}

/// Amplitude of the displayed motion over that of the true one.
[[nodiscard]] inline double gain(int order, double x) {
  return std::abs(taylor_polynomial(order, x));
}

/// Amplitude of the error over that of the motion.
[[nodiscard]] inline double error_ratio(int order, double x) {
  return std::abs(std::polar(1.0, -x) * taylor_polynomial(order, x) - 1.0);
}

/// How far the displayed motion lags the true one, s; negative when it leads.
[[nodiscard]] inline double lag_s(int order, double hz, double interval_s) {
  const double x = phase_of(hz, interval_s);
  return std::remainder(x - std::arg(taylor_polynomial(order, x)), 2.0 * std::numbers::pi) /
         (2.0 * std::numbers::pi * hz);
}

/// Peak rate of change of an error of amplitude `error` at frequency f, as differences of frames `period_s` apart show
/// it.
[[nodiscard]] inline double swim_amplitude(double error, double hz, double period_s) {
  const double half_turn = std::numbers::pi * hz * period_s;
  return error * 2.0 * std::sin(half_turn) / period_s;
}

}  // namespace holdfast::theory

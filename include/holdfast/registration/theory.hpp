/// What theory demands of a displayed sinusoid besides its gain and error (prediction/predictor_theory.hpp): lag and
/// swim.
///
/// Source: evaluation.md, "Values that theory demands". Frequencies in Hz, times in seconds, any unit of amplitude.
/// Bad input: nothing is checked; the frequency must not be zero for lag_s.
#pragma once

#include <cmath>
#include <numbers>

#include <holdfast/prediction/predictor_theory.hpp>

namespace holdfast::theory {

/// How far the displayed sinusoid lags the true one: its effective latency. Constant velocity: (x - atan x) / (2 pi f),
/// that is x^3 / 3 of phase for small x = 2 pi f T. Negative when it leads.
[[nodiscard]] inline double lag_s(Order order, double hz, double interval_s) {
  return -phase_error(order, hz, interval_s) / (2.0 * std::numbers::pi * hz);
}

/// Amplitude of the rate of change of an error that is a sinusoid, as differences between frames `period_s` apart show
/// it.
[[nodiscard]] inline double swim_amplitude(double error, double hz, double period_s) {
  return error * 2.0 * std::sin(std::numbers::pi * hz * period_s) / period_s;
}

}  // namespace holdfast::theory

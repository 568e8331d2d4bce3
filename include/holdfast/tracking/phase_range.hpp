/// The phase of a continuous tone: a very fine distance of which only the last fraction of a wavelength is known (phase
/// coherence, 000 section 3.1.1.2).
///
///   r = phase + n wavelength,   n = the whole number that brings r nearest to the state's distance to the anchor
/// so the residual lies within half a wavelength of zero; `cycles` tells n. The source's parameters are the anchor's
/// position in W (m).
/// Bad input: while the state's own deviation of the distance exceeds `largest_deviation` wavelengths, n would be a
/// guess, and the phase is refused: at the default of a sixth, a deviation of three sigma would take the next cycle.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include <holdfast/tracking/range.hpp>

namespace holdfast {

struct PhaseRange {
  static constexpr int size = 1;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 0;

  double phase_m = 0.0;       ///< phase over 2 pi, times the wavelength; any whole number of wavelengths may be in it
  double wavelength_m = 0.0;  ///< positive
  Vector3 antenna_B = Vector3::Zero();
  double variance = 0.0;                 ///< m^2
  double largest_deviation = 1.0 / 6.0;  ///< of the expected distance, in wavelengths; infinity refuses none

  /// n at this state; nothing when there is no distance, or n is beyond what a double counts.
  template <int Order>
  [[nodiscard]] std::optional<double> cycles(const TargetState<Order>& state, const Vector3& anchor_W) const {
    const detail::AnchorDistance to(state.X_WB * antenna_B, anchor_W);
    const double n = std::round((to.distance_m - phase_m) / wavelength_m);
    if (!to.usable() || !(wavelength_m > 0.0) || !(std::abs(n) < 1.0 / std::numeric_limits<double>::epsilon())) {
      return std::nullopt;
    }
    return n;
  }

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& anchor_W, const DeviceParameters<0>&,
                               Linearization<PhaseRange>& linear) const {
    const std::optional<double> n = cycles(state, anchor_W);
    if (!n) return false;
    const BodyPoint antenna = body_point(state, antenna_B);
    const detail::AnchorDistance to(antenna.p_W, anchor_W);
    linear.residual[0] = phase_m + *n * wavelength_m - to.distance_m;
    linear.H = to.away_W.transpose() * antenna.by_error;
    linear.H_source = -to.away_W.transpose();
    linear.R(0, 0) = variance;
    const double expected_variance = (linear.H * state.P.template topLeftCorner<6, 6>() * linear.H.transpose()).value();
    const double largest = largest_deviation * wavelength_m;
    return expected_variance <= largest * largest;
  }
};

}  // namespace holdfast

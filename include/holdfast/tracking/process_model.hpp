/// How a tracked body moves when nobody measures it: six independent chains of integrators, driven by white noise.
///
/// Each of the six axes (x, y, z of the position in W; the turns about B's x, y, z) keeps `Order` numbers:
///   Order 1  position (P):                         x' = noise
///   Order 2  position, velocity (PV):              x' = v,  v' = -decay v + noise      (002 section 4.2.1, figure 4.1)
///   Order 3  position, velocity, acceleration:     x' = v,  v' = a,  a' = -decay a + noise
/// `intensity` is 002's mu (eq. 4.9), the noise's spectral density: (m/s^Order)^2 s and (rad/s^Order)^2 s; over a time dt
/// the last number of a chain gathers the variance mu dt. `decay` (1/s) lets the last number fade: 0 is 002's PV, or
/// PVA; above 0 a damped PV, or Singer's model (Singer 1970). A chain of order 1 has none.
/// Positions, and their noise, are in W; turns and angular velocities are B's own: intensities that differ among x, y, z
/// tie the model to the world's axes. What a chain does in a time step: chain_step.hpp.
/// Bad input: `problem` names it; a step backwards in time is the caller's to refuse.
#pragma once

#include <optional>
#include <string_view>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

template <int Order>
struct ProcessModel {
  static_assert(Order >= 1 && Order <= 3);
  Vector6 intensity = Vector6::Constant(1.0);  ///< mu: x, y, z (W), then the turns about B's axes
  Vector6 decay = Vector6::Zero();             ///< 1/s, of each chain's last number

  /// 002 table 6.4's parameters: lateral (x and y of a world whose z is up), height, and the three turns.
  [[nodiscard]] static ProcessModel hiball(double lateral, double height, const Vector3& turns) {
    ProcessModel model;
    model.intensity << lateral, lateral, height, turns;
    return model;
  }

  /// What is wrong with it; nothing when it can be used.
  [[nodiscard]] std::optional<std::string_view> problem() const {
    if (!intensity.allFinite() || intensity.minCoeff() < 0.0) return "a noise intensity is negative or not finite";
    if (!decay.allFinite() || decay.minCoeff() < 0.0) return "a decay rate is negative or not finite";
    if (Order == 1 && decay.maxCoeff() > 0.0) return "a chain of positions alone has nothing that could decay";
    return std::nullopt;
  }
};

using PvModel = ProcessModel<2>;
using PvaModel = ProcessModel<3>;

}  // namespace holdfast

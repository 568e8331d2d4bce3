/// Space resection: the pose from several sightings taken for simultaneous, by iterated least squares.
///
/// The Collinearity method of the first ceiling tracker (002 sections 3.4 and E.3.2; Azuma & Ward, TR 91-048): linearise
/// all sightings at the present pose, solve J d = r for the six numbers d = (dp, dphi) of target_state.hpp, move, repeat
/// until d is small. It needs three sightings or more, of beacons that are not all in one line of sight. A step that makes
/// the sum of squares worse is shortened by damping (Levenberg and Marquardt), which lets it start far away: the batch
/// search that acquisition needs.
/// Each sighting counts by 1 / (its own variance + what the beacon's uncertainty adds) when `weighted`; the historical method
/// weighs all alike.
/// Nothing here allocates. Bad input: nothing is answered for fewer than three sightings, beacons that the starting pose
/// puts behind their cameras (`resect` skips those at a trial step as worse), or a system without rank; see ResectionStatus.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/innovation.hpp>

namespace holdfast {

/// A sighting with the beacon it is of.
struct SightedBeacon {
  CameraSighting sighting;
  Vector3 beacon_W = Vector3::Zero();
  double beacon_variance = 0.0;  ///< of each coordinate, m^2
};

enum class ResectionStatus {
  converged,
  too_few,        ///< fewer than three sightings
  behind_camera,  ///< the start puts beacons behind the cameras that saw them
  singular,       ///< the sightings do not determine a pose
  not_converged
};

[[nodiscard]] constexpr std::string_view to_string(ResectionStatus status) {
  switch (status) {
    case ResectionStatus::converged:
      return "converged";
    case ResectionStatus::too_few:
      return "too_few";
    case ResectionStatus::behind_camera:
      return "behind_camera";
    case ResectionStatus::singular:
      return "singular";
    case ResectionStatus::not_converged:
      return "not_converged";
  }
  return "unknown";
}

struct ResectionSettings {
  bool weighted = true;
  int maximum_iterations = 30;
  double small_step = 1e-9;  ///< m and rad: converged when no number of the step is larger
};

struct Resection {
  ResectionStatus status = ResectionStatus::not_converged;
  Rigid X_WB;
  Matrix6 covariance =
      Matrix6::Zero();  ///< of (dp, dphi), by the weights; for unweighted sightings up to their variance
  double cost = 0.0;    ///< sum of squared residuals, each by its weight; chi-square of 2 n - 6 if weighted
  int iterations = 0;

  [[nodiscard]] bool ok() const { return status == ResectionStatus::converged; }
};

namespace detail {

/// J^T W J, J^T W r and r^T W r of all measurements at a pose.
struct NormalEquations {
  Matrix6 A = Matrix6::Zero();
  Vector6 g = Vector6::Zero();
  double cost = 0.0;
};

/// The pose next to `start` that makes the cost least. `gather(X_WB, equations)` sums up zeroed equations at a pose; false
/// when there are none there.
template <typename Gather>
[[nodiscard]] Resection least_squares_pose(const Rigid& start, const ResectionSettings& settings,
                                           const Gather& gather) {
  Resection result;
  result.X_WB = start;
  NormalEquations equations;
  if (!gather(start, equations) || !std::isfinite(equations.cost)) {
    result.status = ResectionStatus::behind_camera;
    return result;
  }
  double damping = 0.0;
  for (; result.iterations < settings.maximum_iterations; ++result.iterations) {
    Matrix6 damped = equations.A;
    damped.diagonal() *= 1.0 + damping;
    Matrix6 L;
    if (!cholesky<6>(damped, L) || L.diagonal().minCoeff() < 1e-7 * L.diagonal().maxCoeff()) {
      result.status = ResectionStatus::singular;
      return result;
    }
    const Vector6 d = solved_by<6, 1>(L, equations.g);
    const Rigid moved(result.X_WB.q() * so3::exp<double>(d.tail<3>()), result.X_WB.p() + d.head<3>());
    const bool small = d.cwiseAbs().maxCoeff() < settings.small_step;
    NormalEquations there;
    if (gather(moved, there) && there.cost <= equations.cost * (1.0 + 1e-12)) {
      result.X_WB = moved;
      equations = there;
      damping = damping < 1e-6 ? 0.0 : damping * 0.1;
    } else if (!small) {
      damping = std::max(1e-3, damping * 10.0);
      continue;
    }
    if (small) {
      result.status = ResectionStatus::converged;
      if (cholesky<6>(equations.A, L)) result.covariance = inverse_by<6>(L);
      break;
    }
  }
  result.cost = equations.cost;
  return result;
}

}  // namespace detail

/// The pose nearest to `start` that explains the sightings best.
[[nodiscard]] inline Resection resect(std::span<const SightedBeacon> sightings, const Rigid& start,
                                      const ResectionSettings& settings = {}) {
  if (sightings.size() < 3) {
    Resection result;
    result.X_WB = start;
    result.status = ResectionStatus::too_few;
    return result;
  }
  return detail::least_squares_pose(start, settings, [&](const Rigid& X_WB, detail::NormalEquations& equations) {
    TargetState<1> state;
    state.X_WB = X_WB;
    for (const SightedBeacon& seen : sightings) {
      Linearization<CameraSighting> linear;
      if (!seen.sighting.linearize(state, seen.beacon_W, {}, linear)) return false;
      Matrix2 W = Matrix2::Identity();
      if (settings.weighted) {
        W = linear.R + seen.beacon_variance * linear.H_source * linear.H_source.transpose();
        W = W.inverse().eval();
      }
      const MatrixOf<double, 6, 2> HtW = linear.H.transpose() * W;
      equations.A.noalias() += HtW * linear.H;
      equations.g.noalias() += HtW * linear.residual;
      equations.cost += linear.residual.dot(W * linear.residual);
    }
    return true;
  });
}

}  // namespace holdfast

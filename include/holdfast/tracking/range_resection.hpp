/// Pose from ranges between receivers on the body and beacons in the world, and from directions that inertial sensors or a
/// compass tell: iterated least squares, as space_resection.hpp does it for sightings.
///
/// Of (dp, dphi): a range's residual r - |p_WB + R_WB l_B - b_W| is range.hpp's; a direction d known in W and seen as s in
/// B has s - R_WB^T d, two numbers' worth. Six ranges from three receivers, or four and the vertical, pin a pose down (003
/// section 1). It ends in the minimum next to its start; range_acquisition.hpp finds that one.
/// Nothing here allocates. Bad input: `too_few` for less than six numbers, `singular` when they do not determine a pose, and
/// `behind_camera` stands for what is not finite. Metres and radians.
#pragma once

#include <span>

#include <holdfast/tracking/range.hpp>
#include <holdfast/tracking/space_resection.hpp>

namespace holdfast {

struct ReceiverRange {
  Vector3 beacon_W = Vector3::Zero();
  Vector3 receiver_B = Vector3::Zero();
  double range_m = 0.0;
  double sigma_m = 1.0;
};

/// The vertical by accelerometers, the heading by a compass. Both of unit length.
struct SeenDirection {
  Vector3 direction_W = Vector3::UnitZ();
  Vector3 seen_B = Vector3::UnitZ();
  double sigma_rad = 0.01;
};

/// The pose X_WB nearest to `start` that explains ranges (m) and directions (unit vectors, rad) best, by least squares.
/// Bad input: fewer than six numbers are `too_few`; other failures are named as in space_resection.hpp.
[[nodiscard]] inline Resection resect_ranges(std::span<const ReceiverRange> ranges,
                                             std::span<const SeenDirection> directions, const Rigid& start,
                                             const ResectionSettings& settings = {}) {
  if (ranges.size() + 2 * directions.size() < 6) {
    Resection result;
    result.X_WB = start;
    result.status = ResectionStatus::too_few;
    return result;
  }
  return detail::least_squares_pose(start, settings, [&](const Rigid& X_WB, detail::NormalEquations& equations) {
    TargetState<1> state;
    state.X_WB = X_WB;
    for (const ReceiverRange& r : ranges) {
      Linearization<Range> linear;
      const Range range{r.range_m, r.receiver_B, r.sigma_m * r.sigma_m};
      if (!range.linearize(state, r.beacon_W, {}, linear)) return false;
      const double weight = 1.0 / linear.R(0, 0);
      equations.A.noalias() += weight * linear.H.transpose() * linear.H;
      equations.g.noalias() += weight * linear.residual[0] * linear.H.transpose();
      equations.cost += weight * linear.residual[0] * linear.residual[0];
    }
    for (const SeenDirection& d : directions) {
      const double weight = 1.0 / (d.sigma_rad * d.sigma_rad);
      const Vector3 expected_B = X_WB.q().conjugate() * d.direction_W;
      const Vector3 residual = d.seen_B - expected_B;
      const Matrix3 H = so3::hat<double>(expected_B);  // by dphi
      equations.A.bottomRightCorner<3, 3>() += weight * H.transpose() * H;
      equations.g.tail<3>() += weight * H.transpose() * residual;
      equations.cost += weight * residual.squaredNorm();
    }
    return true;
  });
}

}  // namespace holdfast

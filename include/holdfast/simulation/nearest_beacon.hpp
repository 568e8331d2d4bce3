/// Which beacon a sighting shows, by where the tracker takes itself to be.
///
/// A sighting may name the wrong beacon. Where it lies on the photodiode tells the right one: beacons hang so far apart, and
/// a pose that is tracked is known so well, that only one can have its image there. Rejected sightings need not be lost then
/// (SearchingTracker). It asks the few beacons that the camera's field reaches (ceiling_footprint.hpp).
/// Two that lie alike near are no answer: the second must be `clearness` times as far.
/// Bad input: preconditions are that the pose is finite, and that the camera and the table's beacons are the rig's.
#pragma once

#include <limits>
#include <optional>

#include <holdfast/simulation/ceiling_footprint.hpp>
#include <holdfast/tracking/device_table.hpp>

namespace holdfast {

struct NearestBeaconSettings {
  double reach_m = 0.02;  ///< from their design beacons are not farther, along each axis of L
  double clearness = 3.0;
};

[[nodiscard]] inline std::optional<int> nearest_beacon(const HiBallRig& rig, const DeviceTable<3>& beacons,
                                                       const Rigid& X_WB, int camera, const Vector2& uv,
                                                       const NearestBeaconSettings& settings = {}) {
  const HiBallCamera& seer = rig.cameras[static_cast<std::size_t>(camera)];
  const CeilingCells cells = ceiling_footprint(rig.ceiling, seer, rig.ceiling.X_WL.inverse() * X_WB, settings.reach_m);
  const Rigid X_BW = X_WB.inverse();
  double least = std::numeric_limits<double>::infinity(), second = least;
  int nearest = -1;
  for (int j = cells.j_begin; j < cells.j_end; ++j) {
    for (int i = cells.i_begin; i < cells.i_end; ++i) {
      const int beacon = rig.ceiling.beacon_at(i, j);
      if (beacon < 0) continue;
      const std::optional<Vector2> image = seer.view.project(X_BW * beacons.record(beacon).x);
      if (!image) continue;
      const double distance = (*image - uv).norm();
      if (distance < least) {
        second = least;
        least = distance;
        nearest = beacon;
      } else if (distance < second) {
        second = distance;
      }
    }
  }
  if (nearest < 0 || second < settings.clearness * least) return std::nullopt;
  return nearest;
}

}  // namespace holdfast

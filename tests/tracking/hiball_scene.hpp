// A HiBall that sways below its ceiling, for tests of whole filters.
#pragma once

#include <cmath>
#include <vector>

#include <holdfast/simulation/ceiling_motion.hpp>
#include <holdfast/simulation/sighting_stream.hpp>
#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/scaat_filter.hpp>

namespace holdfast::test {

/// A head's sway: 0.2 m and 20 degrees or so, at about 0.3 Hz.
inline Rigid swaying(double t) {
  const Vector3 turn(0.2 * std::sin(1.9 * t), 0.15 * std::sin(2.3 * t), 0.5 * std::sin(1.1 * t));
  const Vector3 sway(0.2 * std::sin(1.7 * t), 0.2 * std::cos(1.3 * t), 0.05 * std::sin(2.9 * t));
  return Rigid(so3::exp<double>(turn), Vector3(2.78, 4.35, 1.60) + sway);
}

inline SplineTrajectory swaying_hiball(double seconds) {
  std::vector<TimedPose> poses;
  for (int i = 0; i <= static_cast<int>(50.0 * seconds); ++i) poses.push_back({time_at(0.02 * i), swaying(0.02 * i)});
  return SplineTrajectory(poses);
}

/// All measurements count.
inline ScaatSettings no_gate() {
  ScaatSettings settings;
  settings.gate.probability = 1.0;
  return settings;
}

struct HiBallScene {
  SplineTrajectory truth;
  HiBallSimulator simulator;

  explicit HiBallScene(const SplineTrajectory& motion, double beacon_error_m = 0.001, std::uint64_t seed = 1)
      : truth(motion), simulator(rig(beacon_error_m, seed), truth, seed) {}
  HiBallScene(const HiBallScene&) = delete;

  static HiBallRig rig(double beacon_error_m, std::uint64_t seed) {
    HiBallOptions options;
    options.beacon_error_m = beacon_error_m;
    options.seed = seed;
    return hiball_rig(options);
  }

  /// Beacons as designed, to be learnt.
  [[nodiscard]] DeviceTable<3> beacons() const {
    DeviceSettings<3> settings;
    settings.initial_variance.setConstant(1e-6);
    settings.residual_variance.setConstant(1e-7);
    settings.wander.setConstant(2.8e-10);
    DeviceTable<3> table(settings);
    for (const Vector3& beacon_W : simulator.rig().nominal_beacons_W) table.add(beacon_W);
    return table;
  }
  static PvModel model() { return PvModel::hiball(0.14, 0.17, Vector3::Constant(1.7)); }

  [[nodiscard]] TargetState<2> start() const {
    TargetState<2> state;
    state.t = truth.begin();
    state.X_WB = simulator.pose_at(state.t);
    state.P *= 1e-6;
    state.P.bottomRightCorner<6, 6>() = 0.1 * Matrix6::Identity();
    return state;
  }
  [[nodiscard]] CameraSighting measurement(const BeaconSighting& sighting) const {
    return {sighting.uv, &simulator.rig().cameras[static_cast<std::size_t>(sighting.camera)].view, sighting.variance};
  }
};

}  // namespace holdfast::test

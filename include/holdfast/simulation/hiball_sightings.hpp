/// What a HiBall that moves truly as given would measure: which beacons each camera sees, and each one's sighting.
///
/// A camera sees a beacon whose image lies on its photodiode, that hangs above it, and whose signal is above
/// weakest_signal (tracking/sighting_noise.hpp). The sighting is the image of the true beacon from the true pose, plus
/// normal noise of eq. 6.4's variance in u and in v (002 E.2). `variance` is that true variance: a tracker may use it, or
/// compute its own from its estimate as 002 does.
/// The noise belongs to (seed, t, camera, beacon) (keyed_numbers.hpp): asking in another order, or twice, gives the same.
/// Nothing here changes after construction: any number of threads may ask. `visible` and `sight` allocate nothing once
/// the list has grown.
/// Bad input: camera and beacon must exist (assert); a time outside the motion gets its nearer end's pose.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <holdfast/motion/motion.hpp>
#include <holdfast/simulation/ceiling_footprint.hpp>

namespace holdfast {

/// What faults.hpp did to a sighting: for judging a tracker, which must not look.
struct SightingFaults {
  bool wrong_beacon = false;
  std::optional<int> true_beacon;  ///< where another was named
  bool noise_burst = false;
  bool panel_moved = false;
  bool clock_jumped = false;

  [[nodiscard]] bool any() const { return wrong_beacon || noise_burst || panel_moved || clock_jumped; }
};

struct BeaconSighting {
  HostTime t;
  int camera = 0;
  int beacon = 0;
  Vector2 uv = Vector2::Zero();  ///< on the camera's photodiode, m
  double variance = 0.0;         ///< of u and of v, m^2
  SightingFaults faults;
};

class HiBallSimulator {
 public:
  /// `truth` gives X_WB and must outlive the simulator.
  HiBallSimulator(HiBallRig rig, const Motion& truth, std::uint64_t noise_seed = 1)
      : rig_(std::move(rig)), truth_(&truth), noise_seed_(noise_seed) {
    const Rigid X_LW = rig_.ceiling.X_WL.inverse();
    for (std::size_t k = 0; k < rig_.beacons_W.size(); ++k) {
      const Vector3 off_L = X_LW.q() * Vector3(rig_.beacons_W[k] - rig_.nominal_beacons_W[k]);
      reach_m_ = std::max(reach_m_, off_L.cwiseAbs().maxCoeff());
    }
    reach_m_ += 1e-9;  // more than rounding
  }

  [[nodiscard]] const HiBallRig& rig() const { return rig_; }
  [[nodiscard]] const Motion& truth() const { return *truth_; }
  [[nodiscard]] Rigid pose_at(HostTime t) const { return truth_->at(t).X_WB; }

  /// Where the beacon's image lies on the camera's photodiode, without noise; nothing when the camera does not see it.
  [[nodiscard]] std::optional<Vector2> image(const Rigid& X_WB, int camera, int beacon) const {
    return Seeing(rig_, check_camera(camera), X_WB).image(check_beacon(beacon));
  }

  /// Fills `beacons` with those the camera sees from this pose, in rising order.
  void visible(const Rigid& X_WB, int camera, std::vector<int>& beacons) const {
    beacons.clear();
    const HiBallCamera& seer = check_camera(camera);
    const Rigid X_LB = rig_.ceiling.X_WL.inverse() * X_WB;
    const CeilingCells cells = ceiling_footprint(rig_.ceiling, seer, X_LB, reach_m_);
    if (cells.empty()) return;
    const Seeing seeing(rig_, seer, X_WB);
    for (int j = cells.j_begin; j < cells.j_end; ++j) {
      for (int i = cells.i_begin; i < cells.i_end; ++i) {
        const int beacon = rig_.ceiling.beacon_at(i, j);
        if (beacon >= 0 && seeing.image(rig_.beacons_W[static_cast<std::size_t>(beacon)])) beacons.push_back(beacon);
      }
    }
    std::ranges::sort(beacons);
  }

  /// The sighting at time t from the true pose; nothing when the camera does not see the beacon.
  [[nodiscard]] std::optional<BeaconSighting> sight(HostTime t, int camera, int beacon) const {
    return sight(t, pose_at(t), camera, beacon);
  }
  /// The same with the true pose at t already at hand.
  [[nodiscard]] std::optional<BeaconSighting> sight(HostTime t, const Rigid& X_WB, int camera, int beacon) const {
    const Vector3& beacon_W = check_beacon(beacon);
    const Seeing seeing(rig_, check_camera(camera), X_WB);
    const std::optional<Vector2> image = seeing.image(beacon_W);
    if (!image) return std::nullopt;
    BeaconSighting sighting{t, camera, beacon, *image, seeing.variance(rig_.noise, beacon_W), {}};
    KeyedNumbers numbers(noise_seed_, {t.time_since_epoch().count(), camera, beacon});
    sighting.uv += std::sqrt(sighting.variance) * numbers.normal_pair();
    return sighting;
  }

 private:
  /// A camera at a pose: c = M b_W + m in place of V (X_WB^-1 b_W, 1).
  class Seeing {
   public:
    Seeing(const HiBallRig& rig, const HiBallCamera& camera, const Rigid& X_WB)
        : camera_(camera), beacon_axis_W_(rig.ceiling.beacon_axis_W()), axis_W_(X_WB.q() * camera.axis_B) {
      M_ = camera.view.V.leftCols<3>() * X_WB.q().conjugate().toRotationMatrix();
      m_ = camera.view.V.col(3) - M_ * X_WB.p();
      centre_W_ = X_WB * camera.centre_B;
      const double sine = beacon_axis_W_.cross(axis_W_).norm(), cosine = -beacon_axis_W_.dot(axis_W_);
      bright_ = signal_strength(rig.noise, std::atan2(sine, cosine)) > weakest_signal;
    }

    [[nodiscard]] std::optional<Vector2> image(const Vector3& beacon_W) const {
      if (!bright_ || !(beacon_axis_W_.dot(centre_W_ - beacon_W) > 0.0)) return std::nullopt;
      const Vector3 c = M_ * beacon_W + m_;
      if (!(c.z() > CameraView::nearest_m)) return std::nullopt;
      const Vector2 uv(c.x() / c.z(), c.y() / c.z());
      if (!(uv.cwiseAbs().maxCoeff() <= camera_.half_side_m)) return std::nullopt;
      return uv;
    }

    [[nodiscard]] double variance(const SightingNoise& noise, const Vector3& beacon_W) const {
      return sighting_variance(noise, beacon_axis_W_, axis_W_, (beacon_W - centre_W_).norm());
    }

   private:
    const HiBallCamera& camera_;
    Vector3 beacon_axis_W_, axis_W_, centre_W_, m_;
    Matrix3 M_;
    bool bright_;
  };

  [[nodiscard]] const HiBallCamera& check_camera(int camera) const {
    HOLDFAST_ASSERT(camera >= 0 && camera < static_cast<int>(rig_.cameras.size()), "there is no such camera");
    return rig_.cameras[static_cast<std::size_t>(camera)];
  }
  [[nodiscard]] const Vector3& check_beacon(int beacon) const {
    HOLDFAST_ASSERT(beacon >= 0 && beacon < static_cast<int>(rig_.beacons_W.size()), "there is no such beacon");
    return rig_.beacons_W[static_cast<std::size_t>(beacon)];
  }

  HiBallRig rig_;
  const Motion* truth_;
  std::uint64_t noise_seed_;
  double reach_m_ = 0.0;  ///< no beacon is farther than this from its design along an axis of L
};

}  // namespace holdfast

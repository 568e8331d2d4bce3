/// A HiBall's sightings in the order that its tracker asks for: each time the one that tells most about the direction in which
/// the pose is known least (002 sections 4.6 and 7.5), beside the blind orders of simulation/sighting_stream.hpp.
///
/// Of each camera the beacon that was used longest ago is a candidate, but not of those that looked last
/// (measurement_ordering.hpp says why); the tracker tells what each would take from the error of the three points of
/// three_point_error.hpp along their weakest direction. When it cannot tell, the camera that looked longest ago comes next.
/// As with the blind orders the choice is among what is truly visible.
/// At first all take turns (round-robin). While LEDs are learnt it is the first sightings of each that tie them to the
/// world; a tracker that chooses already then leaves some untied, and is up to a third farther off ever after.
/// Bad input: numbers below 0 are none.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include <holdfast/registration/three_point_error.hpp>
#include <holdfast/simulation/hiball_trackers.hpp>
#include <holdfast/simulation/sighting_stream.hpp>

namespace holdfast {

struct InformedOrderSettings {
  double resting = 2.0 / 3.0;                       ///< share of the cameras, those that looked last, that are left out
  Duration turns = std::chrono::milliseconds(300);  ///< at first
};

class InformedOrder {
 public:
  /// The simulator must outlive it.
  explicit InformedOrder(const HiBallSimulator& simulator, const InformedOrderSettings& settings = {})
      : simulator_(&simulator), schedule_(simulator, SightingOrder::round_robin) {
    const std::size_t cameras = simulator.rig().cameras.size();
    resting_ = static_cast<std::int64_t>(settings.resting * static_cast<double>(cameras) + 1e-9);
    turns_end_ = simulator.truth().begin() + settings.turns;
    last_look_.assign(cameras, -resting_);
    last_use_.assign(simulator.rig().beacons_W.size(), -1);
  }

  /// The next sighting, at time t; nothing when no camera sees anything.
  [[nodiscard]] std::optional<BeaconSighting> next(HostTime t, HiBallTracker& tracker) {
    const Rigid X_WB = simulator_->pose_at(t);
    std::optional<BeaconSighting> sighting;
    if (t < turns_end_) {
      if (const auto turn = schedule_.next(X_WB)) sighting = simulator_->sight(t, X_WB, turn->first, turn->second);
    } else {
      sighting = best(t, X_WB, tracker);
    }
    if (sighting) last_look(sighting->camera) = last_use(sighting->beacon) = ++looks_;
    return sighting;
  }

 private:
  [[nodiscard]] std::optional<BeaconSighting> best(HostTime t, const Rigid& X_WB, HiBallTracker& tracker) {
    const std::optional<Matrix6> weight = weakest(tracker);
    std::optional<BeaconSighting> best;
    double most = -1.0;
    for (const bool all : {false, true}) {  // where only those see anything that should rest, one of them looks
      for (int camera = 0; camera < static_cast<int>(last_look_.size()); ++camera) {
        if (!all && looks_ - last_look(camera) < resting_) continue;
        simulator_->visible(X_WB, camera, visible_);
        if (visible_.empty()) continue;
        const int beacon = *std::ranges::min_element(visible_, {}, [&](int b) { return last_use(b); });
        const BeaconSighting sighting = *simulator_->sight(t, X_WB, camera, beacon);
        const double told = weight ? tracker.expected_reduction(sighting, *weight).value_or(0.0) : 0.0;
        const double reduction = std::isfinite(told) ? told : 0.0;
        if (reduction > most || (reduction == most && last_look(camera) < last_look(best->camera))) {
          most = reduction;
          best = sighting;
        }
      }
      if (best) break;
    }
    return best;
  }

  [[nodiscard]] static std::optional<Matrix6> weakest(const HiBallTracker& tracker) {
    if (tracker.state() == nullptr) return std::nullopt;
    const TargetState<2>& state = *tracker.state();
    const auto direction =
        weakest_direction(state.P.topLeftCorner<6, 6>(), pose_weight(state.X_WB.q(), three_points_B));
    return direction ? std::optional(direction->weight) : std::nullopt;
  }
  std::int64_t& last_look(int camera) { return last_look_[static_cast<std::size_t>(camera)]; }
  std::int64_t& last_use(int beacon) { return last_use_[static_cast<std::size_t>(beacon)]; }

  const HiBallSimulator* simulator_;
  SightingSchedule schedule_;
  std::int64_t resting_ = 0;
  HostTime turns_end_;
  std::vector<std::int64_t> last_look_, last_use_;  ///< of each camera and beacon
  std::vector<int> visible_;
  std::int64_t looks_ = 0;
};

}  // namespace holdfast

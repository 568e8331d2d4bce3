/// Which camera and which beacon come next, and whole streams of sightings made so.
///
///   round_robin          the next camera that sees anything, and of what it sees the beacon after its last one (002 E.2)
///   random               any camera that sees anything, any beacon of those (002 figure 6.10: no peaks in the spectrum)
///   least_recently_used  any camera that sees anything, and its beacon that was used longest ago (HiBall paper 5.3)
/// The choice is among what is truly visible, as 002 chose: it asks for the true pose. A tracker that chooses by its own
/// estimate asks HiBallSimulator::sight itself.
/// A group of N sightings has one time: 002's simultaneous observations (6.2.5). All are different; where fewer are
/// visible there are fewer. At a time when no camera sees anything there is no sighting.
/// Bad input: `sighting_stream` asserts a positive interval and group.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <holdfast/simulation/hiball_sightings.hpp>

namespace holdfast {

enum class SightingOrder { round_robin, random, least_recently_used };

class SightingSchedule {
 public:
  explicit SightingSchedule(const HiBallSimulator& simulator, SightingOrder order, std::uint64_t seed = 1)
      : simulator_(&simulator), order_(order), numbers_(seed, {}) {
    const std::size_t cameras = simulator.rig().cameras.size();
    last_of_camera_.assign(cameras, -1);
    cameras_.resize(cameras);
    last_use_.assign(simulator.rig().beacons_W.size(), -1);
  }

  /// The next camera and beacon, seen from this pose; nothing when no camera sees anything.
  [[nodiscard]] std::optional<std::pair<int, int>> next(const Rigid& X_WB) {
    const int count = static_cast<int>(cameras_.size());
    for (int k = 0; k < count; ++k) cameras_[static_cast<std::size_t>(k)] = k;
    for (int tried = 0; tried < count; ++tried) {
      if (order_ == SightingOrder::round_robin) {
        last_camera_ = (last_camera_ + 1) % count;
      } else {
        std::swap(cameras_[static_cast<std::size_t>(tried)],
                  cameras_[static_cast<std::size_t>(tried + numbers_.below(count - tried))]);
        last_camera_ = cameras_[static_cast<std::size_t>(tried)];
      }
      simulator_->visible(X_WB, last_camera_, visible_);
      if (!visible_.empty()) return std::pair(last_camera_, choose_beacon());
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] int choose_beacon() {
    int& last = last_of_camera_[static_cast<std::size_t>(last_camera_)];
    const auto use = [&](int beacon) -> std::int64_t& { return last_use_[static_cast<std::size_t>(beacon)]; };
    int beacon = visible_.front();
    if (order_ == SightingOrder::round_robin) {
      const auto after = std::ranges::upper_bound(visible_, last);
      if (after != visible_.end()) beacon = *after;
    } else if (order_ == SightingOrder::random) {
      beacon = visible_[static_cast<std::size_t>(numbers_.below(static_cast<int>(visible_.size())))];
    } else {
      for (const int other : visible_) {
        if (use(other) < use(beacon)) beacon = other;
      }
    }
    last = beacon;
    use(beacon) = ++uses_;
    return beacon;
  }

  const HiBallSimulator* simulator_;
  SightingOrder order_;
  KeyedNumbers numbers_;
  int last_camera_ = -1;
  std::vector<int> last_of_camera_, cameras_, visible_;
  std::vector<std::int64_t> last_use_;  ///< of each beacon
  std::int64_t uses_ = 0;
};

struct StreamOptions {
  Duration interval = std::chrono::milliseconds(1);  ///< between sightings, on average: 1000 Hz
  int group = 1;  ///< sightings of one time; the next group is group * interval later
  SightingOrder order = SightingOrder::round_robin;
  std::uint64_t seed = 1;  ///< of the order
};

/// Sightings all along the true motion, in the order of time.
[[nodiscard]] inline std::vector<BeaconSighting> sighting_stream(const HiBallSimulator& simulator,
                                                                 const StreamOptions& options = {}) {
  HOLDFAST_ASSERT(options.interval > Duration(0) && options.group > 0, "a stream needs an interval and a group");
  SightingSchedule schedule(simulator, options.order, options.seed);
  std::vector<BeaconSighting> stream;
  stream.reserve(static_cast<std::size_t>(simulator.truth().duration() / options.interval) + 1);
  const Duration step = options.interval * options.group;
  for (HostTime t = simulator.truth().begin(); t <= simulator.truth().end(); t += step) {
    const Rigid X_WB = simulator.pose_at(t);
    const std::size_t first = stream.size();
    for (int tries = 0; tries < 4 * options.group; ++tries) {
      const std::optional<std::pair<int, int>> chosen = schedule.next(X_WB);
      if (!chosen) break;
      const auto [camera, beacon] = *chosen;
      bool taken = false;
      for (std::size_t k = first; k < stream.size(); ++k) {
        taken = taken || (stream[k].camera == camera && stream[k].beacon == beacon);
      }
      if (!taken) stream.push_back(*simulator.sight(t, X_WB, camera, beacon));
      if (stream.size() - first == static_cast<std::size_t>(options.group)) break;
    }
  }
  return stream;
}

}  // namespace holdfast

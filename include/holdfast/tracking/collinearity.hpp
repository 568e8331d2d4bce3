/// The Collinearity tracker: a pose from each N sightings alone, as the first ceiling tracker did it.
///
/// SCAAT's rival (002 sections 3.4, E.3.2): the sightings of a window are taken for simultaneous and weighed alike, and their
/// space resection starts from the pose before. No filter: no velocity, no covariance between estimates, nothing learnt
/// about beacons. It needs three sightings; 10 to 15 are usual (002 section 5.2.3).
/// Bad input: a window that gives no pose (see ResectionStatus) leaves the last one.
#pragma once

#include <holdfast/tracking/observation_window.hpp>
#include <holdfast/tracking/space_resection.hpp>

namespace holdfast {

class CollinearityTracker {
 public:
  static constexpr int capacity = 32;

  explicit CollinearityTracker(const Rigid& start, const WindowShape& shape = {}) : window_(shape), X_WB_(start) {}

  /// The new pose when this sighting fills the window, or why there is none; nothing while it is filling.
  [[nodiscard]] std::optional<Resection> add(const SightedBeacon& seen) {
    if (!window_.add(seen)) return std::nullopt;
    Resection found = resect(window_.observations(), X_WB_, {.weighted = false});
    if (found.ok()) X_WB_ = found.X_WB;
    return found;
  }

  /// The newest pose.
  [[nodiscard]] const Rigid& X_WB() const { return X_WB_; }

 private:
  ObservationWindow<SightedBeacon, capacity> window_;
  Rigid X_WB_;
};

}  // namespace holdfast

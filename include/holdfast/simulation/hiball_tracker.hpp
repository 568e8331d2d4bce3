/// The one face of all trackers that a HiBall's sightings can be given to (hiball_trackers.hpp has them).
///
/// Sightings come in the order of time, each with the variance that it claims; those back in time are ignored. Poses are X_WB,
/// body in the world.
#pragma once

#include <optional>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/simulation/hiball_sightings.hpp>
#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

class HiBallTracker {
 public:
  virtual ~HiBallTracker() = default;

  /// Takes a sighting; true when there is a new estimate.
  virtual bool add(const BeaconSighting& sighting) = 0;
  /// The newest estimate, of the time of the sighting that made it.
  [[nodiscard]] virtual const Rigid& X_WB() const = 0;
  /// The filter's state; null for a method without a filter.
  [[nodiscard]] virtual const TargetState<2>* state() const = 0;
  /// Normalised innovation squared of the last sighting, which has two numbers; nothing for methods that do not tell.
  [[nodiscard]] virtual std::optional<double> nis() const { return std::nullopt; }
  /// Whether the last sighting was turned away by a gate or for a bad beacon's sake, under the name that it came with.
  [[nodiscard]] virtual bool turned_away() const { return false; }
  /// The beacon that it counted as then; nothing when it did not count.
  [[nodiscard]] virtual std::optional<int> renamed() const { return std::nullopt; }
  /// How much of the weighted mean square of the pose's error such a sighting would take away (measurement_ordering.hpp);
  /// nothing from trackers that do not tell, and while there is no pose. What was seen does not matter.
  [[nodiscard]] virtual std::optional<double> expected_reduction(const BeaconSighting& /*sighting*/,
                                                                 const Matrix6& /*weight*/) {
    return std::nullopt;
  }
  /// Writes to the table of beacons what has been learnt and is not there yet.
  virtual void settle() {}
};

}  // namespace holdfast

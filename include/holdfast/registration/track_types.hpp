/// What an experiment of tracking is told, and what it answers: a row per method, and what an observer sees on the way.
///
/// Source: 002 chapter 6. Apart from track_experiment.hpp, which runs the trackers: who only shows rows needs none of them.
/// Units are told with the members; NEES and NIS are per degree of freedom, and NaN when nothing was judged.
#pragma once

#include <functional>
#include <limits>
#include <optional>

#include <holdfast/registration/three_point_error.hpp>
#include <holdfast/registration/track_methods.hpp>
#include <holdfast/simulation/hiball_tracker.hpp>

namespace holdfast {

/// m, RMS over beacons.
struct BeaconErrors {
  struct Group {
    int beacons = 0;
    double before = 0.0, after = 0.0;
  };
  Group seen, seen_often;
  static constexpr unsigned often = 20;
};

struct TrackRow {
  TrackMethod method = TrackMethod::scaat;
  ThreePointError three_point;  ///< m
  RmsAndPeak position;          ///< m
  RmsAndPeak angle;             ///< rad
  long sightings = 0;           ///< given to the method
  long updates = 0;             ///< estimates
  long accepted = 0;            ///< sightings that estimates were made of
  long gated = 0;               ///< turned away by the gate, under the name that they came with
  long renamed = 0;             ///< of these, how many counted under another name
  double microseconds_per_update = 0.0;
  std::optional<BeaconErrors> beacons;  ///< of methods that learn them
  double nees = std::numeric_limits<double>::quiet_NaN();
  double nis = std::numeric_limits<double>::quiet_NaN();
};

/// After a sighting: its time, the newest estimate, the truth at that time, whether the estimate is new.
struct TrackMoment {
  const BeaconSighting& sighting;
  const HiBallTracker& tracker;
  Rigid X_WB;
  bool fresh;
};
using TrackObserver = std::function<void(const TrackMoment&)>;

/// How well a tracker knows where, and how fast, it starts: standard deviations of an axis. The start itself is the truth.
struct StartKnowledge {
  double pose = 1e-5;      ///< m and rad
  double velocity = 1e-3;  ///< m/s and rad/s
};

}  // namespace holdfast

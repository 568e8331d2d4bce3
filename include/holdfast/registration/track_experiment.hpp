/// Runs methods of tracking (track_methods.hpp) over the same sightings of a simulated HiBall, and says how far off they
/// were (002 chapter 6).
///
/// All start from the true pose and velocity, as 002 did (6.1.4: "we could use a conventional method such as Collinearity to
/// determine the initial state"; its velocity was zero), and take them as known to `StartKnowledge`. That matters: who
/// learns beacons learns them relative to where it takes itself to be, and what it starts with is all that ties both to the
/// world, but for the mean of the design (the gauge freedom of 002 5.1.4). Errors are counted at each
/// estimate's own time (002 6.2.2): a method that estimates every 10 ms is not charged for being silent in between. `observe`
/// sees what a user would, the newest estimate after each sighting.
/// NEES and NIS are means per degree of freedom (1 is consistent, above is too sure): NEES of all 12 numbers at every 20th
/// estimate, NIS of every sighting that reached the gate.
/// Beacon errors are RMS over beacons, of those that the method saw at all and of those it saw 20 times or more, and what the
/// design's error is for the same ones.
/// `microseconds_per_update` is the time spent in the tracker by estimate, of one thread on the machine at hand.
/// Bad input: an empty stream gives rows of zeros.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/registration/informed_order.hpp>
#include <holdfast/registration/track_methods.hpp>
#include <holdfast/registration/track_types.hpp>
#include <holdfast/simulation/hiball_trackers.hpp>
#include <holdfast/tracking/consistency.hpp>

namespace holdfast {

[[nodiscard]] inline TargetState<2> true_target_state(const Motion& truth, HostTime t) {
  const MotionState at = truth.at(t);
  TargetState<2> state;
  state.t = t;
  state.X_WB = at.X_WB;
  state.velocity = {at.v_WB, at.w_WB_B};
  return state;
}

[[nodiscard]] inline TargetState<2> starting_state(const Motion& truth, HostTime t, const StartKnowledge& known = {}) {
  TargetState<2> state = true_target_state(truth, t);
  state.P.setZero();
  state.P.diagonal() << Vector6::Constant(known.pose * known.pose), Vector6::Constant(known.velocity * known.velocity);
  return state;
}

[[nodiscard]] inline BeaconErrors beacon_errors(const HiBallRig& rig, const DeviceTable<3>& beacons) {
  const auto group = [&](unsigned least) {
    BeaconErrors::Group g;
    for (int i = 0; i < beacons.size(); ++i) {
      if (beacons.sightings(i) < least) continue;
      const Vector3& true_W = rig.beacons_W[static_cast<std::size_t>(i)];
      g.before += (rig.nominal_beacons_W[static_cast<std::size_t>(i)] - true_W).squaredNorm();
      g.after += (beacons.at(i).x - true_W).squaredNorm();
      ++g.beacons;
    }
    const double n = std::max(1, g.beacons);
    g.before = std::sqrt(g.before / n);
    g.after = std::sqrt(g.after / n);
    return g;
  };
  return {group(1), group(BeaconErrors::often)};
}

/// The two process models of joint_models, resting and moving, and how long each is taken to last.
[[nodiscard]] inline ModelSet<2, 2> resting_and_moving(const TrackParameters& parameters) {
  return {{resting_process(), parameters.process}, {0.5, 5.0}};
}

/// A tracker that starts from a state. `rig` and `beacons` must outlive it.
[[nodiscard]] inline std::unique_ptr<HiBallTracker> make_tracker(TrackMethod method, const TrackParameters& parameters,
                                                                 const HiBallRig& rig, DeviceTable<3>& beacons,
                                                                 const TargetState<2>& start) {
  if (is_scaat(method)) {
    ScaatSettings settings;
    settings.gate = parameters.gate;
    settings.manoeuvre = parameters.manoeuvre;
    const RenamingSettings renaming{.in_a_row = parameters.renamed_in_a_row};
    if (method == TrackMethod::joint || method == TrackMethod::joint_2) {
      return std::make_unique<JointTracker>(rig, beacons, start, parameters.process, settings, ReacquisitionSettings(),
                                            renaming);
    }
    if (method == TrackMethod::joint_models) {
      return std::make_unique<JointModelsTracker>(rig, beacons, start, resting_and_moving(parameters), settings,
                                                  ReacquisitionSettings(), renaming);
    }
    return std::make_unique<ScaatTracker>(rig, beacons, start, parameters.process, settings, ReacquisitionSettings(),
                                          renaming);
  }
  if (method == TrackMethod::collinearity10) {
    return std::make_unique<ResectionTracker>(rig, beacons, start.X_WB, parameters.window);
  }
  return std::make_unique<McaatTracker>(rig, beacons, start, parameters.process, parameters.window);
}

/// Where sightings come from, one after another; nothing at the end. It may ask the tracker what it wants to see.
using SightingSource = std::function<std::optional<BeaconSighting>(HiBallTracker&)>;

/// Gives a tracker the sightings, and judges it.
inline TrackRow run_tracker(HiBallTracker& tracker, const SightingSource& source, const Motion& truth,
                            const TrackObserver& observe = {}) {
  using Clock = std::chrono::steady_clock;
  TrackRow row;
  Clock::duration spent{};
  ConsistencyMean nees_mean(12), nis_mean(2);
  while (const std::optional<BeaconSighting> next = source(tracker)) {
    const BeaconSighting& sighting = *next;
    const Clock::time_point begin = Clock::now();
    const bool fresh = tracker.add(sighting);
    spent += Clock::now() - begin;
    ++row.sightings;
    row.gated += tracker.turned_away();
    row.renamed += tracker.renamed().has_value();
    nis_mean.add(tracker.nis());
    const Rigid X_WB = truth.at(sighting.t).X_WB;
    if (fresh) {
      row.three_point.add(tracker.X_WB(), X_WB);
      row.position.add((tracker.X_WB().p() - X_WB.p()).norm());
      row.angle.add(so3::angle_between(tracker.X_WB().q(), X_WB.q()));
      if (tracker.state() != nullptr && row.updates % 20 == 0) {
        nees_mean.add(holdfast::nees(*tracker.state(), true_target_state(truth, sighting.t)));
      }
      ++row.updates;
    }
    if (observe) observe({sighting, tracker, X_WB, fresh});
  }
  tracker.settle();
  if (row.updates > 0) {
    row.microseconds_per_update =
        std::chrono::duration<double, std::micro>(spent).count() / static_cast<double>(row.updates);
  }
  row.nees = nees_mean.mean() / nees_mean.expected();
  row.nis = nis_mean.mean() / nis_mean.expected();
  return row;
}

inline TrackRow run_tracker(HiBallTracker& tracker, std::span<const BeaconSighting> stream, const Motion& truth,
                            const TrackObserver& observe = {}) {
  std::size_t next = 0;
  const SightingSource source = [&](HiBallTracker& /*tracker*/) {
    return next < stream.size() ? std::optional(stream[next++]) : std::nullopt;
  };
  return run_tracker(tracker, source, truth, observe);
}

/// One method over a stream. `beacons` goes in as `beacon_table` makes it, or, for the second run, as the first left it.
[[nodiscard]] inline TrackRow run_method(TrackMethod method, const TrackParameters& parameters, const HiBallRig& rig,
                                         const Motion& truth, std::span<const BeaconSighting> stream,
                                         DeviceTable<3>& beacons, const TrackObserver& observe = {},
                                         const StartKnowledge& known = {}) {
  TrackRow row;
  if (!stream.empty()) {
    const auto tracker = make_tracker(method, parameters, rig, beacons, starting_state(truth, stream.front().t, known));
    row = run_tracker(*tracker, stream, truth, observe);
    row.accepted = row.updates * parameters.window.size;
  }
  row.method = method;
  if (parameters.autocalibrate) row.beacons = beacon_errors(rig, beacons);
  return row;
}

/// One method over a stream from the designed beacons on; the second run does the first before.
[[nodiscard]] inline TrackRow run_method(TrackMethod method, const TrackParameters& parameters, const HiBallRig& rig,
                                         const Motion& truth, std::span<const BeaconSighting> stream,
                                         const TrackObserver& observe = {}, const StartKnowledge& known = {}) {
  DeviceTable<3> beacons = beacon_table(rig, parameters.beacons, parameters.autocalibrate);
  if (is_second_run(method)) (void)run_method(method, parameters, rig, truth, stream, beacons, {}, known);
  return run_method(method, parameters, rig, truth, stream, beacons, observe, known);
}

/// One method on the sightings that it asks for itself (informed_order.hpp), 1000 a second unless told otherwise.
[[nodiscard]] inline TrackRow run_informed(TrackMethod method, const TrackParameters& parameters,
                                           const HiBallSimulator& simulator, const TrackObserver& observe = {},
                                           const StartKnowledge& known = {},
                                           Duration interval = std::chrono::milliseconds(1)) {
  const Motion& truth = simulator.truth();
  DeviceTable<3> beacons = beacon_table(simulator.rig(), parameters.beacons, parameters.autocalibrate);
  const auto tracker =
      make_tracker(method, parameters, simulator.rig(), beacons, starting_state(truth, truth.begin(), known));
  InformedOrder order(simulator);
  HostTime t = truth.begin();
  const SightingSource source = [&](HiBallTracker& asked) {
    std::optional<BeaconSighting> sighting;
    for (; !sighting && t <= truth.end(); t += interval) sighting = order.next(t, asked);
    return sighting;
  };
  TrackRow row = run_tracker(*tracker, source, truth, observe);
  row.method = method;
  row.accepted = row.updates;
  if (parameters.autocalibrate) row.beacons = beacon_errors(simulator.rig(), beacons);
  return row;
}

}  // namespace holdfast

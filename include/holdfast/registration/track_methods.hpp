/// The methods that the HiBall experiment compares, and what each is given to work with.
///
///   scaat            one sighting at a time (002 4.3), beacons taken as designed
///   scaat_autocal    the same, and the beacons are learnt (4.4)
///   scaat_autocal_2  a second run that begins with the beacons of the first: 002's dagger
///   joint            SCAAT that keeps what the newest 36 beacons have to do with the pose (tracking/joint_filter.hpp)
///   joint_2          a second run of it
///   joint_models     the same with two process models at once, joint's and one of rest; told neither
///   mcaat3, mcaat10  3 and 10 sightings in one update (E.3.1)
///   collinearity10   10 sightings resected, no filter (E.3.2)
/// The Kalman filters of several sightings learn beacons too, as in 002's figure 6.4: tuned so they are better, or no worse.
/// Where the numbers come from. 002's tables 6.4 to 6.8 do not carry over: intensities found there for one motion are far
/// off for another, and with mu[b] per sighting as printed the filter fails. Intensities are those of one shape,
/// (0.14, 0.17, 1.7, 1.7, 1.7), times 0.1 to 100; `residual_variance`, what a beacon keeps of its error however often it is
/// seen, is 0 to 3e-5 m^2; beacons' initial variance is their own, 1e-6 m^2. Of these each method has what gave it the least
/// three-point RMS over the head recording and handheld/table_04 together, to 4 %; MCAAT 10 has what a search found on them
/// (track_tuning.hpp), with which it is better on every motion. The residual also stands for what a method ignores: MCAAT's
/// sightings are not of one time, and without it SCAAT at rest drifts with its beacons. SCAAT's, of those within the 4 %, is
/// the one with which it is about as sure as it may be.
/// A manoeuvre's threshold is 0.6 for those that learn, whose mean is 0.2 to 0.4 otherwise, and 1.0 for `scaat`, of 0.9.
/// Still tuning: `still_process`. The gate has no probation for beacons: wrong names fall on any of them here, and one that
/// was named wrongly has done nothing wrong (with it, 20 % wrong names cost as many good sightings).
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include <holdfast/tracking/device_table.hpp>
#include <holdfast/tracking/innovation_gate.hpp>
#include <holdfast/tracking/manoeuvre.hpp>
#include <holdfast/tracking/observation_window.hpp>
#include <holdfast/tracking/process_model.hpp>

namespace holdfast {

enum class TrackMethod {
  scaat,
  scaat_autocal,
  scaat_autocal_2,
  joint,
  joint_2,
  joint_models,
  mcaat3,
  mcaat10,
  collinearity10
};

inline constexpr std::array track_methods{TrackMethod::scaat,  TrackMethod::scaat_autocal, TrackMethod::scaat_autocal_2,
                                          TrackMethod::joint,  TrackMethod::joint_2,       TrackMethod::joint_models,
                                          TrackMethod::mcaat3, TrackMethod::mcaat10,       TrackMethod::collinearity10};

[[nodiscard]] constexpr std::string_view name_of(TrackMethod method) {
  constexpr std::array<std::string_view, track_methods.size()> names{"scaat",  "scaat_autocal", "scaat_autocal_2",
                                                                     "joint",  "joint_2",       "joint_models",
                                                                     "mcaat3", "mcaat10",       "collinearity10"};
  return names[static_cast<std::size_t>(method)];
}

[[nodiscard]] constexpr std::optional<TrackMethod> parse_track_method(std::string_view name) {
  for (const TrackMethod method : track_methods) {
    if (name == name_of(method)) return method;
  }
  return std::nullopt;
}

[[nodiscard]] constexpr bool is_scaat(TrackMethod method) {
  return method <= TrackMethod::joint_models;
}
[[nodiscard]] constexpr bool is_second_run(TrackMethod method) {
  return method == TrackMethod::scaat_autocal_2 || method == TrackMethod::joint_2;
}
[[nodiscard]] constexpr bool learns_beacons(TrackMethod method) {
  return method != TrackMethod::scaat && method != TrackMethod::collinearity10;
}

enum class TrackTuning { moving, still };

/// All that can be tuned of a method.
struct TrackParameters {
  PvModel process;
  DeviceSettings<3> beacons;  ///< m^2
  bool autocalibrate = false;
  WindowShape window{1, false};
  GateSettings gate;
  ManoeuvreSettings manoeuvre{.threshold = 0.6};  ///< of SCAAT's filters
  int renamed_in_a_row = 12;                      ///< RenamingSettings (simulation/hiball_trackers.hpp)
};

/// 002 table 6.8's lateral intensity for all directions, and its least one for turns.
[[nodiscard]] inline PvModel still_process() {
  return PvModel::hiball(4.14e-6, 4.14e-6, Vector3::Constant(5.95e-4));
}

/// The still one of two models at once: velocities that fade in 10 ms, of 1.6 mm/s and 3.9 mrad/s. A model that keeps its
/// velocity, as `still_process` does, would be believed wherever a motion is steady, and be surprised by what comes next.
[[nodiscard]] inline PvModel resting_process() {
  PvModel model = PvModel::hiball(5e-4, 5e-4, Vector3::Constant(3e-3));
  model.decay.setConstant(100.0);
  return model;
}

[[nodiscard]] inline TrackParameters track_parameters(TrackMethod method, TrackTuning tuning = TrackTuning::moving) {
  const auto scaled = [](double scale) {
    return PvModel::hiball(0.14 * scale, 0.17 * scale, Vector3::Constant(1.7 * scale));
  };
  TrackParameters p;
  p.gate.device_probation = 0;
  p.autocalibrate = learns_beacons(method);
  if (p.autocalibrate) p.beacons.initial_variance.setConstant(1e-6);
  double residual_m2 = 0.0;
  switch (method) {
    case TrackMethod::scaat:
      p.process = scaled(0.3);
      p.manoeuvre.threshold = 1.0;
      residual_m2 = 1e-6;
      break;
    case TrackMethod::scaat_autocal:
    case TrackMethod::scaat_autocal_2:
      p.process = scaled(0.8);
      residual_m2 = 1e-8;
      break;
    case TrackMethod::joint:
    case TrackMethod::joint_2:
      p.process = scaled(0.5);
      residual_m2 = 3e-9;
      break;
    case TrackMethod::joint_models:
      p.process = scaled(0.5);
      residual_m2 = 5e-9;
      break;
    case TrackMethod::mcaat3:
      p.process = scaled(1.0);
      p.window.size = 3;
      residual_m2 = 1e-6;
      break;
    case TrackMethod::mcaat10:
      p.process = PvModel::hiball(0.39, 1.15, Vector3(1.1, 0.30, 0.57));
      p.beacons.initial_variance.setConstant(6.5e-7);
      p.window.size = 10;
      residual_m2 = 1.8e-5;
      break;
    case TrackMethod::collinearity10:
      p.window.size = 10;
      break;
  }
  p.beacons.residual_variance.setConstant(residual_m2);
  if (tuning == TrackTuning::still && method != TrackMethod::joint_models) p.process = still_process();
  return p;
}

}  // namespace holdfast

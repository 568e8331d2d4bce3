/// Tuning the methods of the HiBall experiment: what can be tuned of each, and what it costs (002 section E.4).
///
/// Cost: the mean distance of three points before the HiBall (three_point_error.hpp), of all estimates of a run, averaged
/// over runs. A search for the least (calibration/filter_tuning.hpp) wants runs other than those that are reported: what
/// is found suits the motions that it was found on. A filter that says nothing is not charged for by that mean; so the
/// share of a run's sightings that come in a silence of more than `lost_after` windows counts as `lost_cost`, and so does
/// a run whose filter diverges.
///
/// 002's parameter set Pi[N] and ours, by name:
///   lateral, height, turn_x, turn_y, turn_z   mu[lambda], mu[z], mu[phi], mu[theta], mu[psi]: the process noise's
///       spectral density, m^2/s^3 and rad^2/s^3. 002 prints [m/s^2]^2 and [rad/s^2]^2; its eq. 4.8 multiplies them by
///       time alone, as ours does, so numbers are the same
///   residual  what stays of a beacon's variance however often it is seen, m^2 an axis. 002 has none
///   initial   xi_b, a beacon's first variance, m^2 an axis
/// 002 has mu[b] as well, the wander: what a beacon's variance gains, m^2 an axis, added at every sighting (6.1.3). Ours
/// is none, and is not tuned: with any, a HiBall at rest drifts away with its beacons.
/// Bad input: no run costs nothing; a method without a filter has no parameters.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/calibration/tuned_parameter.hpp>
#include <holdfast/registration/track_experiment.hpp>

namespace holdfast {

/// Sightings to tune with; none of it is owned.
struct TrainingRun {
  const HiBallRig* rig = nullptr;
  const Motion* truth = nullptr;
  std::span<const BeaconSighting> stream;
};

inline constexpr double lost_cost = 1.0;  ///< m
inline constexpr long lost_after = 50;    ///< windows, as many as rejections make a gate say so

/// In the order of the list above, starting from a method's settings: intensities within a thousand times. Empty for a
/// method without a filter.
[[nodiscard]] inline std::vector<TunedParameter> tuned_parameters(TrackMethod method, const TrackParameters& start) {
  if (method == TrackMethod::collinearity10) return {};
  std::vector<TunedParameter> list;
  const auto add = [&](const char* name, const char* unit, double value, double lower, double upper) {
    list.push_back({name, unit, std::clamp(value, lower, upper), lower, upper, SearchScale::logarithmic});
  };
  const auto add_intensity = [&](const char* name, const char* unit, double value) {
    add(name, unit, value, 1e-3 * value, 1e3 * value);
  };
  const Vector6& mu = start.process.intensity;
  add_intensity("lateral", "m^2/s^3", mu[0]);
  add_intensity("height", "m^2/s^3", mu[2]);
  add_intensity("turn_x", "rad^2/s^3", mu[3]);
  add_intensity("turn_y", "rad^2/s^3", mu[4]);
  add_intensity("turn_z", "rad^2/s^3", mu[5]);
  add("residual", "m^2", start.beacons.residual_variance[0], 1e-10, 1e-3);
  if (start.autocalibrate) add("initial", "m^2", start.beacons.initial_variance[0], 1e-8, 1e-4);
  return list;
}

/// A method's settings with values of `tuned_parameters`' list.
[[nodiscard]] inline TrackParameters with_tuned(TrackParameters parameters, std::span<const double> values) {
  HOLDFAST_ASSERT(values.size() == (parameters.autocalibrate ? 7U : 6U), "the values of tuned_parameters");
  parameters.process.intensity =
      PvModel::hiball(values[0], values[1], Vector3(values[2], values[3], values[4])).intensity;
  parameters.beacons.residual_variance.setConstant(values[5]);
  if (parameters.autocalibrate) parameters.beacons.initial_variance.setConstant(values[6]);
  return parameters;
}

/// m
[[nodiscard]] inline double tuning_cost(TrackMethod method, const TrackParameters& parameters,
                                        std::span<const TrainingRun> runs) {
  double sum = 0.0;
  for (const TrainingRun& run : runs) {
    long silent = 0, lost = 0;  // sightings in a row without an estimate; all beyond lost_after windows
    const TrackRow row = run_method(method, parameters, *run.rig, *run.truth, run.stream, [&](const TrackMoment& m) {
      silent = m.fresh ? 0 : silent + 1;
      if (silent > lost_after * parameters.window.size) ++lost;
    });
    const double cost = row.three_point.cost();
    const bool tracked = row.updates > 0 && std::isfinite(cost);
    const double lost_share = tracked ? static_cast<double>(lost) / static_cast<double>(row.sightings) : 1.0;
    sum += lost_share * lost_cost + (tracked ? (1.0 - lost_share) * std::min(cost, lost_cost) : 0.0);
  }
  return runs.empty() ? 0.0 : sum / static_cast<double>(runs.size());
}

/// What `swimlab track tune` found for the head recording and handheld/table_04 (docs/calibration.md): values of
/// `tuned_parameters`' list. Kept beside the methods' own settings, not in their place: they cost less, mean distance
/// being all that is asked, but scaat and mcaat3 pay with a covariance far from the truth. Nothing for other methods.
[[nodiscard]] inline std::vector<double> found_values(TrackMethod method) {
  switch (method) {
    case TrackMethod::scaat:
      return {0.202, 0.163, 0.549, 0.514, 0.668, 1.05e-5};
    case TrackMethod::scaat_autocal:
    case TrackMethod::scaat_autocal_2:
      return {0.146, 0.157, 1.08, 1.45, 1.46, 2.3e-8, 8.73e-7};
    case TrackMethod::mcaat3:
      return {0.00923, 0.0132, 0.0303, 0.0111, 0.0239, 9.36e-8, 3.5e-8};
    case TrackMethod::mcaat10:
      return {0.391, 1.15, 1.1, 0.301, 0.574, 1.81e-5, 6.48e-7};
    default:
      return {};
  }
}

/// What 002 tuned for, by the number of its table. 6.5 is of methods that do not learn beacons, 6.6 of those that do.
enum class DissertationCase {
  exact_beacons,  ///< 6.4
  typical,        ///< 6.5, 6.6
  hz_100,         ///< 6.7
  hz_10,          ///< 6.7
  still           ///< 6.8
};

/// The parameters that 002 found for its own methods, in ours' terms. Its motion was another, its rig and noise are ours.
/// mu[b] is taken as a rate, times the time between sightings: as printed, gained with every sighting, it loses the
/// beacons within seconds. Nothing where 002 has no table.
[[nodiscard]] inline std::optional<TrackParameters> dissertation_parameters(
    TrackMethod method, DissertationCase of = DissertationCase::typical) {
  using enum DissertationCase;
  const bool learns = method == TrackMethod::scaat_autocal;
  const double dt = of == still ? 5e-4 : of == hz_100 ? 1e-2 : of == hz_10 ? 1e-1 : 1e-3;  // s, between sightings
  const auto set = [&](double lateral, double height, const Vector3& turns, double wander, double initial) {
    TrackParameters p = track_parameters(method);
    p.beacons.residual_variance.setZero();
    p.gate.probability = 1.0;  // 002 has none, and its R knows nothing of the beacons' errors
    p.manoeuvre = {};          // nor does it have this
    p.process = PvModel::hiball(lateral, height, turns);
    p.beacons.wander.setConstant(dt * wander);
    p.beacons.initial_variance.setConstant(initial);
    return p;
  };
  if (of == typical) {
    if (method == TrackMethod::scaat) return set(1.48e-1, 5.81e-2, Vector3(1.05e1, 1.19e1, 1.34e1), 0.0, 0.0);
    if (learns) return set(3.95e-1, 1.07e-1, Vector3(5.18e-1, 1.14, 5.89e-1), 3.29e-4, 2.41e-6);
    if (method == TrackMethod::mcaat3) return set(4.88e-2, 1.42, Vector3(8.25e-1, 1.24, 4.49e-1), 6.24e-5, 5.83e-9);
    if (method == TrackMethod::mcaat10)
      return set(4.85e-3, 3.29e-3, Vector3(8.41e1, 8.59e-3, 2.14e-2), 1.91e-10, 9.09e-7);
  }
  if (of == exact_beacons && method == TrackMethod::scaat)
    return set(5.05e-1, 1.58e-1, Vector3(6.08e-1, 3.66e-1, 2.04e-1), 0.0, 0.0);
  if (of == hz_100 && learns) return set(3.07e-1, 1.65e-1, Vector3(5.10e-1, 4.20e-1, 3.43e-1), 1.27e-3, 5.94e-6);
  if (of == hz_10 && learns) return set(2.74e-1, 1.46e-1, Vector3(7.64e-1, 6.89e-1, 8.29e-1), 1.53e-10, 9.42e-10);
  if (of == still && learns) return set(4.14e-6, 9.30e-4, Vector3(5.95e-4, 1.63e-1, 7.27e-3), 6.99e-3, 1.91e-7);
  return std::nullopt;
}

}  // namespace holdfast

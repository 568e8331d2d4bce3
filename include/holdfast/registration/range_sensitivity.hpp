/// How far errors of an ultrasonic ranging system put a tracker off: the simulation of 003 section 3, figure 6.
///
/// Each trial draws an installation with its errors (simulation/ultrasonic_range.hpp). At places in the tracked volume, with
/// the tracker turned to several angles, each receiver takes the ranges of all beacons in reach and is placed by least
/// squares (tracking/multilateration.hpp), with the ranges' noise of 1 mm a metre as weights but without noise itself: what is
/// left is systematic. Beside it stand the resolution, by the noise alone (figure 8), and the dilution of precision (eq. 1).
/// 003 is silent on the tracker's angles: here they have any heading and tilt by up to `tilt` about any level axis. Every
/// second trial is colder instead of warmer.
/// Heights are along +Y of W. Random numbers belong to the seed.
/// Preconditions: a beacon and a receiver, counts above zero.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/rigid.hpp>
#include <holdfast/simulation/ultrasonic_range.hpp>
#include <holdfast/tracking/range_dilution.hpp>

namespace holdfast {

struct SensitivitySettings {
  ConstellationRig rig{infinite_constellation(), camera_receivers()};
  double first_x_m = 0.0, last_x_m = 0.5 * two_feet_m;  ///< of the places; z the same
  int places_across = 3;
  double tilt_rad = degrees(20.0).radians();
  int angles = 4, trials = 50;
  std::uint64_t seed = 1;        ///< of the installations
  bool angle_at_beacon = false;  ///< transducers' angle errors at the beacon too, not only at the receiver
};

/// At one height: means over places, angles, trials and receivers.
struct SensitivityRow {
  double height_m = 0.0;
  double error_mm = 0.0;                  ///< systematic error of a receiver's position
  double rms_mm = 0.0;                    ///< the same, root mean square
  double least_mm = 0.0, worst_mm = 0.0;  ///< of all
  double resolution_mm = 0.0;             ///< sqrt(trace P) by the ranges' noise
  double gdop = 0.0, horizontal_dop = 0.0, vertical_dop = 0.0;
  double beacons = 0.0;  ///< in reach
  int positions = 0;
  int lost = 0;  ///< without a position: too few beacons in reach
};

struct UltrasonicErrorSource {
  std::string_view name;
  UltrasonicErrors errors;
};

/// Each source of these errors alone.
[[nodiscard]] inline std::array<UltrasonicErrorSource, 5> each_alone(const UltrasonicErrors& all) {
  std::array<UltrasonicErrorSource, 5> sources{{{"beacon_positions", {}},
                                                {"temperature", {}},
                                                {"beacon_delays", {}},
                                                {"receiver_delays", {}},
                                                {"transducer_angles", {}}}};
  sources[0].errors.beacon_horizontal_m = all.beacon_horizontal_m;
  sources[0].errors.beacon_vertical_m = all.beacon_vertical_m;
  sources[1].errors.temperature_celsius = all.temperature_celsius;
  sources[2].errors.beacon_delay_m = all.beacon_delay_m;
  sources[3].errors.receiver_delay_m = all.receiver_delay_m;
  sources[4].errors.angle_m_per_rad = all.angle_m_per_rad;
  return sources;
}

namespace detail {

class SensitivityRun {
 public:
  SensitivityRun(const SensitivitySettings& settings, double height_m) : settings_(settings) {
    row_.height_m = height_m;
  }

  void trial(const UltrasonicErrors& errors, int number) {
    const UltrasonicDevices devices(settings_.rig, errors, installation(number));
    const int across = settings_.places_across;
    const double step = (settings_.last_x_m - settings_.first_x_m) / std::max(1, across - 1);
    for (int place = 0; place < across * across; ++place) {
      const Vector3 p_W(settings_.first_x_m + step * (place / across), row_.height_m,
                        settings_.first_x_m + step * (place % across));
      for (int n = 0; n < settings_.angles; ++n) {
        const Rigid X_WB(angle(n + settings_.angles * number), p_W);
        for (std::size_t k = 0; k < settings_.rig.receivers.size(); ++k) judge(devices, X_WB, k);
      }
    }
  }

  [[nodiscard]] SensitivityRow means() const {
    SensitivityRow row = row_;
    if (row.positions == 0) return row;
    for (double* sum :
         {&row.error_mm, &row.resolution_mm, &row.gdop, &row.horizontal_dop, &row.vertical_dop, &row.beacons}) {
      *sum /= row.positions;
    }
    row.rms_mm = std::sqrt(row.rms_mm / row.positions);
    return row;
  }

 private:
  /// A thousand of them belong to each seed.
  [[nodiscard]] std::uint64_t installation(int number) const {
    return 1000 * (settings_.seed - 1) + static_cast<std::uint64_t>(number) + 1;
  }
  [[nodiscard]] Quaternion angle(int n) const {
    KeyedNumbers numbers(3, {n});
    const double heading = 2.0 * std::numbers::pi * numbers.uniform();
    const double about = 2.0 * std::numbers::pi * numbers.uniform();
    const double tilt = settings_.tilt_rad * numbers.uniform();
    return Quaternion(Eigen::AngleAxisd(tilt, Vector3(std::cos(about), 0.0, std::sin(about))) *
                      Eigen::AngleAxisd(heading, Vector3::UnitY()));
  }

  void judge(const UltrasonicDevices& devices, const Rigid& X_WB, std::size_t k) {
    const RangeReceiver& receiver = settings_.rig.receivers[k];
    const Vector3 p_W = X_WB * receiver.p_B;
    const Vector3 axis_W = X_WB.q() * receiver.axis_B;
    ranges_.clear();
    anchors_W_.clear();
    for (std::size_t i = 0; i < settings_.rig.beacons.size(); ++i) {
      const CodedBeacon& beacon = settings_.rig.beacons[i];
      const TransducerPair pair(devices.beacons_W[i], beacon.axis_W, p_W, axis_W);
      if (!pair.in_reach()) continue;
      double range_m = devices.measured_m(pair, static_cast<int>(i), static_cast<int>(k));
      if (settings_.angle_at_beacon) range_m += devices.angle_m_per_rad * std::acos(std::min(1.0, pair.cos_beacon));
      ranges_.push_back({beacon.p_W, range_m, range_noise_per_m * pair.distance_m});
      anchors_W_.push_back(beacon.p_W);
    }
    const Multilateration found = multilaterate(ranges_, p_W);
    const std::optional<RangeDilution> dilution = range_dilution(anchors_W_, p_W);
    if (!found.ok() || !dilution) {
      ++row_.lost;
      return;
    }
    add(1000.0 * (found.p_W - p_W).norm(), 1000.0 * std::sqrt(found.covariance.trace()), *dilution);
  }

  void add(double error_mm, double resolution_mm, const RangeDilution& dilution) {
    row_.least_mm = row_.positions == 0 ? error_mm : std::min(row_.least_mm, error_mm);
    row_.worst_mm = std::max(row_.worst_mm, error_mm);
    ++row_.positions;
    row_.error_mm += error_mm;
    row_.rms_mm += error_mm * error_mm;
    row_.resolution_mm += resolution_mm;
    row_.gdop += dilution.geometric();
    row_.horizontal_dop += dilution.across(Vector3::UnitY());
    row_.vertical_dop += dilution.along(Vector3::UnitY());
    row_.beacons += static_cast<double>(ranges_.size());
  }

  const SensitivitySettings& settings_;
  SensitivityRow row_;
  std::vector<WeightedRange> ranges_;
  std::vector<Vector3> anchors_W_;
};

}  // namespace detail

[[nodiscard]] inline SensitivityRow range_sensitivity(const UltrasonicErrors& errors, double height_m,
                                                      const SensitivitySettings& settings = {}) {
  HOLDFAST_ASSERT(settings.trials > 0 && settings.angles > 0 && settings.places_across > 0, "nothing to simulate");
  detail::SensitivityRun run(settings, height_m);
  UltrasonicErrors trial_errors = errors;
  for (int trial = 0; trial < settings.trials; ++trial) {
    run.trial(trial_errors, trial);
    trial_errors.temperature_celsius = -trial_errors.temperature_celsius;
  }
  return run.means();
}

}  // namespace holdfast

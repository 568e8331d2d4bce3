/// Which beacon or camera is wrong? Each device's own residuals, since those of all together look innocent.
///
/// SCAAT takes each measurement from another source and sensor, so what one of them does wrong drowns in the common
/// sequence: biases of many devices together look like noise (002 section 7.3). Here each device, or each pair if you
/// number pairs, has a running mean and mean square of its whitened residuals (Innovation::whitened), which are
/// independent with mean 0 and variance 1 when all is as modelled:
///   biased       the mean is off: a beacon that was moved, a camera that sags
///   inconsistent the mean square is too large: a flickering beacon, one that is often mistaken, a variance set too small
/// The newest `window` residuals count, the older the less: mean += g (residual - mean), g = 1 / n at first, then 1 / window.
/// With V the sum of the squared weights (1 / n at first), |mean|^2 / V is chi-square with Size degrees of freedom, and the
/// sum of squares / V is taken for chi-square with Size / V of them.
/// `false_alarm` is the probability that a look finds anything among all devices while nothing is wrong. Filters in the
/// field are never quite as modelled, so what is smaller than `tolerated_bias` (standard deviations) or `tolerated_spread`
/// (times the variance) is no matter. A residual longer than `clip` standard deviations is shortened to it: one mistaken
/// sighting accuses nobody.
/// Give it what the gate turns away, too, or a device that is wrong is never heard. A bias of one camera moves the pose,
/// most of all for the one that is asked next: ask in random order, with beacons locked, and look at the worst one.
/// 16 bytes a device for residuals of two numbers. Only the constructor allocates.
/// Bad input: residuals that are not finite are not taken; an index outside [0, devices) is the caller's mistake.
#pragma once

#include <cmath>
#include <vector>

#include <holdfast/assert.hpp>
#include <holdfast/geometry/types.hpp>
#include <holdfast/tracking/chi_square.hpp>

namespace holdfast {

struct ResidualMonitorSettings {
  int window = 200;
  int fewest = 5;  ///< residuals before a device is judged
  double false_alarm = 1e-4;
  double tolerated_bias = 1.0;
  double tolerated_spread = 2.0;
  double clip = 5.0;
};

enum class DeviceVerdict { unsuspicious, biased, inconsistent };

template <int Size>
class ResidualMonitor {
 public:
  using Residual = VectorOf<double, Size>;

  /// Precondition: window, fewest and clip are positive, false_alarm is in (0, 1).
  explicit ResidualMonitor(int devices, const ResidualMonitorSettings& settings = {})
      : settings_(settings), records_(static_cast<std::size_t>(devices)) {
    HOLDFAST_ASSERT(settings.window > 0 && settings.fewest > 0 && settings.clip > 0.0, "settings must be positive");
    HOLDFAST_ASSERT(settings.false_alarm > 0.0 && settings.false_alarm < 1.0, "a probability of alarm is in (0, 1)");
  }

  void add(int device, const Residual& whitened) {
    const double length = whitened.norm();
    if (!std::isfinite(length)) return;
    Record& record = this->record(device);
    const double shortened = length > settings_.clip ? settings_.clip / length : 1.0;
    const double gain = record.V > 0.0f ? std::max(record.V / (1.0 + record.V), 1.0 / settings_.window) : 1.0;
    record.mean += (gain * (shortened * whitened - record.mean.template cast<double>())).template cast<float>();
    const double square = shortened * shortened * length * length;
    record.square += static_cast<float>(gain * (square - record.square));
    record.V = static_cast<float>((1.0 - gain) * (1.0 - gain) * record.V + gain * gain);
  }

  [[nodiscard]] int devices() const { return static_cast<int>(records_.size()); }

  /// Mean of the whitened residuals, in standard deviations.
  [[nodiscard]] Residual mean(int device) const { return record(device).mean.template cast<double>(); }
  /// Mean square of their numbers: 1 when all is as modelled.
  [[nodiscard]] double spread(int device) const { return record(device).square / Size; }
  /// How many residuals of equal weight would be as telling; 0 for a device not seen.
  [[nodiscard]] double residuals(int device) const { return record(device).V > 0.0f ? 1.0 / record(device).V : 0.0; }

  /// How unlikely the device's bias would be if it were no larger than what is tolerated; 1 is perfectly likely.
  [[nodiscard]] double bias_probability(int device) const {
    if (residuals(device) < settings_.fewest - 0.5) return 1.0;
    const double excess = std::max(0.0, mean(device).norm() - settings_.tolerated_bias);
    return chi_square_tails(excess * excess / record(device).V, Size).above;
  }
  /// The same of its mean square.
  [[nodiscard]] double spread_probability(int device) const {
    if (residuals(device) < settings_.fewest - 0.5) return 1.0;
    const double degrees = std::round(Size * residuals(device));
    return chi_square_tails(degrees * spread(device) / settings_.tolerated_spread, static_cast<int>(degrees)).above;
  }

  [[nodiscard]] DeviceVerdict verdict(int device) const {
    const double least = settings_.false_alarm / (2.0 * devices());  // two questions to each device
    if (bias_probability(device) < least) return DeviceVerdict::biased;
    return spread_probability(device) < least ? DeviceVerdict::inconsistent : DeviceVerdict::unsuspicious;
  }
  /// Fills `found` with the devices that are not unsuspicious, in rising order.
  void suspects(std::vector<int>& found) const {
    found.clear();
    for (int device = 0; device < devices(); ++device) {
      if (verdict(device) != DeviceVerdict::unsuspicious) found.push_back(device);
    }
  }
  /// The device with the largest mean, in standard deviations, of those with enough residuals; -1 without any.
  [[nodiscard]] int most_biased() const {
    int worst = -1;
    for (int device = 0; device < devices(); ++device) {
      if (residuals(device) < settings_.fewest - 0.5) continue;
      if (worst < 0 || mean(device).norm() > mean(worst).norm()) worst = device;
    }
    return worst;
  }

  /// Forgets a device, as after it was repaired.
  void forget(int device) { record(device) = Record(); }

 private:
  struct Record {
    VectorOf<float, Size> mean = VectorOf<float, Size>::Zero();
    float square = 0.0f;  ///< of the residual's length
    float V = 0.0f;       ///< sum of the squared weights; 0 before the first
  };
  static_assert(sizeof(Record) == 4 * (Size + 2));

  [[nodiscard]] const Record& record(int device) const {
    HOLDFAST_ASSERT(device >= 0 && device < devices(), "no such device");
    return records_[static_cast<std::size_t>(device)];
  }
  [[nodiscard]] Record& record(int device) {
    HOLDFAST_ASSERT(device >= 0 && device < devices(), "no such device");
    return records_[static_cast<std::size_t>(device)];
  }

  ResidualMonitorSettings settings_;
  std::vector<Record> records_;
};

}  // namespace holdfast

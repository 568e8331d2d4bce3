/// Tracks a body by ranges, one at a time, and inertial sensors; with and without states for the anchors' biases, with and
/// without a gate (000 section 3.1.1; 002 section 4.4; what 002 section 7.3 asks for).
///
/// The filter is SCAAT's with accelerations (PVA). Each gyro and accelerometer sample corrects it, and each range; an
/// anchor's bias (a late first path, cables, clocks) is the parameter of its device filter. Without bias states all biases
/// are taken for zero, without doubt. The gate is that of every filter (innovation_gate.hpp), but the ranges have one of
/// their own: inertial samples are always taken, and between two ranges there are so many of them that in a common gate
/// rejected ranges would never be rejections in a row.
/// Bad input: what the filter refuses is counted. Preconditions: times do not decrease, indices of anchors exist, the
/// process model and the gate's settings have no problem.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include <holdfast/registration/range_recording.hpp>
#include <holdfast/registration/range_types.hpp>
#include <holdfast/tracking/inertial_measurement.hpp>
#include <holdfast/tracking/range.hpp>
#include <holdfast/tracking/scaat_filter.hpp>

namespace holdfast {

/// What the four variants share. docs/tracking.md tells how the numbers were chosen, and what others give.
struct RangeSettings {
  Vector3 antenna_B = Vector3::Zero();  ///< m
  Vector3 up_W = Vector3::UnitZ();      ///< unit length
  PvaModel process = [] {
    PvaModel model;
    model.intensity << Vector3::Constant(10.0), Vector3::Constant(100.0);
    return model;
  }();
  double range_sigma_m = 0.1;
  double rate_sigma = 0.1;         ///< of a gyro sample, rad/s: vibration, not the sensor
  double force_sigma = 1.0;        ///< of an accelerometer sample, m/s^2: the same
  double rate_bias_sigma = 0.005;  ///< of the gyro's bias before the first sample, rad/s
  double force_bias_sigma = 0.2;   ///< m/s^2
  double bias_sigma_m = 0.5;       ///< of an anchor's bias before its first range
  double bias_wander_m2 = 3e-6;    ///< gained by its variance with each range
  GateSettings gate;
  double start_m = 0.01, start_rad = 0.03;
  double start_velocity = 0.1;  ///< of a rest that is assumed, m/s and rad/s
};

class RangeTracker {
 public:
  RangeTracker(const TargetState<3>& start, std::span<const RangeAnchor> anchors, const RangeVariant& variant,
               const RangeSettings& settings)
      : settings_(settings),
        variant_(variant),
        filter_(start, settings.process, ungated()),
        gate_(settings.gate),
        biases_(bias_settings(variant, settings)) {
    for (const RangeAnchor& anchor : anchors) {
      DeviceEstimate<3> surveyed;
      surveyed.x = anchor.p_W;
      surveyed.locked = true;
      anchors_.push_back(surveyed);
      biases_.add(DeviceParameters<1>(DeviceParameters<1>::Zero()));
    }
    biases_.lock_all(!variant.bias_states);
    rate_bias_.P.diagonal().setConstant(square(settings.rate_bias_sigma));
    force_bias_.P.diagonal().setConstant(square(settings.force_bias_sigma));
  }

  void add(const InertialReading& reading) {
    AngularRate rate;
    rate.rate_S = reading.rate_B;
    rate.variance = square(settings_.rate_sigma);
    SpecificForce force;
    force.force_S = reading.force_B;
    force.gravity_W = -standard_gravity * settings_.up_W;
    force.variance = square(settings_.force_sigma);
    filter_.update(reading.t, rate, {}, rate_bias_);
    filter_.update(reading.t, force, {}, force_bias_);
  }

  UpdateStatus add(const RangeReading& reading) {
    RangeWithBias measurement;
    measurement.range = {reading.range_m, settings_.antenna_B, square(settings_.range_sigma_m)};
    const int index = static_cast<int>(reading.anchor);
    DeviceEstimate<3>& anchor = anchors_[reading.anchor];
    nis_ = std::nan("");
    TargetState<3> then = state();
    if (reading.t >= then.t && advance(then, settings_.process, reading.t)) {
      const auto innovation = extended_innovation(then, measurement, anchor, biases_.for_sighting(index));
      if (innovation) nis_ = innovation->nis();
      if (innovation && variant_.gate) {
        const GateVerdict verdict = gate_.judge(nis_, 1, &biases_.record(index).probation);
        if (verdict == GateVerdict::rejected) return UpdateStatus::gated;
        if (verdict == GateVerdict::on_probation) return UpdateStatus::on_probation;
      }
    }
    return filter_.update(reading.t, measurement, anchor, {biases_, index});
  }

  [[nodiscard]] const TargetState<3>& state() const { return filter_.state(); }
  [[nodiscard]] const DeviceTable<1>& biases() const { return biases_; }
  [[nodiscard]] const UpdateCounters& counters() const { return filter_.counters(); }
  /// Of the last range; not a number if there was no innovation.
  [[nodiscard]] double nis() const { return nis_; }

 private:
  [[nodiscard]] static double square(double x) { return x * x; }

  [[nodiscard]] static ScaatSettings ungated() {
    ScaatSettings settings;
    settings.gate.probability = 1.0;
    settings.longest_gap = Duration::max();
    return settings;
  }
  [[nodiscard]] static DeviceSettings<1> bias_settings(const RangeVariant& variant, const RangeSettings& settings) {
    DeviceSettings<1> devices;
    if (!variant.bias_states) return devices;
    devices.initial_variance[0] = square(settings.bias_sigma_m);
    devices.wander[0] = settings.bias_wander_m2;
    return devices;
  }

  RangeSettings settings_;
  RangeVariant variant_;
  ScaatFilter<3> filter_;
  InnovationGate gate_;
  std::vector<DeviceEstimate<3>> anchors_;
  DeviceTable<1> biases_;
  DeviceEstimate<3> rate_bias_, force_bias_;
  double nis_ = 0.0;
};

}  // namespace holdfast

// Sightings of a head that turns below 400 beacons, and the bare SCAAT update on them: for the benchmark scaat_update.cpp, and for
// counting instructions (scaat_updates.cpp).
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/scaat_filter.hpp>

namespace holdfast::benchmarks {

inline constexpr int round_length = 4096;  // of sightings, 1 ms apart; then the motion begins anew

// A head that turns by 20 degrees a second in the mean, below 400 beacons.
inline Rigid truth(int i) {
  const double a = 2.0 * 3.14159265358979 * i / round_length;
  return Rigid(so3::exp<double>(Vector3(0.10 * std::sin(a), 0.20 * std::sin(2.0 * a), 0.10 * std::cos(a))),
               Vector3(0.10 * std::sin(a), 0.08 * std::cos(a), 0.05 * std::sin(2.0 * a)));
}

struct Setting {
  CameraView camera{view_matrix(Rigid(), 0.037)};
  std::vector<Vector3> beacons_W;
  std::vector<CameraSighting> sightings;
  std::vector<int> seen;

  Setting() {
    std::mt19937 random(8);
    std::normal_distribution<double> noise(0.0, 3e-6);
    for (int i = 0; i < 400; ++i) beacons_W.emplace_back(0.15 * (i % 20) - 1.5, 0.15 * (i / 20) - 1.5, -2.7);
    for (int i = 0; i < round_length; ++i) {
      const int beacon = static_cast<int>(random() % 400);
      const auto uv = camera.project(truth(i).inverse() * beacons_W[static_cast<std::size_t>(beacon)]);
      sightings.push_back({*uv + Vector2(noise(random), noise(random)), &camera, 9e-12});
      seen.push_back(beacon);
    }
  }
  [[nodiscard]] DeviceTable<3> table() const {
    DeviceSettings<3> settings;
    settings.initial_variance.setConstant(1e-6);
    settings.wander.setConstant(2.8e-10);
    DeviceTable<3> devices(settings);
    std::mt19937 random(9);
    std::normal_distribution<double> off(0.0, 1e-3);
    for (const Vector3& p_W : beacons_W) devices.add(p_W + Vector3(off(random), off(random), off(random)));
    return devices;
  }
  [[nodiscard]] std::vector<DeviceEstimate<3>> estimates() const {
    const DeviceTable<3> devices = table();
    std::vector<DeviceEstimate<3>> copies;
    for (int i = 0; i < devices.size(); ++i) copies.push_back(devices.at(i));
    return copies;
  }
  [[nodiscard]] static TargetState<2> start() {
    TargetState<2> state;
    state.X_WB = truth(0);
    state.P *= 1e-6;
    state.P.bottomRightCorner<6, 6>() = 0.1 * Matrix6::Identity();
    return state;
  }
  [[nodiscard]] static PvModel model() { return PvModel::hiball(0.14, 0.17, Vector3::Constant(1.7)); }
};

inline const Setting& setting() {
  static const Setting instance;
  return instance;
}

// The update itself: time, innovation, correction of state and beacon.
class Scaat {
 public:
  void update() {
    const std::size_t k = static_cast<std::size_t>(i_++ % round_length);
    DeviceEstimate<3>& beacon = beacons_[static_cast<std::size_t>(setting().seen[k])];
    if (!beacon.locked) beacon.P.diagonal() += wander_;
    TargetState<2>& next = states_[i_ % 2];
    NoDevice none;
    if (!detail::advance_lower(states_[1 - i_ % 2], model_, HostTime(std::chrono::milliseconds(i_)), next)) return;
    const auto innovation = extended_innovation(next, setting().sightings[k], beacon);
    if (innovation && correct(next, *innovation, beacon, none)) ++updated_;
  }
  [[nodiscard]] const TargetState<2>& state() const { return states_[i_ % 2]; }
  [[nodiscard]] std::uint64_t updated() const { return updated_; }

 private:
  std::vector<DeviceEstimate<3>> beacons_ = setting().estimates();
  Vector3 wander_ = setting().table().settings().wander;
  TargetState<2> states_[2] = {Setting::start(), Setting::start()};
  PvModel model_ = Setting::model();
  std::int64_t i_ = 0;
  std::uint64_t updated_ = 0;
};

/// Just that: what is counted.
template <typename Filter>
int only_update(int count) {
  Filter filter;
  for (int i = 0; i < count; ++i) filter.update();
  return filter.state().is_finite() ? 0 : 1;
}

}  // namespace holdfast::benchmarks

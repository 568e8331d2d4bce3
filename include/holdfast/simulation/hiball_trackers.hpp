/// The trackers that a HiBall's sightings can be given to, all with one face: SCAAT's filters, MCAAT, Collinearity.
///
/// A tracker takes sightings in the order of time, each with the variance that it claims, and knows the cameras and a
/// table of beacons, which it may learn (002 section 4.4) and which outlives it: a second run goes on with it, 002's dagger.
/// SCAAT's also find themselves anew: while it has no pose, or when its gate says that it is lost, or after
/// `ReacquisitionSettings::longest_gap` without sightings, it collects the newest sightings, searches the pose that most
/// of them agree with (acquisition.hpp), and starts from there.
/// And they find the right name of a sighting that their gate turned away: that of the beacon whose image is there
/// (nearest_beacon.hpp), when the gate accepts it as such. But a filter that is off by a period of the ceiling would find a
/// name for everything. So after `RenamingSettings::in_a_row` of them, with none that was named rightly between, it is the
/// pose that is searched for; and once the gate widens nothing is renamed.
/// Bad input: preconditions are that cameras and beacons exist (assert). Sightings back in time are ignored.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/simulation/hiball_sightings.hpp>
#include <holdfast/simulation/hiball_tracker.hpp>
#include <holdfast/simulation/nearest_beacon.hpp>
#include <holdfast/tracking/acquisition.hpp>
#include <holdfast/tracking/collinearity.hpp>
#include <holdfast/tracking/joint_filter.hpp>
#include <holdfast/tracking/mcaat_filter.hpp>
#include <holdfast/tracking/measurement_ordering.hpp>
#include <holdfast/tracking/scaat_filter.hpp>

namespace holdfast {

/// The beacons at their designed places. `autocalibrate` false locks them: they are not learnt.
[[nodiscard]] inline DeviceTable<3> beacon_table(const HiBallRig& rig, const DeviceSettings<3>& settings,
                                                 bool autocalibrate) {
  DeviceTable<3> table(settings);
  table.reserve(static_cast<int>(rig.nominal_beacons_W.size()));
  for (const Vector3& beacon_W : rig.nominal_beacons_W) table.add(beacon_W);
  if (!autocalibrate) table.lock_all();
  return table;
}

[[nodiscard]] inline CameraSighting camera_sighting(const HiBallRig& rig, const BeaconSighting& sighting) {
  return {sighting.uv, &rig.cameras[static_cast<std::size_t>(sighting.camera)].view, sighting.variance};
}

struct ReacquisitionSettings {
  int sightings = 12;                                     ///< that a search is made from; at most 64
  Duration longest_gap = std::chrono::milliseconds(250);  ///< without an update, after which the pose is searched for
  double velocity = 0.5;                                  ///< standard deviation afterwards, m/s an axis
  double angular_velocity = 1.0;                          ///< the same, rad/s
  AcquisitionSettings search{.tolerance_rad = 0.03};      ///< covers a turn of 150 deg/s in 12 ms
};

struct RenamingSettings {
  int in_a_row = 12;  ///< 0: a sighting's name is never doubted
  NearestBeaconSettings nearest{};
};

/// Of one sighting at a time, by a filter that has ScaatFilter's face.
template <typename Filter>
class SearchingTracker : public HiBallTracker {
 public:
  /// Starts from a state. `rig` and `beacons` are not owned. `model`: what the filter takes.
  template <typename Model>
  SearchingTracker(const HiBallRig& rig, DeviceTable<3>& beacons, const TargetState<2>& start, const Model& model,
                   const ScaatSettings& settings = {}, const ReacquisitionSettings& again = {},
                   const RenamingSettings& renaming = {})
      : rig_(&rig),
        beacons_(&beacons),
        filter_(start, model, settings),
        again_(again),
        renaming_(renaming),
        tracking_(true) {}
  /// Knows nothing, and searches.
  template <typename Model>
  SearchingTracker(const HiBallRig& rig, DeviceTable<3>& beacons, const Model& model,
                   const ScaatSettings& settings = {}, const ReacquisitionSettings& again = {},
                   const RenamingSettings& renaming = {})
      : rig_(&rig),
        beacons_(&beacons),
        filter_({}, model, settings),
        again_(again),
        renaming_(renaming),
        tracking_(false) {}

  bool add(const BeaconSighting& sighting) override {
    turned_away_ = false;
    renamed_.reset();
    nis_.reset();
    remember(sighting);
    if (tracking_ && (filter_.gate().lost() || sighting.t - filter_.state().t > again_.longest_gap)) tracking_ = false;
    if (!tracking_) return search(sighting.t);
    const UpdateStatus status = update(sighting, sighting.beacon);
    turned_away_ = status == UpdateStatus::gated || status == UpdateStatus::on_probation;
    if (turned_away_ || status == UpdateStatus::updated) nis_ = filter_.nis();
    if (status == UpdateStatus::updated) renamed_in_a_row_ = 0;
    if (status == UpdateStatus::gated) renamed_ = update_renamed(sighting);
    return status == UpdateStatus::updated || renamed_.has_value();
  }
  [[nodiscard]] const Rigid& X_WB() const override { return filter_.state().X_WB; }
  [[nodiscard]] const TargetState<2>* state() const override { return &filter_.state(); }
  [[nodiscard]] std::optional<double> nis() const override { return nis_; }
  [[nodiscard]] bool turned_away() const override { return turned_away_; }
  [[nodiscard]] std::optional<int> renamed() const override { return renamed_; }
  [[nodiscard]] std::optional<double> expected_reduction(const BeaconSighting& sighting,
                                                         const Matrix6& weight) override {
    if (!tracking_) return std::nullopt;
    const auto expected =
        filter_.expectation(sighting.t, camera_sighting(*rig_, sighting), {*beacons_, sighting.beacon});
    if (!expected) return std::nullopt;
    return holdfast::expected_reduction(*expected, weight);
  }
  void settle() override {
    if constexpr (requires { filter_.settle(); }) filter_.settle();
  }

  [[nodiscard]] bool tracking() const { return tracking_; }
  [[nodiscard]] int searches() const { return searches_; }
  [[nodiscard]] const Filter& filter() const { return filter_; }

 private:
  /// The newest sightings, oldest first, none older than the gap that ends tracking.
  void remember(const BeaconSighting& sighting) {
    if (!recent_.empty() && sighting.t - recent_.back().t > again_.longest_gap) recent_.clear();
    if (static_cast<int>(recent_.size()) == again_.sightings) recent_.erase(recent_.begin());
    recent_.push_back(sighting);
  }

  UpdateStatus update(const BeaconSighting& sighting, int beacon) {
    return filter_.update(sighting.t, camera_sighting(*rig_, sighting), {*beacons_, beacon});
  }

  /// Of a sighting that was gated: the other name under which it is an update.
  std::optional<int> update_renamed(const BeaconSighting& sighting) {
    if (renaming_.in_a_row == 0 || filter_.gate().window() > 1.0) return std::nullopt;
    const TargetState<2>& state = filter_.state();
    const double dt = to_seconds(sighting.t - state.t);
    const Rigid X_WB(state.X_WB.q() * so3::exp<double>(dt * state.velocity.w_WB_B),
                     state.X_WB.p() + dt * state.velocity.v_WB);
    const auto beacon = nearest_beacon(*rig_, *beacons_, X_WB, sighting.camera, sighting.uv, renaming_.nearest);
    if (!beacon || *beacon == sighting.beacon) return std::nullopt;
    if (update(sighting, *beacon) != UpdateStatus::updated) return std::nullopt;
    if (++renamed_in_a_row_ == renaming_.in_a_row) tracking_ = false;
    return beacon;
  }

  bool search(HostTime t) {
    if (static_cast<int>(recent_.size()) < again_.sightings) return false;
    ++searches_;
    settle();
    std::vector<const CameraView*> cameras(recent_.size());
    std::vector<UnplacedSighting> unplaced(recent_.size());
    for (std::size_t i = 0; i < recent_.size(); ++i) {
      const BeaconSighting& s = recent_[i];
      const DeviceEstimate<3> beacon = beacons_->at(s.beacon);
      cameras[i] = &rig_->cameras[static_cast<std::size_t>(s.camera)].view;
      unplaced[i] = {s.uv, std::span(&cameras[i], 1), s.variance, beacon.x,
                     (beacon.P.trace() + beacon.residual_variance.sum()) / 3.0};
    }
    const Acquisition found = acquire(unplaced, again_.search);
    if (!found.ok()) return false;
    TargetState<2> start;
    start.t = t;
    start.X_WB = found.X_WB;
    start.P.setZero();
    start.P.topLeftCorner<6, 6>() = found.covariance;
    // The pose found is one of the window's middle: until its end the body has moved on.
    const double half_window_s = 0.5 * to_seconds(t - recent_.front().t);
    start.P.diagonal().head<3>().array() += std::pow(again_.velocity * half_window_s, 2);
    start.P.diagonal().segment<3>(3).array() += std::pow(again_.angular_velocity * half_window_s, 2);
    start.P.diagonal().segment<3>(6).setConstant(again_.velocity * again_.velocity);
    start.P.diagonal().segment<3>(9).setConstant(again_.angular_velocity * again_.angular_velocity);
    filter_.restart(start);
    renamed_in_a_row_ = 0;
    tracking_ = true;
    return true;
  }

  const HiBallRig* rig_;
  DeviceTable<3>* beacons_;
  Filter filter_;
  ReacquisitionSettings again_;
  RenamingSettings renaming_;
  bool tracking_;
  bool turned_away_ = false;
  std::optional<int> renamed_;
  int renamed_in_a_row_ = 0;
  int searches_ = 0;
  std::optional<double> nis_;
  std::vector<BeaconSighting> recent_;
};

using ScaatTracker = SearchingTracker<ScaatFilter<2>>;
/// A HiBall's six views have some 20 to 80 LEDs in sight. With 12 places the filter is too sure on hand-held motions, with 36
/// it is not (docs/tracking.md); cost goes with the square.
inline constexpr int joint_beacons = 36;
using JointTracker = SearchingTracker<JointFilter<2, 3, joint_beacons>>;
/// Two process models at once.
using JointModelsTracker = SearchingTracker<JointFilter<2, 3, joint_beacons, 2>>;

/// N sightings in one update, after every Nth.
class McaatTracker : public HiBallTracker {
 public:
  McaatTracker(const HiBallRig& rig, DeviceTable<3>& beacons, const TargetState<2>& start, const PvModel& model,
               const WindowShape& window)
      : rig_(&rig), beacons_(&beacons), filter_(start, model, window) {}

  bool add(const BeaconSighting& sighting) override {
    const McaatStatus status = filter_.add(sighting.t, camera_sighting(*rig_, sighting), sighting.beacon, *beacons_);
    beacons_->count_sighting(sighting.beacon, sighting.t);
    return status == McaatStatus::updated;
  }
  [[nodiscard]] const Rigid& X_WB() const override { return filter_.state().X_WB; }
  [[nodiscard]] const TargetState<2>* state() const override { return &filter_.state(); }

 private:
  const HiBallRig* rig_;
  DeviceTable<3>* beacons_;
  McaatFilter<2, CameraSighting> filter_;
};

/// N sightings resected, after every Nth.
class ResectionTracker : public HiBallTracker {
 public:
  ResectionTracker(const HiBallRig& rig, const DeviceTable<3>& beacons, const Rigid& start, const WindowShape& window)
      : rig_(&rig), beacons_(&beacons), tracker_(start, window) {}

  bool add(const BeaconSighting& sighting) override {
    const std::optional<Resection> found =
        tracker_.add({camera_sighting(*rig_, sighting), beacons_->at(sighting.beacon).x, 0.0});
    return found && found->ok();
  }
  [[nodiscard]] const Rigid& X_WB() const override { return tracker_.X_WB(); }
  [[nodiscard]] const TargetState<2>* state() const override { return nullptr; }

 private:
  const HiBallRig* rig_;
  const DeviceTable<3>* beacons_;
  CollinearityTracker tracker_;
};

}  // namespace holdfast

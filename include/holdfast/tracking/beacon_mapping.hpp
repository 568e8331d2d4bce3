/// Auto-mapping: a tracker that knows three beacons finds where all others hang, while its wearer walks about (003 section 5).
///
///     BeaconMapper mapper(seeds, receivers, start);          // start: an acquired pose (range_acquisition.hpp)
///     mapper.add(reading);                                   // inertial, as they come
///     mapper.add(t, CodedRange{receiver, code, range});      // of known and of unknown codes
///     mapper.beacons();                                      // seeds, and what was found
/// The seed fixes the frame of reference and is not corrected. Ranges of an unknown code gather with where their receiver was;
/// once they place the beacon (beacon_candidate.hpp) it is installed, at twice the deviation that they state. From then on it
/// helps to track, and each of its ranges refines it: the inertial navigator's error (strapdown_covariance.hpp) and all beacons
/// found have one covariance, which knows what their errors have to do with each other (simultaneous localisation and
/// mapping, Smith, Self and Cheeseman 1990; joint_state.hpp is the same for process models). So the first beacons carry the
/// tracker to where the next ones are, and the covariance says what that cost.
/// Ranges that do not fit (echoes, early pulses) are gated. Lost (`gate().lost()`), it places nothing more: begin anew.
/// Systematic errors do not average out, so they are states too, as large as 003's table 1 lets expect, and are found along
/// with the beacons (what a range has more than its distance d):
///   d scale + angle angle_receiver + delay_beacon + delay_receiver
/// with the scale for a wrong temperature. Without them the mapper would be many times surer than right.
/// Noises and the unit's place are those of range_aided_ins.hpp; sensor faults are its business: map with a unit that works.
/// Preconditions: a code is one beacon here: map a large building room by room; times do not decrease; `problem` says nothing.
/// Bad input: a MappingStatus.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <holdfast/tracking/beacon_candidate.hpp>
#include <holdfast/tracking/coded_range.hpp>
#include <holdfast/tracking/innovation_gate.hpp>
#include <holdfast/tracking/range.hpp>
#include <holdfast/tracking/range_aided_settings.hpp>
#include <holdfast/tracking/strapdown_covariance.hpp>

namespace holdfast {

struct BeaconMappingSettings {
  RangeAidedInsSettings ins = [] {
    RangeAidedInsSettings known_systematics;
    known_systematics.systematic_m = 0.3e-3;
    return known_systematics;
  }();
  // Standard deviations of what is found out about the ranging system.
  double scale = 3.5e-4;            ///< 0.2 degrees Celsius
  double angle_m_per_rad = 2.5e-3;  ///< a range's gain by the angle off the receiver's axis
  double beacon_delay_m = 0.6e-3, receiver_delay_m = 0.6e-3;
  BeaconPlacingSettings placing;
};

/// Where mapping begins.
struct MappingStart {
  HostTime t;
  Rigid X_WB;
  double position_m = 0.01, orientation_rad = 0.02;  ///< deviations per axis
};

enum class MappingStatus {
  used,        ///< it corrected pose and beacon
  gathered,    ///< of a beacon that is not placed yet
  installed,   ///< it was the last that was wanting: its beacon is placed now
  gated,       ///< too unlikely
  refused,     ///< earlier than what is already in, or later than the readings by more than 0.1 s
  bad_reading  ///< no such receiver, or a range that is not above zero
};

/// A beacon as the mapper knows it.
struct MappedBeacon {
  int code = 0;
  bool seed = false;
  Vector3 p_W = Vector3::Zero();
  Matrix3 covariance = Matrix3::Zero();
  double delay_m = 0.0;
  int ranges = 0;  ///< that refined it
};

class BeaconMapper {
 public:
  /// What is wrong with seeds or receivers; nothing when they can be used.
  [[nodiscard]] static std::optional<std::string_view> problem(std::span<const CodedBeacon> seeds,
                                                               std::span<const RangeReceiver> receivers) {
    if (seeds.size() < 3) return "fewer than three seed beacons";
    if (receivers.empty()) return "no receiver";
    double area = 0.0;
    for (const CodedBeacon& a : seeds) {
      if (!a.p_W.allFinite()) return "a seed beacon's position is not finite";
      for (const CodedBeacon& b : seeds) {
        if (&a != &b && a.code == b.code) return "two seed beacons have one code";
        area = std::max(area, (a.p_W - seeds[0].p_W).cross(b.p_W - seeds[0].p_W).norm());
      }
    }
    if (!(area > 1e-3)) return "all seed beacons hang in one line";
    for (const RangeReceiver& r : receivers) {
      if (!r.p_B.allFinite()) return "a receiver's position is not finite";
    }
    return std::nullopt;
  }

  BeaconMapper(std::span<const CodedBeacon> seeds, std::span<const RangeReceiver> receivers, const MappingStart& start,
               const BeaconMappingSettings& settings = {})
      : settings_(settings),
        gate_(settings.ins.gate),
        receivers_(receivers.begin(), receivers.end()),
        seeds_(seeds.size()) {
    HOLDFAST_ASSERT(!problem(seeds, receivers), "bad seeds or receivers");
    HOLDFAST_ASSERT(start.X_WB.is_finite() && start.position_m > 0.0 && start.orientation_rad > 0.0, "no start");
    const RangeAidedInsSettings& ins = settings.ins;
    state_.t = start.t;
    state_.X_WS = Rigid(start.X_WB.q(), start.X_WB * ins.unit_B);
    state_.gravity_W = ins.gravity_W;
    state_.lever_B = ins.unit_B;
    systematic_ = Eigen::VectorXd::Zero(receiver_delays + static_cast<Eigen::Index>(receivers.size()));
    P_.setZero(strapdown_error_size + systematic_.size(), strapdown_error_size + systematic_.size());
    const auto deviation = [&](int begin, double sigma) { P_.diagonal().segment(begin, 3).setConstant(sigma * sigma); };
    deviation(InertialState::place, start.position_m + start.orientation_rad * ins.unit_B.norm());
    deviation(InertialState::turn, start.orientation_rad);
    deviation(InertialState::velocity, ins.speed_m_s);
    deviation(InertialState::rate_bias, ins.rate_bias);
    deviation(InertialState::force_bias, ins.force_bias);
    for (Eigen::Index i = 0; i < systematic_.size(); ++i) {
      const double sigma = i == 0 ? settings.scale : i == 1 ? settings.angle_m_per_rad : settings.receiver_delay_m;
      P_(strapdown_error_size + i, strapdown_error_size + i) = sigma * sigma;
    }
    for (const CodedBeacon& seed : seeds) add_beacon(seed.code, seed.p_W, Matrix3::Zero());
  }

  /// False when the reading is not later than the newest, or not finite.
  bool add(const InertialReading& reading) {
    if (!reading.rate_B.allFinite() || !reading.force_B.allFinite() || !history_.push(reading)) return false;
    if (to_seconds(reading.t - state_.t) > 0.2) carry(reading.t);  // without ranges: the history is short
    return true;
  }

  MappingStatus add(HostTime t, const CodedRange& range) {
    const bool exists = range.receiver >= 0 && static_cast<std::size_t>(range.receiver) < receivers_.size();
    if (!exists || !std::isfinite(range.range_m) || !(range.range_m > nearest_sighting_m)) {
      return MappingStatus::bad_reading;
    }
    if (!carry(t)) return MappingStatus::refused;
    const auto known =
        std::find_if(beacons_.begin(), beacons_.end(), [&](const Known& b) { return b.code == range.code; });
    if (known == beacons_.end()) return gather(range);
    return refine(range, static_cast<std::size_t>(known - beacons_.begin()));
  }

  /// At the newest range.
  [[nodiscard]] const InertialState& state() const { return state_; }
  [[nodiscard]] const InnovationGate& gate() const { return gate_; }
  /// Seeds first, then as they were installed.
  [[nodiscard]] std::vector<MappedBeacon> beacons() const {
    std::vector<MappedBeacon> beacons;
    for (std::size_t i = 0; i < beacons_.size(); ++i) {
      const Known& known = beacons_[i];
      beacons.push_back(
          {known.code, i < seeds_, known.p_W, P_.block<3, 3>(place_of(i), place_of(i)), known.delay_m, known.ranges});
    }
    return beacons;
  }
  [[nodiscard]] int installed() const { return static_cast<int>(beacons_.size() - seeds_); }
  /// What is found of the speed of sound: true ranges are shorter than measured ones by this share.
  [[nodiscard]] double scale() const { return systematic_[0]; }
  [[nodiscard]] double angle_m_per_rad() const { return systematic_[1]; }
  [[nodiscard]] double receiver_delay_m(int receiver) const { return systematic_[receiver_delays + receiver]; }
  /// Codes that were heard and have no beacon yet.
  [[nodiscard]] int unplaced() const { return static_cast<int>(candidates_.size()); }

 private:
  struct Known {
    int code = 0;
    Vector3 p_W = Vector3::Zero();
    double delay_m = 0.0;
    int ranges = 0;
    std::vector<HostTime> heard;  ///< by receiver, when last
  };
  /// Of systematic_, which follows the navigator's error in P; then come four numbers of each beacon, place and delay.
  static constexpr Eigen::Index receiver_delays = 2, beacon_size = 4;

  void add_beacon(int code, const Vector3& p_W, const Matrix3& P) {
    beacons_.push_back({code, p_W, 0.0, 0, std::vector<HostTime>(receivers_.size(), HostTime::min())});
    const Eigen::Index before = P_.cols();
    P_.conservativeResize(before + beacon_size, before + beacon_size);
    P_.rightCols<beacon_size>().setZero();
    P_.bottomRows<beacon_size>().setZero();
    P_.block<3, 3>(before, before) = P;
    P_(before + 3, before + 3) = settings_.beacon_delay_m * settings_.beacon_delay_m;
  }
  /// In P.
  [[nodiscard]] Eigen::Index place_of(std::size_t beacon) const {
    return strapdown_error_size + systematic_.size() + beacon_size * static_cast<Eigen::Index>(beacon);
  }
  [[nodiscard]] double noise_variance(double range_m) const {
    const double by_length = settings_.ins.range_noise_per_m * range_m;
    return settings_.ins.range_noise_m * settings_.ins.range_noise_m + by_length * by_length;
  }
  [[nodiscard]] TargetState<1> pose() const {
    TargetState<1> pose;
    pose.X_WB = state_.X_WS;
    return pose;
  }
  /// From the unit.
  [[nodiscard]] Vector3 receiver_S(int receiver) const {
    return receivers_[static_cast<std::size_t>(receiver)].p_B - settings_.ins.unit_B;
  }

  /// The navigator goes on to t, and what its error has to do with the beacons' with it.
  bool carry(HostTime t) {
    if (t < state_.t || history_.empty()) return false;
    if (t > history_.newest().t + std::chrono::milliseconds(100)) return false;
    const RangeAidedInsSettings& ins = settings_.ins;
    const StrapdownIncrement step = history_.integrate(state_.t, t, state_.bias, Vector3::Zero());
    const Matrix3 R = state_.X_WS.R();
    const Eigen::Index beacons = P_.cols() - strapdown_error_size;
    StrapdownCovariance P = P_.topLeftCorner<strapdown_error_size, strapdown_error_size>();
    carry_covariance(P, step, R);
    add_noise(P, step.seconds, R,
              {Vector3::Constant(ins.rate_noise), Vector3::Constant(ins.force_noise),
               Vector3::Constant(ins.rate_bias_walk), Vector3::Constant(ins.force_bias_walk)});
    P_.topLeftCorner<strapdown_error_size, strapdown_error_size>() = P;
    const Eigen::MatrixXd cross = strapdown_transition(step, R) * P_.topRightCorner(strapdown_error_size, beacons);
    P_.topRightCorner(strapdown_error_size, beacons) = cross;
    P_.bottomLeftCorner(beacons, strapdown_error_size) = cross.transpose();
    state_.move(step);
    state_.t = t;
    return true;
  }

  MappingStatus refine(const CodedRange& range, std::size_t i) {
    Known& beacon = beacons_[i];
    Linearization<Range> linear;
    const Range measured{range.range_m, receiver_S(range.receiver), noise_variance(range.range_m)};
    if (!measured.linearize(pose(), beacon.p_W, {}, linear)) return MappingStatus::refused;
    Eigen::VectorXd of_systematic = Eigen::VectorXd::Zero(systematic_.size());
    of_systematic[0] = range.range_m - linear.residual[0];
    of_systematic[1] = off_axis(range.receiver, beacon.p_W);
    of_systematic[receiver_delays + range.receiver] = 1.0;
    Eigen::VectorXd h = Eigen::VectorXd::Zero(P_.cols());
    h.head<6>() = linear.H.transpose();
    h.segment(strapdown_error_size, systematic_.size()) = of_systematic;
    h.segment<3>(place_of(i)) = linear.H_source.transpose();
    h[place_of(i) + 3] = 1.0;
    const Eigen::VectorXd PH = P_ * h;
    const double explained = h.dot(PH);
    const double residual = linear.residual[0] - of_systematic.dot(systematic_) - beacon.delay_m;
    const double repeating = settings_.ins.systematic_m * settings_.ins.systematic_m;
    const double nis = residual * residual / (explained + linear.R(0, 0) + repeating);
    if (gate_.judge(nis, 1, nullptr) != GateVerdict::accepted) return MappingStatus::gated;
    HostTime& heard = beacon.heard[static_cast<std::size_t>(range.receiver)];
    double repeated = 1.0;
    if (heard != HostTime::min()) {
      repeated = std::max(1.0, settings_.ins.systematic_correlation_s / std::max(1e-3, to_seconds(state_.t - heard)));
    }
    heard = state_.t;
    const double variance = explained + linear.R(0, 0) + repeated * repeating;
    correct(PH / std::sqrt(variance), residual / std::sqrt(variance));
    ++beacon.ranges;
    return MappingStatus::used;
  }

  /// `white`: the whitened residual; `gain`: covariance of everything with it.
  void correct(const Eigen::VectorXd& gain, double white) {
    P_.noalias() -= gain * gain.transpose();
    P_.diagonal() *= 1.0 + 1e-12;  // what rounding may have taken (innovation.hpp)
    InertialState::Error d = InertialState::Error::Zero();
    d.head<strapdown_error_size>() = white * gain.head<strapdown_error_size>();
    state_.add(d);
    systematic_ += white * gain.segment(strapdown_error_size, systematic_.size());
    for (std::size_t i = 0; i < beacons_.size(); ++i) {
      beacons_[i].p_W += white * gain.segment<3>(place_of(i));
      beacons_[i].delay_m += white * gain[place_of(i) + 3];
    }
  }

  [[nodiscard]] double off_axis(int receiver, const Vector3& beacon_W) const {
    const Vector3 axis_W = state_.X_WS.q() * receivers_[static_cast<std::size_t>(receiver)].axis_B;
    if (axis_W.isZero()) return 0.0;
    const Vector3 to_beacon_W = beacon_W - state_.X_WS * receiver_S(receiver);
    return std::acos(std::clamp(axis_W.dot(to_beacon_W) / to_beacon_W.norm(), -1.0, 1.0));
  }

  MappingStatus gather(const CodedRange& range) {
    if (!gate_.trusted()) return MappingStatus::gated;  // who does not know where it is places nothing
    const BodyPoint at = body_point(pose(), receiver_S(range.receiver));
    CandidateRange heard;
    heard.receiver = range.receiver;
    heard.p_W = at.p_W;
    heard.P = at.by_error * P_.topLeftCorner<6, 6>() * at.by_error.transpose();
    heard.axis_W = state_.X_WS.q() * receivers_[static_cast<std::size_t>(range.receiver)].axis_B;
    heard.range_m = range.range_m;
    // About what delays, angles and temperature amount to.
    heard.variance = noise_variance(range.range_m) + settings_.beacon_delay_m * settings_.beacon_delay_m +
                     settings_.receiver_delay_m * settings_.receiver_delay_m +
                     settings_.angle_m_per_rad * settings_.angle_m_per_rad;
    auto candidate = std::find_if(candidates_.begin(), candidates_.end(),
                                  [&](const BeaconCandidate& c) { return c.code() == range.code; });
    if (candidate == candidates_.end()) candidate = candidates_.insert(candidate, BeaconCandidate(range.code));
    if (!candidate->add(heard, settings_.placing)) return MappingStatus::gathered;
    const std::optional<PlacedBeacon> placed = candidate->place(settings_.placing);
    if (!placed) return MappingStatus::gathered;
    add_beacon(range.code, placed->p_W, 4.0 * placed->P);
    candidates_.erase(candidate);
    return MappingStatus::installed;
  }

  BeaconMappingSettings settings_;
  InnovationGate gate_;
  std::vector<RangeReceiver> receivers_;
  std::size_t seeds_ = 0;
  std::vector<Known> beacons_;  // seeds first
  std::vector<BeaconCandidate> candidates_;
  InertialHistory history_{256};
  InertialState state_;
  Eigen::VectorXd systematic_;  // scale, angle, receivers' delays
  Eigen::MatrixXd P_;           // of the navigator's 15 numbers, of systematic_, then of each beacon's four
};

}  // namespace holdfast

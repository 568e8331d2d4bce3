/// Acquisition: the pose from a handful of sightings when nothing is known beforehand.
///
/// A filter that starts far off seldom converges (002 section 6.2.7); the HiBall searches by brute force instead (course 11,
/// The HiBall Tracking System, 5.5). Here three sightings give up to four poses (three_point_resection.hpp), each is refined on
/// the true geometry of the cameras, and the pose that the most sightings agree with wins: hypothesise and verify, as
/// Fischler & Bolles, Random sample consensus, 1981. Wrongly identified beacons are outvoted.
/// A photodiode behind several lenses sees a beacon through one of them and cannot tell which (5.5): a sighting may name
/// several cameras, and the pose decides. Beacons that a pose puts behind their camera speak against it: the "backwards
/// camera" (002 6.2.7) cannot win.
/// The sightings count as simultaneous; `tolerance_rad` must cover what the body turns meanwhile.
/// Nothing here allocates; the draws of triples are the same in every run.
/// Bad input: AcquisitionStatus names why there is no pose. Sightings beyond `maximum_sightings` are left out; those that
/// are not finite agree with no pose.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include <Eigen/LU>

#include <holdfast/tracking/space_resection.hpp>
#include <holdfast/tracking/three_point_resection.hpp>

namespace holdfast {

/// A sighting of a known beacon by one of a few cameras.
struct UnplacedSighting {
  Vector2 uv = Vector2::Zero();                ///< ideal image coordinates, m
  std::span<const CameraView* const> cameras;  ///< through which it may have been seen; not owned
  double variance = 0.0;                       ///< of u and of v, m^2
  Vector3 beacon_W = Vector3::Zero();
  double beacon_variance = 0.0;  ///< of each coordinate, m^2
};

struct AcquisitionSettings {
  double tolerance_rad = 0.02;  ///< angle between seen and expected direction up to which a sighting agrees
  int minimum_agreeing = 6;     ///< three give the pose, the others confirm it
  double minimum_share = 0.6;   ///< of all sightings that must agree
  int triples = 40;             ///< how many are tried
  double same_pose_m = 0.05;    ///< nearer than this, and
  double same_pose_rad = 0.05;  ///< than this, two poses are one
};

enum class AcquisitionStatus {
  acquired,
  too_few,   ///< fewer sightings than must agree
  no_pose,   ///< no pose that enough sightings agree with
  ambiguous  ///< another pose explains as many: more sightings are needed
};

[[nodiscard]] constexpr std::string_view to_string(AcquisitionStatus status) {
  switch (status) {
    case AcquisitionStatus::acquired:
      return "acquired";
    case AcquisitionStatus::too_few:
      return "too_few";
    case AcquisitionStatus::no_pose:
      return "no_pose";
    case AcquisitionStatus::ambiguous:
      return "ambiguous";
  }
  return "unknown";
}

struct Acquisition {
  static constexpr std::size_t maximum_sightings = 64;

  AcquisitionStatus status = AcquisitionStatus::too_few;
  Rigid X_WB;
  Matrix6 covariance = Matrix6::Zero();               ///< of (dp, dphi), by the sightings' variances
  int agreeing = 0;                                   ///< sightings that agree with the pose
  std::array<int, maximum_sightings> camera_index{};  ///< which of its cameras each was seen by; -1: it does not agree

  [[nodiscard]] bool ok() const { return status == AcquisitionStatus::acquired; }
};

namespace detail {

/// The ray in the body's frame along which a camera sees an image point.
struct CameraRay {
  Vector3 origin_B, direction_B;
};

[[nodiscard]] inline CameraRay ray_of(const CameraView& camera, const Vector2& uv) {
  const Matrix3 inverse = camera.V.leftCols<3>().inverse();
  return {-inverse * camera.V.col(3), Vector3(inverse * Vector3(uv.x(), uv.y(), 1.0)).normalized()};
}

class PoseSearch {
 public:
  PoseSearch(std::span<const UnplacedSighting> sightings, const AcquisitionSettings& settings)
      : sightings_(sightings.first(std::min(sightings.size(), Acquisition::maximum_sightings))), settings_(settings) {}

  [[nodiscard]] Acquisition run() {
    const int count = static_cast<int>(sightings_.size());
    if (count < std::max(3, settings_.minimum_agreeing)) return {};
    for (int trial = 0; trial < settings_.triples; ++trial) try_triple(draw_triple(count));
    return judged(count);
  }

 private:
  using Triple = std::array<std::size_t, 3>;

  /// Three different sightings, by a linear congruence (Knuth's MMIX constants): the same in every run.
  [[nodiscard]] Triple draw_triple(int count) {
    const auto draw = [&](int below) {
      random_ = random_ * 6364136223846793005ULL + 1442695040888963407ULL;
      return static_cast<int>((random_ >> 33) % static_cast<std::uint64_t>(below));
    };
    const int first = draw(count);
    int second = draw(count - 1);
    if (second >= first) ++second;
    int third = draw(count - 2);
    if (third >= std::min(first, second)) ++third;
    if (third >= std::max(first, second)) ++third;
    return {static_cast<std::size_t>(first), static_cast<std::size_t>(second), static_cast<std::size_t>(third)};
  }

  void try_triple(const Triple& triple) {
    const auto& [i, j, k] = triple;
    for (const CameraView* camera_i : sightings_[i].cameras) {
      for (const CameraView* camera_j : sightings_[j].cameras) {
        for (const CameraView* camera_k : sightings_[k].cameras) try_cameras(triple, {camera_i, camera_j, camera_k});
      }
    }
  }

  void try_cameras(const Triple& triple, const std::array<const CameraView*, 3>& cameras) {
    std::array<Vector3, 3> directions_B;
    std::array<Vector3, 3> points_W;
    std::array<SightedBeacon, 3> seen;
    for (std::size_t i = 0; i < 3; ++i) {
      const UnplacedSighting& sighting = sightings_[triple[i]];
      directions_B[i] = ray_of(*cameras[i], sighting.uv).direction_B;
      points_W[i] = sighting.beacon_W;
      seen[i] = {{sighting.uv, cameras[i], sighting.variance}, sighting.beacon_W, sighting.beacon_variance};
    }
    // Three points treat all cameras as one; the cameras' true places, centimetres apart, come in by resection.
    const ThreePointPoses poses = three_point_poses(directions_B, points_W);
    for (int i = 0; i < poses.count; ++i) {
      const Resection refined =
          resect(seen, poses.X_WB[static_cast<std::size_t>(i)], {.weighted = false, .maximum_iterations = 10});
      if (refined.ok()) consider(refined.X_WB);
    }
  }

  /// Counts who agrees, and keeps the pose if it is the best, or the best that differs from the best.
  void consider(const Rigid& X_WB) {
    Acquisition candidate = agreement(X_WB);
    if (candidate.agreeing < settings_.minimum_agreeing) return;
    // A thin triangle puts the pose decimetres off; all who agree bring it to where it can be compared.
    const Resection refined = resect_agreeing(candidate);
    if (!refined.ok()) return;
    candidate = agreement(refined.X_WB);
    const bool same = best_.agreeing > 0 && is_same(candidate.X_WB, best_.X_WB);
    if (candidate.agreeing > best_.agreeing) {
      if (!same) rival_ = best_.agreeing;
      best_ = candidate;
    } else if (!same) {
      rival_ = std::max(rival_, candidate.agreeing);
    }
  }

  /// Least squares over the sightings that agree.
  [[nodiscard]] Resection resect_agreeing(const Acquisition& found) const {
    std::array<SightedBeacon, Acquisition::maximum_sightings> agreeing;
    std::size_t n = 0;
    for (std::size_t i = 0; i < sightings_.size(); ++i) {
      if (found.camera_index[i] < 0) continue;
      const UnplacedSighting& s = sightings_[i];
      const CameraView* camera = s.cameras[static_cast<std::size_t>(found.camera_index[i])];
      agreeing[n++] = {{s.uv, camera, s.variance}, s.beacon_W, s.beacon_variance};
    }
    return resect(std::span(agreeing).first(n), found.X_WB);
  }

  [[nodiscard]] bool is_same(const Rigid& a, const Rigid& b) const {
    return (a.p() - b.p()).norm() < settings_.same_pose_m && so3::angle_between(a.q(), b.q()) < settings_.same_pose_rad;
  }

  /// Which sightings see their beacon within the tolerance of where the pose puts it.
  [[nodiscard]] Acquisition agreement(const Rigid& X_WB) const {
    Acquisition found;
    found.X_WB = X_WB;
    found.camera_index.fill(-1);
    const Rigid X_BW = X_WB.inverse();
    const double cosine = std::cos(settings_.tolerance_rad);
    for (std::size_t i = 0; i < sightings_.size(); ++i) {
      const Vector3 p_B = X_BW * sightings_[i].beacon_W;
      double nearest = cosine;
      for (std::size_t k = 0; k < sightings_[i].cameras.size(); ++k) {
        const CameraRay ray = ray_of(*sightings_[i].cameras[k], sightings_[i].uv);
        const double agreement = ray.direction_B.dot(Vector3(p_B - ray.origin_B).normalized());
        if (!(agreement > nearest)) continue;
        nearest = agreement;
        found.camera_index[i] = static_cast<int>(k);
      }
      found.agreeing += found.camera_index[i] >= 0;
    }
    return found;
  }

  [[nodiscard]] Acquisition judged(int count) {
    Acquisition result = best_;
    if (result.agreeing < settings_.minimum_agreeing || result.agreeing < settings_.minimum_share * count) {
      result.status = AcquisitionStatus::no_pose;
      return result;
    }
    const Resection refined = resect_agreeing(result);
    if (!refined.ok()) {
      result.status = AcquisitionStatus::no_pose;
      return result;
    }
    result.X_WB = refined.X_WB;
    result.covariance = refined.covariance;
    // Moving between the sightings leaves more than their own noise: the covariance grows to what is seen.
    const double freedom = 2.0 * result.agreeing - 6.0;
    result.covariance *= std::max(1.0, refined.cost / freedom);
    result.status = rival_ >= result.agreeing ? AcquisitionStatus::ambiguous : AcquisitionStatus::acquired;
    return result;
  }

  std::span<const UnplacedSighting> sightings_;
  AcquisitionSettings settings_;
  Acquisition best_;
  int rival_ = 0;  // most that agree with a pose other than the best
  std::uint64_t random_ = 1;
};

}  // namespace detail

/// The pose that most of the sightings agree with.
[[nodiscard]] inline Acquisition acquire(std::span<const UnplacedSighting> sightings,
                                         const AcquisitionSettings& settings = {}) {
  return detail::PoseSearch(sightings, settings).run();
}

}  // namespace holdfast

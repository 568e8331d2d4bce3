/// Which measurement to make next: the one that tells most about what is known least (002 sections 4.6 and 7.5).
///
/// A camera that may choose among beacons need not take turns (simulation/sighting_stream.hpp has round-robin, random and
/// least recently used). Before anything is measured the filter knows what each candidate would teach: with C the
/// covariance of the error with the measurement and S its own (innovation.hpp), the pose's covariance loses C S^-1 C^T.
///   pose_weight         turns the pose's six numbers into one: mean over points fixed to the body of their squared error,
///                       d^T W d. Metres and radians cannot be compared otherwise
///   weakest_direction   where the pose is known least, in that measure: the largest eigenvalue of P against W
///   expected_reduction  trace(W C S^-1 C^T): what of the mean square is taken away
///   most_informative    the candidate with the largest reduction
/// 002's scheme is most_informative with WeakestDirection::weight; with W itself the sum over all directions counts, which
/// never needs an eigenvector. A device's uncertainty is part of S: a beacon that nobody knows teaches little. But a filter
/// that drops correlations (innovation.hpp) believes the same beacons again and again, and choosing among all is then worse
/// than taking turns: leave out the half of the cameras that looked last, and of each other take the beacon it used longest
/// ago.
/// Units: W is m^2 per (m, rad)^2. The state should be carried to the measurement's time.
/// Bad input: a candidate that the state cannot see is not chosen; without any there is no answer.
#pragma once

#include <span>

#include <Eigen/Eigenvalues>

#include <holdfast/tracking/innovation.hpp>

namespace holdfast {

/// W: the mean over `points_B` of the squared error in W, by the pose's error (dp, dphi). Precondition: there are points.
[[nodiscard]] inline Matrix6 pose_weight(const Quaternion& q_WB, std::span<const Vector3> points_B) {
  HOLDFAST_ASSERT(!points_B.empty(), "a pose is weighed by points");
  const Matrix3 R_WB = q_WB.toRotationMatrix();
  Matrix6 weight = Matrix6::Zero();
  for (const Vector3& p_B : points_B) {
    MatrixOf<double, 3, 6> by_error;  // of the point's place: dp - R p x dphi
    by_error << Matrix3::Identity(), -R_WB * so3::hat<double>(p_B);
    weight += by_error.transpose() * by_error;
  }
  return weight / static_cast<double>(points_B.size());
}

struct WeakestDirection {
  Vector6 error;       ///< of the pose, one standard deviation long
  double mean_square;  ///< of the points along it, m^2
  Matrix6 weight;      ///< of this direction alone
};

/// Nothing when W is not positive definite (points in one line) or P not finite.
[[nodiscard]] inline std::optional<WeakestDirection> weakest_direction(const Matrix6& P, const Matrix6& weight) {
  Matrix6 L;  // W = L L^T: the points' error is as long as L^T d
  if (!P.allFinite() || !cholesky<6>(weight, L)) return std::nullopt;
  using Plain = Eigen::Matrix<double, 6, 6>;  // Eigen's solver wants its own alignment
  const Eigen::SelfAdjointEigenSolver<Plain> eigen(Plain(L.transpose() * P * L));
  const double mean_square = eigen.eigenvalues()[5];
  if (!(mean_square >= 0.0)) return std::nullopt;
  const Vector6 unit = eigen.eigenvectors().col(5);
  const Vector6 along = L * unit;
  WeakestDirection weakest;
  weakest.mean_square = mean_square;
  weakest.error = std::sqrt(mean_square) * back_substituted<6, 1>(L, unit);
  weakest.weight = along * along.transpose();
  return weakest;
}

/// What a measurement would take from trace(W P); its residual does not matter.
template <int Order, typename M>
[[nodiscard]] double expected_reduction(const Innovation<Order, M>& innovation, const Matrix6& weight) {
  const MatrixOf<double, 6, M::size> G =
      detail::substituted<6, M::size>(innovation.C.template topRows<6>(), innovation.L);
  return G.cwiseProduct(weight * G).sum();
}

template <Measurement M>
struct MeasurementCandidate {
  M measurement;  ///< what was measured may be left zero
  DeviceEstimate<M::source_size> source;
  DeviceEstimate<M::sensor_size> sensor;
};

/// Index of the candidate with the largest expected reduction, the first among equals.
template <int Order, Measurement M>
[[nodiscard]] std::optional<std::size_t> most_informative(const TargetState<Order>& state,
                                                          std::span<const MeasurementCandidate<M>> candidates,
                                                          const Matrix6& weight) {
  std::optional<std::size_t> best;
  double most = 0.0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const auto innovation =
        extended_innovation(state, candidates[i].measurement, candidates[i].source, candidates[i].sensor);
    if (!innovation) continue;
    const double reduction = expected_reduction(*innovation, weight);
    if (reduction > most || (!best && reduction == most)) {
      most = reduction;
      best = i;
    }
  }
  return best;
}

}  // namespace holdfast

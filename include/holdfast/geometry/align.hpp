/// Rigid transform, or similarity, that lays one set of points over another by least squares.
///
/// align_rigid        X_AB that minimises sum |p_A - X_AB p_B|^2
/// align_similarity   T_AB, with a scale as well
/// For sets of poses see align_poses.hpp. Source: Umeyama 1991, Least-squares estimation of transformation parameters.
/// Bad input: nothing for sets that are unequal in number, below 3, not finite or on one line. Metres.
#pragma once

#include <cmath>
#include <optional>
#include <span>

#include <Eigen/SVD>

#include <holdfast/geometry/vqs.hpp>

namespace holdfast {

namespace align_detail {

/// Means, spread and cross-covariance of paired points.
struct PairedPoints {
  Vector3 mean_A = Vector3::Zero(), mean_B = Vector3::Zero();
  double variance_B = 0.0;
  Matrix3 covariance_AB = Matrix3::Zero();
};

[[nodiscard]] inline std::optional<PairedPoints> summarise(std::span<const Vector3> p_A, std::span<const Vector3> p_B) {
  if (p_A.size() != p_B.size() || p_A.size() < 3) return std::nullopt;
  const double n = static_cast<double>(p_A.size());
  PairedPoints pairs;
  for (std::size_t i = 0; i < p_A.size(); ++i) {
    pairs.mean_A += p_A[i] / n;
    pairs.mean_B += p_B[i] / n;
  }
  for (std::size_t i = 0; i < p_A.size(); ++i) {
    const Vector3 from_mean_B = p_B[i] - pairs.mean_B;
    pairs.variance_B += from_mean_B.squaredNorm() / n;
    pairs.covariance_AB += (p_A[i] - pairs.mean_A) * from_mean_B.transpose() / n;
  }
  if (!pairs.covariance_AB.allFinite() || !std::isfinite(pairs.variance_B)) return std::nullopt;
  return pairs;
}

/// Square matrices up to 9 x 9 (align_poses.hpp) and their decomposition: one type of bounded size, so that the
/// compiler makes it once, and no QR step, which only other shapes need.
using SingularMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::DontAlign, 9, 9>;
using SquareSvd = Eigen::JacobiSVD<SingularMatrix, Eigen::NoQRPreconditioner>;

/// The rotation nearest to M (it maximises trace(R^T M)), and that trace. Nothing when several rotations are equally
/// near: the second singular value, with the sign of the third, does not stand out.
struct NearestRotation {
  Matrix3 R;
  double trace;
};

[[nodiscard]] inline std::optional<NearestRotation> nearest_rotation(const Matrix3& M, double least_ratio = 1e-10) {
  if (!M.allFinite()) return std::nullopt;
  const SquareSvd svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (svd.info() != Eigen::Success) return std::nullopt;
  const Matrix3 U = svd.matrixU(), V = svd.matrixV();
  const double sign = U.determinant() * V.determinant() < 0.0 ? -1.0 : 1.0;
  const Vector3 s = svd.singularValues();
  if (!(s[1] + sign * s[2] > least_ratio * s[0])) return std::nullopt;
  const Vector3 signs(1.0, 1.0, sign);
  return NearestRotation{U * signs.asDiagonal() * V.transpose(), s.dot(signs)};
}

}  // namespace align_detail

/// X_AB from matching points p_A ~ X_AB p_B. Degenerate: all points on one line (or within 1e-5 of its length of it).
[[nodiscard]] inline std::optional<Rigid> align_rigid(std::span<const Vector3> p_A, std::span<const Vector3> p_B) {
  const std::optional<align_detail::PairedPoints> pairs = align_detail::summarise(p_A, p_B);
  if (!pairs) return std::nullopt;
  const std::optional<align_detail::NearestRotation> nearest = align_detail::nearest_rotation(pairs->covariance_AB);
  if (!nearest) return std::nullopt;
  const Quaternion q_AB(nearest->R);
  return Rigid(q_AB, pairs->mean_A - q_AB * pairs->mean_B);
}

/// T_AB with scale from matching points p_A ~ T_AB p_B. Degenerate as above.
[[nodiscard]] inline std::optional<Vqs> align_similarity(std::span<const Vector3> p_A, std::span<const Vector3> p_B) {
  const std::optional<align_detail::PairedPoints> pairs = align_detail::summarise(p_A, p_B);
  if (!pairs) return std::nullopt;
  const std::optional<align_detail::NearestRotation> nearest = align_detail::nearest_rotation(pairs->covariance_AB);
  if (!nearest) return std::nullopt;
  const Quaternion q_AB(nearest->R);
  const double s_AB = nearest->trace / pairs->variance_B;
  return Vqs::make(pairs->mean_A - s_AB * (q_AB * pairs->mean_B), q_AB, s_AB);
}

}  // namespace holdfast

/// Lays one recording of poses over another when both their worlds and the bodies they record differ.
///
/// Two trackers watch one moving thing: A records body P, B records body Q, both fixed to the thing. Then for every
/// moment
///   X_AP = X_AB X_BQ X_QP
/// and align_poses finds the constant X_AB and X_QP (the robot-world/hand-eye problem, A X = Y B).
/// Source of the first answer: Shah 2013, Solving the Robot-World/Hand-Eye Calibration Problem Using the Kronecker
/// Product; then Gauss-Newton with weights against outliers. For points alone see align.hpp. Bad input: nothing for
/// sets that are unequal in number, below 3, not finite, or that do not determine the answer (turns about one axis
/// only, or by less than about 1 degree). Metres, radians. Allocates: for preparation and evaluation.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/SVD>

#include <holdfast/geometry/align.hpp>
#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

struct PoseAlignment {
  Rigid X_AB;                 ///< pose of world B in world A
  Rigid X_QP;                 ///< pose of body P in body Q
  double rotation_rms = 0.0;  ///< rad, of what remains
  double position_rms = 0.0;  ///< m, of what remains
  /// Standard deviations if errors are independent: rotation about A's axes (rad), position (m).
  Vector6 deviation_X_AB = Vector6::Zero();
  /// The same for X_QP, in Q.
  Vector6 deviation_X_QP = Vector6::Zero();
};

namespace align_detail {

using Vector12 = VectorOf<double, 12>;
using Matrix12 = MatrixOf<double, 12>;
static_assert(alignof(SquareSvd) == alignof(double));

/// What one pair of poses says against X_AP = X_AB X_BQ X_QP: rotation (rad) and position (m), both expressed in A.
struct PoseResidual {
  Vector3 rotation, position;
};

[[nodiscard]] inline PoseResidual pose_residual(const Rigid& X_AP, const Rigid& X_BQ, const Rigid& X_AB,
                                                const Rigid& X_QP) {
  const Rigid X_AP_expected = X_AB * X_BQ * X_QP;
  return {so3::log<double>(X_AP.q() * X_AP_expected.q().conjugate()), X_AP.p() - X_AP_expected.p()};
}

/// Derivative of the residual's negative by (rotation of X_AB on the left, p_AB, rotation of X_QP on the left, p_QP).
[[nodiscard]] inline MatrixOf<double, 6, 12> pose_residual_jacobian(const Rigid& X_BQ, const Rigid& X_AB,
                                                                    const Rigid& X_QP,
                                                                    const Vector3& rotation_residual) {
  const Matrix3 R_AQ = (X_AB.q() * X_BQ.q()).toRotationMatrix();
  const Matrix3 J = so3::right_jacobian_inverse<double>(rotation_residual);
  MatrixOf<double, 6, 12> D = MatrixOf<double, 6, 12>::Zero();
  D.block<3, 3>(0, 0) = J;
  D.block<3, 3>(0, 6) = J * R_AQ;
  D.block<3, 3>(3, 0) = -so3::hat<double>(X_AB.q() * (X_BQ * X_QP.p()));
  D.block<3, 3>(3, 3) = Matrix3::Identity();
  D.block<3, 3>(3, 9) = R_AQ;
  return D;
}

/// First answer: rotations by the singular vectors of sum R_BQ (x) R_AP (no quaternion signs to guess), positions by
/// linear least squares. Nothing when turns are about one axis only, or too small to tell.
[[nodiscard]] inline std::optional<PoseAlignment> align_poses_linearly(std::span<const Rigid> X_AP,
                                                                       std::span<const Rigid> X_BQ) {
  // R_AP R_PQ = R_AB R_BQ for all pairs: R_PQ and R_AB maximise vec(R_AB)^T K vec(R_PQ), K = mean of R_BQ (x) R_AP.
  SingularMatrix K = SingularMatrix::Zero(9, 9);
  const double n = static_cast<double>(X_AP.size());
  for (std::size_t i = 0; i < X_AP.size(); ++i) {
    const Matrix3 R_AP = X_AP[i].R();
    const Matrix3 R_BQ = X_BQ[i].R();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        K.block<3, 3>(3 * row, 3 * column) += R_BQ(row, column) / n * R_AP;
      }
    }
  }
  const SquareSvd svd(K, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Turns about one axis leave the first singular value double; a second axis exercised by 1 degree separates them by
  // 1e-4.
  if (!(svd.singularValues()[1] < (1.0 - 1e-4) * svd.singularValues()[0])) return std::nullopt;
  Matrix3 M_AB = Eigen::Map<const Matrix3>(svd.matrixU().data());  // the first column
  Matrix3 M_PQ = Eigen::Map<const Matrix3>(svd.matrixV().data());
  if (M_AB.determinant() < 0.0) {
    M_AB = -M_AB;
    M_PQ = -M_PQ;
  }
  const std::optional<NearestRotation> R_AB = nearest_rotation(M_AB);
  const std::optional<NearestRotation> R_PQ = nearest_rotation(M_PQ);
  if (!R_AB || !R_PQ) return std::nullopt;

  // p_AP = R_AB p_BQ + p_AB + C p_QP, C = R_AB R_BQ: linear in p_AB and p_QP; C^T C = I.
  Matrix6 N = Matrix6::Identity() * n;
  Vector6 b = Vector6::Zero();
  for (std::size_t i = 0; i < X_AP.size(); ++i) {
    const Matrix3 C = R_AB->R * X_BQ[i].R();
    const Vector3 r = X_AP[i].p() - R_AB->R * X_BQ[i].p();
    N.block<3, 3>(3, 0) += C.transpose();  // the decomposition reads the lower half only
    b.head<3>() += r;
    b.tail<3>() += C.transpose() * r;
  }
  Matrix6 L;
  if (!cholesky<6>(N, L)) return std::nullopt;
  const Vector6 positions = solved_by<6, 1>(L, b);
  PoseAlignment answer;
  answer.X_AB = Rigid(Quaternion(R_AB->R), positions.head<3>());
  answer.X_QP = Rigid(Quaternion(R_PQ->R).conjugate(), positions.tail<3>());
  return answer;
}

/// Adds three rows D d = e to the normal equations: D^T D, lower half, and D^T e, by blocks of three.
inline void add_to_normal(Matrix12& N, Vector12& b, const MatrixOf<double, 3, 12>& D, const Vector3& e, double weight) {
  for (int column = 0; column < 12; column += 3) {
    const Matrix3 weighted = weight * D.block<3, 3>(0, column);
    b.segment<3>(column) += weighted.transpose() * e;
    for (int row = column; row < 12; row += 3) {
      const Matrix3 other = D.block<3, 3>(0, row);
      N.block<3, 3>(row, column) += other.transpose() * weighted;
    }
  }
}

[[nodiscard]] inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace align_detail

/// X_AB and X_QP of two recordings sampled at the same times. At least 3 pairs; degenerate: turns about one axis only,
/// or by less than about 1 degree. Pairs far from the rest (residual beyond three times the median) lose weight in
/// proportion.
[[nodiscard]] inline std::optional<PoseAlignment> align_poses(std::span<const Rigid> X_AP,
                                                              std::span<const Rigid> X_BQ) {
  if (X_AP.size() != X_BQ.size() || X_AP.size() < 3) return std::nullopt;
  const auto is_finite = [](const Rigid& X) { return X.is_finite(); };
  if (!std::ranges::all_of(X_AP, is_finite) || !std::ranges::all_of(X_BQ, is_finite)) return std::nullopt;
  std::optional<PoseAlignment> answer = align_detail::align_poses_linearly(X_AP, X_BQ);
  if (!answer) return std::nullopt;

  const std::size_t n = X_AP.size();
  std::vector<double> rotation_error(n), position_error(n);
  for (int iteration = 0; iteration < 20; ++iteration) {
    for (std::size_t i = 0; i < n; ++i) {
      const align_detail::PoseResidual r = align_detail::pose_residual(X_AP[i], X_BQ[i], answer->X_AB, answer->X_QP);
      rotation_error[i] = r.rotation.norm();
      position_error[i] = r.position.norm();
    }
    // The medians weigh radians against metres, and tell the common from the outlying; the floors keep exact data
    // finite.
    const double rotation_size = std::max(align_detail::median(rotation_error), 1e-12);
    const double position_size = std::max(align_detail::median(position_error), 1e-12);
    align_detail::Matrix12 N = align_detail::Matrix12::Zero();
    align_detail::Vector12 b = align_detail::Vector12::Zero();
    for (std::size_t i = 0; i < n; ++i) {
      const align_detail::PoseResidual r = align_detail::pose_residual(X_AP[i], X_BQ[i], answer->X_AB, answer->X_QP);
      const MatrixOf<double, 6, 12> D =
          align_detail::pose_residual_jacobian(X_BQ[i], answer->X_AB, answer->X_QP, r.rotation);
      const double weight =
          std::min(1.0, 3.0 / std::max(rotation_error[i] / rotation_size, position_error[i] / position_size));
      align_detail::add_to_normal(N, b, D.topRows<3>(), r.rotation, weight / (rotation_size * rotation_size));
      align_detail::add_to_normal(N, b, D.bottomRows<3>(), r.position, weight / (position_size * position_size));
    }
    align_detail::Matrix12 L;
    if (!cholesky<12>(N, L)) return std::nullopt;
    const align_detail::Vector12 step = solved_by<12, 1>(L, b);
    if (!step.allFinite()) return std::nullopt;
    const auto moved = [&step](const Rigid& X, int at) {
      const Vector3 turn = step.segment<3>(at);
      return Rigid(so3::exp<double>(turn) * X.q(), X.p() + step.segment<3>(at + 3));
    };
    answer->X_AB = moved(answer->X_AB, 0);
    answer->X_QP = moved(answer->X_QP, 6);
    // Residuals were scaled to a median length of 1 over three numbers each: about 0.65 standard deviations per unit.
    align_detail::Vector12 deviation;
    const align_detail::Matrix12 covariance = inverse_by<12>(L);
    for (int k = 0; k < 12; ++k) deviation[k] = 0.65 * std::sqrt(covariance(k, k));
    answer->deviation_X_AB = deviation.head<6>();
    answer->deviation_X_QP = deviation.tail<6>();
    if (step.norm() < 1e-12) break;
  }
  double rotation_sum = 0.0;
  double position_sum = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const align_detail::PoseResidual r = align_detail::pose_residual(X_AP[i], X_BQ[i], answer->X_AB, answer->X_QP);
    rotation_sum += r.rotation.squaredNorm();
    position_sum += r.position.squaredNorm();
  }
  answer->rotation_rms = std::sqrt(rotation_sum / static_cast<double>(n));
  answer->position_rms = std::sqrt(position_sum / static_cast<double>(n));
  return answer;
}

}  // namespace holdfast

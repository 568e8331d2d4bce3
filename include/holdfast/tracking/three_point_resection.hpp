/// The poses from which three known points are seen along three known directions (P3P): up to four.
///
/// Grunert's solution (1841; Haralick et al., Review and analysis of solutions of the three point perspective pose
/// estimation problem, 1994, section 2.1): with the triangle's sides a, b, c opposite to points 1, 2, 3, and the angles alpha, beta, gamma
/// between directions 2 and 3, 1 and 3, 1 and 2, the distances s_1, s_2 = u s_1, s_3 = v s_1 follow from a quartic in v.
/// Its roots are found all at once (Durand & Kerner); Newton's iteration on the law of cosines then removes their rounding.
/// Directions are unit vectors of the body's frame, all from its origin; points are in W, metres.
/// Bad input: no poses for points on a line, directions that coincide, numbers that are not finite.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include <Eigen/LU>

#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

/// Poses of a three point resection.
struct ThreePointPoses {
  int count = 0;
  std::array<Rigid, 4> X_WB;
};

namespace detail {

/// Real parts of the nearly real roots of k4 x^4 + ... + k0.
struct RealRoots {
  int count = 0;
  std::array<double, 4> x{};
};

[[nodiscard]] inline RealRoots quartic_real_roots(const std::array<double, 5>& k) {
  RealRoots roots;
  double largest = 0.0;
  for (const double value : k) largest = std::max(largest, std::abs(value));
  if (!(std::abs(k[4]) > 1e-12 * largest) || !std::isfinite(largest)) return roots;
  // Durand and Kerner's iteration on all four at once, from points on no symmetric figure; it needs no derivative, and what
  // it leaves at double roots the caller removes.
  std::array<std::complex<double>, 4> z;
  const double radius = 1.0 + largest / std::abs(k[4]);  // Cauchy: all roots are within
  const std::complex<double> start(0.4, 0.9);
  for (std::size_t i = 0; i < 4; ++i) z[i] = i == 0 ? std::complex<double>(std::min(radius, 2.0)) : z[i - 1] * start;
  for (int iteration = 0; iteration < 100; ++iteration) {
    double change = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      std::complex<double> value = k[4];
      std::complex<double> others = k[4];
      for (std::size_t j = 0; j < 4; ++j) {
        value = value * z[i] + k[3 - j];
        if (j != i) others *= z[i] - z[j];
      }
      const std::complex<double> step = value / others;
      if (!std::isfinite(step.real()) || !std::isfinite(step.imag())) return roots;
      z[i] -= step;
      change = std::max(change, std::abs(step) / (1.0 + std::abs(z[i])));
    }
    if (change < 1e-14) break;
  }
  for (const std::complex<double>& root : z) {
    // A double root splits into a pair whose imaginary parts are the square root of rounding.
    if (std::abs(root.imag()) < 1e-4 * (1.0 + std::abs(root.real()))) {
      roots.x[static_cast<std::size_t>(roots.count++)] = root.real();
    }
  }
  return roots;
}

/// Newton's iteration on s_i^2 + s_j^2 - 2 s_i s_j cos_ij = side_ij^2; false when it does not settle on positive distances.
[[nodiscard]] inline bool polish_distances(Vector3& s, const Vector3& cosines, const Vector3& squared_sides) {
  const auto defect = [&](const Vector3& d) {
    return Vector3(d[1] * d[1] + d[2] * d[2] - 2.0 * d[1] * d[2] * cosines[0] - squared_sides[0],
                   d[0] * d[0] + d[2] * d[2] - 2.0 * d[0] * d[2] * cosines[1] - squared_sides[1],
                   d[0] * d[0] + d[1] * d[1] - 2.0 * d[0] * d[1] * cosines[2] - squared_sides[2]);
  };
  for (int i = 0; i < 5; ++i) {
    Matrix3 J;
    J << 0.0, 2.0 * (s[1] - s[2] * cosines[0]), 2.0 * (s[2] - s[1] * cosines[0]),  //
        2.0 * (s[0] - s[2] * cosines[1]), 0.0, 2.0 * (s[2] - s[0] * cosines[1]),   //
        2.0 * (s[0] - s[1] * cosines[2]), 2.0 * (s[1] - s[0] * cosines[2]), 0.0;
    const Vector3 step = J.inverse() * defect(s);
    if (!step.allFinite() || step.norm() > 0.5 * s.norm()) break;
    s -= step;
  }
  return s.minCoeff() > 0.0 && defect(s).cwiseAbs().maxCoeff() < 1e-6 * squared_sides.maxCoeff();
}

/// The frame with its origin in p_1, x towards p_2 and z across the triangle.
[[nodiscard]] inline Matrix3 triangle_axes(const std::array<Vector3, 3>& p) {
  const Vector3 x = (p[1] - p[0]).normalized();
  const Vector3 z = x.cross(Vector3(p[2] - p[0])).normalized();
  Matrix3 axes;
  axes << x, z.cross(x), z;
  return axes;
}

}  // namespace detail

[[nodiscard]] inline ThreePointPoses three_point_poses(const std::array<Vector3, 3>& directions_B,
                                                       const std::array<Vector3, 3>& points_W) {
  ThreePointPoses poses;
  const double a2 = (points_W[1] - points_W[2]).squaredNorm();
  const double b2 = (points_W[0] - points_W[2]).squaredNorm();
  const double c2 = (points_W[0] - points_W[1]).squaredNorm();
  const double area = Vector3(points_W[1] - points_W[0]).cross(Vector3(points_W[2] - points_W[0])).norm();
  const double ca = directions_B[1].dot(directions_B[2]);
  const double cb = directions_B[0].dot(directions_B[2]);
  const double cg = directions_B[0].dot(directions_B[1]);
  if (!(area > 1e-6 * std::max({a2, b2, c2})) || !(std::max({ca, cb, cg}) < 1.0 - 1e-9)) return poses;

  // Haralick et al. eq. 9: A4 v^4 + A3 v^3 + A2 v^2 + A1 v + A0 = 0.
  const double d = (a2 - c2) / b2;
  const double e = (a2 + c2) / b2;
  const double a = a2 / b2;
  const double c = c2 / b2;
  const std::array<double, 5> k{(1.0 + d) * (1.0 + d) - 4.0 * a * cg * cg,
                                4.0 * (-d * (1.0 + d) * cb + 2.0 * a * cg * cg * cb - (1.0 - e) * ca * cg),
                                2.0 * (d * d - 1.0 + 2.0 * d * d * cb * cb + 2.0 * (1.0 - c) * ca * ca -
                                       4.0 * e * ca * cb * cg + 2.0 * (1.0 - a) * cg * cg),
                                4.0 * (d * (1.0 - d) * cb - (1.0 - e) * ca * cg + 2.0 * c * ca * ca * cb),
                                (d - 1.0) * (d - 1.0) - 4.0 * c * ca * ca};
  const detail::RealRoots roots = detail::quartic_real_roots(k);
  for (int i = 0; i < roots.count; ++i) {
    const double v = roots.x[static_cast<std::size_t>(i)];
    const double denominator = 2.0 * (cg - v * ca);
    if (std::abs(denominator) < 1e-12) continue;
    const double u = ((d - 1.0) * v * v - 2.0 * d * cb * v + 1.0 + d) / denominator;  // eq. 8
    const double s1_squared = b2 / (1.0 + v * v - 2.0 * v * cb);
    if (!(s1_squared > 0.0)) continue;
    Vector3 s = std::sqrt(s1_squared) * Vector3(1.0, u, v);
    if (!detail::polish_distances(s, Vector3(ca, cb, cg), Vector3(a2, b2, c2))) continue;
    std::array<Vector3, 3> points_B;
    for (std::size_t j = 0; j < 3; ++j) points_B[j] = s[static_cast<int>(j)] * directions_B[j];
    const Matrix3 R_WB = detail::triangle_axes(points_W) * detail::triangle_axes(points_B).transpose();
    const Quaternion q_WB(R_WB);
    poses.X_WB[static_cast<std::size_t>(poses.count++)] = Rigid(q_WB, points_W[0] - R_WB * points_B[0]);
  }
  return poses;
}

}  // namespace holdfast

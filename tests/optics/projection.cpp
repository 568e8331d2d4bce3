#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/projection.hpp>

using namespace holdfast;

namespace {

const double infinity = std::numeric_limits<double>::infinity();
const FieldTangents field{-1.2, 0.8, -0.9, 1.1};
constexpr double n = 0.1;
constexpr double f = 50.0;
constexpr double rounding = 1e-13;  // a dozen operations on numbers near 1

/// Column-major entry, as OpenGL and the conventions count them.
double entry(const Matrix4& m, int i) {
  return m(i % 4, i / 4);
}

double near_depth(DepthRange d) {
  return d == DepthRange::minus_one_to_one ? -1.0 : d == DepthRange::zero_to_one ? 0.0 : 1.0;
}
double far_depth(DepthRange d) {
  return d == DepthRange::one_to_zero ? 0.0 : 1.0;
}

constexpr DepthRange all_depths[] = {DepthRange::minus_one_to_one, DepthRange::zero_to_one, DepthRange::one_to_zero};
constexpr YDirection all_y[] = {YDirection::up, YDirection::down};

}  // namespace

TEST_CASE("the matrix is the one of the conventions, entry by entry") {
  const double l = field.left, r = field.right, d = field.down, u = field.up;
  for (const YDirection y : all_y) {
    const double s = y == YDirection::up ? 1.0 : -1.0;
    for (const DepthRange depth : all_depths) {
      for (const double far_m : {f, infinity}) {
        const Matrix4 m = projection_matrix(field, {n, far_m}, depth, y);
        CHECK(entry(m, 0) == doctest::Approx(2 / (r - l)).epsilon(rounding));
        CHECK(entry(m, 8) == doctest::Approx((r + l) / (r - l)).epsilon(rounding));
        CHECK(entry(m, 5) == doctest::Approx(s * 2 / (u - d)).epsilon(rounding));
        CHECK(entry(m, 9) == doctest::Approx(s * (u + d) / (u - d)).epsilon(rounding));
        CHECK(entry(m, 11) == -1.0);
        for (const int zero : {1, 2, 3, 4, 6, 7, 12, 13, 15}) CHECK(entry(m, zero) == 0.0);
      }
    }
  }
  const auto m10_m14 = [](DepthRange depth, double far_m, double m10, double m14) {
    const Matrix4 m = projection_matrix(field, {n, far_m}, depth);
    CHECK(entry(m, 10) == doctest::Approx(m10).epsilon(rounding));
    CHECK(entry(m, 14) == doctest::Approx(m14).epsilon(rounding));
  };
  m10_m14(DepthRange::minus_one_to_one, f, -(f + n) / (f - n), -2 * f * n / (f - n));
  m10_m14(DepthRange::minus_one_to_one, infinity, -1, -2 * n);
  m10_m14(DepthRange::zero_to_one, f, -f / (f - n), -f * n / (f - n));
  m10_m14(DepthRange::zero_to_one, infinity, -1, -n);
  m10_m14(DepthRange::one_to_zero, f, n / (f - n), f * n / (f - n));
  m10_m14(DepthRange::one_to_zero, infinity, 0, n);
}

TEST_CASE("it is the paper's T_N_E: the window of 7.7 on the near plane") {
  // left, right, bottom, top as in the text, from the virtual image.
  const VirtualImage image{1.57, 1.19, -1.18, -0.187, 0.02};
  const double left = -n * (image.x_cw - image.w_x / 2) / image.z_p;
  const double right = -n * (image.x_cw + image.w_x / 2) / image.z_p;
  const double bottom = -n * (image.y_cw - image.w_y / 2) / image.z_p;
  const double top = -n * (image.y_cw + image.w_y / 2) / image.z_p;
  Matrix4 T_NE = Matrix4::Zero();
  T_NE(0, 0) = 2 * n / (right - left);
  T_NE(0, 2) = (right + left) / (right - left);
  T_NE(1, 1) = 2 * n / (top - bottom);
  T_NE(1, 2) = (top + bottom) / (top - bottom);
  T_NE(2, 2) = -(f + n) / (f - n);
  T_NE(2, 3) = -2 * f * n / (f - n);
  T_NE(3, 2) = -1;
  const Matrix4 ours = projection_matrix(tangents_of(image).value(), {n, f});
  CHECK((ours - T_NE).cwiseAbs().maxCoeff() < rounding);
}

TEST_CASE("the eight corners of the frustum become the corners of clip space") {
  for (const YDirection y : all_y) {
    for (const DepthRange depth : all_depths) {
      const Matrix4 m = projection_matrix(field, {n, f}, depth, y);
      for (const bool is_far : {false, true}) {
        for (const bool is_right : {false, true}) {
          for (const bool is_up : {false, true}) {
            const double distance = is_far ? f : n;
            const Vector3 corner_E((is_right ? field.right : field.left) * distance,
                                   (is_up ? field.up : field.down) * distance, -distance);
            const Vector3 ndc = project_to_ndc(m, corner_E).value();
            CHECK(ndc.x() == doctest::Approx(is_right ? 1 : -1).epsilon(rounding));
            CHECK(ndc.y() == doctest::Approx((is_up ? 1 : -1) * (y == YDirection::up ? 1 : -1)).epsilon(rounding));
            CHECK(std::abs(ndc.z() - (is_far ? far_depth(depth) : near_depth(depth))) < rounding);
          }
        }
      }
    }
  }
}

TEST_CASE("depth grows with distance, or falls when reversed, and an infinite far plane is a limit") {
  for (const DepthRange depth : all_depths) {
    const Matrix4 m = projection_matrix(field, ClipPlanes::with_infinite_far(n), depth);
    const double sign = depth == DepthRange::one_to_zero ? -1.0 : 1.0;
    double last = sign * near_depth(depth);
    for (const double distance : {0.11, 0.5, 3.0, 1e3, 1e6}) {
      const double z = sign * project_to_ndc(m, Vector3(0, 0, -distance)).value().z();
      CHECK(z > last);
      last = z;
    }
    // The finite matrix tends to the infinite one: n/f is what they differ by.
    const Matrix4 finite = projection_matrix(field, {n, 1e9}, depth);
    CHECK((m - finite).cwiseAbs().maxCoeff() < 3 * n / 1e9);
    const double at_infinity = project_to_ndc(m, Vector3(0, 0, -1e12)).value().z();
    CHECK(std::abs(at_infinity - far_depth(depth)) < 1e-12);
  }
}

TEST_CASE("handedness: with Y up the map keeps right to the right and up upward, with Y down it turns only up") {
  const Vector3 right_up_E(0.3, 0.2, -2.0);
  const Vector3 centre_E(0.0, 0.0, -2.0);
  const Matrix4 gl = projection_matrix(field, {n, f});
  const Vector3 moved = project_to_ndc(gl, right_up_E).value() - project_to_ndc(gl, centre_E).value();
  CHECK(moved.x() > 0.0);
  CHECK(moved.y() > 0.0);
  const Matrix4 vulkan = projection_matrix(field, {n, f}, DepthRange::zero_to_one, YDirection::down);
  const Vector3 flipped = project_to_ndc(vulkan, right_up_E).value() - project_to_ndc(vulkan, centre_E).value();
  CHECK(flipped.x() == doctest::Approx(moved.x()).epsilon(rounding));
  CHECK(flipped.y() == doctest::Approx(-moved.y()).epsilon(rounding));
  // Clip space of OpenGL is left-handed, that of Vulkan right-handed: the determinant's sign on the visible side tells.
  CHECK(gl.determinant() * vulkan.determinant() < 0.0);
}

TEST_CASE("unproject undoes projection in every form") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> across(-2.0, 2.0);
  std::uniform_real_distribution<double> away(0.2, 40.0);
  for (const YDirection y : all_y) {
    for (const DepthRange depth : all_depths) {
      for (const double far_m : {f, infinity}) {
        const Matrix4 m = projection_matrix(field, {n, far_m}, depth, y);
        for (int i = 0; i < 20; ++i) {
          const Vector3 p_E(across(random), across(random), -away(random));
          const Vector3 back = unproject(m, project_to_ndc(m, p_E).value()).value();
          // Depth near the far plane has lost a factor z/n of its digits.
          CHECK((back - p_E).norm() < 1e-15 * p_E.squaredNorm() / n * 100);
        }
      }
    }
  }
}

TEST_CASE("points that have no picture are answered with nothing") {
  const Matrix4 m = projection_matrix(field, ClipPlanes::with_infinite_far(n), DepthRange::one_to_zero);
  CHECK_FALSE(project_to_ndc(m, Vector3(0, 0, 1)).has_value());
  CHECK_FALSE(project_to_ndc(m, Vector3(1, 0, 0)).has_value());
  CHECK_FALSE(unproject(m, Vector3(0, 0, 0)).has_value());     // reversed: 0 is infinity
  CHECK_FALSE(unproject(m, Vector3(0, 0, -0.5)).has_value());  // beyond infinity: behind the eye
}

TEST_CASE("impossible clipping planes name their problem") {
  CHECK(problem_of(ClipPlanes{0.0, 10}) == ClipProblem::near_not_positive);
  CHECK(problem_of(ClipPlanes{std::nan(""), 10}) == ClipProblem::near_not_positive);
  CHECK(problem_of(ClipPlanes{1.0, 1.0}) == ClipProblem::far_not_beyond_near);
  CHECK(problem_of(ClipPlanes{1.0, std::nan("")}) == ClipProblem::far_not_beyond_near);
  CHECK(problem_of(ClipPlanes::with_infinite_far(0.1)) == ClipProblem::none);
}

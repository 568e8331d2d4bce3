#include <cmath>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/depth_image.hpp>

#include "deflection/setups.hpp"

using namespace holdfast;

TEST_CASE("distances come back from the depth buffer of every convention") {
  test::Random random(701);
  for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one, DepthRange::one_to_zero}) {
    for (const bool infinite_far : {false, true}) {
      for (const YDirection y : {YDirection::up, YDirection::down}) {
        const ClipPlanes clip = infinite_far ? ClipPlanes::with_infinite_far(0.05) : ClipPlanes{0.05, 200.0};
        const Matrix4 P = projection_matrix(FieldTangents{-1.1, 0.8, -0.7, 0.9}, clip, range, y);
        for (int i = 0; i < 50; ++i) {
          const double distance = random.uniform(0.1, 10.0);
          const double z_ndc = project_to_ndc(P, Vector3(0.1, 0.2, -distance))->z();
          const double stored = range == DepthRange::minus_one_to_one ? (z_ndc + 1.0) / 2.0 : z_ndc;
          // Single precision near 1 keeps 6e-8 of depth: distance^2 / near times that, 1e-4 m at 10 m.
          const double expected_error = 1.3e-7 * distance * distance / clip.near_m + 1e-6 * distance;
          CHECK(std::abs(distance_of_depth(static_cast<float>(stored), P, range) - distance) < expected_error);
        }
      }
    }
  }
}

TEST_CASE("the value that a depth buffer is cleared to means: nothing drawn") {
  for (const DepthRange range : {DepthRange::minus_one_to_one, DepthRange::zero_to_one, DepthRange::one_to_zero}) {
    const Matrix4 P = projection_matrix(FieldTangents{}, ClipPlanes{0.05, 200.0}, range);
    const float cleared = range == DepthRange::one_to_zero ? 0.0f : 1.0f;
    const std::vector<float> buffer{cleared, 0.5f, std::numeric_limits<float>::quiet_NaN()};
    std::vector<float> distance(3);
    distances_of_depth_buffer(buffer, P, range, distance);
    CHECK(std::isinf(distance[0]));
    CHECK(std::isfinite(distance[1]));
    CHECK(distance[1] > 0.05f);
    CHECK(std::isinf(distance[2]));
  }
}

TEST_CASE("an image whose distances do not fit its size is refused by name") {
  CHECK(problem_of(DepthImage{{2, 2}, {1, 1, 1, 1}}) == DepthProblem::none);
  CHECK(problem_of(DepthImage{{2, 2}, {1, 1, 1}}) == DepthProblem::size_mismatch);
  CHECK(problem_of(DepthImage{{0, 2}, {}}) == DepthProblem::no_pixels);
  CHECK(problem_of(DepthImage{{-2, -2}, {1, 1, 1, 1}}) == DepthProblem::no_pixels);
}

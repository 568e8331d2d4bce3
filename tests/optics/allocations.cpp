// What a frame does with an eye allocates nothing: counted by replacing the global operator new of this test program.
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/optics/optics.hpp>

#include "allocation_counter.hpp"
#include "optics/published_lenses.hpp"

using namespace holdfast;

TEST_CASE("no lens model allocates, whatever it is asked") {
  const std::vector<test::PublishedLens> lenses = test::published_lenses();
  double sum = 0.0;
  const std::size_t before = test::allocations();
  for (const test::PublishedLens& p : lenses) {
    for (int i = 0; i < 20; ++i) {
      const Vector2 t(0.05 * i, 0.07 * i - 0.3);  // some outside the domain
      if (const auto seen = p.lens.distort(t)) sum += seen->sum();
      if (const auto panel = p.lens.undistort(t)) sum += panel->sum();
      if (const auto J = p.lens.undistort_jacobian(t)) sum += J->sum();
      sum += p.lens.distort_jacobian(Vector2(0.1 * t)).sum();
    }
  }
  CHECK(test::allocations() == before);
  CHECK(std::isfinite(sum));
}

TEST_CASE("a point mesh allocates when it is made, not when it is asked or copied") {
  std::vector<PointMeshSample> samples;
  for (int i = 0; i < 9; ++i) {
    for (int k = 0; k < 9; ++k) samples.push_back({Vector2(i - 4, k - 4), Vector2(1.1 * i - 4.4, k - 4)});
  }
  const Lens lens(PointMeshLens(make_point_mesh(samples).mesh));
  double sum = 0.0;
  const std::size_t before = test::allocations();
  const Lens copy = mirrored(lens);
  for (int i = 0; i < 50; ++i) {
    const Vector2 t(0.2 * i - 5, 3.0 - 0.1 * i);  // some outside
    if (const auto seen = copy.distort(t)) sum += seen->sum() + copy.distort_jacobian(t).sum();
    if (const auto panel = copy.undistort(t)) sum += panel->sum() + copy.undistort_jacobian(t)->sum();
  }
  CHECK(test::allocations() == before);
  CHECK(std::isfinite(sum));
}

TEST_CASE("projection, rays and lenses allocate nothing") {
  HmdModel hmd = default_hmd();
  hmd.right.lens = Lens(PolynomialLens(std::array<double, 2>{0.22, 0.24}), placed_at(0.9));
  double sum = 0.0;
  const std::size_t before = test::allocations();
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    const EyeModel& eye = hmd.eye(side);
    sum += projection_matrix(eye, ClipPlanes{}).sum() + arcmin_per_pixel(eye);
    const Vector2 pixel = project(eye, Vector3(0.1, 0.2, -1.0)).value();
    sum += ray_E(eye, pixel).sum() + project_jacobian(eye, Vector3(0.1, 0.2, -1.0)).sum();
    for (const LensMode mode : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
      sum += seen_pixel(eye, mode, pixel).value().sum() + ideal_pixel(eye, mode, pixel).value().sum();
      sum += drawn_pixel(eye, mode, pixel).value().sum() + ideal_pixel_at_panel(eye, mode, pixel).value().sum();
    }
    sum += eye.lens.distort_jacobian(Vector2(0.1, 0.2)).sum();
  }
  const std::size_t after = test::allocations();
  CHECK(after == before);
  CHECK(std::isfinite(sum));
  CHECK(test::counts_allocations());
}

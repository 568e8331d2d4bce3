#include <limits>

#include <doctest/doctest.h>

#include <holdfast/deflection/depth_surface.hpp>

#include "deflection/depth_scene.hpp"
#include "deflection/setups.hpp"

using namespace holdfast;

namespace {
const RenderedView view{{}, {-0.6, 0.6, -0.45, 0.45}, {64, 48}, {}};

DepthImage level(float distance) {
  return {view.size, std::vector<float>(64 * 48, distance)};
}
}  // namespace

TEST_CASE("a plane is met exactly, however slanted, and holds together") {
  for (const Vector3& normal : {Vector3(0, 0, 1), Vector3(0.5, 0.2, 1), Vector3(1, 0, 0.05), Vector3(0.1, 1, 0.1)}) {
    test::DepthScene scene;
    scene.planes.push_back(*Plane::make(normal, Vector3(-0.9, -0.8, -2)));
    DepthSurface surface;
    REQUIRE(surface.update(view, scene.depth_image(view)) == DepthProblem::none);
    const Vector3 w_of_direction = scene.planes[0].normal / scene.planes[0].offset;
    for (int y = 1; y < 47; ++y) {
      for (int x = 1; x < 63; ++x) {
        const Vector2 pixel(x + 0.8, y + 0.3);
        const double exact = w_of_direction.dot(direction_of_tangents(surface.tangent_of_pixel(pixel)));
        if (!(exact > 0.05)) continue;  // where the plane ends at its horizon
        CHECK(surface.linked_right(x, y));
        CHECK(surface.linked_up(x, y));
        // Distances are single precision: 6e-8 of w, and a few times that in the slope.
        CHECK(std::abs(surface.facet(x, y).at(pixel) - exact) < 4e-7 * (1.0 + exact));
      }
    }
  }
}

TEST_CASE("an edge cuts: between near and far, and on both sides of a post one pixel wide") {
  DepthImage depth = level(2.0f);
  for (int y = 10; y < 30; ++y) {
    for (int x = 20; x < 30; ++x) depth.distance_m[static_cast<std::size_t>(y * 64 + x)] = 1.0f;
    depth.distance_m[static_cast<std::size_t>(y * 64 + 40)] = 1.5f;
  }
  DepthSurface surface;
  REQUIRE(surface.update(view, depth) == DepthProblem::none);
  for (int y = 10; y < 30; ++y) {
    CHECK_FALSE(surface.linked_right(19, y));
    CHECK(surface.linked_right(20, y));
    CHECK_FALSE(surface.linked_right(29, y));
    CHECK(surface.linked(30, y, 1, 0));
    CHECK_FALSE(surface.linked(30, y, -1, 0));
    CHECK_FALSE(surface.linked_right(39, y));
    CHECK_FALSE(surface.linked_right(40, y));
  }
  CHECK_FALSE(surface.linked_up(25, 9));
  CHECK_FALSE(surface.linked(25, 30, 0, -1));
  // Facets beside an edge lie level with their own side.
  CHECK(surface.facet(20, 20).at(Vector2(20.0, 20.5)) == doctest::Approx(1.0));
  CHECK(surface.facet(19, 20).at(Vector2(20.0, 20.5)) == doctest::Approx(0.5));
  CHECK(surface.greatest_w() >= 1.0);
}

TEST_CASE("nothing drawn is infinitely far; numbers that are no distance are counted and taken for it") {
  DepthImage depth = level(std::numeric_limits<float>::infinity());
  depth.distance_m[5] = -1.0f;
  depth.distance_m[6] = 0.0f;
  depth.distance_m[7] = std::numeric_limits<float>::quiet_NaN();
  depth.distance_m[8] = 1e-40f;  // its inverse is no finite float
  DepthSurface surface;
  REQUIRE(surface.update(view, depth) == DepthProblem::none);
  CHECK(surface.bad_pixels() == 4);
  CHECK(surface.greatest_w() == 0.0);
  CHECK(surface.w_at(Vector2(0, 0)) == 0.0);
  CHECK(surface.linked_right(6, 0));
}

TEST_CASE("an unfit image leaves the surface empty") {
  DepthSurface surface;
  CHECK(surface.is_empty());
  REQUIRE(surface.update(view, level(1.0f)) == DepthProblem::none);
  CHECK_FALSE(surface.is_empty());
  CHECK(surface.update(view, DepthImage{{3, 3}, {1.0f}}) == DepthProblem::size_mismatch);
  CHECK(surface.is_empty());
  RenderedView flat = view;
  flat.tangents.up = flat.tangents.down;
  CHECK(surface.update(flat, level(1.0f)) == DepthProblem::no_field);
  CHECK(surface.is_empty());
}

TEST_CASE("a depth image bound to its view is taken over with it, of whatever size") {
  const RenderedPicture<DepthImage> depth(view, DepthImage{{2, 3}, std::vector<float>(6, 4.0f)});
  DepthSurface surface;
  REQUIRE(surface.update(depth) == DepthProblem::none);
  CHECK(surface.size() == PixelSize{2, 3});
  CHECK((surface.pixel_of_tangent(Vector2(0.6, 0.45)) - Vector2(2, 3)).norm() < 1e-12);
  CHECK(surface.w_at(Vector2(0.9, 0.0)) == 0.25);  // beyond the edge: the nearest pixel's
}

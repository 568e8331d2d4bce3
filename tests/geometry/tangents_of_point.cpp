#include <limits>

#include <doctest/doctest.h>

#include <holdfast/geometry/tangents_of_point.hpp>

using namespace holdfast;

TEST_CASE("tangents: right is +x, up is +y, ahead is -Z") {
  CHECK((*tangents_of_point(Vector3(1, 2, -4)) - Vector2(0.25, 0.5)).norm() == 0.0);
  CHECK_FALSE(tangents_of_point(Vector3(1, 2, 4)));
  CHECK_FALSE(tangents_of_point(Vector3(1, 2, 0)));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    CHECK_FALSE(tangents_of_point(Vector3(bad, 2, -4)));
    CHECK_FALSE(tangents_of_point(Vector3(1, 2, -bad)));
  }
  CHECK((direction_of_tangents(Vector2(0.25, 0.5)) - Vector3(0.25, 0.5, -1)).norm() == 0.0);
}

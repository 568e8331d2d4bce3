#include <doctest/doctest.h>

#include <holdfast/geometry/geometry.hpp>

using namespace holdfast;
using namespace holdfast::literals;

TEST_CASE("the samples of docs/geometry.md do what they say") {
  const Rigid X_WH(so3::exp<double>(Vector3(0, 0.3, 0)), Vector3(0, 1.7, 0));
  const Rigid X_HE = Rigid::translation(Vector3(-0.031, 0, 0));
  const Rigid X_WE = X_WH * X_HE;
  const Vector3 p_E = X_WE.inverse() * Vector3(0, 1.5, -2);
  // The head is turned left, so a point straight ahead in the world lies to the right; the left eye sees it still more
  // so.
  CHECK(p_E.x() == doctest::Approx(2 * std::sin(0.3) + 0.031).epsilon(1e-14));
  CHECK(p_E.y() == doctest::Approx(-0.2).epsilon(1e-14));
  CHECK(p_E.z() == doctest::Approx(-2 * std::cos(0.3)).epsilon(1e-14));

  const Angle a = 30_deg + arcmin(15);
  CHECK(a.degrees() == doctest::Approx(30.25).epsilon(1e-15));

  const Homography turn = Homography::rotation(X_WH.q().conjugate());
  const std::optional<Vector2> t_A = turn.apply(Vector2(0, 0));
  REQUIRE(t_A);
  CHECK(t_A->x() == doctest::Approx(std::tan(0.3)).epsilon(1e-14));
}

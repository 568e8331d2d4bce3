#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/projected_ellipse.hpp>
#include <holdfast/registration/scene_depth.hpp>

using namespace holdfast;

namespace {

const FieldTangents wide{-2.0, 2.0, -2.0, 2.0};

SceneDepth seen_from(const Rigid& X_WE, const RegistrationScene& scene = default_registration_scene()) {
  SceneDepth depth;
  depth.place(scene, X_WE, wide);
  return depth;
}

Vector2 tangent_of(const Rigid& X_WE, const Vector3& p_W) {
  return *tangents_of_point(X_WE.inverse() * p_W);
}

}  // namespace

TEST_CASE("each thing of the scene is at its depth, and beside it there is nothing") {
  const RegistrationScene scene = default_registration_scene();
  const Rigid X_WE(so3::exp<double>(Vector3(0.05, -0.1, 0.2)), Vector3(0.02, -0.03, 0.1));
  const SceneDepth depth = seen_from(X_WE);
  const auto distance = [&](const Vector3& p_W) { return -(X_WE.inverse() * p_W).z(); };
  for (std::size_t i = 0; i < 9; ++i) {
    const Disc& disc = scene.discs[i];
    CHECK(depth.at(tangent_of(X_WE, disc.centre_W)) == doctest::Approx(distance(disc.centre_W)).epsilon(1e-12));
    const Vector3 across = disc.normal_W.cross(Vector3::UnitY()).normalized() * disc.radius_m;
    const Vector3 inside = disc.centre_W + 0.99 * across, outside = disc.centre_W + 1.01 * across;
    CHECK(depth.at(tangent_of(X_WE, inside)) == doctest::Approx(distance(inside)).epsilon(1e-12));
    CHECK(std::isinf(depth.at(tangent_of(X_WE, outside))));
  }
  const Vector3 board = scene.board.X_WC * Vector3(0.07, 0.03, 0.0);
  CHECK(depth.at(tangent_of(X_WE, board)) == doctest::Approx(distance(board)).epsilon(1e-12));
  const Vector3 panel = scene.edge.point_W(0.45) + 0.5 * scene.edge.across_W;
  CHECK(depth.at(tangent_of(X_WE, panel)) == doctest::Approx(distance(panel)).epsilon(1e-12));
  CHECK(std::isinf(depth.at(tangent_of(X_WE, scene.edge.point_W(0.45) - 0.05 * scene.edge.across_W))));
  // A bar of the corner: its face, half a thickness before its middle line.
  const Vector3 bar = scene.corner.X_WF * Vector3(0.5 * scene.corner.length_m, 0.0, 0.0);
  const double at_bar = depth.at(tangent_of(X_WE, bar));
  CHECK(at_bar < distance(bar));
  CHECK(at_bar > distance(bar) - scene.corner.thickness_m);
}

TEST_CASE("the nearer thing hides the farther, and what is behind the eye hides nothing") {
  RegistrationScene scene;
  for (const double z : {-2.0, -1.0, 0.5}) {
    Disc disc;
    disc.centre_W = Vector3(0.0, 0.0, z);
    disc.radius_m = 0.2;
    scene.discs.push_back(disc);
  }
  const SceneDepth depth = seen_from(Rigid(), scene);
  CHECK(depth.at(Vector2(0.05, 0.0)) == doctest::Approx(1.0));
  CHECK(std::isinf(depth.at(Vector2(0.3, 0.0))));
  CHECK(seen_from(Rigid::translation(Vector3(0, 0, -1.5)), scene).at(Vector2(0.0, 0.0)) == doctest::Approx(0.5));
  CHECK(std::isinf(seen_from(Rigid::translation(Vector3(0, 0, 1.0)), scene).at(Vector2(0.0, 0.6))));
}

TEST_CASE("leaving out what the field cannot show changes nothing in it") {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> angle(-3.0, 3.0), tangent(-0.5, 0.5);
  const RegistrationScene scene = default_registration_scene();
  for (int i = 0; i < 20; ++i) {
    const Rigid X_WE(so3::exp<double>(Vector3(0.2, angle(random), 0.1)), Vector3(0.1, 0.0, 0.2));
    SceneDepth narrow, all;
    narrow.place(scene, X_WE, {-0.5, 0.5, -0.5, 0.5});
    all.place(scene, X_WE, {-1e9, 1e9, -1e9, 1e9});
    for (int k = 0; k < 200; ++k) {
      const Vector2 t(tangent(random), tangent(random));
      CHECK(narrow.at(t) == all.at(t));
    }
  }
}

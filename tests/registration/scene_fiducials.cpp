#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/projected_ellipse.hpp>
#include <holdfast/registration/scene_fiducials.hpp>

using namespace holdfast;

namespace {

/// Ellipses of the scene's front discs for the eye of a head at the origin.
std::vector<ProjectedEllipse> front_ellipses(const EyeModel& eye) {
  std::vector<ProjectedEllipse> ellipses;
  for (const Disc& disc : default_registration_scene().discs) {
    if (disc.around) continue;
    const auto e = project_disc(eye, eye.X_HE, disc);
    REQUIRE(e);
    ellipses.push_back(*e);
  }
  return ellipses;
}

}  // namespace

TEST_CASE("every front disc is large enough and wholly in view of both eyes") {
  // 640 x 360 is the smallest picture that the scene promises 8 px for.
  for (const auto& [size, least_px] : {std::pair{PixelSize{1280, 720}, 15.0}, std::pair{PixelSize{640, 360}, 7.7}}) {
    const HmdModel hmd = default_hmd(size);
    for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
      const auto ellipses = front_ellipses(hmd.eye(side));
      CHECK(ellipses.size() == 9);
      for (const ProjectedEllipse& e : ellipses) {
        CHECK(e.front);
        CHECK(e.is_inside(size, 20.0 * size.width / 1280.0));
        CHECK(std::sqrt(e.semi_major_px * e.semi_minor_px) > least_px);
      }
    }
  }
}

TEST_CASE("front discs do not hide one another for either eye") {
  const HmdModel hmd = default_hmd();
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    const auto ellipses = front_ellipses(hmd.eye(side));
    for (std::size_t i = 0; i < ellipses.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const double apart = (ellipses[i].centroid - ellipses[j].centroid).norm();
        CHECK(apart > ellipses[i].semi_major_px + ellipses[j].semi_major_px + 8.0);
      }
    }
  }
}

TEST_CASE("the scene has discs at 0.5, 1 and 2 m and its edge at 2 m") {
  const RegistrationScene scene = default_registration_scene();
  for (const double distance : {0.5, 1.0, 2.0}) {
    int count = 0;
    for (const Disc& disc : scene.discs) {
      CHECK(disc.normal_W.norm() == doctest::Approx(1.0).epsilon(1e-12));
      count += !disc.around && disc.nominal_distance_m == distance && -disc.centre_W.z() == doctest::Approx(distance);
    }
    CHECK(count == 3);
  }
  CHECK(scene.edge.bottom_W.z() == -2.0);
  CHECK(scene.edge.bottom_W.x() == scene.edge.top_W.x());
}

TEST_CASE("the bars of the frame corner all come towards the viewer") {
  const FrameCorner corner = default_registration_scene().corner;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vector3 bar = corner.end_of_axis_W(axis) - corner.X_WF.p();
    CHECK(bar.norm() == doctest::Approx(corner.length_m));
    CHECK(bar.z() == doctest::Approx(corner.length_m / std::sqrt(3.0)));  // a cube seen along its diagonal
  }
}

// OpenXR is optional: without its headers this file is empty.
#ifdef HOLDFAST_TEST_OPENXR
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/interop/openxr.hpp>
#include <holdfast/optics/projection.hpp>

using namespace holdfast;

namespace {
constexpr double float_rounding = 1.2e-7;  // of a number of size 1, twice over
}

TEST_CASE("fields: radians, right and up positive, members by name") {
  const XrFovf fov{-0.9f, 0.8f, 0.7f, -0.6f};  // left, right, up, down: OpenXR's order
  const FieldResult field = from_xr(fov);
  REQUIRE(field.ok());
  CHECK(field.tangents.left == doctest::Approx(std::tan(-0.9)).epsilon(1e-6));
  CHECK(field.tangents.right == doctest::Approx(std::tan(0.8)).epsilon(1e-6));
  CHECK(field.tangents.up == doctest::Approx(std::tan(0.7)).epsilon(1e-6));
  CHECK(field.tangents.down == doctest::Approx(std::tan(-0.6)).epsilon(1e-6));
  const XrFovf back = to_xr(field.tangents);
  CHECK(back.angleLeft == fov.angleLeft);
  CHECK(back.angleRight == fov.angleRight);
  CHECK(back.angleUp == fov.angleUp);
  CHECK(back.angleDown == fov.angleDown);
}

TEST_CASE("impossible fields are named, mirrored ones kept") {
  CHECK(from_xr(XrFovf{0.5f, 0.5f, 0.5f, -0.5f}).problem == FieldProblem::zero_width);
  CHECK(from_xr(XrFovf{-0.5f, 0.5f, 0.3f, 0.3f}).problem == FieldProblem::zero_height);
  CHECK(from_xr(XrFovf{-1.6f, 0.5f, 0.5f, -0.5f}).problem == FieldProblem::angle_beyond_90);
  CHECK(from_xr(XrFovf{std::numeric_limits<float>::quiet_NaN(), 0.5f, 0.5f, -0.5f}).problem ==
        FieldProblem::not_finite);
  const FieldResult mirrored = from_xr(XrFovf{0.5f, -0.5f, -0.4f, 0.4f});
  REQUIRE(mirrored.ok());
  CHECK(is_mirrored_x(mirrored.tangents));
  CHECK(is_mirrored_y(mirrored.tangents));
}

TEST_CASE("poses there and back, by name") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    const Quaternion q = Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
    const Rigid X(q, Vector3(normal(random), normal(random), normal(random)));
    const XrPosef pose = to_xr(X);
    CHECK(pose.orientation.w == static_cast<float>(q.w()));
    CHECK(pose.orientation.x == static_cast<float>(q.x()));
    CHECK(pose.position.z == static_cast<float>(X.p().z()));
    const auto back = from_xr(pose);
    REQUIRE(back);
    CHECK((back->p() - X.p()).norm() < 4 * float_rounding);  // coordinates up to about 4
    CHECK(back->q().angularDistance(q) < 4 * float_rounding);
  }
  CHECK_FALSE(from_xr(XrQuaternionf{0, 0, 0, 0}).has_value());
  CHECK_FALSE(from_xr(XrQuaternionf{0, 0, 0, 1.02f}).has_value());
  CHECK(from_xr(XrQuaternionf{0, 0, 0, 1.005f}).has_value());
  CHECK_FALSE(from_xr(XrQuaternionf{0, std::numeric_limits<float>::quiet_NaN(), 0, 1}).has_value());
  CHECK_FALSE(from_xr(XrPosef{{0, 0, 0, 1}, {0, INFINITY, 0}}).has_value());
}

TEST_CASE("times: nanoseconds, and none at or below zero") {
  CHECK(host_time_of_xr(123'456'789)->time_since_epoch().count() == 123'456'789);
  CHECK(to_xr(HostTime(Duration(987))) == 987);
  CHECK_FALSE(host_time_of_xr(0).has_value());
  CHECK_FALSE(host_time_of_xr(-5).has_value());
}

TEST_CASE("a canted headset survives as views, and its head frame is midway between the eyes") {
  HmdModel hmd = default_hmd({1440, 1600});
  hmd.left.tangents = {-1.2, 0.9, -1.0, 1.1};
  hmd.left.X_HE = eye_pose(EyeSide::left, 0.064, degrees(20), degrees(3));
  hmd.right = mirrored(hmd.left);
  std::array<XrView, 2> views = to_xr(hmd);
  CHECK(views[0].type == XR_TYPE_VIEW);
  // A runtime whose VIEW space lies elsewhere.
  for (XrView& view : views) {
    view.pose.position.y += 0.01f;
    view.pose.position.z -= 0.02f;
  }
  const XrHmd back = hmd_of_xr(views, {hmd.left.resolution, hmd.right.resolution}, 90.0);
  REQUIRE(back.ok());
  CHECK((back.p_VH - Vector3(0, 0.01, -0.02)).norm() < 1e-8);  // floats of that size
  CHECK(back.hmd.ipd_m == doctest::Approx(0.064).epsilon(1e-6));
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    const EyeModel& a = hmd.eye(side);
    const EyeModel& b = back.hmd.eye(side);
    CHECK((a.X_HE.p() - b.X_HE.p()).norm() < 1e-8);
    CHECK(a.X_HE.q().angularDistance(b.X_HE.q()) < 4 * float_rounding);
    CHECK(std::abs(a.tangents.left - b.tangents.left) < 4 * float_rounding);
    CHECK(std::abs(a.tangents.up - b.tangents.up) < 4 * float_rounding);
    CHECK(b.side == side);
    CHECK(b.resolution == a.resolution);
  }
}

TEST_CASE("views that make no headset are refused with the reason") {
  const HmdModel hmd = default_hmd();
  const std::array<PixelSize, 2> sizes{PixelSize{10, 10}, PixelSize{10, 10}};
  auto views = to_xr(hmd);
  CHECK(hmd_of_xr(views, sizes, 90.0).ok());
  CHECK(hmd_of_xr(views, sizes, 0.0).problem.find("refresh") != std::string_view::npos);
  CHECK(hmd_of_xr(views, {PixelSize{10, 10}, PixelSize{0, 10}}, 90.0).problem.find("pixels") != std::string_view::npos);
  std::swap(views[0], views[1]);
  CHECK(hmd_of_xr(views, sizes, 90.0).problem.find("right view") != std::string_view::npos);
  views = to_xr(hmd);
  views[0].pose.orientation = {};
  CHECK(hmd_of_xr(views, sizes, 90.0).problem.find("quaternion") != std::string_view::npos);
  views = to_xr(hmd);
  views[1].fov.angleLeft = views[1].fov.angleRight;
  CHECK(hmd_of_xr(views, sizes, 90.0).problem.find("width") != std::string_view::npos);
}
#endif

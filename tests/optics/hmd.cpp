#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/optics/hmd.hpp>

using namespace holdfast;

namespace {

HmdModel flight_helmet() {
  HmdModel hmd = default_hmd({640, 512});
  hmd.left.tangents = tangents_of(VirtualImage{1.57, 1.19, -1.18, -0.187, 0.0}).value();
  hmd.left.image_distance_m = 1.18;
  hmd.left.eye_relief_m = 0.025;
  hmd.left.lens = Lens(RadialLens{0.1933}, placed_at(0.5), -0.1);
  hmd.right = mirrored(hmd.left);
  return hmd;
}

Vector3 forward_H(const EyeModel& eye) {
  return eye.X_HE.q() * Vector3(0, 0, -1);
}

}  // namespace

TEST_CASE("the default headset: 60 degrees, square pixels, 90 Hz, eyes 62 mm apart") {
  const HmdModel hmd = default_hmd();
  CHECK(fov_horizontal(hmd.left.tangents).degrees() == doctest::Approx(60).epsilon(1e-12));
  CHECK(fov_vertical(hmd.left.tangents).degrees() == doctest::Approx(36).epsilon(0.01));
  const Vector2 s = pixels_per_tangent(hmd.left);
  CHECK(s.x() == doctest::Approx(s.y()).epsilon(1e-12));
  CHECK(hmd.timing.refresh_hz == 90.0);
  CHECK((hmd.right.X_HE.p() - hmd.left.X_HE.p() - Vector3(0.062, 0, 0)).norm() < 1e-15);
  CHECK(hmd.eye(EyeSide::right).side == EyeSide::right);
  // Other sizes keep the pixels square.
  const Vector2 small = pixels_per_tangent(default_hmd({320, 240}).right);
  CHECK(small.x() == doctest::Approx(small.y()).epsilon(1e-12));
}

TEST_CASE("diverged axes turn outward, tilted ones upward, and the left mirrors the right") {
  const Angle phi = degrees(20);
  EyeModel left;
  left.side = EyeSide::left;
  left.X_HE = eye_pose(EyeSide::left, 0.06, phi, degrees(5));
  EyeModel right;
  right.side = EyeSide::right;
  right.X_HE = eye_pose(EyeSide::right, 0.06, phi, degrees(5));
  CHECK(forward_H(left).x() < 0.0);
  CHECK(forward_H(right).x() > 0.0);
  CHECK(forward_H(left).y() == doctest::Approx(std::sin(degrees(5).radians())).epsilon(1e-14));
  CHECK((mirrored(left).X_HE.p() - right.X_HE.p()).norm() < 1e-16);
  CHECK(mirrored(left).X_HE.q().angularDistance(right.X_HE.q()) < 1e-15);
  // Without tilt the angle between the axes is phi, and the quaternion is the one of 7.6 with phi/4.
  const Rigid X_HL = eye_pose(EyeSide::left, 0.06, phi);
  const Rigid X_HR = eye_pose(EyeSide::right, 0.06, phi);
  CHECK(X_HL.q().angularDistance(X_HR.q()) == doctest::Approx(phi.radians()).epsilon(1e-14));
  CHECK(X_HL.q().y() == doctest::Approx(std::sin(phi.radians() / 4)).epsilon(1e-14));
  CHECK(X_HL.q().w() == doctest::Approx(std::cos(phi.radians() / 4)).epsilon(1e-14));
}

TEST_CASE("canting gives the matrix that Valve's runtime reports for an outward turn of 10 degrees") {
  // Pimax 8K X, left eye to head, as published by the tool hmdq.
  Matrix3 R;
  R << 0.984808, 0, 0.173648, 0, 1, 0, -0.173648, 0, 0.984808;
  CHECK((eye_pose(EyeSide::left, 0.06003, degrees(20)).R() - R).cwiseAbs().maxCoeff() < 1e-6);  // six printed digits
}

TEST_CASE("another IPD moves x_cw as figure 7.3 says, and the lens's axis with it") {
  const HmdModel hmd = flight_helmet();
  const HmdModel wide = with_ipd(hmd, 0.072);
  CHECK(wide.ipd_m == 0.072);
  CHECK(wide.left.X_HE.p().x() == doctest::Approx(-0.036).epsilon(1e-15));
  const VirtualImage image = image_of(wide.left.tangents, -1.18);
  CHECK(image.x_cw == doctest::Approx(-0.187 + 0.005).epsilon(1e-12));
  CHECK(image.w_x == doctest::Approx(1.57).epsilon(1e-12));
  CHECK(image_of(wide.right.tangents, -1.18).x_cw == doctest::Approx(0.187 - 0.005).epsilon(1e-12));
  // The axis of the lens stays at its pixel: optics do not move on the panel.
  const auto axis_px = [](const EyeModel& eye) { return pixel_of_tangent(eye, eye.lens.centre()); };
  CHECK((axis_px(wide.left) - axis_px(hmd.left)).norm() < 1e-10);
  // Back again, nothing is left of the change.
  const HmdModel back = with_ipd(wide, 0.062);
  CHECK(back.left.tangents.left == doctest::Approx(hmd.left.tangents.left).epsilon(1e-14));
}

TEST_CASE("a point of the virtual image keeps its pixel for every IPD and eye relief") {
  HmdModel hmd = flight_helmet();
  for (const double divergence_deg : {0.0, 30.0}) {
    for (EyeModel* eye : {&hmd.left, &hmd.right})
      eye->X_HE = eye_pose(eye->side, 0.062, degrees(divergence_deg), degrees(4));
    const Vector3 corner_E(hmd.left.tangents.left * 1.18, hmd.left.tangents.up * 1.18, -1.18);
    const Vector3 corner_H = hmd.left.X_HE * corner_E;
    for (const HmdModel& other : {with_ipd(hmd, 0.075), with_ipd(hmd, 0.05), with_eye_relief(hmd, 0.04)}) {
      // The image hangs in front of the head; the eye has moved, the image has not.
      const Vector2 pixel = project(other.left, other.left.X_HE.inverse() * corner_H).value();
      CHECK((pixel - Vector2(0, 512)).norm() < 1e-10);
    }
  }
}

TEST_CASE("collimated images and optics that follow the eyes keep their field") {
  HmdModel hmd = default_hmd();
  CHECK(with_ipd(hmd, 0.07).left.tangents == hmd.left.tangents);
  HmdModel follows = flight_helmet();
  follows.optics_follow_ipd = true;
  CHECK(with_ipd(follows, 0.07).left.tangents == follows.left.tangents);
  CHECK(with_ipd(follows, 0.07).left.X_HE.p().x() == doctest::Approx(-0.035).epsilon(1e-15));
}

TEST_CASE("a longer eye relief narrows the field") {
  const HmdModel hmd = flight_helmet();
  const HmdModel back = with_eye_relief(hmd, 0.035);
  CHECK(back.left.eye_relief_m == 0.035);
  CHECK(back.left.image_distance_m == doctest::Approx(1.19).epsilon(1e-14));
  CHECK(back.left.tangents.right == doctest::Approx(hmd.left.tangents.right * 1.18 / 1.19).epsilon(1e-14));
  CHECK(back.left.X_HE.p().z() == doctest::Approx(0.01).epsilon(1e-12));
}

TEST_CASE("another resolution keeps the field") {
  const HmdModel hmd = with_resolution(default_hmd(), {640, 480});
  CHECK(hmd.right.resolution == PixelSize{640, 480});
  CHECK(hmd.right.tangents == default_hmd().right.tangents);
}

TEST_CASE("mirroring an eye twice gives it back") {
  EyeModel eye = flight_helmet().left;
  eye.X_HE = eye_pose(EyeSide::left, 0.062, degrees(15), degrees(3));
  eye.lens = Lens(PolynomialLens(std::array<double, 2>{0.2, 0.1}, 1.01), placed_at(0.8, Vector2(0.05, 0.02)), -0.1);
  eye.lens_red = Lens(RadialLens{0.1}, placed_at(0.4, Vector2(0.06, 0.01)));
  const EyeModel other = mirrored(eye);
  CHECK(other.side == EyeSide::right);
  CHECK(other.lens.centre() == Vector2(-0.05, 0.02));
  CHECK(other.lens_red->centre() == Vector2(-0.06, 0.01));
  CHECK_FALSE(other.lens_blue.has_value());
  const EyeModel back = mirrored(other);
  CHECK(back.tangents == eye.tangents);
  CHECK((back.X_HE.p() - eye.X_HE.p()).norm() == 0.0);
  CHECK(back.lens.placement() == eye.lens.placement());
  // A point and its reflection have reflected pixels.
  const Vector3 p_H(0.2, 0.1, -1.5);
  const Vector2 a = project(eye, eye.X_HE.inverse() * p_H).value();
  const Vector2 b = project(other, other.X_HE.inverse() * Vector3(-0.2, 0.1, -1.5)).value();
  CHECK(a.x() + b.x() == doctest::Approx(640).epsilon(1e-12));
  CHECK(a.y() == doctest::Approx(b.y()).epsilon(1e-12));
}

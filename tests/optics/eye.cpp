#include <cmath>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/optics/eye.hpp>

using namespace holdfast;

namespace {

EyeModel make_eye() {
  EyeModel eye;
  eye.tangents = {-0.8, 0.6, -0.5, 0.45};
  eye.resolution = {640, 512};
  return eye;
}

}  // namespace

TEST_CASE("the corners of the field are the corners of the picture, whose origin is at the lower left") {
  const EyeModel eye = make_eye();
  CHECK((project(eye, Vector3(-0.8, -0.5, -1.0)).value() - Vector2(0, 0)).norm() < 1e-12);
  CHECK((project(eye, Vector3(0.6, 0.45, -1.0)).value() - Vector2(640, 512)).norm() < 1e-12);
  CHECK((project(eye, Vector3(-1.6, 0.9, -2.0)).value() - Vector2(0, 512)).norm() < 1e-12);
  // The centre of the first pixel is at half integers: the same place that a rasteriser samples.
  const Vector2 first = tangent_of_pixel(eye, Vector2(0.5, 0.5));
  CHECK(first.x() == doctest::Approx(-0.8 + 0.5 * 1.4 / 640).epsilon(1e-14));
  CHECK(first.y() == doctest::Approx(-0.5 + 0.5 * 0.95 / 512).epsilon(1e-14));
}

TEST_CASE("project agrees with the projection matrix followed by the viewport") {
  for (const bool upside_down : {false, true}) {
    EyeModel eye = make_eye();
    eye.upside_down = upside_down;
    const Matrix4 m = projection_matrix(eye, ClipPlanes{});
    const Vector3 p_E(0.3, -0.2, -1.7);
    const Vector3 ndc = project_to_ndc(m, p_E).value();
    // T_US_N of 7.8.
    const Vector2 viewport((ndc.x() + 1) / 2 * 640, (ndc.y() + 1) / 2 * 512);
    CHECK((project(eye, p_E).value() - viewport).norm() < 1e-10);  // pixels of size 1e3 after a dozen roundings
  }
}

TEST_CASE("ray and pixel are each other's inverse") {
  for (const bool upside_down : {false, true}) {
    EyeModel eye = make_eye();
    eye.upside_down = upside_down;
    for (double x = 0; x <= 640; x += 80) {
      for (double y = 0; y <= 512; y += 64) {
        const Vector3 ray = ray_E(eye, Vector2(x, y));
        CHECK(ray.norm() == doctest::Approx(1.0).epsilon(1e-15));
        CHECK(ray.z() < 0.0);
        CHECK((project(eye, Vector3(ray * 3.0)).value() - Vector2(x, y)).norm() < 1e-11);
      }
    }
  }
}

TEST_CASE("an upside-down panel is a half turn about Z") {
  EyeModel upright = make_eye();
  EyeModel turned = upright;
  turned.upside_down = true;
  const Vector3 p_E(0.3, -0.2, -1.7);
  const Vector2 a = project(upright, p_E).value();
  const Vector2 b = project(turned, p_E).value();
  CHECK((a + b - Vector2(640, 512)).norm() < 1e-11);
  // 000 7.6 composes the turn with the eye's orientation; the matrix does the same.
  Matrix4 half_turn = Matrix4::Identity();
  half_turn(0, 0) = half_turn(1, 1) = -1.0;
  const Matrix4 expected = half_turn * projection_matrix(upright, ClipPlanes{});
  CHECK((projection_matrix(turned, ClipPlanes{}) - expected).cwiseAbs().maxCoeff() < 1e-14);
}

TEST_CASE("points at or behind the eye have no pixel") {
  const EyeModel eye = make_eye();
  CHECK_FALSE(project(eye, Vector3(0, 0, 1)).has_value());
  CHECK_FALSE(project(eye, Vector3(0.1, 0, 0)).has_value());
  CHECK_FALSE(project(eye, Vector3(std::nan(""), 0, -1)).has_value());
  CHECK(is_inside(eye, project(eye, Vector3(0, 0, -1)).value()));
  CHECK_FALSE(is_inside(eye, project(eye, Vector3(-2, 0, -1)).value()));
}

TEST_CASE("the Jacobian of project is that of central differences") {
  EyeModel eye = make_eye();
  for (const bool upside_down : {false, true}) {
    eye.upside_down = upside_down;
    for (const Vector3& p_E : {Vector3(0.3, -0.2, -1.7), Vector3(0, 0, -0.1), Vector3(-30, 20, -50)}) {
      const MatrixOf<double, 2, 3> J = project_jacobian(eye, p_E);
      const double h = 1e-5 * -p_E.z();
      for (int i = 0; i < 3; ++i) {
        const Vector3 step = h * Vector3::Unit(i);
        const Vector2 numeric = (*project(eye, Vector3(p_E + step)) - *project(eye, Vector3(p_E - step))) / (2 * h);
        // Differences of pixels of size 1e3 over h: 1e-13 / 1e-5 relative to the Jacobian's own size.
        CHECK((J.col(i) - numeric).norm() < 1e-7 * J.norm());
      }
    }
  }
}

TEST_CASE("arc minutes per pixel") {
  EyeModel eye;
  eye.tangents = {-1, 1, -1, 1};
  eye.resolution = {1000, 1000};
  // On the axis a square pixel of 0.002 in tangent spans atan(0.002) = 6.8755 arcmin.
  CHECK(arcmin_per_pixel(eye) == doctest::Approx(0.002 * 180 * 60 / std::numbers::pi).epsilon(1e-12));
  CHECK(pixels_per_radian(eye) == doctest::Approx(500).epsilon(1e-12));
  // Off the axis a pixel spans less; its two sides measured by rays agree with the root of the solid angle.
  const Vector2 corner(990, 950);
  const double across = angle_between_pixels(eye, corner - Vector2(0.5, 0), corner + Vector2(0.5, 0)).arcmin();
  const double up = angle_between_pixels(eye, corner - Vector2(0, 0.5), corner + Vector2(0, 0.5)).arcmin();
  CHECK(arcmin_per_pixel(eye, corner) < 0.6 * arcmin_per_pixel(eye));
  CHECK(arcmin_per_pixel(eye, corner) < std::sqrt(across * up));  // the sides are not at right angles there
  CHECK(arcmin_per_pixel(eye, corner) > 0.8 * std::sqrt(across * up));
}

TEST_CASE("the angle between pixels is accurate for tiny and large angles") {
  EyeModel eye;
  eye.tangents = {-1, 1, -1, 1};
  eye.resolution = {1000, 1000};
  CHECK(angle_between_pixels(eye, Vector2(0, 500), Vector2(1000, 500)).degrees() == doctest::Approx(90).epsilon(1e-14));
  // The difference of two rays of length 1 keeps 1e-16 absolute.
  CHECK(angle_between_pixels(eye, Vector2(500, 500), Vector2(500 + 1e-6, 500)).radians() ==
        doctest::Approx(2e-9).epsilon(1e-6));
  CHECK(angle_between_pixels(eye, Vector2(3, 4), Vector2(3, 4)).radians() == 0.0);
}

TEST_CASE("seen, drawn and ideal pixels under each mode") {
  EyeModel eye = make_eye();
  const double r_norm = 0.5;
  eye.lens = Lens(RadialLens{0.1933}, placed_at(r_norm), -0.1);
  const Vector2 ideal(600, 480);
  CHECK((seen_pixel(eye, LensMode::none, ideal).value() - ideal).norm() < 1e-12);
  CHECK((seen_pixel(eye, LensMode::exact, ideal).value() - ideal).norm() < 1e-11);
  // Uncorrected: the tangent grows by 1 + k r^2.
  const Vector2 t = tangent_of_pixel(eye, ideal);
  const Vector2 seen = t * (1 + 0.1933 * t.squaredNorm() / (r_norm * r_norm));
  CHECK((seen_pixel(eye, LensMode::uncorrected, ideal).value() - pixel_of_tangent(eye, seen)).norm() < 1e-10);
  for (const LensMode mode : {LensMode::none, LensMode::exact, LensMode::cubic, LensMode::uncorrected}) {
    const Vector2 s = seen_pixel(eye, mode, ideal).value();
    CHECK((ideal_pixel(eye, mode, s).value() - ideal).norm() < 1e-10);
    const Vector2 d = drawn_pixel(eye, mode, ideal).value();
    CHECK((ideal_pixel_at_panel(eye, mode, d).value() - ideal).norm() < 1e-10);
  }
  // A pincushion lens: predistortion draws nearer to the axis.
  const Vector2 axis = pixel_of_tangent(eye, Vector2::Zero());
  CHECK((drawn_pixel(eye, LensMode::exact, ideal).value() - axis).norm() < (ideal - axis).norm());
}

TEST_CASE("exact correction holds over the whole picture, upside down or not") {
  EyeModel eye = make_eye();
  eye.lens = Lens(RadialLens{0.1933}, placed_at(0.5, Vector2(0.03, -0.02)), -0.1);
  for (const bool upside_down : {false, true}) {
    eye.upside_down = upside_down;
    double worst = 0.0;
    for (double x = 0; x <= 640; x += 20) {
      for (double y = 0; y <= 512; y += 16) {
        const Vector2 ideal(x, y);
        worst = std::max(worst, (seen_pixel(eye, LensMode::exact, ideal).value() - ideal).norm());
      }
    }
    CHECK(worst < 1e-12);  // value 6 of the evaluation asks 1e-6 px
  }
}

TEST_CASE("each colour has its lens, or the common one") {
  EyeModel eye = make_eye();
  eye.lens = Lens(RadialLens{0.2}, placed_at(0.5));
  eye.lens_blue = Lens(RadialLens{0.25}, placed_at(0.5));
  const Vector2 ideal(600, 480);
  const auto seen = [&](Color c) { return seen_pixel(eye, LensMode::uncorrected, ideal, c).value(); };
  CHECK(seen(Color::red) == seen(Color::green));
  CHECK((seen(Color::blue) - seen(Color::green)).norm() > 1.0);
  CHECK((seen_pixel(eye, LensMode::exact, ideal, Color::blue).value() - ideal).norm() < 1e-11);
}

TEST_CASE("the seen field is the panel's edges through the lens") {
  EyeModel eye = make_eye();
  CHECK(seen_field(eye).value() == eye.tangents);
  eye.lens = Lens(RadialLens{0.1933}, placed_at(0.5));
  const FieldTangents seen = seen_field(eye).value();
  CHECK(seen.left == doctest::Approx(-0.8 * (1 + 0.1933 * 2.56)).epsilon(1e-14));
  CHECK(seen.down == doctest::Approx(-0.5 * 1.1933).epsilon(1e-14));
  eye.lens = Lens(RadialLens{-0.2}, placed_at(0.5));  // folds at 0.645, inside the left edge
  CHECK_FALSE(seen_field(eye).has_value());
}

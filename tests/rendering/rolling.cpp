#include <doctest/doctest.h>

#include "pictures.hpp"

using namespace pictures;

TEST_CASE("bands cover a picture without gap or overlap") {
  for (const int height : {1, 7, 720}) {
    for (const int n : {1, 2, 5, 7}) {
      int row = 0, column = 0;
      for (int i = 0; i < n; ++i) {
        const Band rows = band_of({33, height}, ScanDirection::top_to_bottom, n, i);
        CHECK(rows.part == PixelRectangle{0, row, 33, rows.part.top});
        CHECK(rows.middle_px == Vector2(16.5, 0.5 * (row + rows.part.top)));
        row = rows.part.top;
        const Band columns = band_of({height, 33}, ScanDirection::right_to_left, n, i);
        CHECK(columns.part == PixelRectangle{column, 0, columns.part.right, 33});
        CHECK(columns.middle_px == Vector2(0.5 * (column + columns.part.right), 16.5));
        column = columns.part.right;
      }
      CHECK(row == height);
      CHECK(column == height);
    }
  }
}

TEST_CASE("in bands of one pose the picture is the one drawn at once") {
  for (const int samples : {1, 4}) {
    Studio studio(built_backends().front(), default_hmd().left, samples);
    const io::Image whole = studio.draw(studio.eye.X_HE, virtual_style());
    for (const ScanDirection direction : {ScanDirection::top_to_bottom, ScanDirection::left_to_right}) {
      for (const int bands : {1, 7, 90}) {
        studio.target.clear();
        draw_rolling(studio.target, direction, bands, [&](const Band& band) {
          View view = studio.view(studio.eye.X_HE);
          view.part = band.part;
          studio.painter.draw(view, virtual_style());
        });
        const ImageDifference d = compare(studio.target.read_rgba(), whole);
        INFO(describe(d));
        CHECK(d.max == 0);
      }
    }
  }
}

TEST_CASE("a rolling scan-out of 11.1 ms at 100 deg/s tilts the upright edge by 66.6 arcmin") {
  // evaluation.md, value 9. The edge is drawn at the eye's height and turned about the upright axis through the eye.
  EyeModel eye = default_hmd().left;
  eye.X_HE = Rigid();
  RegistrationScene scene = default_registration_scene();
  scene.edge.bottom_W = Vector3(0.0, -1.5, -2.0);
  scene.edge.top_W = Vector3(0.0, 1.5, -2.0);
  Studio studio(built_backends().front(), eye, 1, scene);
  SceneStyle style = disc_measuring_style();
  style.discs = false;
  style.edge = true;
  const DisplayTiming timing{
      .refresh_hz = 90.0, .scan_out = ScanOut::rolling, .scan_duration = std::chrono::microseconds(11100)};
  const double rate = degrees(100.0).radians();
  studio.target.clear();
  draw_rolling(studio.target, timing.scan_direction, 720, [&](const Band& band) {
    const double fraction = line_fraction_of_pixel(timing.scan_direction, band.middle_px, Vector2(1280.0, 720.0));
    const double t = line_seconds_from_middle(timing, fraction);
    View view = studio.view(Rigid::rotation(so3::exp<double>(Vector3(0.0, rate * t, 0.0))));
    view.part = band.part;
    studio.painter.draw(view, style);
  });
  const auto line = picture_edge(look_at(studio.target.read_rgba()), {600, 0, 680, 720});
  REQUIRE(line);
  const Vector2 top(line->x_at(720.0), 360.0), bottom(line->x_at(0.0), 360.0);
  const double tilt = angle_between_pixels(eye, top, bottom).arcmin();
  // 100 deg/s * 11.1 ms = 1.11 deg = 66.6 arcmin over the whole height.
  CHECK(tilt == doctest::Approx(66.6).epsilon(2e-3));
  // Turning to the left, the world slides to the right; the top is scanned first, so the bottom has slid further.
  CHECK(bottom.x() > top.x());
}

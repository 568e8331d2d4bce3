#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/png.hpp>

#include "pictures.hpp"

using namespace pictures;

TEST_CASE("a disc's centroid in the picture is that of its projected ellipse") {
  for (const Backend backend : built_backends()) {
    for (const int samples : {1, 4}) {
      Studio studio(backend, default_hmd().left, samples);
      std::vector<CentroidError> all;
      for (const Rigid& X_WE : wandering_eyes(12, studio.eye.X_HE)) {
        const io::Image image = studio.draw(X_WE, disc_measuring_style());
        const auto errors = centroid_errors(image, studio.eye, X_WE, studio.scene);
        all.insert(all.end(), errors.begin(), errors.end());
      }
      CAPTURE(backend_name(backend));
      CAPTURE(samples);
      REQUIRE(all.size() > 60);
      const double rms = rms_px(all);
      MESSAGE(std::string(backend_name(backend)), ", ", samples, " samples: centroid error ", rms, " px RMS over ",
              all.size(), " discs");
      // evaluation.md, value 5, allows 0.02 px. What is left here is the rounding to 8 bits and the outline's curvature
      // within a pixel; it measured 0.0005.
      CHECK(rms < 0.0015);
      for (const CentroidError& e : all) CHECK(e.area_ratio == doctest::Approx(1.0).epsilon(2e-3));
    }
  }
}

TEST_CASE("small discs too: the radius of 8 px that evaluation.md names as the least") {
  EyeModel eye = default_hmd({600, 338}).left;  // radius 8.3 px
  Studio studio(built_backends().front(), eye);
  std::vector<CentroidError> all;
  for (const Rigid& X_WE : wandering_eyes(20, eye.X_HE)) {
    const auto errors = centroid_errors(studio.draw(X_WE, disc_measuring_style()), eye, X_WE, studio.scene);
    all.insert(all.end(), errors.begin(), errors.end());
  }
  REQUIRE(all.size() > 20);
  MESSAGE("radius of 8 px: centroid error ", rms_px(all), " px RMS over ", all.size(), " discs");
  CHECK(rms_px(all) < 0.006);  // the 8-bit rounding weighs more on fewer rim pixels
}

TEST_CASE("coloured virtual discs and grey real ones are as exact as white ones") {
  Studio studio(built_backends().front());
  for (SceneStyle style : {real_style(), virtual_style()}) {
    style.corner = style.edge = style.board = false;
    std::vector<CentroidError> all;
    for (const Rigid& X_WE : wandering_eyes(6, studio.eye.X_HE)) {
      const auto errors = centroid_errors(studio.draw(X_WE, style), studio.eye, X_WE, studio.scene);
      all.insert(all.end(), errors.begin(), errors.end());
    }
    REQUIRE(all.size() > 30);
    CHECK(rms_px(all) < 0.006);  // fewer grey levels than white has
  }
}

TEST_CASE("an off-centre, upside-down or canted eye draws where project says") {
  std::vector<EyeModel> eyes(3, default_hmd().left);
  eyes[0].tangents = {-0.3, 0.8, -0.5, 0.2};
  eyes[1].tangents = {-0.7, 0.4, -0.35, 0.45};
  eyes[1].upside_down = true;
  eyes[2].X_HE = eye_pose(EyeSide::left, 0.064, degrees(20.0), degrees(-5.0));
  for (const EyeModel& eye : eyes) {
    Studio studio(built_backends().front(), eye);
    std::vector<CentroidError> all;
    for (const Rigid& X_WE : wandering_eyes(6, eye.X_HE)) {
      const auto errors = centroid_errors(studio.draw(X_WE, disc_measuring_style()), eye, X_WE, studio.scene);
      all.insert(all.end(), errors.begin(), errors.end());
    }
    REQUIRE(all.size() > 12);
    CHECK(rms_px(all) < 0.006);  // discs are smaller here
  }
}

TEST_CASE("solid things project like flat ones: the frame corner's bar ends") {
  // A bar's silhouette must contain the projections of its axis and leave out points two widths away.
  Studio studio(built_backends().front());
  SceneStyle style = virtual_style();
  style.discs = style.edge = style.board = false;
  const Rigid X_WE = studio.eye.X_HE;
  const io::Image image = studio.draw(X_WE, style);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vector3 end_W = studio.scene.corner.end_of_axis_W(axis);
    const Vector3 origin_W = studio.scene.corner.X_WF.p();
    const auto inside = project(studio.eye, X_WE.inverse() * Vector3(origin_W + 0.9 * (end_W - origin_W)));
    const auto beyond = project(studio.eye, X_WE.inverse() * Vector3(origin_W + 1.2 * (end_W - origin_W)));
    REQUIRE(inside);
    REQUIRE(beyond);
    const io::Rgba colour = image.at(static_cast<int>(inside->x()), static_cast<int>(inside->y()));
    CHECK(colour[axis] > 60);  // red, green, blue
    CHECK(colour[(axis + 1) % 3] == 0);
    CHECK(image.at(static_cast<int>(beyond->x()), static_cast<int>(beyond->y())) == io::Rgba{0, 0, 0, 255});
  }
}

TEST_CASE("the upright edge lies where it is projected, to a few thousandths of a pixel") {
  Studio studio(built_backends().front());
  SceneStyle style = disc_measuring_style();
  style.discs = false;
  style.edge = true;
  for (const double yaw : {0.0, 0.011, -0.0237}) {
    const Rigid X_WE = Rigid::rotation(so3::exp<double>(Vector3(0.0, yaw, 0.01))) * studio.eye.X_HE;
    const io::Image image = studio.draw(X_WE, style);
    const auto at = [&](double s) { return project(studio.eye, X_WE.inverse() * studio.scene.edge.point_W(s)); };
    const auto low = at(0.42), high = at(0.58);
    REQUIRE(low);
    REQUIRE(high);
    const auto x_true = [&](double y) {
      return low->x() + (y - low->y()) / (high->y() - low->y()) * (high->x() - low->x());
    };
    const int middle = static_cast<int>(x_true(360.0));
    const auto line = picture_edge(look_at(image), {middle - 15, 200, middle + 15, 520});
    REQUIRE(line);
    // 8-bit rounding: half of 1/255 px at most in a row, and all rows may err alike on an upright edge.
    CHECK(std::abs(line->x_at(360.0) - x_true(360.0)) < 0.004);
    CHECK(line->slope == doctest::Approx((high->x() - low->x()) / (high->y() - low->y())).epsilon(1e-4).scale(1.0));
  }
}

TEST_CASE("checkerboard squares lie where they are projected") {
  Studio studio(built_backends().front());
  SceneStyle style = virtual_style();
  style.discs = style.edge = style.corner = false;
  style.board_bright = Vector3::Ones();
  style.board_dark = Vector3(0.2, 0.2, 0.2);
  const Rigid X_WE = Rigid::rotation(so3::exp<double>(Vector3(0.02, 0.1, 0.05))) * studio.eye.X_HE;
  const io::Image image = studio.draw(X_WE, style);
  const Checkerboard& board = studio.scene.board;
  for (int column = 0; column < board.columns; ++column) {
    for (int row = 0; row < board.rows; ++row) {
      const Vector3 p_C(board.square_m * (column + 0.5), board.square_m * (row + 0.5), 0.0);
      const auto pixel = project(studio.eye, X_WE.inverse() * (board.X_WC * p_C));
      REQUIRE(pixel);
      if (!is_inside(studio.eye, *pixel)) continue;
      const int expected = (column + row) % 2 == 0 ? 255 : 51;
      CHECK(image.at(static_cast<int>(pixel->x()), static_cast<int>(pixel->y()))[0] == expected);
    }
  }
  // A corner where four squares meet: half bright, half dark in its pixel's neighbourhood.
  const auto corner =
      project(studio.eye, X_WE.inverse() * (board.X_WC * Vector3(2 * board.square_m, 2 * board.square_m, 0)));
  REQUIRE(corner);
  double sum = 0.0;
  for (int dx = -4; dx < 4; ++dx)
    for (int dy = -4; dy < 4; ++dy)
      sum +=
          image.at(static_cast<int>(std::lround(corner->x())) + dx, static_cast<int>(std::lround(corner->y())) + dy)[0];
  CHECK(sum / 64.0 == doctest::Approx(0.5 * (255 + 51)).epsilon(0.03));
}

TEST_CASE("the depth buffer tells each disc's distance along the optical axis") {
  for (const Backend backend : built_backends()) {
    Studio studio(backend);
    const Rigid X_WE = studio.eye.X_HE;
    static_cast<void>(studio.draw(X_WE, disc_measuring_style()));
    const std::vector<float> depth = studio.target.read_depth();
    int checked = 0;
    for (const Disc& disc : studio.scene.discs) {
      const auto pixel = project(studio.eye, X_WE.inverse() * disc.centre_W);
      if (!pixel || !is_inside(studio.eye, *pixel)) continue;
      const int x = static_cast<int>(pixel->x()), y = static_cast<int>(pixel->y());
      // The plane's distance at the pixel's own centre.
      const Vector3 ray = ray_E(studio.eye, Vector2(x + 0.5, y + 0.5));
      const Vector3 n_E = X_WE.inverse().q() * disc.normal_W;
      const Vector3 c_E = X_WE.inverse() * disc.centre_W;
      const double expected = -(n_E.dot(c_E) / n_E.dot(ray)) * ray.z();
      const double found =
          distance_of_depth(studio.view(X_WE), depth[static_cast<std::size_t>(y * studio.eye.resolution.width + x)]);
      // Single precision of a depth near 1: 6e-8 of z^2 / near = 2 m * 100, about 1e-5 relative.
      CHECK(found == doctest::Approx(expected).epsilon(3e-5));
      ++checked;
    }
    CHECK(checked == 9);
  }
}

TEST_CASE("what lies behind the eye or beside the picture draws nothing") {
  RegistrationScene scene = default_registration_scene();
  scene.discs.clear();
  for (const double z : {0.5, 0.0, 0.01}) {  // behind, through the eye's plane
    Disc disc;
    disc.centre_W = Vector3(0.3, 0.0, z);
    disc.normal_W = Vector3(1.0, 0.0, 0.2).normalized();
    disc.radius_m = 0.2;
    scene.discs.push_back(disc);
  }
  EyeModel eye = default_hmd().left;
  eye.X_HE = Rigid();
  Studio studio(built_backends().front(), eye, 1, scene);
  SceneStyle style = disc_measuring_style();
  CHECK(studio.draw(Rigid(), style) == io::Image(eye.resolution.width, eye.resolution.height));
  // Turned round, they are seen.
  const Rigid turned = Rigid::rotation(so3::exp<double>(Vector3(0.0, -2.6, 0.0)));
  CHECK(!(studio.draw(turned, style) == io::Image(eye.resolution.width, eye.resolution.height)));
}

TEST_CASE("a plane that passes under the eye is cut at its horizon, without stray pixels") {
  RegistrationScene scene = default_registration_scene();
  scene.discs.clear();
  Disc floor;
  floor.centre_W = Vector3(0, -1.0, 0);
  floor.normal_W = Vector3(0, 1, 0);
  floor.radius_m = 3.0;
  scene.discs.push_back(floor);
  EyeModel eye = default_hmd().left;
  Studio studio(built_backends().front(), eye, 1, scene);
  const io::Image image = studio.draw(Rigid(), disc_measuring_style());
  // Its far rim, 3 m away and 1 m down, is seen at a tangent of -1/3; the picture's lower edge is at -0.325: the floor
  // covers nothing in the middle, where its rim is lowest... so look down by 0.3 rad, where the rim is at a known row.
  CHECK(image == io::Image(eye.resolution.width, eye.resolution.height));
  const Rigid down = Rigid::rotation(so3::exp<double>(Vector3(-0.3, 0, 0)));
  const io::Image seen = studio.draw(down, disc_measuring_style());
  const auto rim = project(eye, down.inverse() * Vector3(0, -1, -3));
  REQUIRE(rim);
  const int x = static_cast<int>(rim->x());
  CHECK(seen.at(x, static_cast<int>(rim->y()) - 2)[0] == 255);
  CHECK(seen.at(x, static_cast<int>(rim->y()) + 2)[0] == 0);
  CHECK(seen.at(x, 0)[0] == 255);
  CHECK(seen.at(x, eye.resolution.height - 1)[0] == 0);
}

TEST_CASE("both backends draw the same picture") {
  if (built_backends().size() < 2) return;
  for (const int samples : {1, 4}) {
    Studio a(Backend::osmesa, default_hmd().left, samples);
    Studio b(Backend::egl, default_hmd().left, samples);
    for (const Rigid& X_WE : wandering_eyes(3, a.eye.X_HE)) {
      const ImageDifference d = compare(a.draw(X_WE, virtual_style()), b.draw(X_WE, virtual_style()));
      INFO(describe(d));
      CHECK(d.within(1));
    }
  }
}

TEST_CASE("drawing twice gives the same picture, and creates nothing in OpenGL") {
  Studio studio(built_backends().front(), default_hmd().left, 4);
  const io::Image first = studio.draw(studio.eye.X_HE, real_style());
  const GlFunctions& gl = studio.context->gl();
  // OpenGL hands out names in order: the step from one new buffer to the next tells whether any was made in between.
  const auto next_buffer = [&] {
    GLuint name = 0;
    gl.GenBuffers(1, &name);
    return name;
  };
  const auto next_texture = [&] {
    GLuint name = 0;
    gl.GenTextures(1, &name);
    return name;
  };
  const GLuint buffer = next_buffer(), texture = next_texture();
  for (int i = 0; i < 3; ++i) CHECK(studio.draw(studio.eye.X_HE, real_style()) == first);
  CHECK(next_buffer() == buffer + 1);
  CHECK(next_texture() == texture + 1);
  CHECK(gl.GetError() == GL_NO_ERROR);
}

// Run by the next test in processes of its own: llvmpipe reads its number of threads once.
TEST_CASE("write a picture for the comparison of thread counts" * doctest::skip()) {
  const char* path = std::getenv("HOLDFAST_TEST_PICTURE");
  REQUIRE(path != nullptr);
  Studio studio(built_backends().front(), default_hmd().left, 4);
  io::write_png(path, overlay(studio.draw(studio.eye.X_HE, real_style()), studio.draw(Rigid(), virtual_style())));
}

TEST_CASE("pictures are bit-identical for 0, 1 and 2 threads of the rasteriser") {
  const auto folder = std::filesystem::temp_directory_path() / ("holdfast_test_threads_" + std::to_string(std::rand()));
  std::filesystem::create_directories(folder);
  std::vector<io::Image> images;
  for (const int threads : {0, 1, 2}) {
    const std::string file = (folder / (std::to_string(threads) + ".png")).string();
    const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command = "LP_NUM_THREADS=" + std::to_string(threads) + " HOLDFAST_TEST_PICTURE='" + file +
                                "' '" + self + "' --no-skip --test-case='write a picture for*' > /dev/null";
    REQUIRE(std::system(command.c_str()) == 0);
    images.push_back(io::read_png(file));
  }
  CHECK(describe(compare(images[0], images[1])) == "the pictures are identical");
  CHECK(describe(compare(images[0], images[2])) == "the pictures are identical");
  std::filesystem::remove_all(folder);
}

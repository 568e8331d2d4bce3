#include <numeric>
#include <random>
#include <set>

#include <doctest/doctest.h>

#include <holdfast/geometry/rays_planes.hpp>
#include <holdfast/simulation/hiball_rig.hpp>

using namespace holdfast;

namespace {

double angle_deg(const Vector3& a, const Vector3& b) {
  return radians(std::atan2(a.cross(b).norm(), a.dot(b))).degrees();
}

HiBallOptions all_views() {
  HiBallOptions options;
  options.secondary_views = true;
  return options;
}

}  // namespace

TEST_CASE("ceiling: panels of 32 LEDs with periods of 7.6 and 15.2 cm") {
  const CeilingLayout layout;
  CHECK(layout.panels() == 96);
  CHECK(layout.beacons() == 3072);
  const std::vector<Vector3> places = layout.places_W();
  REQUIRE(places.size() == 3072);
  std::set<long> xs, ys;  // tenths of a millimetre
  for (const Vector3& p : places) {
    xs.insert(std::lround(p.x() * 1e4));
    ys.insert(std::lround(p.y() * 1e4));
    CHECK(p.z() == doctest::Approx(2.75));
  }
  REQUIRE(xs.size() == 64);
  REQUIRE(ys.size() == 48);
  for (auto x = std::next(xs.begin()); x != xs.end(); ++x) CHECK(*x - *std::prev(x) == 762);
  for (auto y = std::next(ys.begin()); y != ys.end(); ++y) CHECK(*y - *std::prev(y) == 1524);
  // The mean is the middle: sums of 3072 numbers err by 1e-13.
  const Vector3 middle = std::accumulate(places.begin(), places.end(), Vector3(Vector3::Zero())) / 3072.0;
  CHECK((middle - Vector3(2.74, 4.27, 2.75)).norm() < 1e-12);
}

TEST_CASE("ceiling: the L-shaped one has 5.5 x 8.5 m, about 3000 LEDs, and no panel in its corner") {
  const CeilingLayout layout = CeilingLayout::l_shaped();
  CHECK(layout.width_m() == doctest::Approx(5.4864));
  CHECK(layout.depth_m() == doctest::Approx(8.5344));
  CHECK(layout.beacons() == 3008);
  std::vector<int> seen(3008, 0);
  int empty = 0;
  for (int j = 0; j < 14 * 4; ++j) {
    for (int i = 0; i < 9 * 8; ++i) {
      const int beacon = layout.beacon_at(i, j);
      CHECK((beacon < 0) == (i >= 5 * 8 && j >= 6 * 4));
      if (beacon < 0) {
        ++empty;
        continue;
      }
      ++seen[static_cast<std::size_t>(beacon)];
      CHECK(beacon / 32 == layout.panel_at(i / 8, j / 4));
    }
  }
  CHECK(empty == 4 * 8 * 32);
  for (const int times : seen) CHECK(times == 1);
  CHECK(layout.beacon_at(-1, 0) == -1);
  CHECK(layout.beacon_at(0, 14 * 4) == -1);
  CHECK(layout.beacon_at(9 * 8, 0) == -1);
}

TEST_CASE("ceiling: a panel's beacons lie in its own square") {
  const CeilingLayout layout = CeilingLayout::l_shaped();
  const std::vector<Vector3> places = layout.places_W();
  for (int panel = 0; panel < layout.panels(); ++panel) {
    Vector3 low = places[static_cast<std::size_t>(panel * 32)], high = low;
    for (int k = 0; k < 32; ++k) {
      low = low.cwiseMin(places[static_cast<std::size_t>(panel * 32 + k)]);
      high = high.cwiseMax(places[static_cast<std::size_t>(panel * 32 + k)]);
    }
    CHECK((high - low - Vector3(7 * 0.0762, 3 * 0.1524, 0)).norm() < 1e-12);
  }
}

TEST_CASE("ceiling: any direction may be up") {
  CeilingLayout layout;
  layout.X_WL = ceiling_pose(Vector3(0, 2.75, 0), Vector3(0, 3, 0));
  CHECK((layout.beacon_axis_W() - Vector3(0, -1, 0)).norm() < 1e-15);
  for (const Vector3& p : layout.places_W()) CHECK(p.y() == doctest::Approx(2.75));
}

TEST_CASE("ceiling: what cannot be built is named") {
  CeilingLayout layout;
  CHECK_FALSE(layout.problem());
  layout.cut_columns = layout.columns, layout.cut_rows = layout.rows;
  CHECK(layout.problem() == "the corner that is cut out leaves no panel");
  layout.cut_rows = -1;
  CHECK(layout.problem() == "the corner that is cut out has a negative size");
  layout.columns = 0;
  CHECK(layout.problem() == "a ceiling has 1 to 1000 panels each way");
}

TEST_CASE("HiBall: six primary views, the five 57 deg from the top one and 59.1 deg from each other") {
  const std::vector<HiBallCamera> cameras = hiball_cameras({});
  REQUIRE(cameras.size() == 6);
  CHECK((cameras[0].axis_B - Vector3::UnitZ()).norm() < 1e-15);
  // Spherical law of cosines for two sides of 57 deg and 72 deg between them.
  const double c = std::cos(degrees(57.0).radians()), s2 = 1 - c * c;
  const double neighbours = std::acos(c * c + s2 * std::cos(degrees(72.0).radians()));
  CHECK(radians(neighbours).degrees() == doctest::Approx(59.07).epsilon(1e-4));
  for (std::size_t k = 1; k < 6; ++k) {
    CHECK(cameras[k].is_primary());
    CHECK(angle_deg(cameras[0].axis_B, cameras[k].axis_B) == doctest::Approx(57.0));
    CHECK(angle_deg(cameras[k].axis_B, cameras[k % 5 + 1].axis_B) == doctest::Approx(radians(neighbours).degrees()));
  }
}

TEST_CASE("HiBall: the dodecahedral spacing is the one angle that six axes can all have with each other") {
  HiBallOptions options;
  options.spacing = dodecahedral_spacing;
  CHECK(options.spacing.degrees() == doctest::Approx(63.4349).epsilon(1e-6));
  const std::vector<HiBallCamera> cameras = hiball_cameras(options);
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      CHECK(std::abs(cameras[a].axis_B.dot(cameras[b].axis_B)) == doctest::Approx(1 / std::sqrt(5.0)));
    }
  }
}

TEST_CASE("HiBall: 26 views, five secondary ones through the top lens and three through each other") {
  const std::vector<HiBallCamera> cameras = hiball_cameras(all_views());
  REQUIRE(cameras.size() == 26);
  std::array<int, 6> through{}, on{};
  std::set<std::pair<int, int>> pairs;
  for (const HiBallCamera& camera : cameras) {
    pairs.emplace(camera.lens, camera.photodiode);
    if (camera.is_primary()) continue;
    ++through[static_cast<std::size_t>(camera.lens)];
    ++on[static_cast<std::size_t>(camera.photodiode)];
    // Half-way between two primary views.
    const double to_lens = angle_deg(camera.axis_B, cameras[static_cast<std::size_t>(camera.lens)].axis_B);
    CHECK(to_lens ==
          doctest::Approx(angle_deg(camera.axis_B, cameras[static_cast<std::size_t>(camera.photodiode)].axis_B)));
    CHECK(to_lens == doctest::Approx(camera.lens * camera.photodiode == 0 ? 28.5 : 29.53).epsilon(1e-3));
  }
  CHECK(pairs.size() == 26);
  CHECK(through == std::array<int, 6>{5, 3, 3, 3, 3, 3});
  CHECK(on == through);
}

TEST_CASE("HiBall: a field is less than six degrees wide, and (u, v) counts from the photodiode's middle") {
  for (const HiBallCamera& camera : hiball_cameras(all_views())) {
    const double half = camera.half_side_m;
    const std::array<Vector2, 4> corners{Vector2(-half, -half), Vector2(half, -half), Vector2(half, half),
                                         Vector2(-half, half)};
    // Sizes are millimetres: 1e-15 is rounding.
    CHECK(camera.view.project(camera.centre_B + 2.0 * camera.axis_B)->norm() < 1e-15);
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector2 uv = *camera.view.project(camera.centre_B + 50.0 * camera.corners_B[k]);
      CHECK((uv - corners[k]).norm() < 1e-15);
    }
    if (!camera.is_primary()) continue;
    const Vector3 left = camera.corners_B[0] + camera.corners_B[3], right = camera.corners_B[1] + camera.corners_B[2];
    CHECK(angle_deg(left, right) == doctest::Approx(2 * radians(std::atan(2.0 / 39.0)).degrees()));
    CHECK(angle_deg(left, right) < 6.0);
    CHECK(angle_deg(left, right) > 5.8);
  }
}

TEST_CASE("HiBall: the image is where light through the lens meets the photodiode") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  const std::vector<HiBallCamera> cameras = hiball_cameras(all_views());
  for (const HiBallCamera& camera : cameras) {
    const Vector3 lens_axis = cameras[static_cast<std::size_t>(camera.lens)].axis_B;
    const Vector3 diode_axis = cameras[static_cast<std::size_t>(camera.photodiode)].axis_B;
    const Vector3 lens = 0.0195 * lens_axis, middle = -0.0195 * diode_axis;
    for (int trial = 0; trial < 20; ++trial) {
      const Vector3 beacon = lens + 2.0 * (camera.axis_B + 0.04 * Vector3(share(random), share(random), share(random)));
      const Vector3 hit = *intersection(*Ray::make(lens, lens - beacon), *Plane::make(diode_axis, middle));
      const Vector2 uv = *camera.view.project(beacon);
      // Light falls upside down: the spot's distance from the middle is the image's, and a pinhole's spots of the corner
      // rays are the corners; 1e-15 is rounding.
      CHECK(std::abs((hit - middle).norm() - uv.norm()) < 1e-15);
    }
  }
}

TEST_CASE("HiBall: a turn by 72 deg takes each tilted view to the next") {
  const std::vector<HiBallCamera> cameras = hiball_cameras({});
  const Quaternion turn = so3::exp<double>(Vector3(0, 0, degrees(72.0).radians()));
  for (std::size_t k = 1; k < 6; ++k) {
    const Vector3 p = cameras[k].centre_B + 1.7 * (cameras[k].axis_B + Vector3(0.01, 0.02, -0.01));
    CHECK((*cameras[k].view.project(p) - *cameras[k % 5 + 1].view.project(turn * p)).norm() < 1e-15);
  }
}

TEST_CASE("rig: true beacons are 1 mm off along each axis, 1.7 mm RMS, by the seed") {
  const HiBallRig rig = hiball_rig();
  REQUIRE(rig.beacons_W.size() == 3072);
  double sum = 0.0;
  Vector3 mean = Vector3::Zero();
  Matrix3 products = Matrix3::Zero();
  for (std::size_t k = 0; k < 3072; ++k) {
    const Vector3 off = (rig.beacons_W[k] - rig.nominal_beacons_W[k]) / 0.001;
    sum += off.squaredNorm();
    mean += off;
    products += off * off.transpose();
  }
  // Chi-square with 9216 degrees of freedom: within four standard deviations, sqrt(2 * 9216).
  CHECK(std::abs(sum - 9216.0) < 4 * std::sqrt(2 * 9216.0));
  CHECK(std::sqrt(sum / 3072.0) == doctest::Approx(1.732).epsilon(0.03));
  CHECK(mean.cwiseAbs().maxCoeff() < 4 * std::sqrt(3072.0));
  products.diagonal().setZero();
  CHECK(products.cwiseAbs().maxCoeff() < 4 * std::sqrt(3072.0));

  HiBallOptions other;
  CHECK(hiball_rig(other).beacons_W == rig.beacons_W);
  other.seed = 2;
  CHECK(hiball_rig(other).beacons_W[5] != rig.beacons_W[5]);
  other.beacon_error_m = 0.0;
  CHECK(hiball_rig(other).beacons_W == rig.nominal_beacons_W);
}

TEST_CASE("rig: a panel moves with its 32 beacons and no other") {
  HiBallRig rig = hiball_rig();
  const std::vector<Vector3> before = rig.beacons_W;
  move_panel(rig, 7, Vector3(0.01, 0.02, -0.03));
  for (std::size_t k = 0; k < before.size(); ++k) {
    const Vector3 expected = rig.panel_of(static_cast<int>(k)) == 7 ? Vector3(0.01, 0.02, -0.03) : Vector3(0, 0, 0);
    CHECK((rig.beacons_W[k] - before[k] - expected).norm() < 1e-15);
  }
}

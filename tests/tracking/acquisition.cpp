#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/tracking/acquisition.hpp>

#include "camera_ball.hpp"

using namespace holdfast;

namespace {

using test::Ball;
using test::pi;

struct Scene {
  Rigid X_WB;
  std::vector<UnplacedSighting> sightings;
  std::vector<const CameraView*> all;                 // cameras, for ambiguous sightings
  std::vector<std::array<const CameraView*, 1>> own;  // each sighting's own
};

/// `count` beacons on a ceiling 2.5 m up, each seen by a camera of a ball that leans at most half a radian.
Scene look_at_ceiling(const Ball& ball, std::mt19937& random, std::size_t count) {
  std::normal_distribution<double> normal(0.0, 1.0);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Scene scene;
  const Quaternion heading = so3::exp<double>(Vector3(0.0, pi * unit(random), 0.0));
  const Quaternion tilt = so3::exp<double>(Vector3(0.2 * unit(random), 0.0, 0.2 * unit(random)));
  scene.X_WB = Rigid(heading * tilt, Vector3(4.0 * unit(random), 1.0 + 0.3 * unit(random), 4.0 * unit(random)));
  scene.own.reserve(count);
  for (std::size_t i = 0; scene.sightings.size() < count; ++i) {
    const std::size_t k = i % ball.views.size();
    const Vector3 direction_C(0.05 * unit(random), 0.05 * unit(random), -1.0);
    const Rigid X_WC = scene.X_WB * ball.X_BC[k];
    const Vector3 direction_W = X_WC.q() * direction_C;
    const double distance = (2.75 - X_WC.p().y()) / direction_W.y();
    if (!(distance > 0.0 && distance < 8.0)) continue;
    const Vector3 beacon = X_WC.p() + distance * direction_W;
    const auto uv = ball.views[k].project(scene.X_WB.inverse() * beacon);
    REQUIRE(uv);
    scene.own.push_back({&ball.views[k]});
    UnplacedSighting sighting;
    sighting.uv = *uv + 1e-6 * Vector2(normal(random), normal(random));
    sighting.variance = 1e-12;
    sighting.beacon_W = beacon + 1e-3 * Vector3(normal(random), normal(random), normal(random));
    sighting.beacon_variance = 1e-6;
    scene.sightings.push_back(sighting);
  }
  for (std::size_t i = 0; i < count; ++i) scene.sightings[i].cameras = scene.own[i];
  for (const CameraView& view : ball.views) scene.all.push_back(&view);
  return scene;
}

// Beacons a millimetre off, seen 2 m away by some dozen sightings.
bool is_right(const Acquisition& found, const Rigid& X_WB) {
  return found.ok() && (found.X_WB.p() - X_WB.p()).norm() < 0.01 &&
         so3::angle_between(found.X_WB.q(), X_WB.q()) < 0.005;
}

}  // namespace

TEST_CASE("acquisition finds a ball of cameras anywhere under the ceiling, whatever its heading") {
  const Ball ball;
  std::mt19937 random(5);
  int right = 0;
  int wrong = 0;
  double normalised = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    const Scene scene = look_at_ceiling(ball, random, 12);
    const Acquisition found = acquire(scene.sightings);
    right += is_right(found, scene.X_WB);
    wrong += found.ok() && !is_right(found, scene.X_WB);
    if (!found.ok()) continue;
    Vector6 d;
    d.head<3>() = scene.X_WB.p() - found.X_WB.p();
    d.tail<3>() = so3::log<double>(found.X_WB.q().conjugate() * scene.X_WB.q());
    normalised += d.dot(found.covariance.inverse() * d);
  }
  CHECK(right >= 196);
  CHECK(wrong == 0);
  // Six numbers' chi-square; it is below 6 where the covariance was enlarged.
  CHECK(normalised / right > 3.0);
  CHECK(normalised / right < 8.0);
}

TEST_CASE("acquisition outvotes a quarter of wrong identifications and names those") {
  const Ball ball;
  std::mt19937 random(6);
  std::uniform_real_distribution<double> shift(-1.0, 1.0);
  int right = 0;
  for (int trial = 0; trial < 100; ++trial) {
    Scene scene = look_at_ceiling(ball, random, 16);
    for (std::size_t i = 0; i < 4; ++i) {
      scene.sightings[4 * i].beacon_W += Vector3(shift(random) > 0 ? 0.5 : -0.6, 0.0, 0.3 * shift(random));
    }
    const Acquisition found = acquire(scene.sightings);
    if (!is_right(found, scene.X_WB)) continue;
    ++right;
    for (std::size_t i = 0; i < 4; ++i) CHECK(found.camera_index[4 * i] == -1);
  }
  CHECK(right >= 95);
}

TEST_CASE("acquisition tells through which lens each beacon was seen") {
  const Ball ball;
  std::mt19937 random(7);
  int right = 0;
  for (int trial = 0; trial < 20; ++trial) {
    Scene scene = look_at_ceiling(ball, random, 12);
    for (UnplacedSighting& sighting : scene.sightings) sighting.cameras = scene.all;
    const Acquisition found = acquire(scene.sightings);
    if (!is_right(found, scene.X_WB)) continue;
    ++right;
    for (std::size_t i = 0; i < scene.sightings.size(); ++i) {
      CHECK(scene.all[static_cast<std::size_t>(found.camera_index[i])] == scene.own[i][0]);
    }
  }
  CHECK(right >= 19);
}

TEST_CASE("acquisition says why it has no pose") {
  const Ball ball;
  std::mt19937 random(8);
  Scene scene = look_at_ceiling(ball, random, 12);
  CHECK(acquire(std::span(scene.sightings).first(5)).status == AcquisitionStatus::too_few);
  CHECK(acquire({}).status == AcquisitionStatus::too_few);

  std::uniform_real_distribution<double> anywhere(-5.0, 5.0);
  Scene nonsense = scene;
  for (UnplacedSighting& s : nonsense.sightings) s.beacon_W = Vector3(anywhere(random), 2.75, anywhere(random));
  CHECK(acquire(nonsense.sightings).status == AcquisitionStatus::no_pose);
  for (UnplacedSighting& s : nonsense.sightings) s.uv.x() = std::nan("");
  CHECK(acquire(nonsense.sightings).status == AcquisitionStatus::no_pose);

  // Two beacons seen again and again leave a circle of poses; nothing is made up.
  Scene two = scene;
  for (std::size_t i = 2; i < two.sightings.size(); ++i) two.sightings[i] = two.sightings[i % 2];
  CHECK_FALSE(acquire(two.sightings).ok());
}

TEST_CASE("acquisition does not depend on the world's directions") {
  const Ball ball;
  std::mt19937 random(9);
  Scene scene = look_at_ceiling(ball, random, 12);
  const Acquisition here = acquire(scene.sightings);
  const Rigid X_VW(so3::exp<double>(Vector3(1.0, -2.0, 0.5)), Vector3(3.0, 1.0, -2.0));
  for (UnplacedSighting& s : scene.sightings) s.beacon_W = X_VW * s.beacon_W;
  const Acquisition turned = acquire(scene.sightings);
  REQUIRE(here.ok());
  REQUIRE(turned.ok());
  const Rigid expected = X_VW * here.X_WB;
  CHECK((turned.X_WB.p() - expected.p()).norm() < 1e-6);  // both stop where steps are below 1e-9
  CHECK(so3::angle_between(turned.X_WB.q(), expected.q()) < 1e-6);
}

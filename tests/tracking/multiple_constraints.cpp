#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <doctest/doctest.h>

#include <holdfast/tracking/collinearity.hpp>
#include <holdfast/tracking/device_table.hpp>
#include <holdfast/tracking/innovation.hpp>
#include <holdfast/tracking/mcaat_filter.hpp>

#include "camera_ball.hpp"

using namespace holdfast;
using test::Ball;

namespace {

struct Seen {
  CameraSighting sighting;
  int beacon;
};

/// A still ball under beacons of a millimetre's deviation that are believed to be elsewhere by so much.
struct Still {
  Ball ball;
  Rigid X_WB{so3::exp<double>(Vector3(0.1, 0.7, -0.05)), Vector3(0.3, 1.2, -0.4)};
  std::vector<Vector3> truth;
  DeviceTable<3> believed{{.initial_variance = Vector3::Constant(1e-6),
                           .wander = Vector3::Constant(1e-10),
                           .residual_variance = Vector3::Constant(1e-7)}};
  std::vector<Seen> seen;

  [[nodiscard]] double beacon_error() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < truth.size(); ++i) sum += (believed.at(static_cast<int>(i)).x - truth[i]).squaredNorm();
    return sum;
  }

  explicit Still(std::size_t count, double beacon_deviation_m = 1e-3) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal(0.0, 1.0);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t k = i % ball.views.size();
      const Rigid X_WC = X_WB * ball.X_BC[k];
      truth.push_back(X_WC * Vector3(Vector3(0.05 * unit(random), 0.05 * unit(random), -1.0) * 2.0));
      believed.add(truth.back() + beacon_deviation_m * Vector3(normal(random), normal(random), normal(random)));
      const Vector2 noise = 1e-6 * Vector2(normal(random), normal(random));
      seen.push_back({{*ball.views[k].project(X_WB.inverse() * truth.back()) + noise, &ball.views[k], 1e-12},
                      static_cast<int>(i)});
    }
  }
};

TargetState<2> start_near(const Rigid& X_WB) {
  TargetState<2> state;
  state.X_WB =
      Rigid(X_WB.q() * so3::exp<double>(Vector3(0.002, -0.001, 0.001)), X_WB.p() + Vector3(0.002, 0.001, -0.003));
  state.P *= 1e-5;
  return state;
}

ProcessModel<2> calm() {
  ProcessModel<2> model;
  model.intensity.setConstant(1e-3);
  return model;
}

}  // namespace

TEST_CASE("MCAAT with one measurement at a time is SCAAT") {
  Still world(60);
  DeviceTable<3> beacons = world.believed;
  TargetState<2> scaat = start_near(world.X_WB);
  McaatFilter<2, CameraSighting> mcaat(scaat, calm(), {.size = 1});
  for (std::size_t i = 0; i < world.seen.size(); ++i) {
    const HostTime t = time_at(0.001 * static_cast<double>(i));
    advance(scaat, calm(), t);
    DeviceEstimate<3> beacon = beacons.for_sighting(world.seen[i].beacon);
    const auto innovation = extended_innovation(scaat, world.seen[i].sighting, beacon);
    REQUIRE(innovation);
    NoDevice none;
    correct(scaat, *innovation, beacon, none);
    beacons.store(world.seen[i].beacon, beacon);
    REQUIRE(mcaat.add(t, world.seen[i].sighting, world.seen[i].beacon, world.believed) == McaatStatus::updated);
  }
  // The same equations in another order of summing.
  CHECK(scaat.error_of(mcaat.state()).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((scaat.P - mcaat.state().P).cwiseAbs().maxCoeff() < 1e-12);
  for (std::size_t i = 0; i < world.truth.size(); ++i) {
    const int beacon = static_cast<int>(i);
    CHECK((beacons.at(beacon).x - world.believed.at(beacon).x).norm() < 1e-12);
    CHECK((beacons.at(beacon).P - world.believed.at(beacon).P).cwiseAbs().maxCoeff() < 1e-15);
  }
}

TEST_CASE("MCAAT of a still target brings pose and beacons nearer to the truth") {
  for (const WindowShape shape : {WindowShape{3, false}, WindowShape{10, false}, WindowShape{10, true}}) {
    CAPTURE(shape.size);
    CAPTURE(shape.moving);
    Still world(600);
    McaatFilter<2, CameraSighting> filter(start_near(world.X_WB), calm(), shape);
    const double before = world.beacon_error();
    int updates = 0;
    for (std::size_t i = 0; i < world.seen.size(); ++i) {
      updates += filter.add(time_at(0.001 * static_cast<double>(i)), world.seen[i].sighting, world.seen[i].beacon,
                            world.believed) == McaatStatus::updated;
    }
    CHECK(updates == (shape.moving ? 600 - shape.size + 1 : 600 / shape.size));
    CHECK(world.beacon_error() < before);
    // Beacons a millimetre off, from one place: the pose and what is learnt of them move together a little.
    CHECK((filter.state().X_WB.p() - world.X_WB.p()).norm() < 1.5e-3);
    CHECK(so3::angle_between(filter.state().X_WB.q(), world.X_WB.q()) < 1e-3);
    CHECK(Eigen::LLT<Matrix12>(filter.state().P).info() == Eigen::Success);  // positive definite
  }
}

TEST_CASE("MCAAT says when nothing could be done") {
  Still world(10);
  McaatFilter<2, CameraSighting> filter(start_near(world.X_WB), calm(), {.size = 2});
  CHECK(filter.add(time_at(0.001), world.seen[0].sighting, 0, world.believed) == McaatStatus::collecting);
  CHECK(filter.add(time_at(-1.0), world.seen[1].sighting, 1, world.believed) == McaatStatus::time_backwards);
  Still behind(10);
  for (int i = 0; i < behind.believed.size(); ++i) {
    DeviceEstimate<3> beacon = behind.believed.at(i);
    beacon.x = 2.0 * behind.X_WB.p() - beacon.x;
    behind.believed.store(i, beacon);
  }
  McaatFilter<2, CameraSighting> blind(start_near(world.X_WB), calm(), {.size = 1});
  CHECK(blind.add(time_at(0.001), behind.seen[0].sighting, 0, behind.believed) == McaatStatus::nothing_seen);
  CHECK(blind.state().error_of(start_near(world.X_WB)).norm() == 0.0);
}

TEST_CASE("collinearity: exact sightings of a still target give its pose, fixed and moving") {
  Still world(40, 0.0);
  for (const bool moving : {false, true}) {
    CollinearityTracker tracker(start_near(world.X_WB).X_WB, {10, moving});
    int estimates = 0;
    for (const Seen& seen : world.seen) {
      const std::optional<Resection> found =
          tracker.add({seen.sighting, world.truth[static_cast<std::size_t>(seen.beacon)], 0.0});
      if (!found) continue;
      ++estimates;
      CHECK(found->ok());
    }
    CHECK(estimates == (moving ? 31 : 4));
    // A micrometre's noise at 37 mm: 54 micrometres at 2 m, of one sighting along one direction.
    CHECK((tracker.X_WB().p() - world.X_WB.p()).norm() < 3e-4);
    CHECK(so3::angle_between(tracker.X_WB().q(), world.X_WB.q()) < 1e-4);
  }
}

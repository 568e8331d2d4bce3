#include <cstdio>
#include <filesystem>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/io/trajectory.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/simulation/simulation.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

const std::filesystem::path recordings = HOLDFAST_RECORDINGS;

std::vector<TimedPose> walk() {
  return sample(*make_walk_around(3, 10s), 10ms);
}

}  // namespace

TEST_CASE("placement: a level head that looks along -Z stands below the ceiling, upright and unturned") {
  const std::vector<TimedPose> samples(3, TimedPose{time_at(0.0), Rigid::translation(Vector3(5, 6, 7))});
  const std::vector<TimedPose> placed = place_under_ceiling(samples);
  REQUIRE(placed.size() == 3);
  CHECK((placed[1].X_WB.p() - Vector3(2.74, 4.27, 1.45)).norm() < 1e-12);
  // B: x right, y forward, z up; W: the recording's -Z has become +y.
  CHECK(so3::angle_between<double>(placed[1].X_WB.q(), Quaternion::Identity()) < 1e-12);
}

TEST_CASE("placement: moves and turns the motion as a whole") {
  const std::vector<TimedPose> samples = walk();
  CeilingPlacement placement;
  placement.X_DB = Rigid(so3::exp<double>(Vector3(-1.5, 0.1, 0.2)), Vector3(0.0, 0.1, 0.02));
  for (const bool mounted : {false, true}) {
    CeilingPlacement used = placement;
    if (!mounted) used.X_DB.reset();
    const std::vector<TimedPose> placed = place_under_ceiling(samples, used);
    const Rigid X_DB = mounted ? *placement.X_DB : upright_mount(samples, placement.up_R);
    Vector3 mean = Vector3::Zero(), up_B = Vector3::Zero();
    double lowest = 1e9, highest = -1e9;
    for (std::size_t k = 0; k < placed.size(); ++k) {
      CHECK(placed[k].t == samples[k].t);
      mean += placed[k].X_WB.p() / static_cast<double>(placed.size());
      up_B += placed[k].X_WB.q().conjugate() * Vector3(Vector3::UnitZ());
      lowest = std::min(lowest, placed[k].X_WB.p().z());
      highest = std::max(highest, placed[k].X_WB.p().z());
      // Rigidly: the movement since the first sample, seen from the HiBall, is the recording's seen from its device.
      const Rigid moved_B = placed[0].X_WB.inverse() * placed[k].X_WB;
      const Rigid moved_D = samples[0].X_WB.inverse() * samples[k].X_WB;
      const Rigid difference = moved_B.inverse() * (X_DB.inverse() * moved_D * X_DB);
      CHECK(difference.p().norm() < 1e-12);
      CHECK(so3::log<double>(difference.q()).norm() < 1e-12);
    }
    CHECK((mean - Vector3(2.74, 4.27, 1.45)).norm() < 1e-12);
    CHECK(highest - lowest < 0.3);  // heights stay heights: the walk bobs, and leans by its mount
    if (!mounted) CHECK(up_B.normalized().z() == doctest::Approx(1.0));  // looks up on average
  }
}

TEST_CASE("placement: up may be anything on both sides") {
  CeilingPlacement placement;
  placement.up_R = Vector3(0, 0, 2);
  placement.up_W = Vector3(0, 1, 0);
  std::vector<TimedPose> samples(2);
  samples[1] = {time_at(1.0), Rigid::translation(Vector3(0, 0, 0.5))};  // rises
  const std::vector<TimedPose> placed = place_under_ceiling(samples, placement);
  CHECK((placed[1].X_WB.p() - placed[0].X_WB.p() - Vector3(0, 0.5, 0)).norm() < 1e-15);
  CHECK((placed[0].X_WB.q() * Vector3::UnitZ() - Vector3::UnitY()).norm() < 1e-15);
}

TEST_CASE("truth: slow motion passes, shaking above the cut-off does not, and nothing comes late") {
  std::vector<TimedPose> samples;
  const auto slow = [](double t) { return 0.1 * std::sin(2 * std::numbers::pi * 0.5 * t); };
  for (int k = 0; k <= 1200; ++k) {
    const double t = k / 120.0, shake = 0.01 * std::sin(2 * std::numbers::pi * 30.0 * t);
    samples.push_back({time_at(t), Rigid::translation(Vector3(slow(t) + shake, 0, 0))});
  }
  const SplineTrajectory truth = hiball_truth(samples);
  for (double t = 2.0; t < 8.0; t += 0.0137) {
    // At 30 Hz the gain is below (5/30)^4 = 8e-4 of 10 mm; at 0.5 Hz it differs from 1 by 0.4 * (0.5/5)^4 = 4e-5 of 0.1 m.
    CHECK(std::abs(truth.at(time_at(t)).X_WB.p().x() - slow(t)) < 1.5e-5);
  }
}

TEST_CASE("still HiBall: does not move, and stands where 002's did") {
  const SplineTrajectory still = still_hiball(600s);
  CHECK(still.duration() == 600s);
  for (const double t : {0.0, 1.0, 333.3, 600.0}) {
    const MotionState state = still.at(time_at(t));
    CHECK((state.X_WB.p() - Vector3(2.74, 4.27, 1.60)).norm() < 1e-14);  // rounding
    CHECK(state.v_WB.norm() + state.w_WB_B.norm() == 0.0);
  }
}

TEST_CASE("what the views see along recordings: beacons, blind views, and never fewer than three views") {
  struct Recording {
    const char* name;
    Vector3 up_R;
  };
  const Recording head{"head/optitrack_head_120hz.tum", Vector3::UnitY()};
  const Recording handheld{"handheld/table_04.txt", Vector3::UnitZ()};
  if (!std::filesystem::exists(recordings / head.name)) {
    MESSAGE("skipped: no recordings at " << recordings.string());
    return;
  }
  for (const Recording& recording : {head, handheld}) {
    CeilingPlacement placement;
    placement.up_R = recording.up_R;
    const std::vector<TimedPose> samples = io::read_trajectory(recordings / recording.name).samples;
    const SplineTrajectory truth = hiball_truth(place_under_ceiling(samples, placement));
    const HiBallSimulator simulator(hiball_rig(), truth);
    std::array<double, 6> beacons{}, blind{};
    Vector3 low = Vector3::Constant(1e9), high = -low, speed = Vector3::Zero(), fastest = speed;
    std::array<int, 7> with_views{};
    std::vector<int> visible;
    int n = 0;
    for (HostTime t = truth.begin(); t <= truth.end(); t += 100ms, ++n) {
      const MotionState state = truth.at(t);
      low = low.cwiseMin(state.X_WB.p());
      high = high.cwiseMax(state.X_WB.p());
      speed += state.v_WB.cwiseAbs();
      fastest = fastest.cwiseMax(state.v_WB.cwiseAbs());
      std::size_t views = 0;
      for (std::size_t camera = 0; camera < 6; ++camera) {
        simulator.visible(state.X_WB, static_cast<int>(camera), visible);
        beacons[camera] += static_cast<double>(visible.size());
        blind[camera] += visible.empty();
        views += !visible.empty();
      }
      ++with_views[views];
    }
    std::printf("%s\n", recording.name);
    for (int axis = 0; axis < 3; ++axis) {
      std::printf("  %c: %.2f to %.2f m, mean speed %.3f, peak %.2f m/s\n", "xyz"[axis], low[axis], high[axis],
                  speed[axis] / n, fastest[axis]);
    }
    std::printf("  beacons seen by each view:");
    for (const double sum : beacons) std::printf(" %.1f", sum / n);
    std::printf("\n  share of time without any:");
    for (const double sum : blind) std::printf(" %.3f", sum / n);
    std::printf("\n  share of time with 0 to 6 seeing views:");
    for (const int count : with_views) std::printf(" %.3f", static_cast<double>(count) / n);
    std::printf("\n");
    // The top view's field, 13 cm wide at the height of a head, holds 32 LEDs per 0.37 square metres: 1.5 of them.
    CHECK(beacons[0] / n > 1.2);
    CHECK(beacons[0] / n < 2.0);
    CHECK(with_views[0] + with_views[1] + with_views[2] <= n / 100);
  }
}

TEST_CASE("the page's example") {
  const auto walking = make_walk_around(1, std::chrono::seconds(10));
  const SplineTrajectory truth = hiball_truth(place_under_ceiling(sample(*walking, std::chrono::milliseconds(10))));
  const HiBallSimulator simulator(hiball_rig(), truth);
  std::vector<BeaconSighting> sightings = sighting_stream(simulator);  // 1000 a second

  misidentify(sightings, simulator, 0.05, 1);  // one in twenty names a wrong LED
  block_cameras(sightings, {truth.begin() + std::chrono::seconds(4), truth.begin() + std::chrono::seconds(6)});

  CHECK(sightings.size() == 8001);
}

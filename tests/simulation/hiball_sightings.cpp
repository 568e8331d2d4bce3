#include <map>
#include <random>
#include <set>

#include <doctest/doctest.h>

#include <holdfast/simulation/ceiling_motion.hpp>
#include <holdfast/simulation/nearest_beacon.hpp>
#include <holdfast/simulation/sighting_stream.hpp>
#include <holdfast/tracking/camera_sighting.hpp>

#include "allocation_counter.hpp"

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

Vector3 random_vector(std::mt19937_64& random, double sigma) {
  std::normal_distribution<double> normal(0.0, sigma);
  return Vector3(normal(random), normal(random), normal(random));
}

/// A place where all six primary views see beacons. (002's own is between the LEDs: its top view sees none.)
SplineTrajectory still_below_a_beacon(Duration duration) {
  return still_hiball(duration, Rigid::translation(Vector3(2.78, 4.35, 1.60)));
}

HiBallRig rig_with(bool secondary_views, double beacon_error_m = 0.001) {
  HiBallOptions options;
  options.secondary_views = secondary_views;
  options.beacon_error_m = beacon_error_m;
  return hiball_rig(options);
}

}  // namespace

TEST_CASE("visible: the footprint's lookup finds what a test of every beacon finds") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const SplineTrajectory still = still_hiball(1s);
  for (const bool l_shaped : {false, true}) {
    HiBallOptions options;
    options.secondary_views = true;
    if (l_shaped) options.ceiling = CeilingLayout::l_shaped();
    // A ceiling that hangs askew in a world of its own, and two panels that hang loose.
    options.ceiling.X_WL = Rigid(so3::exp<double>(random_vector(random, 1.0)), random_vector(random, 3.0));
    HiBallRig rig = hiball_rig(options);
    move_panel(rig, 40, Vector3(0.03, -0.05, 0.04));
    move_panel(rig, 41, Vector3(0.0, 0.0, -0.1));
    const HiBallSimulator simulator(rig, still);
    std::vector<int> found;
    int seen = 0, blind = 0;
    for (int trial = 0; trial < 40; ++trial) {
      // Below the ceiling, now and then among the LEDs or above; upright within 40 deg, or turned anyhow.
      const Vector3 p_LB(4.0 * share(random) - 2.0, 6.0 * share(random) - 3.0, 0.15 - 2.5 * share(random));
      const double tilt = trial % 2 == 0 ? 0.3 : 2.0;
      const Rigid X_WB = rig.ceiling.X_WL * Rigid(so3::exp<double>(random_vector(random, tilt)), p_LB);
      for (int camera = 0; camera < 26; ++camera) {
        simulator.visible(X_WB, camera, found);
        std::vector<int> expected;
        for (int beacon = 0; beacon < rig.ceiling.beacons(); ++beacon) {
          if (simulator.image(X_WB, camera, beacon)) expected.push_back(beacon);
        }
        CHECK(found == expected);
        seen += static_cast<int>(expected.size());
        blind += expected.empty();
      }
    }
    CHECK(seen > 1000);  // the comparison was about something
    CHECK(blind > 100);
  }
}

TEST_CASE("visible: images lie on the photodiode, beacons above the camera, and numbers rise") {
  std::mt19937_64 random(2);
  const SplineTrajectory still = still_hiball(1s);
  const HiBallSimulator simulator(rig_with(true), still);
  std::vector<int> visible;
  for (int trial = 0; trial < 50; ++trial) {
    const Rigid X_WB(so3::exp<double>(random_vector(random, 0.3)),
                     Vector3(2.74, 4.27, 1.4) + random_vector(random, 0.3));
    for (int camera = 0; camera < 26; ++camera) {
      const HiBallCamera& seer = simulator.rig().cameras[static_cast<std::size_t>(camera)];
      simulator.visible(X_WB, camera, visible);
      CHECK(std::ranges::is_sorted(visible));
      for (const int beacon : visible) {
        const Vector3& beacon_W = simulator.rig().beacons_W[static_cast<std::size_t>(beacon)];
        const std::optional<Vector2> uv = seer.view.project(X_WB.inverse() * beacon_W);
        REQUIRE(uv);
        CHECK(uv->cwiseAbs().maxCoeff() <= seer.half_side_m);
        // Metres against millimetres of image: rounding of 1e-15 m in the room is 1e-17 here.
        CHECK((*uv - *simulator.image(X_WB, camera, beacon)).norm() < 1e-16);
        CHECK(beacon_W.z() > (X_WB * seer.centre_B).z());
      }
    }
  }
}

TEST_CASE("visible: a HiBall on its head, above the ceiling or outside sees nothing") {
  const SplineTrajectory still = still_hiball(1s);
  const HiBallSimulator simulator(rig_with(true), still);
  std::vector<int> visible{1, 2, 3};
  const Quaternion upside_down = so3::exp<double>(Vector3(3.14159265, 0, 0));
  for (const Rigid& X_WB : {Rigid(upside_down, Vector3(2.74, 4.27, 1.5)), Rigid::translation(Vector3(2.74, 4.27, 3.5)),
                            Rigid::translation(Vector3(60, 4.27, 1.5))}) {
    for (int camera = 0; camera < 26; ++camera) {
      simulator.visible(X_WB, camera, visible);
      CHECK(visible.empty());
    }
  }
  CHECK_FALSE(simulator.sight(time_at(0.0), Rigid(upside_down, Vector3(2.74, 4.27, 1.5)), 0, 100));
}

TEST_CASE("nearest beacon: each image tells its own beacon; what lies between two, or where none hangs, tells none") {
  std::mt19937_64 random(3);
  const SplineTrajectory still = still_below_a_beacon(1s);
  const HiBallSimulator simulator(rig_with(true), still);
  const HiBallRig& rig = simulator.rig();
  DeviceTable<3> beacons;
  for (const Vector3& beacon_W : rig.nominal_beacons_W) beacons.add(beacon_W);
  std::vector<int> seen;
  int told = 0, between = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Rigid X_WB =
        still.at(still.begin()).X_WB * Rigid(so3::exp<double>(random_vector(random, 0.2)), random_vector(random, 0.2));
    // As well known as by a tracker that has just lost a few sightings.
    const Rigid estimate = X_WB * Rigid(so3::exp<double>(random_vector(random, 0.001)), random_vector(random, 0.001));
    for (int camera = 0; camera < 26; ++camera) {
      simulator.visible(X_WB, camera, seen);
      for (std::size_t k = 0; k < seen.size(); ++k) {
        const Vector2 uv = *simulator.image(X_WB, camera, seen[k]);
        CHECK(nearest_beacon(rig, beacons, estimate, camera, uv) == seen[k]);
        ++told;
        const bool side_by_side = k > 0 && seen[k] == seen[k - 1] + 1 && seen[k] % CeilingLayout::leds_along != 0;
        if (!side_by_side) continue;
        const Vector2 middle = 0.5 * (uv + *simulator.image(X_WB, camera, seen[k - 1]));
        CHECK_FALSE(nearest_beacon(rig, beacons, estimate, camera, middle));
        ++between;
      }
    }
  }
  CHECK(told > 300);
  CHECK(between > 100);
  const Rigid on_its_head(Quaternion(0.0, 1.0, 0.0, 0.0), Vector3(2.74, 4.27, 1.6));
  CHECK_FALSE(nearest_beacon(rig, beacons, on_its_head, 0, Vector2::Zero()));
}

TEST_CASE("sighting: straight below a beacon its noise is eq. 6.4's without angle, and the model of tracking fits it") {
  const SplineTrajectory still = still_hiball(1s);
  const HiBallSimulator simulator(rig_with(false, 0.0), still);
  const Vector3 beacon_W = simulator.rig().beacons_W[1000];
  const HiBallCamera& top = simulator.rig().cameras[0];
  const Rigid X_WB = Rigid::translation(Vector3(beacon_W - Vector3(0, 0, 1.0) - top.centre_B));
  const std::optional<BeaconSighting> sighting = simulator.sight(time_at(0.1), X_WB, 0, 1000);
  REQUIRE(sighting);
  CHECK(sighting->variance == doctest::Approx(2.89e-14));
  CHECK(sighting->uv.norm() < 5 * 1.7e-7);  // in the middle but for the noise

  TargetState<2> state;
  state.X_WB = X_WB;
  Linearization<CameraSighting> linear;
  const CameraSighting measurement{*simulator.image(X_WB, 0, 1000), &top.view, sighting->variance};
  REQUIRE(measurement.linearize(state, beacon_W, {}, linear));
  CHECK(linear.residual.norm() < 1e-15);
}

TEST_CASE("sighting: 10,000 draws have the variance they claim") {
  const SplineTrajectory still = still_hiball(100s);
  const HiBallSimulator simulator(rig_with(false), still);
  const std::vector<BeaconSighting> stream = sighting_stream(simulator, {.interval = 1ms});
  const int n = 10000;
  double squares = 0.0, product = 0.0, next = 0.0;
  int within = 0;
  Vector2 sum = Vector2::Zero(), last = Vector2::Zero();
  for (int k = 0; k < n; ++k) {
    const BeaconSighting& s = stream[static_cast<std::size_t>(k)];
    const Vector2 noise = (s.uv - *simulator.image(simulator.pose_at(s.t), s.camera, s.beacon)) / std::sqrt(s.variance);
    squares += noise.squaredNorm();
    product += noise.x() * noise.y();
    next += noise.dot(last);
    sum += noise;
    within += std::abs(noise.x()) < 1.0;
    last = noise;
  }
  // All bounds are four standard deviations: chi-square with 20,000 degrees of freedom; sums of n products of variance 1;
  // a count of probability 0.6827.
  CHECK(std::abs(squares - 2.0 * n) < 4 * std::sqrt(4.0 * n));
  CHECK(std::abs(product) < 4 * std::sqrt(1.0 * n));
  CHECK(std::abs(next) < 4 * std::sqrt(2.0 * n));
  CHECK(sum.cwiseAbs().maxCoeff() < 4 * std::sqrt(1.0 * n));
  CHECK(std::abs(within - 0.682689 * n) < 4 * std::sqrt(0.682689 * 0.317311 * n));
}

TEST_CASE("sighting: its noise belongs to time, camera, beacon and seed, not to the order of asking") {
  const SplineTrajectory still = still_hiball(1s);
  const HiBallSimulator simulator(rig_with(false), still), same(rig_with(false), still),
      other(rig_with(false), still, 2);
  std::vector<int> visible;
  simulator.visible(simulator.pose_at(time_at(0.0)), 3, visible);
  REQUIRE(visible.size() >= 2);
  const auto uv = [&](const HiBallSimulator& s, double t, int beacon) -> Vector2 {
    return s.sight(time_at(t), 3, beacon)->uv;
  };
  const Vector2 a = uv(simulator, 0.5, visible[0]), b = uv(simulator, 0.5, visible[1]);
  CHECK(uv(same, 0.5, visible[1]) == b);
  CHECK(uv(same, 0.5, visible[0]) == a);
  CHECK(uv(simulator, 0.500000001, visible[0]) != a);
  CHECK(uv(other, 0.5, visible[0]) != a);
}

TEST_CASE("sighting: a turned world gives the same") {
  std::mt19937_64 random(3);
  const Rigid X_VW(so3::exp<double>(random_vector(random, 1.0)), random_vector(random, 5.0));
  HiBallOptions options;
  options.beacon_error_m = 0.0;  // errors are along W's axes
  HiBallOptions turned_options = options;
  turned_options.ceiling.X_WL = X_VW * options.ceiling.X_WL;
  const SplineTrajectory still = still_hiball(10ms);
  const SplineTrajectory turned_still = still_hiball(10ms, X_VW * still.at(still.begin()).X_WB);
  const std::vector<BeaconSighting> a = sighting_stream(HiBallSimulator(hiball_rig(options), still));
  const std::vector<BeaconSighting> b = sighting_stream(HiBallSimulator(hiball_rig(turned_options), turned_still));
  REQUIRE(a.size() == 11);
  REQUIRE(b.size() == 11);
  for (std::size_t k = 0; k < 11; ++k) {
    CHECK(a[k].camera == b[k].camera);
    CHECK(a[k].beacon == b[k].beacon);
    CHECK((a[k].uv - b[k].uv).norm() < 1e-15);  // rounding of 1e-15 m in the room, 50 times less on the image
    CHECK(b[k].variance == doctest::Approx(a[k].variance));
  }
}

TEST_CASE("stream: round-robin goes through the cameras, and through each camera's beacons") {
  const SplineTrajectory still = still_below_a_beacon(2s);
  const HiBallSimulator simulator(rig_with(false), still);
  const std::vector<BeaconSighting> stream = sighting_stream(simulator, {.interval = 500us});
  REQUIRE(stream.size() == 4001);
  std::map<std::pair<int, int>, int> uses;
  for (std::size_t k = 0; k < stream.size(); ++k) {
    CHECK(stream[k].t == HostTime(500us * static_cast<int>(k)));
    if (k > 0) CHECK(stream[k].camera == (stream[k - 1].camera + 1) % 6);
    ++uses[{stream[k].camera, stream[k].beacon}];
  }
  std::vector<int> visible;
  for (int camera = 0; camera < 6; ++camera) {
    simulator.visible(simulator.pose_at(still.begin()), camera, visible);
    const double even = 4001.0 / 6.0 / static_cast<double>(visible.size());
    for (const int beacon : visible) CHECK(std::abs(uses[{camera, beacon}] - even) <= 1.0);
  }
}

TEST_CASE("stream: random takes every seeing camera and each of its beacons alike") {
  const SplineTrajectory still = still_below_a_beacon(20s);
  const HiBallSimulator simulator(rig_with(false), still);
  const StreamOptions options{.order = SightingOrder::random, .seed = 5};
  const std::vector<BeaconSighting> stream = sighting_stream(simulator, options);
  std::array<int, 6> cameras{};
  std::map<int, int> beacons_of_2;
  for (const BeaconSighting& s : stream) {
    ++cameras[static_cast<std::size_t>(s.camera)];
    if (s.camera == 2) ++beacons_of_2[s.beacon];
  }
  const auto chi_square = [](const auto& counts, double expected) {
    double sum = 0.0;
    for (const int count : counts) sum += (count - expected) * (count - expected) / expected;
    return sum;
  };
  CHECK(chi_square(cameras, static_cast<double>(stream.size()) / 6.0) < 20.5);  // 99.9 % point, 5 degrees of freedom
  std::vector<int> visible, counts;
  simulator.visible(simulator.pose_at(still.begin()), 2, visible);
  for (const int beacon : visible) counts.push_back(beacons_of_2[beacon]);
  const auto freedom = static_cast<double>(counts.size()) - 1.0;
  REQUIRE(freedom > 3.0);
  CHECK(chi_square(counts, cameras[2] / (freedom + 1.0)) < freedom + 4 * std::sqrt(2 * freedom) + 4);

  const std::vector<BeaconSighting> again = sighting_stream(simulator, options);
  REQUIRE(again.size() == stream.size());
  bool equal = true;
  for (std::size_t k = 0; k < stream.size(); ++k) equal = equal && again[k].uv == stream[k].uv;
  CHECK(equal);
}

TEST_CASE("stream: least recently used spreads a camera's sightings evenly") {
  const SplineTrajectory still = still_below_a_beacon(5s);
  const HiBallSimulator simulator(rig_with(false), still);
  std::map<int, std::map<int, int>> uses;
  for (const BeaconSighting& s : sighting_stream(simulator, {.order = SightingOrder::least_recently_used})) {
    ++uses[s.camera][s.beacon];
  }
  REQUIRE(uses.size() == 6);
  for (const auto& [camera, beacons] : uses) {
    int least = 1 << 30, most = 0;
    for (const auto& [beacon, count] : beacons) {
      least = std::min(least, count);
      most = std::max(most, count);
    }
    CHECK(most - least <= 1);  // fields of different cameras share no beacon here
  }
}

TEST_CASE("stream: a group's sightings have one time and differ; the rate of sightings stays") {
  const SplineTrajectory still = still_hiball(1s);
  const HiBallSimulator simulator(rig_with(false), still);
  const std::vector<BeaconSighting> stream = sighting_stream(simulator, {.group = 10});
  REQUIRE(stream.size() == 1010);  // 101 groups, one each 10 ms
  for (std::size_t k = 0; k < stream.size(); k += 10) {
    std::set<std::pair<int, int>> different;
    for (std::size_t i = k; i < k + 10; ++i) {
      CHECK(stream[i].t == HostTime(1ms * static_cast<int>(k)));
      different.emplace(stream[i].camera, stream[i].beacon);
    }
    CHECK(different.size() == 10);
  }
}

TEST_CASE("stream: nothing seen, nothing sent") {
  const SplineTrajectory away = still_hiball(1s, Rigid::translation(Vector3(60, 4, 1.5)));
  CHECK(sighting_stream(HiBallSimulator(rig_with(true), away)).empty());
}

TEST_CASE("visible and sight allocate nothing") {
  const SplineTrajectory still = still_hiball(1s);
  const HiBallSimulator simulator(rig_with(true), still);
  SightingSchedule schedule(simulator, SightingOrder::least_recently_used);
  const Rigid X_WB = simulator.pose_at(still.begin());
  for (int k = 0; k < 100; ++k) CHECK(schedule.next(X_WB));  // grows the list
  const std::size_t before = test::allocations();
  double sum = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const auto [camera, beacon] = *schedule.next(X_WB);
    sum += simulator.sight(time_at(1e-3 * k), camera, beacon)->uv.x();
  }
  CHECK(test::allocations() == before);
  CHECK(std::isfinite(sum));
}

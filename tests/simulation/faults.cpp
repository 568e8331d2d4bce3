#include <map>
#include <set>

#include <doctest/doctest.h>

#include <holdfast/simulation/ceiling_motion.hpp>
#include <holdfast/simulation/faults.hpp>
#include <holdfast/simulation/sighting_stream.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

/// Twenty seconds of a HiBall at rest and its 20,001 sightings.
struct Scene {
  SplineTrajectory still = still_hiball(20s);
  HiBallSimulator simulator{hiball_rig(), still};
  std::vector<BeaconSighting> clean = sighting_stream(simulator);
  std::vector<BeaconSighting> stream = clean;

  [[nodiscard]] Vector2 noise_of(const BeaconSighting& s) const {
    return (s.uv - *simulator.image(simulator.pose_at(s.t), s.camera, s.beacon)) / std::sqrt(s.variance);
  }
};

/// True when `count` of n events of this probability lies within four standard deviations of its expectation.
bool plausible(std::size_t count, std::size_t n, double probability) {
  const double mean = probability * static_cast<double>(n);
  return std::abs(static_cast<double>(count) - mean) < 4 * std::sqrt(mean * (1 - probability));
}

}  // namespace

TEST_CASE("blocked cameras: gone in the span, all or those named, and nothing else") {
  Scene scene;
  const TimeSpan span{time_at(1.0), time_at(3.0)};
  std::vector<BeaconSighting> some = scene.stream;
  block_cameras(scene.stream, span);
  CHECK(scene.stream.size() == scene.clean.size() - 2000);
  for (const BeaconSighting& s : scene.stream) CHECK_FALSE(span.contains(s.t));

  const std::array<int, 2> cameras{0, 4};
  block_cameras(some, span, cameras);
  for (const BeaconSighting& s : some) CHECK_FALSE((span.contains(s.t) && (s.camera == 0 || s.camera == 4)));
  CHECK(some.size() > scene.stream.size());
  CHECK(some.size() < scene.clean.size());
}

TEST_CASE("wrong identifications: at the stated rate, another beacon of the view, the image untouched") {
  Scene scene;
  misidentify(scene.stream, scene.simulator, 0.2, 7);
  REQUIRE(scene.stream.size() == scene.clean.size());
  std::size_t wrong = 0;
  std::vector<int> visible;
  for (std::size_t k = 0; k < scene.stream.size(); ++k) {
    const BeaconSighting &s = scene.stream[k], &was = scene.clean[k];
    CHECK(s.uv == was.uv);
    CHECK(s.faults.wrong_beacon == (s.beacon != was.beacon));
    if (s.beacon == was.beacon) continue;
    ++wrong;
    scene.simulator.visible(scene.simulator.pose_at(s.t), s.camera, visible);
    const bool in_view = std::ranges::find(visible, s.beacon) != visible.end();
    CHECK((in_view || (visible.size() == 1 && s.beacon / 8 == was.beacon / 8)));
  }
  CHECK(plausible(wrong, scene.clean.size(), 0.2));

  std::vector<BeaconSighting> none = scene.clean, all = scene.clean;
  misidentify(none, scene.simulator, 0.0, 7);
  misidentify(all, scene.simulator, 1.0, 7);
  for (const BeaconSighting& s : none) CHECK_FALSE(s.faults.any());
  for (const BeaconSighting& s : all) CHECK(s.faults.wrong_beacon);
}

TEST_CASE("wrong identifications hit the same sightings whatever was blocked before") {
  Scene scene;
  std::vector<BeaconSighting> blocked = scene.clean;
  block_cameras(blocked, {time_at(0.5), time_at(9.0)});
  misidentify(blocked, scene.simulator, 0.1, 3);
  misidentify(scene.stream, scene.simulator, 0.1, 3);
  std::map<HostTime, int> beacon_at;
  for (const BeaconSighting& s : scene.stream) beacon_at[s.t] = s.beacon;
  for (const BeaconSighting& s : blocked) CHECK(beacon_at[s.t] == s.beacon);
}

TEST_CASE("noise burst: the stated multiple of the claimed deviation, in the span only") {
  Scene scene;
  const TimeSpan span{time_at(5.0), time_at(15.0)};
  add_noise_burst(scene.stream, span, 8.0, 11);
  double squares = 0.0;
  int n = 0;
  for (std::size_t k = 0; k < scene.stream.size(); ++k) {
    const BeaconSighting& s = scene.stream[k];
    CHECK(s.variance == scene.clean[k].variance);
    CHECK(s.faults.noise_burst == span.contains(s.t));
    if (span.contains(s.t)) {
      squares += scene.noise_of(s).squaredNorm() / 64.0;
      ++n;
    } else {
      CHECK(s.uv == scene.clean[k].uv);
    }
  }
  CHECK(n == 10000);
  CHECK(std::abs(squares - 2.0 * n) < 4 * std::sqrt(4.0 * n));  // chi-square, four standard deviations
}

TEST_CASE("clock jump: times after it are off by so much, nothing else changes") {
  Scene scene;
  jump_clock(scene.stream, time_at(10.0), -30ms);
  for (std::size_t k = 0; k < scene.stream.size(); ++k) {
    const bool after = scene.clean[k].t >= time_at(10.0);
    CHECK(scene.stream[k].t == scene.clean[k].t - (after ? 30ms : 0ms));
    CHECK(scene.stream[k].faults.clock_jumped == after);
    CHECK(scene.stream[k].uv == scene.clean[k].uv);
  }
}

TEST_CASE("moved panel: later images are those of the moved beacons, with the noise they had") {
  Scene scene;
  const Vector3 displacement(0.004, -0.003, -0.006);
  // The panel that gives most sightings.
  std::map<int, int> counts;
  for (const BeaconSighting& s : scene.clean) ++counts[scene.simulator.rig().panel_of(s.beacon)];
  const int panel = std::ranges::max_element(counts, {}, [](const auto& entry) { return entry.second; })->first;
  move_panel(scene.stream, scene.simulator, panel, time_at(4.0), displacement);

  HiBallRig moved_rig = scene.simulator.rig();
  move_panel(moved_rig, panel, displacement);
  const HiBallSimulator moved(moved_rig, scene.still);
  std::map<HostTime, const BeaconSighting*> was;
  for (const BeaconSighting& s : scene.clean) was[s.t] = &s;
  int changed = 0;
  for (const BeaconSighting& s : scene.stream) {
    const bool affected = s.t >= time_at(4.0) && s.beacon / 32 == panel;
    CHECK(s.faults.panel_moved == affected);
    const Vector2 change = s.uv - was[s.t]->uv;
    if (!affected) {
      CHECK(change.norm() == 0.0);
      continue;
    }
    ++changed;
    const Rigid X_WB = scene.simulator.pose_at(s.t);
    const Vector2 expected = *moved.image(X_WB, s.camera, s.beacon) - *scene.simulator.image(X_WB, s.camera, s.beacon);
    CHECK((change - expected).norm() < 1e-15);  // millimetres: rounding
    CHECK(change.norm() > 1e-6);                // some millimetres at two metres, seen with a focal distance of 39 mm
  }
  CHECK(changed > 100);
  CHECK(scene.stream.size() > scene.clean.size() * 9 / 10);  // few images leave the photodiode
}

TEST_CASE("delivery: one in ten late by up to 50 ms, and overtaken by others") {
  Scene scene;
  const std::vector<DeliveredSighting> delivered = deliver(scene.clean, {.usual = 2ms});
  REQUIRE(delivered.size() == scene.clean.size());
  std::size_t late = 0, overtaken = 0;
  Duration latest{0};
  HostTime newest = HostTime::min();
  std::set<HostTime> times;
  for (std::size_t k = 0; k < delivered.size(); ++k) {
    const DeliveredSighting& d = delivered[k];
    if (k > 0) CHECK(d.delivered >= delivered[k - 1].delivered);
    const Duration delay = d.delivered - d.sighting.t;
    CHECK(delay >= 2ms);
    CHECK(delay <= 52ms);
    latest = std::max(latest, delay);
    late += delay > 2ms;
    overtaken += d.sighting.t < newest;
    newest = std::max(newest, d.sighting.t);
    times.insert(d.sighting.t);
  }
  CHECK(times.size() == scene.clean.size());  // none lost, none doubled
  CHECK(plausible(late, scene.clean.size(), 0.1));
  CHECK(latest > 51ms);  // 2000 uniform delays: the largest is within 2 % of the longest
  // Late by less than a sighting's interval, 2 % of them, is not overtaken.
  CHECK(plausible(overtaken, scene.clean.size(), 0.098));

  const std::vector<DeliveredSighting> prompt = deliver(scene.clean, {.late_share = 0.0});
  for (std::size_t k = 0; k < prompt.size(); ++k) CHECK(prompt[k].delivered == scene.clean[k].t);
}

TEST_CASE("faults add up, and the same seeds give the same stream") {
  const auto spoiled = [] {
    Scene scene;
    move_panel(scene.stream, scene.simulator, 40, time_at(2.0), Vector3(0, 0, -0.01));
    misidentify(scene.stream, scene.simulator, 0.05, 1);
    add_noise_burst(scene.stream, {time_at(3.0), time_at(3.5)}, 10.0, 1);
    block_cameras(scene.stream, {time_at(6.0), time_at(8.0)});
    jump_clock(scene.stream, time_at(12.0), 5ms);
    return deliver(scene.stream);
  };
  const std::vector<DeliveredSighting> a = spoiled(), b = spoiled();
  REQUIRE(a.size() == b.size());
  std::array<int, 3> marks{};
  bool equal = true;
  for (std::size_t k = 0; k < a.size(); ++k) {
    equal = equal && a[k].delivered == b[k].delivered && a[k].sighting.uv == b[k].sighting.uv &&
            a[k].sighting.beacon == b[k].sighting.beacon;
    const SightingFaults& faults = a[k].sighting.faults;
    marks[0] += faults.wrong_beacon && faults.noise_burst;
    marks[1] += faults.wrong_beacon && faults.clock_jumped;
    marks[2] += !faults.any();
  }
  CHECK(equal);
  for (const int mark : marks) CHECK(mark > 0);
}

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Cholesky>
#include <allocation_counter.hpp>
#include <doctest/doctest.h>
#include <tracking/dense_ekf.hpp>

#include <holdfast/tracking/camera_sighting.hpp>
#include <holdfast/tracking/scaat_filter.hpp>

using namespace holdfast;

namespace {

constexpr double rate_hz = 1000.0;

// A body that turns and sways below a ceiling of beacons, seen by three cameras of 60 degrees apart.
struct Scene {
  std::vector<CameraView> cameras;
  std::vector<Vector3> beacons_W;
  std::mt19937 random{5};

  Scene() {
    for (const double tilt : {-1.0, 0.0, 1.0}) {
      cameras.push_back({view_matrix(Rigid(so3::exp<double>(Vector3(0.3 * tilt, tilt, 0.0)), Vector3::Zero()), 0.037)});
    }
    for (int i = 0; i < 400; ++i) beacons_W.emplace_back(0.4 * (i % 20) - 4.0, 0.4 * (i / 20) - 4.0, -2.7);
  }

  double normal(double sigma) { return std::normal_distribution<double>(0.0, sigma)(random); }

  static Rigid truth(double t) {
    return Rigid(so3::exp<double>(Vector3(0.2 * std::sin(1.3 * t), 0.3 * std::sin(0.9 * t), 0.4 * std::sin(0.7 * t))),
                 Vector3(0.2 * std::sin(1.1 * t), 0.15 * std::cos(0.8 * t), 0.1 * std::sin(1.7 * t)));
  }
  static TargetState<2> start() {
    TargetState<2> state;
    state.X_WB = truth(0.0);
    state.P *= 1e-6;
    state.P.bottomRightCorner<6, 6>() = 0.1 * Matrix6::Identity();
    return state;
  }
  static PvModel model() { return PvModel::hiball(0.14, 0.17, Vector3::Constant(1.7)); }

  DeviceTable<3> table() {
    DeviceSettings<3> settings;
    settings.initial_variance.setConstant(1e-6);
    settings.residual_variance.setConstant(1e-7);
    settings.wander.setConstant(1e-10);
    DeviceTable<3> devices(settings);
    for (const Vector3& p_W : beacons_W) devices.add(p_W + Vector3(normal(1e-3), normal(1e-3), normal(1e-3)));
    return devices;
  }

  struct Sighting {
    int beacon = 0;
    CameraSighting measurement;
  };
  // Of a beacon that a camera has within 30 degrees of its axis, at random.
  Sighting sighting(double t, double sigma) { return sighting_from(truth(t), sigma); }
  Sighting sighting_from(const Rigid& X_WB, double sigma) {
    while (true) {
      const CameraView& camera = cameras[random() % cameras.size()];
      const int beacon = static_cast<int>(random() % beacons_W.size());
      const auto uv = camera.project(X_WB.inverse() * beacons_W[static_cast<std::size_t>(beacon)]);
      if (!uv || uv->norm() > 0.02) continue;
      return {beacon, {*uv + Vector2(normal(sigma), normal(sigma)), &camera, sigma * sigma}};
    }
  }
};

bool is_positive_definite(const Matrix12& P) {
  const VectorOf<double, 12> scale = P.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix12 correlation = scale.asDiagonal() * P * scale.asDiagonal();
  return correlation.allFinite() && Eigen::LLT<Eigen::MatrixXd>(correlation).info() == Eigen::Success;
}

}  // namespace

TEST_CASE("equal to the dense filter of 15 states after 100,000 updates") {
  Scene scene;
  DeviceTable<3> beacons = scene.table();
  DeviceSettings<3> settings = beacons.settings();
  settings.residual_variance.setZero();  // a textbook has none
  beacons.set_settings(settings);
  DeviceTable<3> dense_beacons = beacons;
  ScaatSettings open;
  open.gate.probability = 1.0;
  ScaatFilter<2> filter(Scene::start(), Scene::model(), open);
  test::DenseEkf dense;
  dense.state = Scene::start();
  dense.P.topLeftCorner<12, 12>() = dense.state.P;
  double worst = 0.0;
  for (int i = 1; i <= 100000; ++i) {
    const double t = i / rate_hz;
    const Scene::Sighting seen = scene.sighting(t, 3e-6);
    const bool asks = i % 100 == 0;
    const auto expected =
        asks ? filter.expectation(time_at(t), seen.measurement, {beacons, seen.beacon}) : std::nullopt;
    REQUIRE(filter.update(time_at(t), seen.measurement, {beacons, seen.beacon}) == UpdateStatus::updated);
    if (asks) REQUIRE(expected.value().nis() == doctest::Approx(filter.nis()).epsilon(1e-9));
    DeviceEstimate<3> beacon = dense_beacons.for_sighting(seen.beacon);
    REQUIRE(dense.update(time_at(t), Scene::model(), seen.measurement, beacon));
    dense_beacons.store(seen.beacon, beacon);
    worst = std::max(worst, (filter.state().X_WB.p() - dense.state.X_WB.p()).norm());
  }
  MESSAGE("largest difference of positions: " << worst << " m");
  CHECK(worst < 1e-7);  // the issue's
  CHECK(so3::angle_between(filter.state().X_WB.q(), dense.state.X_WB.q()) < 1e-7);
  // It tracks, too: beacons start 1 mm off.
  CHECK((filter.state().X_WB.p() - Scene::truth(100.0).p()).norm() < 1e-3);
}

TEST_CASE("the gate turns away one good measurement in a hundred, and the normalised innovations fit") {
  // One dimension of position, repeatedly: a static filter whose every assumption holds.
  Scene scene;
  ProcessModel<1> model;
  model.intensity.setConstant(1e-8);
  TargetState<1> state;
  state.P *= 1e-6;
  TargetState<1> truth = state;
  for (int i = 0; i < 3; ++i) {
    truth.X_WB = Rigid(truth.X_WB.q(), truth.X_WB.p() + Vector3::Unit(i) * scene.normal(1e-3));
  }
  ScaatFilter<1> filter(state, model, {.manoeuvre = {.threshold = 1.5}});  // there is none: it changes nothing
  double nis = 0.0, roused = 0.0;
  const int n = 40000;
  for (int i = 1; i <= n; ++i) {
    // The truth wanders as the model says; sigma per millisecond is sqrt(1e-8 * 1e-3).
    Vector3 step, turn;
    for (int k = 0; k < 3; ++k) {
      step[k] = scene.normal(std::sqrt(1e-11));
      turn[k] = scene.normal(std::sqrt(1e-11));
    }
    truth.X_WB = Rigid(truth.X_WB.q() * so3::exp<double>(turn), truth.X_WB.p() + step);
    const Vector3& beacon_W = scene.beacons_W[scene.random() % scene.beacons_W.size()];
    const CameraView& camera = scene.cameras[scene.random() % scene.cameras.size()];
    const auto uv = camera.project(truth.X_WB.inverse() * beacon_W);
    if (!uv || uv->norm() > 0.02) continue;
    DeviceEstimate<3> known;
    known.x = beacon_W;
    known.locked = true;
    const CameraSighting seen{*uv + Vector2(scene.normal(1e-5), scene.normal(1e-5)), &camera, 1e-10};
    (void)filter.update(time_at(0.001 * i), seen, known);
    nis += filter.nis();
    roused += filter.manoeuvre().noise_scale() > 1.0;
  }
  const double judged = static_cast<double>(filter.counters().total());
  const double rejected = static_cast<double>(filter.counters()[UpdateStatus::gated]) / judged;
  MESSAGE("rejected " << 100.0 * rejected << " % of " << judged);
  REQUIRE(judged > 5000.0);
  CHECK(rejected == doctest::Approx(0.01).epsilon(0.3));  // the 0.3 of 1 %; its deviation here is 0.1 of 1 %
  CHECK(roused / judged < 0.01);
  CHECK(nis / judged == doctest::Approx(2.0).epsilon(0.04));  // mean of chi-square with 2; deviation 0.02 and less
}

TEST_CASE("wrong identifications are turned away, put their beacon on probation, and do not shake the filter") {
  Scene scene;
  double error[2] = {0.0, 0.0};
  int roused[2] = {0, 0};
  for (const bool faulty : {false, true}) {
    scene.random.seed(11);
    DeviceTable<3> beacons = scene.table();
    ScaatFilter<2> filter(Scene::start(), Scene::model(), {.manoeuvre = {.threshold = 0.6}});
    std::mt19937 faults(3);
    int wrong = 0, wrong_used = 0;
    for (int i = 1; i <= 20000; ++i) {
      const double t = i / rate_hz;
      Scene::Sighting seen = scene.sighting(t, 3e-6);
      const bool is_wrong = faulty && faults() % 5 == 0;
      if (is_wrong) seen.beacon = (seen.beacon + 1 + static_cast<int>(faults() % 399)) % 400;
      const UpdateStatus status = filter.update(time_at(t), seen.measurement, {beacons, seen.beacon});
      roused[faulty] += filter.manoeuvre().noise_scale() > 1.0;
      wrong += is_wrong;
      wrong_used += is_wrong && status == UpdateStatus::updated;
      if (is_wrong && status == UpdateStatus::gated && i > 100) CHECK(beacons.record(seen.beacon).probation == 1);
      if (i > 2000) error[faulty] += (filter.state().X_WB.p() - Scene::truth(t).p()).squaredNorm();
    }
    if (faulty) {
      MESSAGE(wrong_used << " of " << wrong << " wrong identifications used");
      CHECK(wrong_used <= wrong / 100);
      CHECK(filter.counters()[UpdateStatus::on_probation] > 0);
    }
    CHECK(filter.gate().trusted());
  }
  MESSAGE("error with 20 % wrong identifications: " << std::sqrt(error[1] / error[0]) << " times");
  CHECK(std::sqrt(error[1] / error[0]) < 1.5);
  MESSAGE("roused by " << roused[0] << " of 20000 without, " << roused[1] << " with");
  CHECK(roused[1] < roused[0] + 200);  // wrong names are no manoeuvre
}

TEST_CASE("a body at rest that is snatched up: the filter that notices stays with it, and calms down again") {
  // 13 m/s^2 and 1,500 deg/s^2 for 80 ms, and as much to stop: as a hand takes a thing from a table.
  const auto snatched = [](double t) {
    const double begin = 1.0, half = 0.08;
    const double up = std::clamp(t - begin, 0.0, half), down = std::clamp(t - begin - half, 0.0, half);
    const double way = 0.5 * up * up + half * down - 0.5 * down * down;
    return Rigid(so3::exp<double>(Vector3(0.0, 26.0 * way, 0.0)), Vector3(0.0, 0.0, -13.0 * way));
  };
  PvModel model = Scene::model();
  model.intensity *= 0.8;
  double peak[2] = {0.0, 0.0}, after[2] = {0.0, 0.0}, gated[2] = {0.0, 0.0};  // of both filters, sums over runs
  for (unsigned run = 1; run <= 4; ++run) {
    for (const bool notices : {false, true}) {
      Scene scene;
      scene.random.seed(run);
      DeviceTable<3> beacons = scene.table();
      TargetState<2> start = Scene::start();
      start.X_WB = snatched(0.0);
      ScaatSettings settings;
      settings.manoeuvre.threshold = notices ? 0.6 : 0.0;
      ScaatFilter<2> filter(start, model, settings);
      double worst = 0.0;
      for (int i = 1; i <= 2500; ++i) {
        const double t = i / rate_hz;
        const Rigid X_WB = snatched(t);
        const Scene::Sighting seen = scene.sighting_from(X_WB, 3e-6);
        (void)filter.update(time_at(t), seen.measurement, {beacons, seen.beacon});
        const double error = (filter.state().X_WB.p() - X_WB.p()).norm();
        worst = std::max(worst, error);
        if (t > 2.0) after[notices] += error * error;
      }
      peak[notices] += worst;
      gated[notices] += static_cast<double>(filter.counters()[UpdateStatus::gated]);
      CHECK(filter.counters().total() == 2500);
    }
  }
  MESSAGE("mean peak " << 250.0 * peak[0] << " mm, " << gated[0] << " turned away; noticed " << 250.0 * peak[1]
                       << " mm, " << gated[1]);
  CHECK(peak[1] < 0.5 * peak[0]);  // a quarter; single runs scatter by a half
  CHECK(gated[1] < 0.5 * gated[0]);
  CHECK(after[1] < 1.2 * after[0]);  // at rest again it is as it was
}

TEST_CASE("what cannot be used changes nothing and is counted by its cause") {
  Scene scene;
  DeviceTable<3> beacons = scene.table();
  ScaatFilter<2> filter(Scene::start(), Scene::model());
  Scene::Sighting seen = scene.sighting(0.001, 3e-6);
  const TargetState<2> before = filter.state();
  const auto refused = [&](HostTime t, const CameraSighting& measurement, int beacon, UpdateStatus expected) {
    const std::uint64_t count = filter.counters()[expected];
    const UpdateStatus status = filter.update(t, measurement, {beacons, beacon});
    CHECK(status == expected);
    CAPTURE(name_of(status));
    CHECK(filter.counters()[expected] == count + 1);
    CHECK(filter.state().t == before.t);
    CHECK(filter.state().P == before.P);
    CHECK(filter.state().X_WB.p() == before.X_WB.p());
    if (beacons.contains(beacon)) CHECK(beacons.sightings(beacon) == 0);
  };
  const double nan = std::nan("");
  CameraSighting bad = seen.measurement;
  bad.uv.x() = nan;
  refused(time_at(0.001), bad, seen.beacon, UpdateStatus::not_finite);
  bad.uv.x() = std::numeric_limits<double>::infinity();
  refused(time_at(0.001), bad, seen.beacon, UpdateStatus::not_finite);
  bad.uv.x() = 1e300;
  refused(time_at(0.001), bad, seen.beacon, UpdateStatus::not_finite);
  bad.uv.x() = 0.01;
  refused(time_at(0.001), bad, seen.beacon, UpdateStatus::gated);
  bad = seen.measurement;
  bad.variance = -1e-12;
  refused(time_at(0.001), bad, seen.beacon, UpdateStatus::not_positive);
  bad.variance = nan;
  refused(time_at(0.001), bad, seen.beacon, UpdateStatus::not_finite);
  refused(time_at(-0.001), seen.measurement, seen.beacon, UpdateStatus::time_backwards);
  refused(time_at(6.0), seen.measurement, seen.beacon, UpdateStatus::gap_too_long);
  refused(HostTime::max(), seen.measurement, seen.beacon, UpdateStatus::gap_too_long);
  refused(HostTime::min(), seen.measurement, seen.beacon, UpdateStatus::time_backwards);
  refused(time_at(0.001), seen.measurement, 400, UpdateStatus::no_such_device);
  refused(time_at(0.001), seen.measurement, -1, UpdateStatus::no_such_device);
  DeviceEstimate<3> behind;
  behind.x = Vector3(0.0, 0.0, 5.0);
  CHECK(filter.update(time_at(0.001), seen.measurement, behind) == UpdateStatus::cannot_be_seen);
  CHECK(filter.counters().total() == 13);
  CHECK(filter.update(time_at(0.001), seen.measurement, {beacons, seen.beacon}) == UpdateStatus::updated);
  CHECK(beacons.sightings(seen.beacon) == 1);
  CHECK(*beacons.last_sighting(seen.beacon) == time_at(0.001));
}

TEST_CASE("a locked beacon stays; one of exact position is an exact measurement's other end") {
  Scene scene;
  DeviceTable<3> beacons = scene.table();
  const Scene::Sighting seen = scene.sighting(0.001, 3e-6);
  beacons.lock(seen.beacon);
  const DeviceEstimate<3> before = beacons.at(seen.beacon);
  ScaatFilter<2> filter(Scene::start(), Scene::model());
  REQUIRE(filter.update(time_at(0.001), seen.measurement, {beacons, seen.beacon}) == UpdateStatus::updated);
  CHECK(beacons.at(seen.beacon).x == before.x);
  CHECK(beacons.at(seen.beacon).P == before.P);
  CHECK(beacons.is_locked(seen.beacon));
  beacons.unlock(seen.beacon);
  REQUIRE(filter.update(time_at(0.002), seen.measurement, {beacons, seen.beacon}) == UpdateStatus::updated);
  CHECK(beacons.at(seen.beacon).x != before.x);
  CHECK(beacons.at(seen.beacon).P.trace() < before.P.trace());
}

TEST_CASE("a million bad measurements: the state stays finite, its covariance symmetric and positive definite") {
  Scene scene;
  DeviceTable<3> beacons = scene.table();
  std::vector<ScaatFilter<2>> filters;
  ScaatSettings open;
  open.gate.probability = 1.0;
  open.manoeuvre.threshold = 1.5;
  open.longest_gap = from_seconds(1e9);
  PvModel still;
  still.intensity.setZero();  // nothing ever loosens its covariance but time
  filters.emplace_back(Scene::start(), Scene::model());
  filters.emplace_back(Scene::start(), Scene::model(), open);
  filters.emplace_back(Scene::start(), still, open);
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  const double odd[] = {nan, inf, -inf, 0.0, 1e308, -1e308, 1e-308, 5e-324, 1e150, -1e20, 1e12, 0.037};
  const double gaps[] = {0.0, 0.0, 1e-9, 0.001, 0.001, 0.001, 0.1, 3.0, 5.1, 1e5, 1e8, -1.0, -1e9};
  const auto pick = [&](const auto& list) { return list[scene.random() % std::size(list)]; };
  const double variances[] = {0.0, 1e-300, 1e-30, 9e-12, 1e-6, 1.0, 1e300, -1.0, nan, inf};
  const int updates = 333334;
  int unsound = 0;
  const std::size_t allocations = test::allocations();
  for (ScaatFilter<2>& filter : filters) {
    Scene::Sighting seen = scene.sighting(0.0, 3e-6);
    for (int i = 0; i < updates; ++i) {
      if (i % 500 == 0) {  // else they would soon be far from anything that can be seen
        TargetState<2> start = Scene::start();
        start.t = time_at(i / 500);
        start.X_WB = Scene::truth(i / 500);
        filter.restart(start);
      }
      const unsigned kind = scene.random() % 16;
      const double gap = kind == 4 ? pick(gaps) : 0.001 * static_cast<double>(scene.random() % 2);
      const HostTime t = filter.state().t + from_seconds(gap);
      if (kind > 6) {
        seen = scene.sighting(to_seconds(t.time_since_epoch()), 3e-6);
      } else if (kind != 0) {  // else the same again
        seen = {static_cast<int>(scene.random() % 400),
                {Vector2(scene.normal(0.01), scene.normal(0.01)), &scene.cameras[scene.random() % 3], 9e-12}};
      }
      if (kind == 1) seen.measurement.uv[static_cast<int>(scene.random() % 2)] = pick(odd);
      if (kind == 2) seen.measurement.variance = pick(variances);
      if (kind == 3) seen.beacon = static_cast<int>(scene.random() % 800) - 200;
      (void)filter.update(t, seen.measurement, {beacons, seen.beacon});
      const TargetState<2>& state = filter.state();
      if (!state.is_finite() || state.P != state.P.transpose()) ++unsound;
      if (i % 32 == 0) {
        const VectorOf<double, 12> scale = state.P.diagonal().cwiseSqrt().cwiseInverse();
        const Matrix12 correlation = scale.asDiagonal() * state.P * scale.asDiagonal();
        Matrix12 L;
        if (!cholesky<12>(correlation, L)) ++unsound;
      }
    }
    CHECK(filter.counters().total() == static_cast<std::uint64_t>(updates));
  }
  CHECK(test::allocations() == allocations);
  CHECK(unsound == 0);
  int bad_devices = 0;
  for (int i = 0; i < beacons.size(); ++i) {
    const DeviceEstimate<3> beacon = beacons.at(i);
    if (!beacon.x.allFinite() || Eigen::LLT<Eigen::Matrix3d>(beacon.P).info() != Eigen::Success) ++bad_devices;
  }
  CHECK(bad_devices == 0);
  for (std::size_t status = 0; status < update_statuses; ++status) {
    std::uint64_t sum = 0;
    for (const auto& filter : filters) sum += filter.counters()[static_cast<UpdateStatus>(status)];
    CAPTURE(name_of(static_cast<UpdateStatus>(status)));
    CHECK(sum > 0);
  }
}

TEST_CASE(
    "contradictory exact measurements of one direction, without noise of any kind, keep the covariance positive") {
  // Every update takes all but nothing of one direction: the case that breaks (I - K H) P.
  Scene scene;
  ScaatSettings open;
  open.gate.probability = 1.0;
  PvModel still;
  still.intensity.setZero();
  ScaatFilter<2> filter(Scene::start(), still, open);
  DeviceEstimate<3> beacon;
  beacon.x = Vector3(0.1, 0.2, -2.7);
  beacon.locked = true;
  int updated = 0;
  for (int i = 0; i < 2000; ++i) {
    // Near what it expects, so that it stays in sight; hundreds of standard deviations off nevertheless.
    const Vector2 expected = *scene.cameras[1].project(filter.state().X_WB.inverse() * beacon.x);
    const CameraSighting seen{expected + Vector2(scene.normal(1e-9), scene.normal(1e-9)), &scene.cameras[1], 0.0};
    beacon.x.x() += scene.normal(1e-9);
    updated += filter.update(time_at(i < 1000 ? 0.0 : 0.0001 * i), seen, beacon) == UpdateStatus::updated;
    CHECK(is_positive_definite(filter.state().P));
    CHECK(filter.state().is_finite());
  }
  CHECK(updated > 1500);
}

TEST_CASE("an innovation's likelihood is the normal density") {
  Scene scene;
  TargetState<2> state = Scene::start();
  const Scene::Sighting seen = scene.sighting(0.0, 3e-6);
  DeviceEstimate<3> beacon;
  beacon.x = scene.beacons_W[static_cast<std::size_t>(seen.beacon)];
  const auto innovation = extended_innovation(state, seen.measurement, beacon);
  REQUIRE(innovation);
  const Matrix2 S = innovation->S;
  const Vector2 y = innovation->residual;
  CHECK(innovation->nis() == doctest::Approx(y.dot(S.inverse() * y)).epsilon(1e-9));
  CHECK(innovation->log_likelihood() ==
        doctest::Approx(-0.5 * innovation->nis() - 0.5 * std::log(S.determinant()) - std::log(2.0 * 3.14159265358979))
            .epsilon(1e-9));
}

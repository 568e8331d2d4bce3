// Interacting multiple models: one alone is the plain filter, two find out which of them is true.
#include <cmath>
#include <random>
#include <string>

#include <allocation_counter.hpp>
#include <doctest/doctest.h>
#include <tracking/hiball_scene.hpp>

#include <holdfast/tracking/consistency.hpp>
#include <holdfast/tracking/multiple_models.hpp>
#include <holdfast/tracking/pose_measurement.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

namespace {

using Random = std::mt19937;

PvModel pv(double intensity) {
  PvModel model;
  model.intensity.setConstant(intensity);
  return model;
}

constexpr double pose_sigma = 1e-3;  // m and rad

PoseMeasurement measured(const TargetState<2>& truth, Random& random) {
  const Vector6 noise = pose_sigma * random_vector<6>(random);
  PoseMeasurement pose;
  pose.X_WB = Rigid(truth.X_WB.q() * so3::exp<double>(Vector3(noise.tail<3>())), truth.X_WB.p() + noise.head<3>());
  pose.covariance.diagonal().setConstant(pose_sigma * pose_sigma);
  return pose;
}

/// A truth, and what a filter knows of it at the start.
struct Beginning {
  TargetState<2> truth, known;

  explicit Beginning(Random& random, double velocity_sigma = 0.01) {
    VectorOf<double, 12> sigma;
    sigma << Vector6::Constant(1e-3), Vector6::Constant(velocity_sigma);
    known.P = sigma.cwiseAbs2().asDiagonal();
    truth = known;
    TargetState<2>::Error d;
    d << random_vector<6>(random), random_vector<6>(random);
    truth.add(d.cwiseProduct(sigma));
  }
};

}  // namespace

TEST_CASE("multiple models: mean and covariance of a mixture are those of a mixture") {
  std::array<TargetState<1>, 2> states;
  states[0].X_WB = Rigid::translation(Vector3(1.0, 2.0, 3.0));
  states[1].X_WB = Rigid(so3::exp<double>(Vector3(0.0, 0.0, 1e-3)), Vector3(1.4, 2.0, 3.0));
  states[0].P *= 0.01;
  states[1].P *= 0.02;
  const TargetState<1> matched = moment_matched(states, {0.25, 0.75});
  CHECK(matched.X_WB.p().x() == Approx(1.3).epsilon(1e-14));
  CHECK(so3::log<double>(matched.X_WB.q()).z() == Approx(0.75e-3).epsilon(1e-9));
  CHECK(matched.P(0, 0) == Approx(0.0175 + 0.25 * 0.75 * 0.16).epsilon(1e-14));
  CHECK(matched.P(1, 1) == Approx(0.0175).epsilon(1e-14));
  CHECK(matched.P(0, 5) == Approx(0.25 * 0.75 * 0.4e-3).epsilon(1e-9));
  CHECK(matched.P == matched.P.transpose());
  CHECK(moment_matched(states, {0.0, 1.0}).P == states[1].P);

  std::array<DeviceEstimate<1>, 2> devices;
  devices[0].x[0] = 1.0;
  devices[1].x[0] = 2.0;
  devices[0].P(0, 0) = devices[1].P(0, 0) = 0.5;
  CHECK(moment_matched(devices, {0.25, 0.75}).x[0] == Approx(1.75));
  CHECK(moment_matched(devices, {0.25, 0.75}).P(0, 0) == Approx(0.5 + 0.1875));
  devices[0].locked = devices[1].locked = true;
  CHECK(moment_matched(devices, {0.25, 0.75}).P(0, 0) == 0.5);
}

TEST_CASE("multiple models: one alone is the plain filter, two alike are as good as one; nothing is allocated") {
  const test::HiBallScene scene(test::swaying_hiball(1.0));
  const PvModel model = test::HiBallScene::model();
  const std::vector<BeaconSighting> sightings = sighting_stream(scene.simulator);
  DeviceTable<3> tables[3] = {scene.beacons(), scene.beacons(), scene.beacons()};
  ScaatFilter<2> plain(scene.start(), model);
  MultipleModelFilter<2, 1> one(scene.start(), {{model}, {1.0}});
  MultipleModelFilter<2, 2> two(scene.start(), {{model, model}, {0.1, 0.3}});
  const std::size_t allocations = test::allocations();
  std::size_t count = 0;
  for (const BeaconSighting& s : sightings) {
    CameraSighting seen = scene.measurement(s);
    if (++count % 17 == 0) seen.uv.x() += 1e-3;  // gated
    if (count % 19 == 0) seen.uv.x() = std::nan("");
    if (count % 23 == 0) seen.variance = -1.0;
    const HostTime t = count % 29 == 0 ? s.t - std::chrono::milliseconds(5) : s.t;
    const UpdateStatus status = plain.update(t, seen, {tables[0], s.beacon});
    REQUIRE(one.update(t, seen, {tables[1], s.beacon}) == status);
    REQUIRE(two.update(t, seen, {tables[2], s.beacon}) == status);
  }
  CHECK(test::allocations() == allocations);
  CHECK(plain.counters()[UpdateStatus::updated] > 700);
  for (const UpdateStatus status :
       {UpdateStatus::gated, UpdateStatus::not_finite, UpdateStatus::not_positive, UpdateStatus::time_backwards}) {
    CHECK(plain.counters()[status] > 0);
    CHECK(one.counters()[status] == plain.counters()[status]);
  }
  CHECK(one.state().P == plain.state().P);
  CHECK(one.state().X_WB.p() == plain.state().X_WB.p());
  CHECK(one.state().velocity.w_WB_B == plain.state().velocity.w_WB_B);
  // Rounding of 1000 updates.
  CHECK(plain.state().error_of(two.state()).norm() < 1e-10);
  CHECK((two.state().P - plain.state().P).norm() < 1e-10 * plain.state().P.norm());
  // Alike, they leave each other at 1 / mean stay: the chain's own balance.
  CHECK(two.probabilities()[0] == Approx(0.25).epsilon(0.01));
  double worst = 0.0;
  for (int i = 0; i < tables[0].size(); ++i) {
    REQUIRE(tables[1].at(i).x == tables[0].at(i).x);
    worst = std::max(worst, (tables[2].at(i).x - tables[0].at(i).x).norm());
  }
  CHECK(worst < 1e-10);
  CHECK(one.update(time_at(100.0), scene.measurement(sightings[0]), {tables[1], 0}) == UpdateStatus::gap_too_long);
  CHECK(one.update(time_at(1.01), scene.measurement(sightings[0]), {tables[1], -1}) == UpdateStatus::no_such_device);
}

TEST_CASE("multiple models: the true one is found, either way") {
  Random random(1);
  const ModelSet<2, 2> set{{pv(1e-6), pv(0.3)}, {1.0, 1.0}};
  for (const std::size_t true_model : {std::size_t(0), std::size_t(1)}) {
    Beginning begin(random);
    MultipleModelFilter<2, 2> filter(begin.known, set, no_gate());
    CHECK(filter.probabilities()[0] == 0.5);
    double mean = 0.0;
    for (int i = 1; i <= 400; ++i) {
      wander(begin.truth, set.models[true_model], time_at(0.01 * i), random);
      REQUIRE(filter.update(time_at(0.01 * i), measured(begin.truth, random)) == UpdateStatus::updated);
      CHECK(filter.probabilities()[0] + filter.probabilities()[1] == Approx(1.0).epsilon(1e-12));
      if (i > 100) mean += filter.probabilities()[true_model] / 300.0;
    }
    MESSAGE("mean probability of the true model " << true_model << ": " << mean);
    CHECK(mean > 0.9);
  }
}

TEST_CASE("multiple models: as sure as they may be when the truth changes between them as they say") {
  Random random(2);
  const ModelSet<2, 2> set{{pv(0.001), pv(0.1)}, {0.4, 0.4}};
  ConsistencyMean combined(12);
  double brier = 0.0, expected_brier = 0.0;
  int looks = 0;
  for (int run = 0; run < 150; ++run) {
    Beginning begin(random);
    std::size_t model = random() % 2;
    MultipleModelFilter<2, 2> filter(begin.known, set, no_gate());
    for (int i = 1; i <= 100; ++i) {
      const double leave = -std::expm1(-0.01 / set.mean_stay_s[model]);
      if (std::uniform_real_distribution<double>()(random) < leave) model = 1 - model;
      wander(begin.truth, set.models[model], time_at(0.01 * i), random);
      REQUIRE(filter.update(time_at(0.01 * i), measured(begin.truth, random)) == UpdateStatus::updated);
      const double p = filter.probabilities()[1];
      const double happened = static_cast<double>(model);
      brier += (p - happened) * (p - happened);
      expected_brier += p * (1.0 - p);
      ++looks;
    }
    combined.add(nees(filter.state(), begin.truth));
  }
  const auto bounds = combined.bounds();
  MESSAGE("NEES " << combined.mean() << " within " << bounds.low << " and " << bounds.high << "; Brier "
                  << brier / looks << " for " << expected_brier / looks);
  CHECK(combined.consistent());
  // Probabilities mean what they say: some 400 independent looks would scatter by 10 %, and merging costs a little.
  CHECK(brier == Approx(expected_brier).epsilon(0.25));
}

TEST_CASE("multiple models: as good as the still filter at rest, and as the moving one in motion") {
  Random random(3);
  const PvModel still = pv(1e-5), moving = pv(1.0);
  const ModelSet<2, 2> set{{still, moving}, {50.0, 2.0}};
  Beginning begin(random, 1e-4);
  begin.truth.velocity = {};
  ScaatFilter<2> still_filter(begin.known, still, no_gate());
  ScaatFilter<2> moving_filter(begin.known, moving, no_gate());
  MultipleModelFilter<2, 2> both(begin.known, set, no_gate());
  double squares[2][3] = {};  // at rest, moving; by still, moving, both
  const Rigid X_rest = begin.truth.X_WB;
  for (int i = 1; i <= 4000; ++i) {
    const double t = 0.005 * i;
    const bool at_rest = i <= 2000;
    if (!at_rest) {  // a hand that is shaken: 0.1 m at 1 Hz
      const double phase = 6.28 * (t - 10.0);
      begin.truth.X_WB = Rigid(X_rest.q() * so3::exp<double>(Vector3(0.0, 0.0, 0.3 * std::sin(phase))),
                               X_rest.p() + Vector3(0.1 * std::sin(phase), 0.0, 0.05 * std::sin(2.0 * phase)));
    }
    const PoseMeasurement pose = measured(begin.truth, random);
    (void)still_filter.update(time_at(t), pose);
    (void)moving_filter.update(time_at(t), pose);
    (void)both.update(time_at(t), pose);
    if (i % 2000 < 400) continue;  // settling, and the change itself
    const TargetState<2>* states[3] = {&still_filter.state(), &moving_filter.state(), &both.state()};
    for (int k = 0; k < 3; ++k) {
      squares[at_rest ? 0 : 1][k] += states[k]->error_of(begin.truth).head<6>().squaredNorm() / 1600.0;
    }
  }
  for (int part = 0; part < 2; ++part) {
    MESSAGE((part == 0 ? "at rest, " : "moving, ")
            << "mm: still " << 1e3 * std::sqrt(squares[part][0]) << ", moving " << 1e3 * std::sqrt(squares[part][1])
            << ", both " << 1e3 * std::sqrt(squares[part][2]));
  }
  // Deviations, not squares. It pays a little for being ready: a fifth.
  CHECK(std::sqrt(squares[0][2]) < 1.2 * std::sqrt(squares[0][0]));
  CHECK(std::sqrt(squares[0][2]) < 0.5 * std::sqrt(squares[0][1]));
  CHECK(std::sqrt(squares[1][2]) < 1.05 * std::sqrt(squares[1][1]));
  CHECK(std::sqrt(squares[1][2]) < 0.2 * std::sqrt(squares[1][0]));
}

TEST_CASE("multiple models: bad sets are named; a model that is never left and impossible does no harm") {
  ModelSet<2, 2> set{{pv(1e-6), pv(1.0)}, {0.5, 0.5}};
  CHECK_FALSE(set.problem());
  set.mean_stay_s[1] = 0.0;
  CHECK(set.problem());
  set.mean_stay_s[1] = std::nan("");
  CHECK(set.problem());
  set.mean_stay_s[1] = 1.0;
  set.models[0].intensity[2] = -1.0;
  CHECK(set.problem());

  // Never changing, the unlikely one's probability ends at zero, and stays there without harm.
  Random random(4);
  constexpr double never = std::numeric_limits<double>::infinity();
  const ModelSet<2, 2> fixed{{pv(1e-9), pv(1.0)}, {never, never}};
  Beginning begin(random);
  MultipleModelFilter<2, 2> filter(begin.known, fixed, no_gate());
  for (int i = 1; i <= 2000; ++i) {
    wander(begin.truth, fixed.models[1], time_at(0.01 * i), random);
    REQUIRE(filter.update(time_at(0.01 * i), measured(begin.truth, random)) == UpdateStatus::updated);
  }
  CHECK(filter.probabilities()[0] == 0.0);
  CHECK(filter.state().is_finite());
  CHECK(filter.state().P == filter.state_of(1).P);
  CHECK(begin.truth.error_of(filter.state()).head<6>().norm() < 5.0 * pose_sigma);
}

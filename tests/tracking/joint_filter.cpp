// A target and its newest devices in one filter: against a textbook's dense one over all of them, and against the truth.
#include <cmath>
#include <limits>
#include <map>

#include <Eigen/Dense>
#include <allocation_counter.hpp>
#include <doctest/doctest.h>
#include <tracking/hiball_scene.hpp>

#include <holdfast/tracking/consistency.hpp>
#include <holdfast/tracking/delayed_measurements.hpp>
#include <holdfast/tracking/inertial_measurement.hpp>
#include <holdfast/tracking/joint_filter.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

namespace {

/// Few kinds of filters: each takes the compiler long.
using One = JointFilter<2, 3, 6>;
using Two = JointFilter<2, 3, 6, 2>;

/// One dense extended Kalman filter over target and all devices that were ever seen.
class DenseJointEkf {
 public:
  DenseJointEkf(const TargetState<2>& start, const PvModel& model) : state(start), model_(model), P(start.P) {}

  bool update(HostTime t, const CameraSighting& sighting, int beacon, const DeviceTable<3>& table) {
    if (!place_.contains(beacon)) {
      place_[beacon] = static_cast<int>(P.rows());
      x[beacon] = table.at(beacon).x;
      const Eigen::MatrixXd before = P;
      P.setZero(P.rows() + 3, P.cols() + 3);
      P.topLeftCorner(before.rows(), before.cols()) = before;
      P.bottomRightCorner<3, 3>() = table.at(beacon).P;
    }
    const int first = place_[beacon];
    P.block<3, 3>(first, first).diagonal() += table.settings().wander;

    Eigen::MatrixXd F = Eigen::MatrixXd::Identity(P.rows(), P.cols());
    F.topLeftCorner<12, 12>() = state_transition(state, model_, t);
    P = F * P * F.transpose();
    TargetState<2> noise = state;  // what advance adds beyond F P F^T
    noise.P.setZero();
    advance(noise, model_, t);
    P.topLeftCorner<12, 12>() += noise.P;
    state = noise;

    Linearization<CameraSighting> linear;
    if (!sighting.linearize(state, x[beacon], {}, linear)) return false;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(2, P.cols());
    H.leftCols<6>() = linear.H;
    H.middleCols<3>(first) = linear.H_source;
    const Eigen::Matrix2d S =
        H * P * H.transpose() + linear.R +
        linear.H_source * table.settings().residual_variance.asDiagonal() * linear.H_source.transpose();
    const Eigen::MatrixXd K = P * H.transpose() * S.inverse();
    const Eigen::VectorXd d = K * linear.residual;
    P -= K * S * K.transpose();
    P = Eigen::MatrixXd(0.5 * (P + P.transpose()));
    state.add(d.head<12>());
    for (auto& [index, place] : place_) x[index] += d.segment<3>(place);
    return true;
  }

  [[nodiscard]] Matrix3 covariance(int beacon) const { return P.block<3, 3>(place_.at(beacon), place_.at(beacon)); }

  TargetState<2> state;

 private:
  PvModel model_;
  std::map<int, int> place_;

 public:
  Eigen::MatrixXd P;
  std::map<int, Vector3> x;
};

/// The first sightings of the scene that are of no more than `most` different beacons.
std::vector<BeaconSighting> sightings_of_few(const HiBallScene& scene, std::size_t most) {
  std::map<int, int> known;
  std::vector<BeaconSighting> few;
  for (const BeaconSighting& s : sighting_stream(scene.simulator)) {
    if (known.size() < most) known[s.beacon] = 0;
    if (known.contains(s.beacon)) few.push_back(s);
  }
  return few;
}

}  // namespace

TEST_CASE("joint filter: with a slot for each, it is the textbook's filter of target and all devices") {
  const HiBallScene scene(still_hiball(from_seconds(1.0)));  // which sees the same beacons again and again
  const std::vector<BeaconSighting> sightings = sightings_of_few(scene, 6);
  REQUIRE(sightings.size() > 100);
  DeviceTable<3> table = scene.beacons();
  const DeviceTable<3> designed = table;
  One filter(scene.start(), HiBallScene::model(), no_gate());
  DenseJointEkf dense(scene.start(), HiBallScene::model());
  const std::size_t allocations = test::allocations();
  for (const BeaconSighting& s : sightings) {
    const auto expected = filter.expectation(s.t, scene.measurement(s), {table, s.beacon});
    REQUIRE(expected);
    REQUIRE(filter.update(s.t, scene.measurement(s), {table, s.beacon}) == UpdateStatus::updated);
    REQUIRE(expected->nis() == doctest::Approx(filter.nis()).epsilon(1e-9));
  }
  CHECK(test::allocations() == allocations);
  for (const BeaconSighting& s : sightings) REQUIRE(dense.update(s.t, scene.measurement(s), s.beacon, designed));
  // Rounding of hundreds of updates, and the floor of 1e-12 by which ours raises variances.
  CHECK(dense.state.error_of(filter.state()).cwiseAbs().maxCoeff() < 1e-8);
  CHECK((filter.state().P - dense.P.topLeftCorner<12, 12>()).norm() < 1e-7 * filter.state().P.norm());
  CHECK(filter.state().P == filter.state().P.transpose());
  CHECK(filter.joint_of(0).P_dd == filter.joint_of(0).P_dd.transpose());
  filter.settle();
  for (const auto& [beacon, x] : dense.x) {
    CHECK((table.at(beacon).x - x).norm() < 1e-9);
    CHECK((table.at(beacon).P - dense.covariance(beacon)).norm() < 1e-7 * table.at(beacon).P.norm());
  }
}

TEST_CASE("joint filter: with locked devices it is the plain filter; inertial sensors go beside the slots") {
  const HiBallScene scene(swaying_hiball(0.5));
  DeviceTable<3> table = scene.beacons(), same = scene.beacons();
  DeviceEstimate<3> bias, same_bias;
  bias.P = same_bias.P = 1e-4 * Matrix3::Identity();
  table.lock_all();
  same.lock_all();
  One joint(scene.start(), HiBallScene::model());
  ScaatFilter<2> plain(scene.start(), HiBallScene::model());
  for (const BeaconSighting& s : sighting_stream(scene.simulator)) {
    const AngularRate rate{scene.truth.at(s.t).w_WB_B + Vector3(0.01, 0.0, -0.005), Quaternion::Identity(), 1e-5};
    REQUIRE(joint.update(s.t, scene.measurement(s), {table, s.beacon}) ==
            plain.update(s.t, scene.measurement(s), {same, s.beacon}));
    REQUIRE(joint.update(s.t, rate, {}, bias) == plain.update(s.t, rate, {}, same_bias));
  }
  CHECK(same_bias.x.norm() > 1e-4);
  CHECK((bias.x - same_bias.x).norm() < 1e-10);  // rounding
  CHECK(plain.state().error_of(joint.state()).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((plain.state().P - joint.state().P).norm() < 1e-9 * plain.state().P.norm());
}

namespace {

/// A target that moves as its model says, and beacons off their design as their table says; a camera at B looks at them.
struct MatchedWorld {
  std::mt19937 random;
  PvModel model;
  CameraView camera;
  TargetState<2> known, truth;
  std::vector<Vector3> beacons;
  DeviceTable<3> table;
  static constexpr double uv_variance = 1e-8;
  static constexpr int count = 6;

  explicit MatchedWorld(unsigned seed) : random(seed) {
    model.intensity << Vector3::Constant(0.01), Vector3::Constant(0.05);
    camera.V = view_matrix(Rigid(), 0.04);
    VectorOf<double, 12> sigma;
    sigma << Vector6::Constant(1e-3), Vector6::Constant(0.05);
    known.P = sigma.cwiseAbs2().asDiagonal();
    truth = known;
    truth.add(random_vector<12>(random).cwiseProduct(sigma));
    DeviceSettings<3> settings;
    settings.initial_variance.setConstant(4e-6);
    table = DeviceTable<3>(settings);
    for (int k = 0; k < count; ++k) {
      const double angle = 1.1 * k;
      const Vector3 designed(0.5 * std::cos(angle), 0.4 * std::sin(angle), -1.5 - 0.1 * k);
      table.add(designed);
      beacons.push_back(designed + random_vector<3>(random, 2e-3));
    }
  }

  void move(HostTime t) { wander(truth, model, t, random); }

  [[nodiscard]] CameraSighting sight(int beacon) {
    CameraSighting sighting{Vector2::Zero(), &camera, uv_variance};
    Linearization<CameraSighting> linear;
    REQUIRE(sighting.linearize(truth, beacons[static_cast<std::size_t>(beacon)], {}, linear));
    sighting.uv = random_vector<2>(random, std::sqrt(uv_variance)) - linear.residual;
    return sighting;
  }
};

}  // namespace

TEST_CASE("joint filter: as sure as it may be of pose and devices, where dropped correlation makes a filter too sure") {
  using Joint = One;
  constexpr int numbers = 3 * MatchedWorld::count;
  ConsistencyMean all(12 + numbers), innovations(2), joint_pose(6), plain_pose(6);
  for (unsigned run = 0; run < 60; ++run) {
    MatchedWorld world(100 + run);
    DeviceTable<3> plain_table = world.table;
    ScaatSettings attentive = no_gate();
    attentive.manoeuvre.threshold = 1.5;  // there is none
    Joint joint(world.known, world.model, attentive);
    ScaatFilter<2> plain(world.known, world.model, no_gate());
    for (int i = 1; i <= 300; ++i) {
      const HostTime t = time_at(0.005 * i);
      const int beacon = i % MatchedWorld::count;
      world.move(t);
      const CameraSighting sighting = world.sight(beacon);
      REQUIRE(joint.update(t, sighting, {world.table, beacon}) == UpdateStatus::updated);
      REQUIRE(plain.update(t, sighting, {plain_table, beacon}) == UpdateStatus::updated);
      innovations.add(joint.nis());
    }
    VectorOf<double, 12 + numbers> d;
    MatrixOf<double, 12 + numbers> P;
    const Joint::Joint& at_end = joint.joint_of(0);
    d.head<12>() = at_end.target.error_of(world.truth);
    P.topLeftCorner<12, 12>() = at_end.target.P;
    P.bottomLeftCorner<numbers, 12>() = at_end.P_dt;
    P.topRightCorner<12, numbers>() = at_end.P_dt.transpose();
    P.bottomRightCorner<numbers, numbers>() = at_end.P_dd;
    for (int beacon = 0; beacon < MatchedWorld::count; ++beacon) {
      const int slot = *joint.slot_of(world.table, beacon);
      d.segment<3>(12 + 3 * slot) = world.beacons[static_cast<std::size_t>(beacon)] - at_end.x.segment<3>(3 * slot);
    }
    all.add(normalised_square<12 + numbers>(d, P));
    joint_pose.add(pose_nees(joint.state(), world.truth));
    plain_pose.add(pose_nees(plain.state(), world.truth));
  }
  MESSAGE("NEES of all " << all.mean() << " of " << all.expected() << ", of the pose " << joint_pose.mean() << " of 6, "
                         << plain_pose.mean() << " where correlation is dropped; NIS " << innovations.mean()
                         << " of 2");
  CHECK(all.consistent());
  CHECK(joint_pose.consistent());
  CHECK(innovations.consistent());
  CHECK(plain_pose.mean() > 1.5 * joint_pose.mean());  // what it is for; 60 runs scatter by 7 %
}

TEST_CASE("joint filter: devices leave with what is known of them, and settle when asked") {
  const HiBallScene scene(still_hiball(from_seconds(0.2)));
  DeviceTable<3> table = scene.beacons();
  One filter(scene.start(), HiBallScene::model(), no_gate());
  const std::vector<BeaconSighting> sightings = sightings_of_few(scene, 8);
  std::map<int, HostTime> last;
  for (const BeaconSighting& s : sightings) {
    std::optional<int> leaves;
    if (!filter.slot_of(table, s.beacon) && last.size() >= 6) {
      for (const auto& [beacon, t] : last) {
        if (filter.slot_of(table, beacon) && (!leaves || t < last[*leaves])) leaves = beacon;
      }
    }
    DeviceEstimate<3> left;
    if (leaves) left = filter.joint_of(0).device(*filter.slot_of(table, *leaves));
    REQUIRE(filter.update(s.t, scene.measurement(s), {table, s.beacon}) == UpdateStatus::updated);
    last[s.beacon] = s.t;
    REQUIRE(filter.slot_of(table, s.beacon).has_value());
    // As of its last sighting a device is in the table as in its slot, to rounding.
    const DeviceEstimate<3> seated = filter.joint_of(0).device(*filter.slot_of(table, s.beacon));
    CHECK((table.at(s.beacon).x - seated.x).norm() < 1e-12);
    CHECK((table.at(s.beacon).P - seated.P).norm() < 1e-12 * seated.P.norm());
    if (!leaves) continue;
    CHECK_FALSE(filter.slot_of(table, *leaves).has_value());
    CHECK(table.at(*leaves).x == left.x);
    CHECK(table.at(*leaves).P == left.P);
  }
  filter.settle();
  for (const auto& [beacon, t] : last) {
    CHECK(table.sightings(beacon) > 0);
    if (const auto slot = filter.slot_of(table, beacon)) {
      CHECK(table.at(beacon).x == filter.joint_of(0).device(*slot).x);
    }
  }
  filter.restart(scene.start());
  for (const auto& [beacon, t] : last) CHECK_FALSE(filter.slot_of(table, beacon).has_value());
}

TEST_CASE("joint filter: what is refused changes nothing, and is counted by cause") {
  const HiBallScene scene(swaying_hiball(0.3));
  DeviceTable<3> table = scene.beacons();
  One filter(scene.start(), HiBallScene::model());
  const std::vector<BeaconSighting> sightings = sighting_stream(scene.simulator);
  for (const BeaconSighting& s : sightings) (void)filter.update(s.t, scene.measurement(s), {table, s.beacon});
  const One::Joint before = filter.joint_of(0);
  const int newcomer = table.size() - 1;
  REQUIRE_FALSE(filter.slot_of(table, newcomer).has_value());
  const HostTime later = sightings.back().t + std::chrono::milliseconds(1);
  CameraSighting sighting = scene.measurement(sightings.back());
  const auto refused = [&](HostTime t, const CameraSighting& s, int beacon, UpdateStatus why) {
    const std::uint64_t count = filter.counters()[why];
    CHECK(filter.update(t, s, {table, beacon}) == why);
    CHECK(filter.counters()[why] == count + 1);
    CHECK(filter.joint_of(0).P_dd == before.P_dd);
    CHECK(filter.joint_of(0).P_dt == before.P_dt);
    CHECK(filter.joint_of(0).x == before.x);
    CHECK(filter.state().P == before.target.P);
    CHECK_FALSE(filter.slot_of(table, newcomer).has_value());
  };
  refused(later, sighting, table.size(), UpdateStatus::no_such_device);
  refused(later - std::chrono::seconds(1), sighting, newcomer, UpdateStatus::time_backwards);
  refused(later + std::chrono::seconds(9), sighting, newcomer, UpdateStatus::gap_too_long);
  sighting.uv.x() += 0.003;  // beside a photodiode of 4 mm
  refused(later, sighting, sightings.back().beacon, UpdateStatus::gated);
  sighting.uv.x() = std::nan("");
  refused(later, sighting, newcomer, UpdateStatus::not_finite);
  sighting.uv.x() = 0.0;
  sighting.variance = -1.0;
  refused(later, sighting, newcomer, UpdateStatus::not_positive);
}

TEST_CASE("joint filter: finite and positive definite, whatever is measured; nothing is allocated") {
  const HiBallScene scene(swaying_hiball(0.2));
  const std::vector<BeaconSighting> sightings = sighting_stream(scene.simulator);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  const double inf = std::numeric_limits<double>::infinity();
  const std::array<double, 8> odd{0.0, -1.0, inf, -inf, std::nan(""), 1e300, 1e-300, 1e12};
  const auto any = [&](double good) { return share(random) < 0.3 ? odd[random() % odd.size()] : good; };
  const DeviceTable<3> fresh = scene.beacons();
  DeviceTable<3> table = fresh;
  const PvModel still = PvModel::hiball(1e-6, 1e-6, Vector3::Constant(1e-5));
  Two filter(scene.start(), ModelSet<2, 2>{{still, HiBallScene::model()}, {1.0, 1.0}},
             {.manoeuvre = {.threshold = 1.0}});
  double t = 0.0;
  const std::size_t allocations = test::allocations();
  for (int i = 0; i < 20000; ++i) {
    const BeaconSighting& s = sightings[random() % sightings.size()];
    CameraSighting sighting = scene.measurement(s);
    sighting.uv.x() = any(sighting.uv.x());
    sighting.uv.y() = any(sighting.uv.y() + 0.01 * (share(random) - 0.5));
    sighting.variance = any(sighting.variance * std::pow(10.0, 20.0 * share(random) - 15.0));
    if (i % 500 == 0) {  // or it would soon know nothing but nonsense, and refuse all
      TargetState<2> start = scene.start();
      start.t = time_at(t);
      filter.restart(start);
      table = fresh;
    }
    t += share(random) < 0.01 ? 4.0 * share(random) : 0.002 * share(random) - 0.0005;
    (void)filter.update(time_at(t), sighting, {table, s.beacon});
    if (share(random) < 0.01) table.lock(s.beacon, share(random) < 0.5);
    if (i % 500 != 499) continue;
    for (std::size_t model = 0; model < 2; ++model) {
      const auto& joint = filter.joint_of(model);
      REQUIRE(joint.target.is_finite());
      REQUIRE(joint.x.allFinite());
      REQUIRE(joint.P_dd.allFinite());
    }
    REQUIRE(filter.probabilities()[0] + filter.probabilities()[1] == Approx(1.0).epsilon(1e-12));
  }
  CHECK(test::allocations() == allocations);
  MatrixOf<double, 30> P;
  const auto& joint = filter.joint_of(0);
  P << joint.target.P, joint.P_dt.transpose(), joint.P_dt, joint.P_dd;
  CHECK(P == P.transpose());
  VectorOf<double, 30> scale = P.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation = scale.cwiseInverse().asDiagonal() * P * scale.cwiseInverse().asDiagonal();
  CHECK(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation).eigenvalues().minCoeff() > 0.0);
  CHECK(filter.counters()[UpdateStatus::updated] > 500);
  CHECK(filter.counters().total() == 20000);
}

TEST_CASE("joint filter: two models alike are as good as one; late measurements leave nothing behind") {
  const HiBallScene scene(swaying_hiball(0.5));
  const PvModel model = HiBallScene::model();
  const std::vector<BeaconSighting> sightings = sighting_stream(scene.simulator);
  DeviceTable<3> tables[3] = {scene.beacons(), scene.beacons(), scene.beacons()};
  One one(scene.start(), model);
  Two two(scene.start(), ModelSet<2, 2>{{model, model}, {0.1, 0.3}});
  for (const BeaconSighting& s : sightings) {
    const UpdateStatus status = one.update(s.t, scene.measurement(s), {tables[0], s.beacon});
    REQUIRE(two.update(s.t, scene.measurement(s), {tables[1], s.beacon}) == status);
  }
  one.settle();
  two.settle();
  // Rounding of 500 updates and mixtures.
  CHECK(one.state().error_of(two.state()).cwiseAbs().maxCoeff() < 1e-9);
  CHECK((one.state().P - two.state().P).norm() < 1e-9 * one.state().P.norm());

  using Event = UpdateEvent<CameraSighting>;
  DelayedFilter<One, Event> delayed(One(scene.start(), model), 60);
  std::mt19937 random(5);
  std::vector<std::size_t> arrivals(sightings.size());
  for (std::size_t i = 0; i < arrivals.size(); ++i) arrivals[i] = i;
  for (std::size_t i = 0; i + 50 < arrivals.size(); i += 50) std::shuffle(&arrivals[i], &arrivals[i] + 50, random);
  for (const std::size_t i : arrivals) {
    const BeaconSighting& s = sightings[i];
    (void)delayed.update(Event(s.t, scene.measurement(s), {tables[2], s.beacon}, static_cast<std::int64_t>(i)));
  }
  CHECK(delayed.counters().too_old == 0);
  CHECK(delayed.counters().late > 300);
  CHECK(delayed.filter().state().error_of(one.state()).norm() == 0.0);
  One settled = delayed.filter();
  settled.settle();
  double worst = 0.0;
  for (int i = 0; i < tables[0].size(); ++i) {
    worst = std::max(
        {worst, (tables[2].at(i).x - tables[0].at(i).x).norm(), (tables[2].at(i).P - tables[0].at(i).P).norm()});
  }
  CHECK(worst == 0.0);
}

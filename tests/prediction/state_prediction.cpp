#include <cmath>
#include <limits>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/prediction/state_prediction.hpp>

#include "allocation_counter.hpp"
#include "tracking/random_values.hpp"

using namespace holdfast;
using test::random_vector;

namespace {

using Random = std::mt19937;
constexpr StatePredictionLimits unlimited{std::chrono::hours(1), std::chrono::hours(1)};

template <int Order>
TargetState<Order> random_state(Random& random, double deviation = 0.01) {
  TargetState<Order> state;
  state.t = time_at(7.0);
  state.X_WB = Rigid(so3::exp<double>(random_vector<3>(random)), random_vector<3>(random, 2.0));
  if (Order >= 2) state.velocity = {random_vector<3>(random, 0.5), random_vector<3>(random, 1.5)};
  if (Order >= 3) state.acceleration = {random_vector<3>(random, 3.0), random_vector<3>(random, 6.0)};
  typename TargetState<Order>::Covariance root;
  for (int j = 0; j < root.cols(); ++j) root.col(j) = random_vector<6 * Order>(random, deviation);
  state.P = root * root.transpose();
  return state;
}

template <int Order>
ProcessModel<Order> model_of(double intensity, double decay) {
  ProcessModel<Order> model;
  model.intensity << 1.0, 2.0, 3.0, 0.7, 1.1, 0.4;
  model.intensity *= intensity;
  if (Order >= 2) model.decay.setConstant(decay);
  return model;
}

template <int Order>
void check_against_time_update(double decay) {
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const TargetState<Order> state = random_state<Order>(random);
    const ProcessModel<Order> model = model_of<Order>(0.5, decay);
    TargetState<Order> carried = state;
    const HostTime t = state.t + from_seconds(0.002 * trial);
    REQUIRE(advance(carried, model, t));
    const StatePrediction predicted = predict_state(state, model, t);
    CHECK(predicted.status == PredictionStatus::ok);
    CHECK(predicted.t == t);
    CHECK((predicted.X_WB.p() - carried.X_WB.p()).norm() < 1e-14);
    CHECK(so3::angle_between<double>(predicted.X_WB.q(), carried.X_WB.q()) < 1e-14);
    // Turns below a milliradian: the time update takes a short cut, good to a ten millionth.
    const Matrix6 P = carried.P.template topLeftCorner<6, 6>();
    CHECK((predicted.covariance - P).norm() < 1e-7 * P.norm());
    CHECK(predicted.covariance == predicted.covariance.transpose());
    CHECK(predicted.velocity.has_value() == (Order >= 2));
    if constexpr (Order >= 2) {
      CHECK((predicted.velocity->v_WB - carried.velocity.v_WB).norm() < 1e-14);
      CHECK((predicted.velocity->w_WB_B - carried.velocity.w_WB_B).norm() < 1e-14);
    }
  }
}

template <int Order>
void check_there_and_back(double decay) {
  Random random(4);
  for (int trial = 0; trial < 30; ++trial) {
    TargetState<Order> state = random_state<Order>(random);
    const HostTime t = state.t;
    const Rigid X_WB = state.X_WB;
    const Matrix6 P = state.P.template topLeftCorner<6, 6>();
    // No noise: what was certain of the past is what the past knew.
    ProcessModel<Order> silent = model_of<Order>(0.0, decay), noisy = model_of<Order>(1.0, decay);
    REQUIRE(advance(state, silent, t + std::chrono::milliseconds(20)));
    const StatePrediction back = predict_state(state, silent, t);
    CHECK(back.status == PredictionStatus::ok);
    CHECK(back.interval == -std::chrono::milliseconds(20));
    CHECK((back.X_WB.p() - X_WB.p()).norm() < 1e-13);
    CHECK(so3::angle_between<double>(back.X_WB.q(), X_WB.q()) < 1e-13);
    CHECK((back.covariance - P).norm() < 1e-6 * P.norm());
    // With noise it knows less.
    const Matrix6 more = predict_state(state, noisy, t).covariance - back.covariance;
    CHECK(more.trace() > 0.0);
    CHECK(more.diagonal().minCoeff() > 0.0);
  }
}

}  // namespace

TEST_CASE("ahead it is the filter's own time update") {
  check_against_time_update<1>(0.0);
  check_against_time_update<2>(0.0);
  check_against_time_update<2>(4.0);
  check_against_time_update<3>(0.0);
  check_against_time_update<3>(9.0);
}

TEST_CASE("back it undoes the time update") {
  check_there_and_back<1>(0.0);
  check_there_and_back<2>(0.0);
  check_there_and_back<2>(8.0);
  check_there_and_back<3>(0.0);
  check_there_and_back<3>(20.0);
}

TEST_CASE("no interval changes nothing") {
  Random random(1);
  const TargetState<3> state = random_state<3>(random);
  const StatePrediction now = predict_state(state, model_of<3>(1.0, 3.0), state.t);
  CHECK(now.status == PredictionStatus::ok);
  CHECK(now.interval == Duration(0));
  CHECK(now.X_WB.p() == state.X_WB.p());
  CHECK(so3::angle_between<double>(now.X_WB.q(), state.X_WB.q()) < 1e-15);
  CHECK(now.velocity->w_WB_B == state.velocity.w_WB_B);
  CHECK((now.covariance - state.P.topLeftCorner<6, 6>()).norm() < 1e-15 * state.P.norm());
}

TEST_CASE("closed forms: constant velocity, constant acceleration, what fades") {
  const double T = 0.08;
  TargetState<2> pv;
  pv.velocity = {Vector3(0.5, 0.0, -0.2), Vector3(0.0, 1.5, 0.0)};
  pv.P = 1e-4 * TargetState<2>::Covariance::Identity();
  for (int i = 0; i < 3; ++i) pv.P(i, 6 + i) = pv.P(6 + i, i) = 3e-5;
  const double q = 0.3;
  PvModel model;
  model.intensity.setConstant(q);
  const StatePrediction steady = predict_state(pv, model, time_at(T));
  CHECK((steady.X_WB.p() - T * pv.velocity.v_WB).norm() < 1e-16);
  CHECK(so3::log<double>(steady.X_WB.q()).y() == doctest::Approx(1.5 * T).epsilon(1e-14));
  CHECK(steady.velocity->v_WB == pv.velocity.v_WB);
  const double noise = q * T * T * T / 3.0;  // 002 eq. 4.7
  CHECK(steady.covariance(0, 0) == doctest::Approx(1e-4 + 2.0 * T * 3e-5 + T * T * 1e-4 + noise).epsilon(1e-13));
  CHECK(steady.covariance(4, 4) == doctest::Approx(1e-4 + T * T * 1e-4 + noise).epsilon(1e-13));  // the turn's own axis

  TargetState<3> pva;
  pva.velocity = pv.velocity;
  pva.acceleration = {Vector3(0.0, 2.0, 0.0), Vector3(0.0, -6.0, 0.0)};
  pva.P.setZero();
  PvaModel free;
  free.intensity.setConstant(q);
  const StatePrediction thrown = predict_state(pva, free, time_at(T));
  CHECK(thrown.X_WB.p().y() == doctest::Approx(0.5 * T * T * 2.0).epsilon(1e-14));
  CHECK(so3::log<double>(thrown.X_WB.q()).y() == doctest::Approx(1.5 * T - 0.5 * T * T * 6.0).epsilon(1e-13));
  CHECK(thrown.velocity->w_WB_B.y() == doctest::Approx(1.5 - 6.0 * T).epsilon(1e-14));
  CHECK(thrown.covariance(1, 1) == doctest::Approx(q * std::pow(T, 5) / 20.0).epsilon(1e-12));

  // A velocity that fades at rate g goes v (1 - exp(-g T)) / g, and at last v / g: it comes to rest.
  model.decay.setConstant(5.0);
  const StatePrediction fading = predict_state(pv, model, time_at(T));
  CHECK(fading.X_WB.p().x() == doctest::Approx(0.5 * (1.0 - std::exp(-5.0 * T)) / 5.0).epsilon(1e-13));
  CHECK(fading.velocity->v_WB.x() == doctest::Approx(0.5 * std::exp(-5.0 * T)).epsilon(1e-13));
  const StatePrediction rest = predict_state(pv, model, time_at(20.0), unlimited);
  CHECK(rest.X_WB.p().x() == doctest::Approx(0.5 / 5.0).epsilon(1e-13));
  CHECK(rest.velocity->v_WB.norm() < 1e-30);
  // By then position walks at random: q / g^2 (T - 3 / (2 g)), beside what the start left: var p + 2 cov / g + var v / g^2.
  CHECK(rest.covariance(0, 0) ==
        doctest::Approx(q / 25.0 * (20.0 - 0.3) + 1e-4 + 2.0 * 3e-5 / 5.0 + 1e-4 / 25.0).epsilon(1e-12));
  // An acceleration that fades leaves the velocity v + a / g.
  free.decay.setConstant(5.0);
  const StatePrediction coasting = predict_state(pva, free, time_at(20.0), unlimited);
  CHECK(coasting.velocity->v_WB.y() == doctest::Approx(2.0 / 5.0).epsilon(1e-13));
}

TEST_CASE("one long step is many short ones") {
  Random random(8);
  for (const double decay : {0.0, 6.0}) {
    for (int trial = 0; trial < 10; ++trial) {
      TargetState<3> state = random_state<3>(random);
      // Turning about one axis: with the acceleration in the rate's direction.
      state.acceleration.alpha_WB_B = -4.0 * state.velocity.w_WB_B;
      const PvaModel model = model_of<3>(0.4, decay);
      const Duration T = std::chrono::milliseconds(100);
      const StatePrediction once = predict_state(state, model, state.t + T);
      TargetState<3> stepped = state;
      for (int i = 1; i <= 50; ++i) REQUIRE(advance(stepped, model, state.t + T * i / 50));
      CHECK((once.X_WB.p() - stepped.X_WB.p()).norm() < 1e-13);
      CHECK(so3::angle_between<double>(once.X_WB.q(), stepped.X_WB.q()) < 1e-13);
      CHECK((once.velocity->w_WB_B - stepped.velocity.w_WB_B).norm() < 1e-12);
      // The covariance's step is that of a turn at the mean rate: what turns meanwhile differs, by less than the turn
      // squared / 12 of the part that velocities and noise add.
      const Matrix6 P = stepped.P.topLeftCorner<6, 6>();
      CHECK((once.covariance - P).norm() < 0.01 * P.norm());

      // Rate and acceleration in different directions: the next term of Magnus's series.
      state.acceleration.alpha_WB_B = random_vector<3>(random, 6.0);
      const StatePrediction turning = predict_state(state, model, state.t + T);
      stepped = state;
      for (int i = 1; i <= 50; ++i) REQUIRE(advance(stepped, model, state.t + T * i / 50));
      const double next = 1e-3 * state.velocity.w_WB_B.cross(state.acceleration.alpha_WB_B).norm() / 12.0;
      CHECK(so3::angle_between<double>(turning.X_WB.q(), stepped.X_WB.q()) < 1.1 * next + 1e-9);
    }
  }
}

TEST_CASE("the covariance is that of many heads that move as the model says") {
  Random random(21);
  const TargetState<3> state = random_state<3>(random, 0.004);
  const PvaModel model = model_of<3>(4.0, 10.0);
  const Duration T = std::chrono::milliseconds(60);
  const StatePrediction predicted = predict_state(state, model, state.t + T);
  const Eigen::LLT<Eigen::Matrix<double, 18, 18>> factor(state.P + 1e-15 * TargetState<3>::Covariance::Identity());
  REQUIRE(factor.info() == Eigen::Success);
  const TargetState<3>::Covariance root = factor.matrixL();
  std::array<MatrixOf<double, 3>, 6> kicks;
  constexpr int steps = 6, heads = 20000;
  for (int axis = 0; axis < 6; ++axis) {
    const ChainStep<3> step = chain_step<3>(model.intensity[axis], model.decay[axis], to_seconds(T) / steps);
    kicks[static_cast<std::size_t>(axis)] = step.Q.llt().matrixL();
  }
  Matrix6 sum = Matrix6::Zero();
  Vector6 mean = Vector6::Zero();
  for (int head = 0; head < heads; ++head) {
    TargetState<3> truth = state;
    truth.P.setZero();
    truth.add(root * random_vector<18>(random));
    for (int i = 1; i <= steps; ++i) {
      // The nominal motion alone, by a prediction of this head's state: advance() would carry its covariance as well.
      const HostTime t = state.t + T * i / steps;
      const StatePrediction next = predict_state(truth, model, t);
      const double fade = std::exp(-10.0 * to_seconds(t - truth.t));
      truth.t = t;
      truth.X_WB = next.X_WB;
      truth.velocity = *next.velocity;
      truth.acceleration.a_WB *= fade;
      truth.acceleration.alpha_WB_B *= fade;
      TargetState<3>::Error d;
      for (int axis = 0; axis < 6; ++axis) {
        const Vector3 kick = kicks[static_cast<std::size_t>(axis)] * random_vector<3>(random);
        for (int k = 0; k < 3; ++k) d[axis + 6 * k] = kick[k];
      }
      truth.add(d);
    }
    Vector6 d;
    d << truth.X_WB.p() - predicted.X_WB.p(), so3::log<double>(predicted.X_WB.q().conjugate() * truth.X_WB.q());
    mean += d / heads;
    sum += d * d.transpose() / heads;
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      // A covariance from n heads scatters by sqrt((1 + rho^2) / n), here at most 1 %; 4 of these.
      const double scale = std::sqrt(predicted.covariance(i, i) * predicted.covariance(j, j));
      CHECK(std::abs(sum(i, j) - predicted.covariance(i, j)) < 0.04 * scale);
    }
    CHECK(std::abs(mean[i]) < 0.04 * std::sqrt(predicted.covariance(i, i)));  // 4 / sqrt(n) is 0.03; Magnus's term adds
  }
}

TEST_CASE("turning the whole world turns the prediction with it") {
  Random random(6);
  TargetState<3> state = random_state<3>(random), turned = state;
  const Rigid X_VW(so3::exp<double>(Vector3(-0.7, 2.0, 0.4)), Vector3(1, 5, -2));
  Eigen::Matrix<double, 18, 18> turn = Eigen::Matrix<double, 18, 18>::Identity();
  for (const int i : {0, 6, 12}) turn.block<3, 3>(i, i) = X_VW.R();
  turned.X_WB = X_VW * state.X_WB;
  turned.velocity.v_WB = X_VW.q() * state.velocity.v_WB;
  turned.acceleration.a_WB = X_VW.q() * state.acceleration.a_WB;
  turned.P = turn * state.P * turn.transpose();
  PvaModel model;  // the same along all of the world's axes
  model.decay.setConstant(3.0);
  for (const int ms : {-15, 40, 300}) {
    const HostTime t = state.t + std::chrono::milliseconds(ms);
    const StatePrediction a = predict_state(state, model, t), b = predict_state(turned, model, t);
    CHECK((X_VW * a.X_WB.p() - b.X_WB.p()).norm() < 1e-13);
    CHECK(so3::angle_between<double>(X_VW.q() * a.X_WB.q(), b.X_WB.q()) < 1e-13);
    const Matrix6 expected = turn.topLeftCorner<6, 6>() * a.covariance * turn.topLeftCorner<6, 6>().transpose();
    CHECK((expected - b.covariance).norm() < 1e-12 * expected.norm());
  }
}

TEST_CASE("uncertainty never shrinks with the interval, before and beyond the limit") {
  TargetState<3> state;
  state.velocity = {Vector3(0.4, 0, 0), Vector3(0, 1, 0)};
  state.acceleration = {Vector3(0, 2, 0), Vector3(3, 0, 0)};
  state.P = 1e-6 * TargetState<3>::Covariance::Identity();
  const PvaModel model = model_of<3>(1.0, 5.0);
  double before = 0.0;
  for (int ms = 0; ms <= 600; ms += 10) {
    const double trace = predict_state(state, model, time_at(0.001 * ms)).covariance.trace();
    CHECK(trace > before);
    before = trace;
  }
}

TEST_CASE("limits, bad states and absurd times have a status, a usable pose and finite numbers") {
  Random random(2);
  const TargetState<3> state = random_state<3>(random);
  const PvaModel model = model_of<3>(1.0, 30.0);
  const StatePredictionLimits limits{std::chrono::milliseconds(50), std::chrono::milliseconds(5)};
  const auto at = [&](Duration d) { return predict_state(state, model, state.t + d, limits); };
  const StatePrediction limit = at(std::chrono::milliseconds(50)), beyond = at(std::chrono::milliseconds(70));
  CHECK(limit.status == PredictionStatus::ok);
  CHECK(beyond.status == PredictionStatus::clamped);
  CHECK(beyond.X_WB.p() == limit.X_WB.p());
  CHECK(beyond.interval == std::chrono::milliseconds(50));
  CHECK_FALSE(beyond.velocity);
  CHECK(at(-std::chrono::milliseconds(5)).status == PredictionStatus::ok);
  const StatePrediction past = at(-std::chrono::milliseconds(6));
  CHECK(past.status == PredictionStatus::backwards);
  CHECK(past.X_WB.p() == state.X_WB.p());
  CHECK(past.interval == Duration(0));
  for (const auto ticks : {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
    const StatePrediction far = predict_state(state, model, HostTime{Duration(ticks)});
    CHECK(far.status == (ticks > 0 ? PredictionStatus::clamped : PredictionStatus::backwards));
    CHECK(far.X_WB.is_finite());
    CHECK(far.covariance.allFinite());
  }

  const double nan = std::numeric_limits<double>::quiet_NaN();
  TargetState<3> bad_velocity = state, bad_covariance = state, bad_pose = state, fast = state;
  bad_velocity.velocity.w_WB_B.y() = nan;
  bad_covariance.P(2, 7) = nan;
  bad_pose.X_WB = Rigid::translation(Vector3(0, nan, 0));
  fast.velocity.w_WB_B.setConstant(1e200);
  for (const TargetState<3>& bad : {bad_velocity, bad_covariance, bad_pose, fast}) {
    const StatePrediction result = predict_state(bad, model, state.t + std::chrono::milliseconds(10));
    CHECK(result.status == PredictionStatus::not_finite);
    CHECK(result.X_WB.is_finite());
    CHECK(result.covariance.allFinite());
    CHECK_FALSE(result.velocity);
  }
  CHECK(predict_state(bad_velocity, model, state.t).X_WB.p() == state.X_WB.p());
  CHECK(predict_state(bad_pose, model, state.t).X_WB.p() == Vector3::Zero());
}

TEST_CASE("predicting a state allocates nothing") {
  Random random(2);
  const TargetState<3> state = random_state<3>(random);
  const PvaModel model = model_of<3>(1.0, 30.0);
  const std::size_t before = test::allocations();
  double sum = 0.0;
  for (const int ms : {-50, -10, 0, 60, 500}) {
    sum += predict_state(state, model, state.t + std::chrono::milliseconds(ms)).covariance.trace();
  }
  CHECK(test::allocations() == before);
  CHECK(std::isfinite(sum));
}

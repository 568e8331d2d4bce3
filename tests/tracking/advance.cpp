#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/geometry/numeric_jacobian.hpp>
#include <holdfast/tracking/advance.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;

namespace {

template <int Order>
TargetState<Order> random_state(std::mt19937& random, double speed) {
  TargetState<Order> state;
  state.X_WB = Rigid(so3::exp<double>(random_vector<3>(random, 1.0)), random_vector<3>(random, 2.0));
  if (Order >= 2) state.velocity = {random_vector<3>(random, speed), random_vector<3>(random, speed)};
  if (Order >= 3) state.acceleration = {random_vector<3>(random, 3.0), random_vector<3>(random, speed)};
  using Covariance = typename TargetState<Order>::Covariance;
  Covariance root;
  for (int j = 0; j < root.cols(); ++j) root.col(j) = random_vector<6 * Order>(random, 0.1);
  state.P = root * root.transpose() + 1e-3 * Covariance::Identity();
  return state;
}

template <int Order>
ProcessModel<Order> random_model(std::mt19937& random) {
  ProcessModel<Order> model;
  model.intensity = random_vector<6>(random, 1.0).cwiseAbs();
  if (Order >= 2) model.decay = random_vector<6>(random, 3.0).cwiseAbs();
  if (Order >= 2) model.decay[1] = 0.0;
  return model;
}

// Q of a chain by its defining equation, Q' = A Q + Q A^T + B B^T, in Runge and Kutta's steps.
template <int Order>
MatrixOf<double, Order> noise_by_integration(double decay, double dt) {
  using Matrix = MatrixOf<double, Order>;
  Matrix A = Matrix::Zero();
  for (int i = 0; i + 1 < Order; ++i) A(i, i + 1) = 1.0;
  A(Order - 1, Order - 1) = -decay;
  Matrix B = Matrix::Zero();
  B(Order - 1, Order - 1) = 1.0;
  const auto rate = [&](const Matrix& Q) { return Matrix(A * Q + Q * A.transpose() + B); };
  const int steps = std::max(400, static_cast<int>(decay * dt * 400.0));
  const double h = dt / steps;
  Matrix Q = Matrix::Zero();
  for (int i = 0; i < steps; ++i) {
    const Matrix k1 = rate(Q), k2 = rate(Q + 0.5 * h * k1), k3 = rate(Q + 0.5 * h * k2), k4 = rate(Q + h * k3);
    Q += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return Q;
}

template <typename A, typename B>
double relative_difference(const A& a, const B& b) {
  double worst = 0.0;
  for (int i = 0; i < a.rows(); ++i) {
    for (int j = 0; j < a.cols(); ++j) {
      const double scale = std::sqrt(std::abs(b(i, i) * b(j, j)));
      worst = std::max(worst, std::abs(a(i, j) - b(i, j)) / scale);
    }
  }
  return worst;
}

template <int Order>
void check_transition() {
  std::mt19937 random(7 + Order);
  for (int trial = 0; trial < 60; ++trial) {
    // From still to several turns a second, over steps of up to half a second: turns beyond pi as well.
    const TargetState<Order> state = random_state<Order>(random, trial % 3 == 0 ? 1e-4 : trial % 3 == 1 ? 0.4 : 6.0);
    const ProcessModel<Order> model = random_model<Order>(random);
    const HostTime t = time_at(trial % 2 == 0 ? 0.001 : 0.5);
    TargetState<Order> carried = state;
    REQUIRE(advance(carried, model, t));
    const auto error_after = [&](const typename TargetState<Order>::Error& d) {
      TargetState<Order> moved = state;
      moved.add(d);
      REQUIRE(advance(moved, model, t));
      return carried.error_of(moved);
    };
    using Error = typename TargetState<Order>::Error;
    const auto numeric = numeric_jacobian(error_after, Error(Error::Zero()));
    const auto F = state_transition(state, model, t);
    // Central differences of functions of size 1 are good to 1e-9 here.
    CHECK((F - numeric).cwiseAbs().maxCoeff() < 1e-8);

    typename TargetState<Order>::Covariance Q = TargetState<Order>::Covariance::Zero();
    for (int axis = 0; axis < 6; ++axis) {
      const ChainStep<Order> step =
          chain_step<Order>(model.intensity[axis], model.decay[axis], to_seconds(t - state.t));
      for (int i = 0; i < Order; ++i) {
        for (int j = 0; j < Order; ++j) Q(axis + 6 * i, axis + 6 * j) = step.Q(i, j);
      }
    }
    const typename TargetState<Order>::Covariance dense = F * state.P * F.transpose() + Q;
    // A turn below a milliradian, here in a millisecond, has J off by 1e-7 of the 1e-3 s that multiply it.
    CHECK(relative_difference(carried.P, dense) < 1e-9);
    CHECK(carried.P == carried.P.transpose());

    // The filter's own variant leaves the same lower triangle.
    TargetState<Order> beside;
    beside.P.setConstant(std::nan(""));
    REQUIRE(detail::advance_lower(state, model, t, beside));
    CHECK(beside.P.template triangularView<Eigen::Lower>().toDenseMatrix() ==
          carried.P.template triangularView<Eigen::Lower>().toDenseMatrix());
    CHECK(beside.P.template topLeftCorner<6, 6>() == carried.P.template topLeftCorner<6, 6>());
  }
}

}  // namespace

TEST_CASE("a chain's noise: 002 eq. 4.7 for PV, and the integral of its defining equation for all") {
  const double dt = 0.013;
  const double mu = 0.7;
  const ChainStep<2> pv = chain_step<2>(mu, 0.0, dt);
  CHECK(pv.Q(0, 0) == doctest::Approx(mu * dt * dt * dt / 3.0).epsilon(1e-15));
  CHECK(pv.Q(0, 1) == doctest::Approx(mu * dt * dt / 2.0).epsilon(1e-15));
  CHECK(pv.Q(1, 1) == doctest::Approx(mu * dt).epsilon(1e-15));
  CHECK(pv.A(0, 1) == dt);
  for (const double decay : {0.0, 1e-9, 1e-3, 0.3, 7.0, 76.9, 77.0, 300.0, 8000.0}) {  // the form changes at 1 / dt
    CAPTURE(decay);
    // Runge and Kutta's error with 400 steps per decay time is about 1e-11.
    CHECK(relative_difference(chain_step<2>(1.0, decay, dt).Q, noise_by_integration<2>(decay, dt)) < 1e-9);
    CHECK(relative_difference(chain_step<3>(1.0, decay, dt).Q, noise_by_integration<3>(decay, dt)) < 1e-9);
  }
}

TEST_CASE("both forms of a decaying chain's noise agree where they meet") {
  for (const double u : {1.0, 1.001}) {
    CHECK(relative_difference(detail::decaying_noise_by_points<2>(u, 1.0), detail::decaying_noise_closed<2>(u, 1.0)) <
          1e-12);
    CHECK(relative_difference(detail::decaying_noise_by_points<3>(u, 1.0), detail::decaying_noise_closed<3>(u, 1.0)) <
          1e-12);
  }
  for (int n = 0; n < 3; ++n) {
    CHECK(detail::decayed_power(n, 1.0 - 1e-15) == doctest::Approx(detail::decayed_power(n, 1.0)).epsilon(1e-13));
  }
}

TEST_CASE("Singer's model is PVA without decay, damped PV is PV, and both forget in the long run") {
  for (const double dt : {1e-3, 0.1, 2.0}) {
    // The first difference is of relative order decay dt.
    CHECK(relative_difference(chain_step<3>(1.0, 1e-12, dt).Q, chain_step<3>(1.0, 0.0, dt).Q) < 1e-11);
    CHECK(relative_difference(chain_step<2>(1.0, 1e-12, dt).Q, chain_step<2>(1.0, 0.0, dt).Q) < 1e-11);
    CHECK((chain_step<3>(1.0, 1e-12, dt).A - chain_step<3>(1.0, 0.0, dt).A).cwiseAbs().maxCoeff() < 1e-11);
    CHECK((chain_step<3>(1.0, 5e-324, dt).A - chain_step<3>(1.0, 0.0, dt).A).cwiseAbs().maxCoeff() < 1e-15);
  }
  for (const double dt : {100.0, 1e5, 9e9}) {  // up to what a HostTime can hold
    const ChainStep<3> step = chain_step<3>(2.0, 5.0, dt);
    CHECK(step.A(2, 2) == doctest::Approx(0.0).epsilon(1e-12));
    CHECK(step.A(1, 2) == doctest::Approx(1.0 / 5.0));
    CHECK(step.Q(2, 2) == doctest::Approx(2.0 / (2.0 * 5.0)));
    CHECK(step.Q(1, 1) == doctest::Approx(2.0 / 25.0 * (dt - 1.5 / 5.0)));
  }
}

TEST_CASE("a step is two half steps") {
  const auto check = [](const auto& whole, const auto& half) {
    CHECK((half.A * half.A - whole.A).cwiseAbs().maxCoeff() < 1e-14);
    CHECK(relative_difference((half.A * half.Q * half.A.transpose() + half.Q).eval(), whole.Q) < 1e-12);
  };
  for (const double decay : {0.0, 1e-3, 0.9, 1.7, 3.0, 30.0}) {
    check(chain_step<1>(0.3, 0.0, 1.0), chain_step<1>(0.3, 0.0, 0.5));
    check(chain_step<2>(0.3, decay, 1.0), chain_step<2>(0.3, decay, 0.5));
    check(chain_step<3>(0.3, decay, 1.0), chain_step<3>(0.3, decay, 0.5));
  }
}

TEST_CASE("the transition of errors is the derivative of the nominal motion, and carries the covariance") {
  check_transition<1>();
  check_transition<2>();
  check_transition<3>();
}

TEST_CASE("a state is carried by its velocities; a turn without end is refused") {
  TargetState<2> state;
  state.velocity = {Vector3(1.0, 0.0, -2.0), Vector3(0.0, 0.0, 0.5)};
  PvModel model;
  REQUIRE(advance(state, model, time_at(0.5)));
  CHECK((state.X_WB.p() - Vector3(0.5, 0.0, -1.0)).norm() < 1e-15);
  CHECK(so3::angle_between(state.X_WB.q(), so3::exp<double>(Vector3(0.0, 0.0, 0.25))) < 1e-15);
  const TargetState<2> before = state;
  state.velocity.w_WB_B.setConstant(1e200);
  CHECK_FALSE(advance(state, model, time_at(1.0)));
  CHECK(state.P == before.P);
  CHECK(state.t == before.t);
}

TEST_CASE("process models name what is wrong with them") {
  CHECK_FALSE(PvModel().problem());
  PvModel model;
  model.intensity[2] = -1.0;
  CHECK(model.problem());
  model = PvModel();
  model.decay[0] = std::nan("");
  CHECK(model.problem());
  ProcessModel<1> still;
  still.decay[3] = 1.0;
  CHECK(still.problem());
}

// Prediction is part of every frame: it allocates nothing. Counted by replacing the global operator new of this test
// program.
#include <cmath>
#include <cstddef>

#include <doctest/doctest.h>

#include <holdfast/prediction/predictor.hpp>
#include <holdfast/tracking/backward_difference.hpp>

#include "allocation_counter.hpp"

using namespace holdfast;

TEST_CASE("velocity, prediction and covariance allocate nothing, whatever the status") {
  const Rigid older, newer(so3::exp<double>(Vector3(0.01, 0.02, 0.0)), Vector3(0.001, 0, 0));
  double sum = 0.0;
  const std::size_t before = test::allocations();
  const PoseEstimate estimate = backward_difference({time_at(1.0), older}, {time_at(1.0167), newer}, {1e-4, 2e-4});
  for (const Predictor predictor : predictors) {
    for (const int ms : {-5, 0, 60, 500}) {
      const PredictionResult r = predict(predictor, estimate, estimate.t + std::chrono::milliseconds(ms));
      sum += r.covariance.trace() + r.X_WB.p().x();
    }
  }
  const std::size_t after = test::allocations();
  CHECK(after == before);
  CHECK(std::isfinite(sum));
  CHECK(test::counts_allocations());
}

// The code of docs/prediction.md, as it stands there.
#include <cstdio>

#include <doctest/doctest.h>

#include <holdfast/prediction/prediction.hpp>

using namespace holdfast;

TEST_CASE("the page's example") {
  const TimedPose older{time_at(0.0), Rigid()}, newer{time_at(0.01), Rigid::translation(Vector3(0.001, 0, 0))};
  PoseEstimate head = backward_difference(older, newer);
  PredictionResult r = predict_constant_velocity(head, head.t + std::chrono::milliseconds(20));
  if (r.status != PredictionStatus::ok) std::puts(to_string(r.status).data());
  Rigid X_WH = r.X_WB;
  CHECK((X_WH.p() - Vector3(0.003, 0, 0)).norm() < 1e-15);
}

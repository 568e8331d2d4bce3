// The code of docs/prediction.md, as it stands there.
#include <cmath>
#include <cstdio>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/prediction/predictor.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/tracking/backward_difference.hpp>
#include <holdfast/tracking/pose_filter.hpp>

using namespace holdfast;

TEST_CASE("the page's example") {
  const TimedPose older{time_at(0.0), Rigid()}, newer{time_at(0.01), Rigid::translation(Vector3(0.001, 0, 0))};
  PoseEstimate head = backward_difference(older, newer);
  PredictionResult r = predict_constant_velocity(head, head.t + std::chrono::milliseconds(20));
  if (r.status != PredictionStatus::ok) std::puts(to_string(r.status).data());
  Rigid X_WH = r.X_WB;
  CHECK((X_WH.p() - Vector3(0.003, 0, 0)).norm() < 1e-15);
}

TEST_CASE("the page's example of a filter") {
  std::vector<TimedPose> measured;
  for (int i = 0; i < 100; ++i) {
    measured.push_back({time_at(0.01 * i), Rigid::translation(Vector3(0.003 * i, 0, 0))});
  }
  const HostTime display_time = time_at(1.05);
  const auto draw = [](const Rigid& X_WH, const Matrix6& covariance) {
    CHECK(std::abs(X_WH.p().x() - 0.315) < 1e-5);  // a start without velocity has died out by exp(-20) or so
    CHECK(covariance(0, 0) > 0.0);
  };

  PoseFilter<3> filter(head_model());  // or a ScaatFilter, or any other with a state and a model
  for (const TimedPose& pose : measured) filter.update(pose);
  StatePrediction s = predict_state(filter.state(), filter.model(), display_time);
  draw(s.X_WB, s.covariance);  // s.velocity too
}

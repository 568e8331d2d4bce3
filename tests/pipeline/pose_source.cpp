// Sources of poses behind one interface.
#include <limits>
#include <optional>

#include <doctest/doctest.h>

#include <holdfast/pipeline/pose_source.hpp>

using namespace holdfast;

namespace {

PoseEstimate turning_head(double t) {
  PoseEstimate e;
  e.t = time_at(t);
  e.X_WB = Rigid(so3::exp<double>(Vector3(0.1, 0.5, 0.0)), Vector3(0.1, 1.7, 0.3));
  e.velocity = Twist{Vector3(0.2, 0.0, -0.1), Vector3(0.0, 1.7, 0.2)};
  return e;
}

}  // namespace

TEST_CASE("a latest-pose source says what the predictor says of the newest estimate") {
  LatestPose latest;
  const LatestPoseSource source(latest);
  const LatestPoseSource unpredicted(latest, Predictor::none);
  CHECK_FALSE(source.newest(time_at(1.0)).has_value());
  latest.publish(turning_head(0.99));
  latest.publish(turning_head(1.0));
  const std::optional<PoseEstimate> newest = source.newest(time_at(1.0));
  REQUIRE(newest.has_value());
  CHECK(newest->t == time_at(1.0));

  const PredictionResult expected = predict_constant_velocity(*newest, time_at(1.03));
  const PredictionResult got = source.predict(*newest, time_at(1.03));
  CHECK(got.X_WB.matrix() == expected.X_WB.matrix());
  CHECK(got.covariance == expected.covariance);
  CHECK(got.status == PredictionStatus::ok);
  CHECK(source.predict(*newest, time_at(1.5)).status == PredictionStatus::clamped);
  CHECK(unpredicted.predict(*newest, time_at(1.03)).X_WB.matrix() == newest->X_WB.matrix());
}

TEST_CASE("a runtime that predicts by itself is not predicted again") {
  // It answers with a velocity, as OpenXR's xrLocateSpace may: extrapolating from it would predict twice.
  bool is_tracked = true;
  const auto locate = [&](HostTime t) -> std::optional<PoseEstimate> {
    if (!is_tracked) return std::nullopt;
    PoseEstimate e = turning_head(0.0);
    e.X_WB = Rigid::translation(Vector3(to_seconds(t.time_since_epoch()), 0, 0));
    return e;
  };
  const RuntimePoseSource source(locate);
  const std::optional<PoseEstimate> now = source.newest(time_at(1.0));
  REQUIRE(now.has_value());
  CHECK(now->t == time_at(1.0));
  CHECK(now->X_WB.p().x() == 1.0);
  const PredictionResult later = source.predict(*now, time_at(1.25));
  CHECK(later.X_WB.p().x() == 1.25);
  CHECK(later.status == PredictionStatus::ok);
  CHECK(later.interval == from_milliseconds(250));

  // Lost in between: the pose is held, and that is told.
  is_tracked = false;
  CHECK_FALSE(source.newest(time_at(1.0)).has_value());
  const PredictionResult lost = source.predict(*now, time_at(1.25));
  CHECK(lost.X_WB.p().x() == 1.0);
  CHECK(lost.status == PredictionStatus::no_velocity);
}

TEST_CASE("a runtime's NaN is told") {
  const auto locate = [](HostTime) -> std::optional<PoseEstimate> {
    PoseEstimate e;
    e.X_WB = Rigid::translation(Vector3(std::numeric_limits<double>::quiet_NaN(), 0, 0));
    return e;
  };
  const RuntimePoseSource source(locate);
  CHECK(source.predict(turning_head(1.0), time_at(1.0)).status == PredictionStatus::not_finite);
  CHECK(source.predict(turning_head(1.0), time_at(1.0)).X_WB.is_finite());
}

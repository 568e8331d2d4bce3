/// Where a frame loop gets its head poses from: the small interface behind which any tracker or runtime fits.
///
/// `newest` is the newest measurement, `predict` carries a measurement to another time. They are two calls, so that
/// all poses of one frame (both eyes, start and end of the scan) come from one measurement. The frame loop itself never
/// extrapolates: a source whose runtime predicts (OpenXR's xrLocateSpace) hands the runtime's answers through, and
/// nothing is predicted twice.
///   LatestPoseSource      LatestPose and one of prediction/'s predictors
///   RuntimePoseSource     a function from a time to a pose that is already predicted
/// Threads: as many as LatestPose allows; a RuntimePoseSource as many as its function. Nothing here allocates, locks or
/// throws. Bad input: answered by PredictionStatus.
#pragma once

#include <optional>
#include <utility>

#include <holdfast/pipeline/latest_pose.hpp>
#include <holdfast/prediction/predictor.hpp>

namespace holdfast {

class PoseSource {
 public:
  virtual ~PoseSource() = default;

  /// The newest measurement that is known at `now`; nothing when there is none.
  [[nodiscard]] virtual std::optional<PoseEstimate> newest(HostTime now) const = 0;

  /// The pose at t, from a measurement that `newest` gave.
  [[nodiscard]] virtual PredictionResult predict(const PoseEstimate& from, HostTime t) const = 0;
};

/// What a tracker publishes, carried on by a predictor.
class LatestPoseSource : public PoseSource {
 public:
  /// `latest` is not owned.
  explicit LatestPoseSource(const LatestPose& latest, Predictor predictor = Predictor::constant_velocity,
                            const PredictionLimits& limits = {}, const HeadDynamics& head = {})
      : latest_(&latest), predictor_(predictor), limits_(limits), head_(head) {}

  [[nodiscard]] std::optional<PoseEstimate> newest(HostTime) const override { return latest_->newest(); }
  [[nodiscard]] PredictionResult predict(const PoseEstimate& from, HostTime t) const override {
    return holdfast::predict(predictor_, from, t, limits_, head_);
  }

 private:
  const LatestPose* latest_;
  Predictor predictor_;
  PredictionLimits limits_;
  HeadDynamics head_;
};

/// A runtime that answers "where will the head be at t" itself. `Locate` is callable as
/// std::optional<PoseEstimate>(HostTime t), from a const object; nothing while the head is not tracked.
template <typename Locate>
class RuntimePoseSource : public PoseSource {
 public:
  explicit RuntimePoseSource(Locate locate) : locate_(std::move(locate)) {}

  /// The runtime does not tell when it measured, so its pose of `now` stands for the measurement.
  [[nodiscard]] std::optional<PoseEstimate> newest(HostTime now) const override { return located(now); }

  /// Asks the runtime anew; when it has lost the head meanwhile, the pose is held, with status no_velocity.
  [[nodiscard]] PredictionResult predict(const PoseEstimate& from, HostTime t) const override {
    const std::optional<PoseEstimate> at_t = located(t);
    if (!at_t) {
      PredictionResult held = predict_none(from, t);
      if (held.status == PredictionStatus::ok) held.status = PredictionStatus::no_velocity;  // nothing to carry it on
      return held;
    }
    PredictionResult result = predict_none(*at_t, t);
    result.interval = t - from.t;
    return result;
  }

 private:
  [[nodiscard]] std::optional<PoseEstimate> located(HostTime t) const {
    std::optional<PoseEstimate> estimate = locate_(t);
    if (estimate) estimate->t = t;
    return estimate;
  }

  Locate locate_;
};

}  // namespace holdfast

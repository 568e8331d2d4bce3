/// Curves for the page of `swimlab track hiball`: error against time, its spectrum, recovery. Short however long the run.
#pragma once

#include <optional>
#include <vector>

#include <holdfast/registration/track_types.hpp>

namespace swimlab {

/// What a curve says of a row. Errors are of three points, mm.
enum class TrackCurveKind {
  error,           ///< against s: each bin's worst estimate
  noise,           ///< against Hz: density of the error that each estimate had at its own time, mm/sqrt(Hz)
  held_noise,      ///< the same of the newest estimate against the truth of each sighting's time
  half_recovered,  ///< against ms since there was something to see again: what half of the trials are below
  most_recovered   ///< what nine of ten trials are below
};

struct TrackCurve {
  struct Point {
    double x = 0.0, y = 0.0;
  };
  TrackCurveKind kind = TrackCurveKind::error;
  std::vector<Point> points;
};

/// Watches one method. Sightings come at a constant rate where noise is asked for.
class TrackCurves {
 public:
  explicit TrackCurves(const holdfast::Motion& truth, bool noise = false);

  void add(const holdfast::TrackMoment& moment);
  [[nodiscard]] std::vector<TrackCurve> curves() const;

 private:
  using Errors = holdfast::VectorOf<double, 9>;

  [[nodiscard]] TrackCurve spectrum(TrackCurveKind kind, const std::vector<Errors>& errors) const;

  bool noise_;
  holdfast::HostTime begin_;
  double bin_s_;
  std::vector<std::optional<double>> worst_mm_;
  Errors newest_mm_ = Errors::Zero();
  std::vector<Errors> at_estimates_mm_, held_mm_;
  std::optional<holdfast::HostTime> first_, last_;
};

/// Watches trials of finding the pose, each of 0.3 s from the moment on from which there is something to see.
class RecoveryCurves {
 public:
  void begin(holdfast::HostTime since);
  /// Of the trial begun last.
  void add(const holdfast::TrackMoment& moment);
  [[nodiscard]] std::vector<TrackCurve> curves() const;

 private:
  struct Trial {
    holdfast::HostTime since;
    bool found = false;
    std::vector<double> error_mm;  ///< infinite as long as there is no estimate
  };
  [[nodiscard]] TrackCurve below(TrackCurveKind kind, double part) const;

  std::vector<Trial> trials_;
};

}  // namespace swimlab

/// The report's charts as JSON: what report.js draws with dygraphs.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include <holdfast/io/results.hpp>
#include <holdfast/motion/motion.hpp>

#include "row_runner.hpp"

namespace swimlab {

/// A number with four significant digits, or null: charts need no more, and a page of 10,000 frames stays small.
[[nodiscard]] holdfast::io::ResultJson rounded(std::optional<double> value);

/// "P4", or "P4 shift" when it deflects in another way than its own, or "P3 10 ms too far" when it predicts so.
[[nodiscard]] std::string variant_name(const holdfast::ExperimentSettings& settings);
[[nodiscard]] std::string variant_name(const holdfast::ExperimentRow& row);
/// "P4, late rotation", or "P4 shift".
[[nodiscard]] std::string variant_title(const holdfast::ExperimentRow& row);

/// One series of a time chart: a row's samples.
struct TimeSeries {
  holdfast::ExperimentRow row;
  std::span<const FrameSample> samples;
};

/// Registration error, and swim velocity, against time; all series share their frames.
[[nodiscard]] holdfast::io::ResultJson error_chart(const std::vector<TimeSeries>& series);
[[nodiscard]] holdfast::io::ResultJson swim_chart(const std::vector<TimeSeries>& series);

/// RMS registration error against latency (001's figure 7) of each variant, experiments without pictures.
[[nodiscard]] holdfast::io::ResultJson latency_chart(const holdfast::Motion& motion,
                                                     std::span<const holdfast::ExperimentSettings> variants,
                                                     const holdfast::RegistrationScene& scene);

/// Amplitude of what is displayed over that of the true motion, and by how much it comes first, rad.
struct Response {
  double gain = 0.0, phase_rad = 0.0;
};

/// To a yaw of 1 deg at one frequency, seen at the display's frames. `displayed` is asked for later and later times.
[[nodiscard]] Response response_at(
    double hz, double refresh_hz,
    const std::function<holdfast::Rigid(const holdfast::Motion&, holdfast::HostTime)>& displayed);

/// Gain and lag of the displayed against the true motion, per frequency, beside theory's curves. Variants that predict
/// alike, over the same time, share their curves.
[[nodiscard]] std::vector<holdfast::io::ResultJson> frequency_charts(
    std::span<const holdfast::ExperimentSettings> variants);

/// Error of each source alone, stacked, against latency: without prediction (P0), or with P3.
[[nodiscard]] holdfast::io::ResultJson budget_chart(const holdfast::Motion& motion,
                                                    const holdfast::ExperimentSettings& settings,
                                                    holdfast::Pipeline pipeline,
                                                    const holdfast::RegistrationScene& scene);

}  // namespace swimlab

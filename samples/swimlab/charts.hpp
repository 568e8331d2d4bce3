/// The report's charts as JSON: what report.js draws with dygraphs.
#pragma once

#include <span>
#include <vector>

#include <holdfast/io/results.hpp>
#include <holdfast/motion/motion.hpp>

#include "row_runner.hpp"

namespace swimlab {

/// A number with four significant digits, or null: charts need no more, and a page of 10,000 frames stays small.
[[nodiscard]] holdfast::io::ResultJson rounded(std::optional<double> value);

/// One series of a time chart: a row's samples.
struct TimeSeries {
  holdfast::Pipeline pipeline;
  std::span<const FrameSample> samples;
};

/// Registration error, and swim velocity, against time; all series share their frames.
[[nodiscard]] holdfast::io::ResultJson error_chart(const std::vector<TimeSeries>& series);
[[nodiscard]] holdfast::io::ResultJson swim_chart(const std::vector<TimeSeries>& series);

/// RMS registration error against latency (001's figure 7), experiments without pictures.
[[nodiscard]] holdfast::io::ResultJson latency_chart(const holdfast::Motion& motion,
                                                     const holdfast::ExperimentSettings& settings,
                                                     std::span<const holdfast::Pipeline> pipelines,
                                                     const holdfast::RegistrationScene& scene);

/// Gain and lag of the displayed against the true motion, per frequency, beside theory's curves.
[[nodiscard]] std::vector<holdfast::io::ResultJson> frequency_charts(const holdfast::ExperimentSettings& settings,
                                                                     std::span<const holdfast::Pipeline> pipelines);

/// Error of each source alone, stacked, against latency.
[[nodiscard]] holdfast::io::ResultJson budget_chart(const holdfast::Motion& motion,
                                                    const holdfast::ExperimentSettings& settings,
                                                    const holdfast::RegistrationScene& scene);

/// Name and style of a pipeline's line.
[[nodiscard]] holdfast::io::ResultJson pipeline_series(holdfast::Pipeline pipeline);

}  // namespace swimlab

/// Options of the command line: read as text, checked here, so that every message names option, value and expectation.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include <holdfast/optics/hmd.hpp>
#include <holdfast/registration/experiment_types.hpp>
#include <holdfast/rendering/backend.hpp>

namespace swimlab {

/// What `swimlab run` was asked, checked.
struct RunOptions {
  std::vector<std::string> motions;  ///< names M0-M8 or files
  std::vector<holdfast::Pipeline> pipelines;
  std::vector<std::optional<holdfast::DeflectionKind>> deflections;  ///< nothing: the pipeline's own
  std::vector<double> interval_errors_ms;                            ///< besides the right interval
  double plane_distance_m = 2.0;
  std::vector<double> latencies_ms;
  std::vector<holdfast::EyeSide> eyes;
  std::vector<holdfast::LensMode> lenses;
  std::vector<std::optional<holdfast::ScanOut>> displays;  ///< nothing: as the headset's descriptor says
  /// The motion that the default run shows on a rolling display, through the last of the lenses alone: on a global one
  /// P6 is P5. Empty: all motions are shown alike.
  std::string rolling_motion;
  double late_ms = 3.0;
  double low_pass_hz = 10.0;         ///< of recordings; 0: as they are
  std::filesystem::path hmd, model;  ///< empty: none
  std::optional<holdfast::PixelSize> size;
  bool full = false, lenient = false;
  std::uint64_t seed = 1;
  std::optional<holdfast::rendering::Backend> backend;
  std::filesystem::path out, json;
  std::string command;  ///< as typed, for the report
};

struct PredictOptions {
  std::filesystem::path trajectory, imu, json, out;  ///< out empty: no report
  std::vector<double> intervals_ms;
  holdfast::PoseNoise noise = holdfast::PoseFilterSettings().noise;  ///< of the recording, as the filter is told
  double pose_hz = 0.0;                                              ///< every so many-th pose is measured; 0: all
  bool lenient = false;
  std::string command;  ///< as typed, for the report
};

struct LatencyCommandOptions {
  std::filesystem::path reference, observed, json;
  bool same_frames = false, lenient = false;
};

/// The words given to one option, cut at commas.
using Words = std::vector<std::string>;

/// Throws io::InputError about an option.
[[noreturn]] void refuse(const std::string& option, const std::string& problem, const std::string& value,
                         const std::string& expected);
[[nodiscard]] std::uint64_t seed_of(const std::string& word);

/// `word` as a number within [least, most]; io::InputError that names the option otherwise.
[[nodiscard]] double number_of(const std::string& option, const std::string& word, double least, double most,
                               const std::string& expected);
[[nodiscard]] std::vector<double> numbers_of(const std::string& option, const Words& words, double least, double most,
                                             const std::string& expected);

/// An option that takes WORD,WORD,... and may be repeated; empty words are kept, to be refused.
CLI::Option* add_words(CLI::App& command, const std::string& name, Words& words, const std::string& help);

/// --json FILE.
void add_json(CLI::App& command, std::string& json);

/// The subcommands' options; the returned callables check them when the command line is read, and run the command.
void add_run_command(CLI::App& app, const std::string& command_line, int& exit_code);
void add_predict_command(CLI::App& app, const std::string& command_line, int& exit_code);
void add_latency_command(CLI::App& app, int& exit_code);

// run_command.cpp, predict_command.cpp, latency_command.cpp
[[nodiscard]] int run(const RunOptions& options);
[[nodiscard]] int predict(const PredictOptions& options);
[[nodiscard]] int latency(const LatencyCommandOptions& options);

}  // namespace swimlab

/// swimlab track ranges: a recording of ranges to anchors, tracked with and without bias states and gate.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/io/range_files.hpp>
#include <holdfast/io/range_results.hpp>
#include <holdfast/registration/range_experiment.hpp>

#include "exit_code.hpp"
#include "interruption.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "range_page.hpp"
#include "report_page.hpp"
#include "track_command.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

struct RangeOptions {
  io::RangeFiles files;
  RangeSettings settings;
  std::filesystem::path json, out;  ///< empty: none
  std::string command;
};

RangeTrack tracked(const RangeRecording& recording, const RangeVariant& variant, const RangeSettings& settings,
                   const InterruptionWatch& interruption) {
  RangeTrack track;
  track.row = track_ranges(recording, variant, settings, [&](const RangeMoment& m) {
    interruption.check();
    track.places.push_back(
        {to_seconds(m.reading.t - recording.ranges.front().t), m.tracker.state().X_WB.p(), m.X_WB.p()});
  });
  return track;
}

ResultJson track_json(const RangeOptions& o, const RangeRecording& recording, const std::vector<RangeTrack>& tracks) {
  const Vector3& antenna_B = o.settings.antenna_B;
  ResultJson json;
  json["schema"] = "holdfast/track/1";
  json["scenario"] = "ranges";
  json["motion"] = o.files.ranges.filename().string();
  json["seconds"] = to_seconds(recording.ranges.back().t - recording.ranges.front().t);
  json["start_mm"] = 1e3 * o.settings.start_m;
  json["antenna_mm"] = {1e3 * antenna_B.x(), 1e3 * antenna_B.y(), 1e3 * antenna_B.z()};
  json["rows"] = ResultJson::array();
  for (const RangeTrack& track : tracks) json["rows"].push_back(io::range_row_json(track.row, recording.anchors));
  return json;
}

void print_table(const RangeOptions& o, const RangeRecording& recording, const std::vector<RangeTrack>& tracks) {
  std::printf("ranges: %s, %.1f s, %zu anchors, %ld ranges one at a time, %zu inertial samples\n\n",
              o.files.ranges.filename().string().c_str(),
              to_seconds(recording.ranges.back().t - recording.ranges.front().t), recording.anchors.size(),
              tracks.front().row.ranges, recording.inertial.size());
  std::printf("  %-14s %15s %10s %8s %15s\n", "", "position m", "horizontal", "height", "angle deg");
  std::printf("  %-14s %7s %7s %10s %8s %7s %7s %9s %7s %6s %6s\n", "method", "rms", "peak", "rms", "rms", "rms",
              "peak", "accepted", "gated", "NIS", "NEES");
  for (const RangeTrack& track : tracks) {
    const RangeRow& row = track.row;
    std::printf("  %-14s %7.3f %7.2f %10.3f %8.3f %7.2f %7.2f %9ld %7ld %6.2f %6.2f\n",
                std::string(name_of(row.variant)).c_str(), row.position.rms(), row.position.peak(),
                row.horizontal.rms(), row.height.rms(), degrees_per_rad * row.angle.rms(),
                degrees_per_rad * row.angle.peak(), row.accepted, row.gated, row.nis, row.position_nees);
  }
  std::printf("\nBiases learnt (bias_and_gate), m:");
  for (std::size_t k = 0; k < recording.anchors.size(); ++k) {
    std::printf("  %d: %.3f", recording.anchors[k].id, tracks.back().row.biases_m[k]);
  }
  std::printf(
      "\nNIS of ranges and NEES of positions, per degree of freedom: 1 is as sure as right, above is too sure.\n");
}

OutputKind range_output() {
  return {.command = "swimlab track ranges",
          .summary = "track.json",
          .schema = "\"holdfast/track/1\"",
          .files = {"report.html"}};
}

int track(const RangeOptions& o) {
  const std::filesystem::path json_file = checked_json_file(o.json);
  const RangeRecording recording = io::read_range_recording(o.files);
  std::optional<OutputFolder> folder;
  if (!o.out.empty()) folder.emplace(o.out, range_output());
  const InterruptionWatch interruption;
  std::vector<RangeTrack> tracks;
  {
    Progress progress("track", range_variants.size());
    for (const RangeVariant& variant : range_variants) {
      progress.show(tracks.size(), std::string(name_of(variant)));
      tracks.push_back(tracked(recording, variant, o.settings, interruption));
      if (tracks.front().row.ranges == 0) {
        throw io::InputError({.file = o.files.truth.string(),
                              .problem = "shares no time with the ranges",
                              .expected = "poses of the time in which ranges were measured"});
      }
    }
  }
  const std::string json = io::json_text(track_json(o, recording, tracks));
  if (folder) {
    io::write_whole_file(folder->path() / "track.json", json);
    io::write_whole_file(
        folder->path() / "report.html",
        report_page(range_page(tracks, o.settings.up_W, o.files.ranges.filename().string(), o.command)));
    interruption.check();
    folder->commit();
  }
  if (!json_file.empty()) io::write_whole_file(json_file, json);
  print_table(o, recording, tracks);
  return done;
}

struct RangeWords {
  std::string ranges, anchors, imu, truth, up = "z", start_mm = "10", json, out;
  Words antenna{"-0.01245", "0.00127", "0.0908"};
};

RangeOptions checked(const RangeWords& words) {
  RangeOptions o;
  o.files = {words.ranges, words.anchors, words.imu, words.truth};
  const std::string lever = "three numbers x,y,z in metres";
  const std::vector<double> antenna = numbers_of("--antenna", words.antenna, -100.0, 100.0, lever);
  if (antenna.size() != 3) {
    throw io::InputError({.key = "--antenna",
                          .problem = "has " + std::to_string(antenna.size()) + " numbers",
                          .value = words.antenna.front() + (antenna.size() > 1 ? ",..." : ""),
                          .expected = lever});
  }
  o.settings.antenna_B = Vector3(antenna[0], antenna[1], antenna[2]);
  o.settings.start_m = 1e-3 * number_of("--start-mm", words.start_mm, 0.1, 1e4, "millimetres, 0.1 to 10000");
  if (words.up != "x" && words.up != "y" && words.up != "z") {
    throw io::InputError({.key = "--up",
                          .problem = "unknown axis",
                          .value = words.up,
                          .expected = "the recording's axis that points up: x, y or z"});
  }
  o.settings.up_W = Vector3::Unit(words.up[0] - 'x');
  o.json = words.json;
  o.out = words.out;
  o.command = "swimlab track ranges --ranges " + words.ranges + " --anchors " + words.anchors + " --imu " + words.imu +
              " --truth " + words.truth + " --antenna " + words.antenna[0] + "," + words.antenna[1] + "," +
              words.antenna[2] + " --up " + words.up + " --start-mm " + words.start_mm;
  return o;
}

}  // namespace

void add_track_ranges_command(CLI::App& track_app, int& exit_code) {
  CLI::App& app = *track_app.add_subcommand(
      "ranges",
      "A recording of ranges to anchors, one at a time, with inertial sensors: what bias states and a gate give");
  const auto words = std::make_shared<RangeWords>();
  app.add_option("--ranges", words->ranges, "CSV with t, anchor, range: one distance a row")
      ->required()
      ->type_name("FILE");
  app.add_option("--anchors", words->anchors, "CSV with id, x, y, z: where the anchors stand")
      ->required()
      ->type_name("FILE");
  app.add_option("--imu", words->imu, "CSV with t, gx, gy, gz, ax, ay, az: rad/s and m/s^2")
      ->required()
      ->type_name("FILE");
  app.add_option("--truth", words->truth, "The true motion: TUM, EuRoC or CSV")->required()->type_name("FILE");
  add_words(app, "--antenna", words->antenna,
            "The antenna's place on the body, x,y,z in m; default -0.01245,0.00127,0.0908, of the UTIL aircraft");
  app.add_option("--up", words->up, "The axis of the anchors' world that points up: x, y or z; default z");
  app.add_option("--start-mm", words->start_mm, "How well the start, the true pose, is taken as known; default 10");
  app.add_option("--json", words->json, "Write the results also to this file")->type_name("FILE");
  app.add_option("--out", words->out, "Folder for report.html and track.json")->type_name("DIR");
  app.footer(
      "Example:\n  swimlab track ranges --ranges range.csv --anchors anchors.csv --imu imu.csv --truth pose.csv --out "
      "out\n"
      "Exit code: 0 done, 2 wrong use or unreadable input.");
  app.callback([words, &exit_code] { exit_code = track(checked(*words)); });
}

}  // namespace swimlab

#include "lens_command.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <holdfast/io/hmd.hpp>
#include <holdfast/io/mesh_writer.hpp>
#include <holdfast/io/results.hpp>
#include <holdfast/optics/mesh_overfill.hpp>

#include "exit_code.hpp"
#include "lens_facts.hpp"
#include "lens_pictures.hpp"
#include "options.hpp"
#include "output_folder.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

struct LensOptions {
  std::filesystem::path hmd, out, json;
  std::vector<EyeSide> eyes;
  double max_error_px = 0.05;
  int grid = 0;  ///< cells a side; 0: adaptive
  std::optional<FieldTangents> field;
  DeflectionBudget budget;
};

/// Makes the folder; files of ours in it are replaced one by one.
void make_folder(const std::filesystem::path& folder) {
  const auto refuse = [&](const std::string& problem) {
    throw io::InputError(
        {.key = "--out", .problem = problem, .value = folder.string(), .expected = "a writable folder"});
  };
  std::error_code error;
  if (folder.empty()) refuse("empty");
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error)) refuse("is no folder");
  std::filesystem::create_directories(folder, error);
  if (error) refuse("cannot be made: " + error.message());
}

PredistortionMesh mesh_of(const EyeModel& eye, const LensOptions& options) {
  PredistortionMesh mesh;
  if (options.grid > 0) {
    mesh = grid_mesh(eye, LensMode::exact, options.grid, options.grid, options.field);
  } else {
    mesh = adaptive_mesh(eye, LensMode::exact, {.max_error_px = options.max_error_px, .field = options.field});
  }
  if (!mesh.ok()) {
    throw io::InputError({.file = options.hmd.string(),
                          .problem = "no mesh for the " + std::string(io::name_of(eye.side)) +
                                     " eye: " + std::string(describe(mesh.problem)),
                          .expected = "a headset whose lenses show some of its panels"});
  }
  return mesh;
}

ResultJson end_json(const std::optional<LensEnd>& end) {
  if (!end) return nullptr;
  return {{"radius_px", end->radius_px},
          {"panel_px", {end->panel_px.x(), end->panel_px.y()}},
          {"seen_deg", end->seen_off_axis.degrees()}};
}

ResultJson field_json(const FieldTangents& field) {
  const FieldAngles a = angles_of(field);
  return {{"left_deg", a.left.degrees()},
          {"right_deg", a.right.degrees()},
          {"down_deg", a.down.degrees()},
          {"up_deg", a.up.degrees()}};
}

ResultJson row_json(const EyeModel& eye, const LensFacts& facts, const PredistortionMesh& mesh) {
  ResultJson json;
  json["eye"] = io::name_of(eye.side);
  json["color"] = facts.color;
  json["model"] = facts.model;
  json["valid_radius_px"] = io::number_or_null(facts.valid_radius_px);
  json["residual_px"] = {{"rms", facts.residual_rms_px}, {"max", facts.residual_max_px}};
  json["vertices"] = mesh.vertices.size();
  json["mesh_error_px"] = mesh.max_error_px;
  json["triangles"] = mesh.triangle_count();
  json["unanswered"] = facts.unanswered;
  json["dark_pct"] = facts.dark_pct;
  json["first_end"] = end_json(facts.first_end);
  json["last_end"] = end_json(facts.last_end);
  return json;
}

/// Share of the panel's pixels by which the overfilled picture is larger than the shown one would be.
struct Overfilled {
  FieldResult field;
  PixelSize shown_size, size;
};

Overfilled overfill_of(const EyeModel& eye, const PredistortionMesh& mesh, const DeflectionBudget& budget) {
  Overfilled out{overfilled(mesh, budget), overfilled_size(eye, shown_field(mesh).value()), {}};
  if (out.field.ok()) out.size = overfilled_size(eye, out.field.value());
  return out;
}

ResultJson eye_json(const EyeModel& eye, const PredistortionMesh& mesh, const DeflectionBudget& budget) {
  ResultJson json;
  json["eye"] = io::name_of(eye.side);
  json["resolution_px"] = {eye.resolution.width, eye.resolution.height};
  json["seen_to_corners"] = field_json(shown_field(mesh).value());
  const std::optional<FieldTangents> edges = seen_field(eye);
  json["seen_to_edges"] = edges ? field_json(*edges) : ResultJson(nullptr);
  const Overfilled overfill = overfill_of(eye, mesh, budget);
  json["shown_px"] = {overfill.shown_size.width, overfill.shown_size.height};
  json["overfill"] = nullptr;
  if (overfill.field.ok()) {
    json["overfill"] = field_json(overfill.field.value());
    json["overfill"]["size_px"] = {overfill.size.width, overfill.size.height};
  }
  return json;
}

void print_ends(const LensFacts& facts) {
  if (facts.unanswered > 0)
    std::printf("    %s: the inverse does not answer %zu points\n", facts.color.c_str(), facts.unanswered);
  if (!facts.first_end) return;
  const LensEnd &first = *facts.first_end, &last = *facts.last_end;
  std::printf(
      "    %s: the lens ends inside the panel, %.0f px from its centre at (%.0f, %.0f) px, seen %.1f deg off the "
      "axis",
      facts.color.c_str(), first.radius_px, first.panel_px.x(), first.panel_px.y(), first.seen_off_axis.degrees());
  if (last.radius_px > first.radius_px + 1.0) std::printf("; elsewhere up to %.0f px", last.radius_px);
  std::printf(". %.1f %% of the panel is dark.\n", facts.dark_pct);
}

void print_field(const char* what, const FieldTangents& field) {
  const FieldAngles a = angles_of(field);
  std::printf("  %-22s %5.1f x %5.1f deg: left %.1f, right %.1f, down %.1f, up %.1f\n", what,
              std::abs((a.right - a.left).degrees()), std::abs((a.up - a.down).degrees()), a.left.degrees(),
              a.right.degrees(), a.down.degrees(), a.up.degrees());
}

void print_eye(const EyeModel& eye, const std::vector<LensFacts>& lenses, const PredistortionMesh& mesh,
               const LensOptions& options) {
  std::printf("\n%s eye, %d x %d px\n", std::string(io::name_of(eye.side)).c_str(), eye.resolution.width,
              eye.resolution.height);
  std::printf("  %-6s %-16s %15s %14s %14s\n", "color", "model", "valid radius px", "residual rms px",
              "residual max px");
  for (const LensFacts& facts : lenses) {
    const std::string radius = std::isfinite(facts.valid_radius_px) ? std::to_string(std::lround(facts.valid_radius_px))
                                                                    : std::string("no limit");
    std::printf("  %-6s %-16s %15s %15.1e %15.1e\n", facts.color.c_str(), facts.model.c_str(), radius.c_str(),
                facts.residual_rms_px, facts.residual_max_px);
  }
  for (const LensFacts& facts : lenses) print_ends(facts);
  std::printf("  mesh: %zu vertices, %zu triangles, at most %.3g px off%s\n", mesh.vertices.size(),
              mesh.triangle_count(), mesh.max_error_px, mesh.per_color ? " in any colour" : "");
  print_field("seen to the corners", shown_field(mesh).value());
  if (const auto edges = seen_field(eye)) print_field("seen to edges' middles", *edges);
  const Overfilled overfill = overfill_of(eye, mesh, options.budget);
  if (!overfill.field.ok()) {
    std::printf("  overfill: impossible, %s\n", std::string(describe(overfill.field.problem)).c_str());
    return;
  }
  print_field("overfilled", overfill.field.value());
  const auto area = [](const PixelSize& size) { return static_cast<double>(size.width) * size.height; };
  std::printf("  %-22s %d x %d px as dense as the panel's; without overfill %d x %d (%+.1f %% pixels)\n", "",
              overfill.size.width, overfill.size.height, overfill.shown_size.width, overfill.shown_size.height,
              100.0 * (area(overfill.size) / area(overfill.shown_size) - 1.0));
}

void write_files(const std::string& hmd, const EyeModel& eye, const PredistortionMesh& mesh,
                 const std::filesystem::path& folder) {
  const std::string side(io::name_of(eye.side));
  const LensSubject subject{hmd, eye, mesh};
  io::write_whole_file(folder / (side + "_drawn.svg"), drawn_picture(subject));
  io::write_whole_file(folder / (side + "_seen.svg"), seen_picture(subject));
  io::write_whole_file(folder / (side + "_mesh.svg"), mesh_picture(subject));
  io::write_whole_file(folder / (side + "_mesh.json"), io::mesh_json(mesh, hmd, eye.side));
  io::write_whole_file(folder / (side + "_mesh.obj"), io::mesh_obj(mesh, hmd, eye.side, shown_field(mesh).value()));
}

int lens(const LensOptions& options) {
  const std::filesystem::path json_file = checked_json_file(options.json);
  const HmdModel hmd = io::read_hmd(options.hmd);
  std::vector<PredistortionMesh> meshes;
  for (const EyeSide side : options.eyes) meshes.push_back(mesh_of(hmd.eye(side), options));
  make_folder(options.out);
  const DeflectionBudget& budget = options.budget;
  ResultJson json;
  json["schema"] = "holdfast/lens/1";
  json["hmd"] = hmd.name;
  json["rows"] = ResultJson::array();
  json["budget_deg"] = {
      {"yaw", budget.yaw.degrees()}, {"pitch", budget.pitch.degrees()}, {"roll", budget.roll.degrees()}};
  json["eyes"] = ResultJson::array();
  std::printf("%s: %s\n", options.hmd.string().c_str(), hmd.name.c_str());
  for (std::size_t i = 0; i < options.eyes.size(); ++i) {
    const EyeModel& eye = hmd.eye(options.eyes[i]);
    const std::vector<LensFacts> lenses = facts_of(eye);
    for (const LensFacts& facts : lenses) json["rows"].push_back(row_json(eye, facts, meshes[i]));
    json["eyes"].push_back(eye_json(eye, meshes[i], budget));
    print_eye(eye, lenses, meshes[i], options);
    write_files(hmd.name, eye, meshes[i], options.out);
  }
  std::printf(
      "\nResidual: distort(undistort(v)) - v over what the panel shows. Overfill: for a head that turns up to %g, %g "
      "and %g deg\n(yaw, pitch, roll) between drawing and light. Pictures and meshes are in %s.\n",
      budget.yaw.degrees(), budget.pitch.degrees(), budget.roll.degrees(), options.out.string().c_str());
  io::write_whole_file(options.out / "lens.json", io::json_text(json));
  if (!json_file.empty()) io::write_whole_file(json_file, io::json_text(json));
  return done;
}

std::vector<EyeSide> eyes_of(const std::string& word) {
  if (word == "left") return {EyeSide::left};
  if (word == "right") return {EyeSide::right};
  if (word == "both") return {EyeSide::left, EyeSide::right};
  throw io::InputError({.key = "--eye", .problem = "unknown", .value = word, .expected = "one of left, right, both"});
}

DeflectionBudget budget_of(const Words& words) {
  const std::string expected = "three angles, 0 to 45 degrees: yaw,pitch,roll";
  const std::vector<double> deg = numbers_of("--budget-deg", words, 0.0, 45.0, expected);
  if (deg.size() != 3) {
    throw io::InputError({.key = "--budget-deg",
                          .problem = "not three angles",
                          .value = std::to_string(deg.size()) + " of them",
                          .expected = expected});
  }
  return {degrees(deg[0]), degrees(deg[1]), degrees(deg[2])};
}

}  // namespace

void add_lens_command(CLI::App& app, int& exit_code) {
  struct Given {
    std::string hmd, eye = "left", max_error = "0.05", grid, limit, out = "out/lens", json;
    Words budget;
  };
  CLI::App& lens_app = *app.add_subcommand("lens", "Say what a headset's lenses do, and write the mesh that undoes it");
  const auto given = std::make_shared<Given>();
  lens_app.add_option("HMD", given->hmd, "Headset descriptor: assets/hmds/*.json, or OSVR's")->required();
  lens_app.add_option("--eye", given->eye, "left, right or both; default left");
  lens_app.add_option("--max-error-px", given->max_error,
                      "Bound of the mesh's error in the source picture, 0.005 or more; default 0.05");
  lens_app.add_option("--grid", given->grid, "A fixed mesh of N x N cells instead")->type_name("N");
  lens_app.add_option("--limit-deg", given->limit, "Draw this far from the axis to each side, not the whole panel")
      ->type_name("DEG");
  add_words(lens_app, "--budget-deg", given->budget,
            "How far the head may turn meanwhile: yaw,pitch,roll; default 6,4,3")
      ->type_name("YAW,PITCH,ROLL");
  lens_app.add_option("--out", given->out, "Folder for pictures and meshes; default out/lens")->type_name("DIR");
  lens_app.add_option("--json", given->json, "Write the results also to this file")->type_name("FILE");
  lens_app.footer(
      "Example:\n  swimlab lens assets/hmds/flight_helmet.json --eye both --out out/flight_helmet\n"
      "It writes for each eye EYE_drawn.svg, EYE_seen.svg, EYE_mesh.svg, EYE_mesh.obj and EYE_mesh.json,\n"
      "and lens.json.");
  lens_app.callback([given, &exit_code] {
    LensOptions o;
    o.hmd = given->hmd;
    o.out = given->out;
    o.json = given->json;
    o.eyes = eyes_of(given->eye);
    o.max_error_px = number_of("--max-error-px", given->max_error, 0.005, 100.0, "pixels, 0.005 to 100");
    if (!given->grid.empty()) {
      const double cells = number_of("--grid", given->grid, 1.0, 1024.0, "whole cells, 1 to 1024");
      if (cells != std::floor(cells)) {
        throw io::InputError(
            {.key = "--grid", .problem = "not whole", .value = given->grid, .expected = "whole cells, 1 to 1024"});
      }
      o.grid = static_cast<int>(cells);
    }
    if (!given->limit.empty()) {
      const double t = tan(degrees(number_of("--limit-deg", given->limit, 1.0, 85.0, "degrees, 1 to 85")));
      o.field = FieldTangents{-t, t, -t, t};
    }
    o.budget = budget_of(given->budget.empty() ? Words{"6", "4", "3"} : given->budget);
    exit_code = lens(o);
  });
}

}  // namespace swimlab

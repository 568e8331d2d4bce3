#include "lens_command.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <holdfast/io/hmd.hpp>
#include <holdfast/io/mesh_writer.hpp>
#include <holdfast/io/result_json.hpp>
#include <holdfast/optics/mesh_overfill.hpp>

#include "exit_code.hpp"
#include "interruption.hpp"
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
  std::optional<double> limit_deg;
  std::array<double, 3> budget_deg{6.0, 4.0, 3.0};  ///< yaw, pitch, roll
  std::optional<io::PhoneScreen> phone;
  bool write_large_obj = false;

  [[nodiscard]] std::optional<FieldTangents> field() const {
    if (!limit_deg) return std::nullopt;
    const double t = tan(degrees(*limit_deg));
    return FieldTangents{-t, t, -t, t};
  }
  [[nodiscard]] DeflectionBudget budget() const {
    return {degrees(budget_deg[0]), degrees(budget_deg[1]), degrees(budget_deg[2])};
  }
};

/// One eye, what was found out about it, and the files of it.
struct LensReport {
  const EyeModel& eye;
  PredistortionMesh mesh;
  std::vector<LensFacts> lenses;
  std::vector<std::string> files;
  std::optional<std::string> left_out;  ///< a file that is not written, and why
};

constexpr std::array file_names{"drawn.svg", "seen.svg", "mesh.svg", "mesh.json", "mesh.obj"};

OutputKind lens_output() {
  OutputKind kind{.command = "swimlab lens", .summary = "lens.json", .schema = "\"holdfast/lens/1\"", .files = {}};
  for (const EyeSide side : {EyeSide::left, EyeSide::right}) {
    for (const char* name : file_names) kind.files.push_back(std::string(name_of(side)) + "_" + name);
  }
  return kind;
}

io::HmdFile headset(const LensOptions& options) {
  io::HmdOptions how;
  how.phone = options.phone;
  how.phone_expected = "the phone's screen, for example --phone-mm 110x62 --phone-px 1920x1080";
  io::HmdFile file = io::read_hmd_file(options.hmd, how);
  if (options.phone && file.format != io::HmdFormat::cardboard) {
    throw io::InputError({.file = options.hmd.string(),
                          .key = "--phone-mm",
                          .problem = "this headset has a display of its own",
                          .expected = "a Cardboard viewer, or no phone"});
  }
  return file;
}

/// Names come from files, and go to terminals.
std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  return text;
}

PredistortionMesh mesh_of(const EyeModel& eye, const LensOptions& options) {
  PredistortionMesh mesh;
  if (options.grid > 0) {
    mesh = grid_mesh(eye, LensMode::exact, options.grid, options.grid, options.field());
  } else {
    mesh = adaptive_mesh(eye, LensMode::exact, {.max_error_px = options.max_error_px, .field = options.field()});
  }
  if (mesh.problem == MeshProblem::too_many_vertices) {
    throw io::InputError({.key = "--max-error-px",
                          .problem = std::string(describe(mesh.problem)),
                          .value = std::to_string(options.max_error_px),
                          .expected = "a larger bound"});
  }
  if (!mesh.ok()) {
    throw io::InputError({.file = options.hmd.string(),
                          .problem = "no mesh for the " + std::string(name_of(eye.side)) +
                                     " eye: " + std::string(describe(mesh.problem)),
                          .expected = "a headset whose lenses show some of its panels"});
  }
  return mesh;
}

/// Whether the mesh keeps to the bound that was asked for. A fixed grid was asked for none.
bool keeps_bound(const PredistortionMesh& mesh, const LensOptions& options) {
  return options.grid > 0 || mesh.max_error_px <= options.max_error_px;
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

ResultJson samples_json(const std::optional<SampleFacts>& samples) {
  if (!samples) return nullptr;
  return {{"samples", samples->samples},
          {"triangles", samples->triangles},
          {"left_out", samples->folded + samples->cut_off},
          {"folded", samples->folded}};
}

ResultJson row_json(const EyeModel& eye, const LensFacts& facts, const PredistortionMesh& mesh) {
  ResultJson json;
  json["eye"] = name_of(eye.side);
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
  json["samples"] = samples_json(facts.samples);
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

ResultJson eye_json(const LensReport& report, const LensOptions& options) {
  const auto& [eye, mesh, lenses, files, left_out] = report;
  ResultJson json;
  json["eye"] = name_of(eye.side);
  json["resolution_px"] = {eye.resolution.width, eye.resolution.height};
  json["mesh_error_px"] = mesh.max_error_px;
  json["mesh_bound_px"] = options.grid > 0 ? ResultJson(nullptr) : ResultJson(options.max_error_px);
  json["mesh_verdict"] = options.grid > 0 ? "none" : keeps_bound(mesh, options) ? "pass" : "fail";
  json["seen_to_corners"] = field_json(shown_field(mesh).value());
  const std::optional<FieldTangents> edges = seen_field(eye);
  json["seen_to_edges"] = edges ? field_json(*edges) : ResultJson(nullptr);
  const Overfilled overfill = overfill_of(eye, mesh, options.budget());
  json["shown_px"] = {overfill.shown_size.width, overfill.shown_size.height};
  json["overfill"] = nullptr;
  if (overfill.field.ok()) {
    json["overfill"] = field_json(overfill.field.value());
    json["overfill"]["size_px"] = {overfill.size.width, overfill.size.height};
  }
  json["files"] = files;
  return json;
}

void print_ends(const LensFacts& facts) {
  if (const auto& samples = facts.samples) {
    std::printf("    %s: %zu samples make %zu triangles", facts.color.c_str(), samples->samples, samples->triangles);
    if (const std::size_t left_out = samples->folded + samples->cut_off; left_out > 0) {
      std::printf("; %zu are left out: %zu fold over, %zu are cut off by folds or overlap", left_out, samples->folded,
                  samples->cut_off);
    } else {
      std::printf(", none of which folds over");
    }
    std::printf(".\n");
  }
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
  std::printf("  %-23s %5.1f x %5.1f deg: left %.1f, right %.1f, down %.1f, up %.1f\n", what,
              std::abs((a.right - a.left).degrees()), std::abs((a.up - a.down).degrees()), a.left.degrees(),
              a.right.degrees(), a.down.degrees(), a.up.degrees());
}

void print_mesh(const LensReport& report, const LensOptions& options) {
  const PredistortionMesh& mesh = report.mesh;
  std::printf("  mesh: %zu vertices, %zu triangles, at most %.3g px off%s", mesh.vertices.size(), mesh.triangle_count(),
              mesh.max_error_px, mesh.per_color ? " in any colour" : "");
  if (options.grid == 0) {
    std::printf(keeps_bound(mesh, options) ? " (bound %g px)" : ": MISSES the bound of %g px", options.max_error_px);
  }
  std::printf("\n");
  if (report.left_out) std::printf("  %s\n", report.left_out->c_str());
}

void print_eye(const LensReport& report, const LensOptions& options) {
  const EyeModel& eye = report.eye;
  std::printf("\n%s eye, %d x %d px\n", std::string(name_of(eye.side)).c_str(), eye.resolution.width,
              eye.resolution.height);
  std::printf("  %-6s %-16s %15s %15s %15s\n", "color", "model", "valid radius px", "residual rms px",
              "residual max px");
  for (const LensFacts& facts : report.lenses) {
    const std::string radius = std::isfinite(facts.valid_radius_px) ? std::to_string(std::lround(facts.valid_radius_px))
                                                                    : std::string("no limit");
    std::printf("  %-6s %-16s %15s %15.1e %15.1e\n", facts.color.c_str(), facts.model.c_str(), radius.c_str(),
                facts.residual_rms_px, facts.residual_max_px);
  }
  for (const LensFacts& facts : report.lenses) print_ends(facts);
  print_mesh(report, options);
  print_field(options.limit_deg ? "within --limit-deg" : "seen to the corners", shown_field(report.mesh).value());
  if (const auto edges = seen_field(eye)) {
    print_field(options.limit_deg ? "unlimited, to the edges" : "seen to edges' middles", *edges);
  }
  const Overfilled overfill = overfill_of(eye, report.mesh, options.budget());
  if (!overfill.field.ok()) {
    std::printf("  overfill: impossible, %s\n", std::string(describe(overfill.field.problem)).c_str());
    return;
  }
  print_field("overfilled", overfill.field.value());
  const auto area = [](const PixelSize& size) { return static_cast<double>(size.width) * size.height; };
  std::printf("  %-23s %d x %d px as dense as the panel's; without overfill %d x %d (%+.1f %% pixels)\n", "",
              overfill.size.width, overfill.size.height, overfill.shown_size.width, overfill.shown_size.height,
              100.0 * (area(overfill.size) / area(overfill.shown_size) - 1.0));
}

/// `text` in lines of at most 112 characters, each after two blanks.
void print_wrapped(const std::string& text) {
  std::size_t column = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    if (column > 0 && column + 1 + (end - begin) > 112) column = 0;
    std::printf(column == 0 ? (begin == 0 ? "  %s" : "\n  %s") : " %s", text.substr(begin, end - begin).c_str());
    column += end - begin + 1;
    begin = end + 1;
  }
  std::printf("\n");
}

void write_files(const std::string& hmd, LensReport& report, const LensOptions& options,
                 const std::filesystem::path& folder, const InterruptionWatch& interruption) {
  const std::string side(name_of(report.eye.side));
  const LensSubject subject{hmd, report.eye, report.mesh};
  const auto write = [&](std::size_t i, const std::string& text) {
    report.files.push_back(side + "_" + file_names[i]);
    io::write_whole_file(folder / report.files.back(), text);
    interruption.check();
  };
  write(0, drawn_picture(subject));
  write(1, seen_picture(subject));
  write(2, mesh_picture(subject));
  write(3, io::mesh_json(report.mesh, hmd, report.eye.side));
  // OBJ repeats every triangle for each colour, in 40 letters.
  constexpr std::size_t most_faces = 250'000;
  const std::size_t faces = report.mesh.triangle_count() * (report.mesh.per_color ? 3 : 1);
  if (faces <= most_faces || options.write_large_obj) {
    write(4, io::mesh_obj(report.mesh, hmd, report.eye.side, shown_field(report.mesh).value()));
  } else {
    report.left_out = side + "_" + file_names[4] + " is left out, as it would have " + std::to_string(faces) +
                      " faces: the mesh is in " + report.files.back() + "; --obj writes it, and a larger " +
                      "--max-error-px makes a smaller mesh";
  }
}

ResultJson lens_json(const io::HmdFile& file, const std::vector<LensReport>& reports, const LensOptions& options) {
  ResultJson json;
  json["schema"] = "holdfast/lens/1";
  json["hmd"] = file.hmd.name;
  json["source"] = file.hmd.source;
  json["notes"] = file.notes;
  json["rows"] = ResultJson::array();
  for (const LensReport& report : reports) {
    for (const LensFacts& facts : report.lenses) json["rows"].push_back(row_json(report.eye, facts, report.mesh));
  }
  json["budget_deg"] = {
      {"yaw", options.budget_deg[0]}, {"pitch", options.budget_deg[1]}, {"roll", options.budget_deg[2]}};
  json["limit_deg"] = options.limit_deg ? ResultJson(*options.limit_deg) : ResultJson(nullptr);
  json["eyes"] = ResultJson::array();
  for (const LensReport& report : reports) json["eyes"].push_back(eye_json(report, options));
  return json;
}

int lens(const LensOptions& options) {
  const std::filesystem::path json_file = checked_json_file(options.json);
  const io::HmdFile file = headset(options);
  OutputFolder folder(options.out, lens_output());
  const InterruptionWatch interruption;
  std::vector<LensReport> reports;
  for (const EyeSide side : options.eyes) {
    const EyeModel& eye = file.hmd.eye(side);
    reports.push_back({eye, mesh_of(eye, options), {}, {}, {}});
    interruption.check();
    reports.back().lenses = facts_of(eye);
    write_files(file.hmd.name, reports.back(), options, folder.path(), interruption);
  }
  const std::string json = io::json_text(lens_json(file, reports, options));
  io::write_whole_file(folder.path() / "lens.json", json);
  interruption.check();
  folder.commit();
  if (!json_file.empty()) io::write_whole_file(json_file, json);

  std::printf("%s: %s\n", options.hmd.string().c_str(), printable(file.hmd.name).c_str());
  print_wrapped("source: " + printable(file.hmd.source));
  for (const LensReport& report : reports) print_eye(report, options);
  std::printf(
      "\nResidual: distort(undistort(v)) - v over what the panel shows. Overfill: for a head that turns up to %g, %g "
      "and %g deg\n(yaw, pitch, roll) between drawing and light. Pictures and meshes are in %s.\n",
      options.budget_deg[0], options.budget_deg[1], options.budget_deg[2], options.out.string().c_str());
  bool all_keep = true;
  for (const LensReport& report : reports) all_keep = all_keep && keeps_bound(report.mesh, options);
  if (all_keep) return done;
  std::printf("A mesh misses its bound: the lens bends too sharply for it, or its panel has too many pixels.\n");
  return check_failed;
}

std::vector<EyeSide> eyes_of(const std::string& word) {
  if (word == "left") return {EyeSide::left};
  if (word == "right") return {EyeSide::right};
  if (word == "both") return {EyeSide::left, EyeSide::right};
  throw io::InputError({.key = "--eye", .problem = "unknown", .value = word, .expected = "one of left, right, both"});
}

std::array<double, 3> budget_of(const Words& words) {
  const std::string expected = "three angles, 0 to 45 degrees: yaw,pitch,roll";
  const std::vector<double> deg = numbers_of("--budget-deg", words, 0.0, 45.0, expected);
  if (deg.size() != 3) {
    throw io::InputError({.key = "--budget-deg",
                          .problem = "not three angles",
                          .value = std::to_string(deg.size()) + " of them",
                          .expected = expected});
  }
  return {deg[0], deg[1], deg[2]};
}

/// "AxB", each a number within [least, most].
std::array<double, 2> size_of(const std::string& option, const std::string& word, double least, double most,
                              const std::string& expected) {
  const std::size_t x = std::min(word.find('x'), word.size());
  if (x == word.size()) {
    throw io::InputError({.key = option, .problem = "not a size", .value = word, .expected = expected});
  }
  return {number_of(option, word.substr(0, x), least, most, expected),
          number_of(option, word.substr(x + 1), least, most, expected)};
}

struct PhoneWords {
  std::string mm, px, hz;
};

/// Nothing when no phone was asked for.
std::optional<io::PhoneScreen> phone_of(const PhoneWords& words) {
  if (words.mm.empty() && words.px.empty() && words.hz.empty()) return std::nullopt;
  const auto need = [](const std::string& option, const std::string& word, const std::string& expected) {
    if (word.empty()) throw io::InputError({.key = option, .problem = "is missing", .expected = expected});
  };
  const std::string mm = "width x height of the lit screen, lying, 10 to 1000 mm: 110x62";
  const std::string px = "whole pixels across and up, the first even: 1920x1080";
  need("--phone-mm", words.mm, mm);
  need("--phone-px", words.px, px);
  const std::array<double, 2> size = size_of("--phone-mm", words.mm, 10.0, 1000.0, mm);
  const std::array<double, 2> pixels = size_of("--phone-px", words.px, 1.0, 32768.0, px);
  io::PhoneScreen phone{size[0] / 1000.0, size[1] / 1000.0, {static_cast<int>(pixels[0]), static_cast<int>(pixels[1])}};
  if (phone.resolution.width != pixels[0] || phone.resolution.height != pixels[1] || phone.resolution.width % 2 != 0) {
    throw io::InputError({.key = "--phone-px", .problem = "not whole, or odd", .value = words.px, .expected = px});
  }
  if (!words.hz.empty()) phone.refresh_hz = number_of("--phone-hz", words.hz, 1.0, 1e5, "hertz, 1 to 100000");
  return phone;
}

}  // namespace

void add_lens_command(CLI::App& app, int& exit_code) {
  struct Given {
    std::string hmd, eye = "left", max_error, grid, limit, out = "out/lens", json;
    PhoneWords phone;
    Words budget;
    bool obj = false;
  };
  CLI::App& lens_app = *app.add_subcommand("lens", "Say what a headset's lenses do, and write the mesh that undoes it");
  const auto given = std::make_shared<Given>();
  lens_app.add_option("HMD", given->hmd, "Headset descriptor: assets/hmds/*.json, OSVR's, or a Cardboard viewer's")
      ->required();
  lens_app.add_option("--eye", given->eye, "left, right or both; default left");
  lens_app.add_option("--max-error-px", given->max_error,
                      "Bound of the mesh's error in the source picture, 0.005 or more; default 0.05");
  lens_app.add_option("--grid", given->grid, "A fixed mesh of N x N cells instead")->type_name("N");
  lens_app.add_option("--limit-deg", given->limit, "Draw this far from the axis to each side, not the whole panel")
      ->type_name("DEG");
  lens_app.add_option("--phone-mm", given->phone.mm, "Lit screen of the phone in a Cardboard viewer, lying, in mm")
      ->type_name("WxH");
  lens_app.add_option("--phone-px", given->phone.px, "The same in pixels")->type_name("WxH");
  lens_app.add_option("--phone-hz", given->phone.hz, "The phone's refresh rate; default 60")->type_name("HZ");
  add_words(lens_app, "--budget-deg", given->budget,
            "How far the head may turn meanwhile: yaw,pitch,roll; default 6,4,3")
      ->type_name("YAW,PITCH,ROLL");
  lens_app.add_flag("--obj", given->obj, "Write EYE_mesh.obj even if it has more than 250000 faces");
  lens_app.add_option("--out", given->out, "Folder for pictures and meshes; default out/lens")->type_name("DIR");
  lens_app.add_option("--json", given->json, "Write the results also to this file")->type_name("FILE");
  lens_app.footer(
      "Example:\n  swimlab lens assets/hmds/flight_helmet.json --eye both --out out/flight_helmet\n"
      "It writes for each eye EYE_drawn.svg, EYE_seen.svg, EYE_mesh.svg, EYE_mesh.obj and EYE_mesh.json,\n"
      "and lens.json.\n"
      "Exit code: 0 done, 1 a mesh missed its bound, 2 wrong use or unreadable input.");
  lens_app.callback([given, &exit_code] {
    LensOptions o;
    o.hmd = given->hmd;
    o.out = given->out;
    o.json = given->json;
    o.eyes = eyes_of(given->eye);
    if (!given->max_error.empty()) {
      o.max_error_px = number_of("--max-error-px", given->max_error, 0.005, 100.0, "pixels, 0.005 to 100");
    }
    if (!given->grid.empty()) {
      if (!given->max_error.empty()) {
        throw io::InputError({.key = "--grid",
                              .problem = "given beside --max-error-px",
                              .value = given->grid,
                              .expected = "a fixed mesh, or a bound to be kept"});
      }
      const double cells = number_of("--grid", given->grid, 1.0, 1024.0, "whole cells, 1 to 1024");
      if (cells != std::floor(cells)) {
        throw io::InputError(
            {.key = "--grid", .problem = "not whole", .value = given->grid, .expected = "whole cells, 1 to 1024"});
      }
      o.grid = static_cast<int>(cells);
    }
    if (!given->limit.empty()) o.limit_deg = number_of("--limit-deg", given->limit, 1.0, 85.0, "degrees, 1 to 85");
    if (!given->budget.empty()) o.budget_deg = budget_of(given->budget);
    o.phone = phone_of(given->phone);
    o.write_large_obj = given->obj;
    exit_code = lens(o);
  });
}

}  // namespace swimlab

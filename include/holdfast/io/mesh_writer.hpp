/// Predistortion meshes (optics/predistortion_mesh.hpp) as files that other programs read.
///
/// JSON, schema "holdfast/mesh/1":
///
///     {"schema", "hmd", "eye": "left"|"right", "resolution_px": [w, h], "per_color", "max_error_px",
///      "vertices": [[panel_x, panel_y, tx, ty], ...], "triangles": [[a, b, c], ...]}
///
/// panel_x, panel_y: 0 to 1 of the eye's panel picture, origin at the lower left. tx, ty: the ideal tangent that is
/// shown there; with per_color six numbers, those of red, green and blue. Every number reads back to the same float.
///
/// OBJ (Wavefront): v is (panel_x, panel_y, 0), vt the place in a source picture with the tangents `source`: 0 0 its
/// lower left, 1 1 its upper right. With per_color there are the objects red, green and blue with texture coordinates of
/// their own over common vertices, else one. Bad input: an empty mesh is written as such.
#pragma once

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#include <holdfast/io/result_json.hpp>
#include <holdfast/optics/predistortion_mesh.hpp>

namespace holdfast::io {

namespace detail {

/// The shortest text that reads back to the same number.
template <typename Number>
void append_number(std::string& text, Number value) {
  char digits[40];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, end);
}

/// As a JSON string; what is not UTF-8 is replaced.
[[nodiscard]] inline std::string quoted(std::string_view text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// The colours that the mesh tells apart: 0 red, 1 green, 2 blue.
struct MeshColors {
  std::size_t first, end;
};
[[nodiscard]] inline MeshColors colors_of(const PredistortionMesh& mesh) {
  return mesh.per_color ? MeshColors{0, 3} : MeshColors{1, 2};
}

}  // namespace detail

[[nodiscard]] inline std::string mesh_json(const PredistortionMesh& mesh, std::string_view hmd, EyeSide eye) {
  std::string text = "{\n  \"schema\": \"holdfast/mesh/1\",\n  \"hmd\": " + detail::quoted(hmd) + ",\n  \"eye\": \"" +
                     std::string(name_of(eye)) + "\",\n  \"resolution_px\": [" + std::to_string(mesh.resolution.width) +
                     ", " + std::to_string(mesh.resolution.height) +
                     "],\n  \"per_color\": " + (mesh.per_color ? "true" : "false") + ",\n  \"max_error_px\": ";
  detail::append_number(text, mesh.max_error_px);
  text += ",\n  \"vertices\": [";
  const auto [first, end] = detail::colors_of(mesh);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const PredistortionVertex& v = mesh.vertices[i];
    text += i == 0 ? "\n[" : ",\n[";
    detail::append_number(text, v.panel_x);
    text += ',';
    detail::append_number(text, v.panel_y);
    for (std::size_t c = first; c < end; ++c) {
      for (const float t : v.tangent[c]) {
        text += ',';
        detail::append_number(text, t);
      }
    }
    text += ']';
  }
  text += "\n  ],\n  \"triangles\": [";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    text += i % 3 != 0 ? "," : i == 0 ? "\n[" : ",\n[";
    detail::append_number(text, mesh.triangles[i]);
    if (i % 3 == 2) text += ']';
  }
  return text + "\n  ]\n}\n";
}

[[nodiscard]] inline std::string mesh_obj(const PredistortionMesh& mesh, std::string_view hmd, EyeSide eye,
                                          const FieldTangents& source) {
  // A name of several lines would end the comment.
  std::string name(hmd);
  for (char& c : name) c = static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  std::string text = "# Predistortion mesh of " + name + ", " + std::string(name_of(eye)) +
                     " eye. v: 0 to 1 of the panel, origin lower left.\n# vt 0 0 is the tangent (";
  const auto append_pair = [&text](auto x, auto y, char between) {
    detail::append_number(text, x);
    text += between;
    detail::append_number(text, y);
  };
  append_pair(source.left, source.down, ' ');
  text += "), vt 1 1 is (";
  append_pair(source.right, source.up, ' ');
  text += ").\n";
  for (const PredistortionVertex& v : mesh.vertices) {
    text += "v ";
    append_pair(v.panel_x, v.panel_y, ' ');
    text += " 0\n";
  }
  const double width = source.right - source.left, height = source.up - source.down;
  const auto [first, end] = detail::colors_of(mesh);
  for (std::size_t c = first; c < end; ++c) {
    constexpr std::string_view names[] = {"red", "green", "blue"};
    text += "o " + std::string(mesh.per_color ? names[c] : "panel") + "\n";
    for (const PredistortionVertex& v : mesh.vertices) {
      text += "vt ";
      append_pair(static_cast<float>((static_cast<double>(v.tangent[c][0]) - source.left) / width),
                  static_cast<float>((static_cast<double>(v.tangent[c][1]) - source.down) / height), ' ');
      text += '\n';
    }
    const std::size_t before = (c - first) * mesh.vertices.size();
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      text += i % 3 == 0 ? "f " : " ";
      append_pair(mesh.triangles[i] + std::size_t(1), mesh.triangles[i] + std::size_t(1) + before, '/');
      if (i % 3 == 2) text += '\n';
    }
  }
  return text;
}

}  // namespace holdfast::io

/// Headset descriptors: JSON files of the schema "holdfast/hmd/1" (assets/schema/hmd.schema.json) to and from HmdModel.
///
/// The field of an eye is given in one of four ways: signed `tangents`, signed `angles_deg` (OpenXR), full `fov_deg`,
/// or the virtual image's rectangle `virtual_image_m` (Robinett & Holloway 7.7). An eye that mirrors the other is
/// written "mirrored". Lengths are in metres (key suffix _m), angles in degrees (_deg), times in milliseconds (_ms).
/// Bad input: io::InputError with file, line, key path, value and what was expected. Unknown keys are refused by name,
/// and a file of another kind is called by its own. write_hmd and read_hmd give back every number bit by bit.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <system_error>

#include <holdfast/io/hmd_reader.hpp>
#include <holdfast/io/hmd_writer.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

/// Reads a descriptor file.
[[nodiscard]] inline HmdModel read_hmd(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw InputError({.file = path.string(),
                      .line = 0,
                      .key = {},
                      .problem = "this is a folder",
                      .value = {},
                      .expected = "a headset descriptor (JSON)"});
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw InputError({.file = path.string(),
                      .line = 0,
                      .key = {},
                      .problem = "the file cannot be opened",
                      .value = {},
                      .expected = "a headset descriptor (JSON)"});
  }
  std::string text;
  text.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  if (file.bad()) {
    throw InputError({.file = path.string(),
                      .line = 0,
                      .key = {},
                      .problem = "the file cannot be read to its end",
                      .value = {},
                      .expected = "a headset descriptor (JSON)"});
  }
  return parse_hmd(text, path.string());
}

/// Writes a descriptor; the file appears whole or not at all. A model that read_hmd would refuse is refused here, by
/// the same message.
inline void write_hmd(const std::filesystem::path& path, const HmdModel& hmd) {
  const std::string text = hmd_json(hmd);
  static_cast<void>(parse_hmd(text, path.string()));
  std::filesystem::path part = path;
  part += ".part";
  {
    std::ofstream file(part, std::ios::binary | std::ios::trunc);
    file << text;
    file.flush();
    if (!file) {
      std::error_code ignored;
      std::filesystem::remove(part, ignored);
      throw InputError({.file = path.string(),
                        .line = 0,
                        .key = {},
                        .problem = "the file cannot be written",
                        .value = {},
                        .expected = "a folder that exists and may be written to"});
    }
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    throw InputError({.file = path.string(),
                      .line = 0,
                      .key = {},
                      .problem = "the file cannot be written: " + error.message(),
                      .value = {},
                      .expected = "a path that may be written to"});
  }
}

}  // namespace holdfast::io

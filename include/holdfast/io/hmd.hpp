/// Headset descriptors: JSON files of the schema "holdfast/hmd/1" (assets/schema/hmd.schema.json) to and from HmdModel.
///
/// The field of an eye is given in one of four ways: signed `tangents`, signed `angles_deg` (OpenXR), full `fov_deg`,
/// or the virtual image's rectangle `virtual_image_m` (Robinett & Holloway 7.7). An eye that mirrors the other is
/// written "mirrored". Lengths are in metres (key suffix _m), angles in degrees (_deg), times in milliseconds (_ms).
/// Bad input: io::InputError with file, line, key path, value and what was expected. Unknown keys are refused by name,
/// and a file of another kind is called by its own. write_hmd and read_hmd give back every number bit by bit.
#pragma once

#include <filesystem>
#include <string>

#include <holdfast/io/hmd_reader.hpp>
#include <holdfast/io/hmd_writer.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/whole_file.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

/// Reads a descriptor file.
[[nodiscard]] inline HmdModel read_hmd(const std::filesystem::path& path) {
  return parse_hmd(read_whole_file(path), path.string());
}

/// Writes a descriptor; the file appears whole or not at all. A model that read_hmd would refuse is refused here, by
/// the same message.
inline void write_hmd(const std::filesystem::path& path, const HmdModel& hmd) {
  const std::string text = hmd_json(hmd);
  static_cast<void>(parse_hmd(text, path.string()));
  write_whole_file(path, text);
}

}  // namespace holdfast::io

/// Headset descriptors to and from HmdModel: our JSON, schema "holdfast/hmd/1" (assets/schema/hmd.schema.json), and,
/// to read, OSVR's descriptors and meshes (osvr.hpp) and Cardboard viewers (cardboard.hpp).
///
/// read_hmd tells the formats apart by their content. Of ours:
/// The field of an eye is given in one of four ways: signed `tangents`, signed `angles_deg` (OpenXR), full `fov_deg`,
/// or the virtual image's rectangle `virtual_image_m` (Robinett & Holloway 7.7). An eye that mirrors the other is
/// written "mirrored". Lengths are in metres (key suffix _m), angles in degrees (_deg), times in milliseconds (_ms).
/// Bad input: io::InputError with file, line, key path, value and what was expected. Unknown keys are refused by name,
/// and a file of another kind is called by its own. write_hmd and read_hmd give back every number bit by bit.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/cardboard.hpp>
#include <holdfast/io/hmd_reader.hpp>
#include <holdfast/io/hmd_writer.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/osvr.hpp>
#include <holdfast/io/whole_file.hpp>
#include <holdfast/optics/hmd.hpp>

namespace holdfast::io {

namespace detail {

enum class HmdForm { json, address, binary, other };

/// By the first character that is no blank. A buffer of numbers always holds zero bytes, text never does.
[[nodiscard]] inline HmdForm form_of(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  const std::string_view rest = begin == std::string_view::npos ? std::string_view() : text.substr(begin);
  if (rest.starts_with("{") || rest.starts_with("[") || rest.starts_with("/")) return HmdForm::json;
  if (rest.starts_with("http")) return HmdForm::address;
  return text.find('\0') != std::string_view::npos ? HmdForm::binary : HmdForm::other;
}

/// Of a file that is no text.
[[nodiscard]] inline CardboardViewer viewer_of_binary(std::string_view bytes, const std::string& file) {
  try {
    return parse_cardboard_buffer(bytes, file);
  } catch (const InputError& error) {
    throw InputError({.file = file,
                      .key = error.key(),
                      .problem = "neither text nor the buffer of a Cardboard viewer: " + error.problem(),
                      .value = error.value(),
                      .expected = error.expected()});
  }
}

}  // namespace detail

/// What formats other than ours do not say.
struct HmdOptions {
  OsvrAssumptions osvr;
  std::optional<PhoneScreen> phone;  ///< in a Cardboard viewer
  std::string_view phone_expected = "the size and resolution of the phone's screen beside it";  ///< when there is none
};

/// A headset and what its file was.
struct HmdFile {
  HmdModel hmd;
  HmdFormat format = HmdFormat::unknown;
  std::vector<std::string> notes;  ///< what the file left to assume
};

/// Reads a descriptor of any format; `file` is for messages, `beside` answers files that an OSVR descriptor names.
[[nodiscard]] inline HmdFile parse_hmd_file(std::string_view text, std::string file, const BesideReader& beside,
                                            const HmdOptions& options = {}) {
  const auto with_phone = [&](const CardboardViewer& viewer) {
    if (options.phone) return HmdFile{checked_cardboard_hmd(viewer, *options.phone, file), HmdFormat::cardboard, {}};
    throw InputError({.file = file,
                      .problem = "this is a Cardboard viewer, which is a headset only with a phone",
                      .expected = std::string(options.phone_expected)});
  };
  switch (detail::form_of(text)) {
    case detail::HmdForm::json:
      break;
    case detail::HmdForm::address:
      return with_phone(parse_cardboard(text, file));
    case detail::HmdForm::binary:
      return with_phone(detail::viewer_of_binary(text, file));
    case detail::HmdForm::other:
      throw InputError({.file = file,
                        .problem = "this is no headset descriptor",
                        .expected = "JSON (ours, OSVR's, or a Cardboard viewer's) or a viewer's address or buffer"});
  }
  const JsonDocument document = JsonDocument::parse(text, file);
  const JsonNode root = document.root();
  switch (detail::format_of(root)) {
    case HmdFormat::osvr: {
      OsvrHmd osvr = osvr_of(root, document.file(), beside, options.osvr);
      return {std::move(osvr.hmd), HmdFormat::osvr, std::move(osvr.notes)};
    }
    case HmdFormat::cardboard:
      return with_phone(cardboard_of(root, file));
    default:
      return {hmd_of(root), HmdFormat::holdfast, {}};
  }
}
[[nodiscard]] inline HmdModel parse_any_hmd(std::string_view text, std::string file, const BesideReader& beside,
                                            const HmdOptions& options = {}) {
  return parse_hmd_file(text, std::move(file), beside, options).hmd;
}

/// Reads a descriptor file, and says of which format it is and what it left to assume.
[[nodiscard]] inline HmdFile read_hmd_file(const std::filesystem::path& path, const HmdOptions& options = {}) {
  return parse_hmd_file(read_whole_file(path), path.string(), files_in(path.parent_path()), options);
}
/// Reads a descriptor file.
[[nodiscard]] inline HmdModel read_hmd(const std::filesystem::path& path, const HmdOptions& options = {}) {
  return read_hmd_file(path, options).hmd;
}

/// Writes a descriptor; the file appears whole or not at all. A model that read_hmd would refuse is refused here, by
/// the same message.
inline void write_hmd(const std::filesystem::path& path, const HmdModel& hmd) {
  const std::string text = hmd_json(hmd);
  static_cast<void>(parse_hmd(text, path.string()));
  write_whole_file(path, text);
}

}  // namespace holdfast::io

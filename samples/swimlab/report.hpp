/// Pictures of a run on disk and in the page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <holdfast/io/image.hpp>
#include <holdfast/io/results.hpp>

#include "report_page.hpp"
#include "row_runner.hpp"

namespace swimlab {

/// "M1_P0_left_none_60ms_global": a file name that tells a row.
[[nodiscard]] std::string file_stem(const holdfast::ExperimentRow& row);

/// Writes STEM_contact.png (real, virtual, overlay with arrows, the same in detail; time runs to the right), STEM_worst.png (overlay of the
/// frame of the largest error) and STEM_worst_difference.png.
void write_pictures(const std::filesystem::path& folder, const RowResult& result);

/// A picture for the page: {src, width, height, caption, arrows}.
[[nodiscard]] holdfast::io::ResultJson page_picture(const holdfast::io::Image& image, const std::string& caption,
                                                    const std::vector<Arrow>* arrows = nullptr);

/// The contact sheet of a motion: real, then each pipeline, in detail, whole, and alone; with the disc's place in the
/// details, for a close-up, and each picture's error.
[[nodiscard]] holdfast::io::ResultJson contact_sheet(const std::vector<const RowResult*>& rows);

/// The overlay of a row's worst frame, at half size.
[[nodiscard]] holdfast::io::ResultJson worst_picture(const RowResult& result);

}  // namespace swimlab

#include "report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <span>

#include <holdfast/io/png.hpp>
#include <holdfast/rendering/composition.hpp>

#include "charts.hpp"

namespace swimlab {

using namespace holdfast;
using io::Image;
using io::ResultJson;

namespace {

std::string base64(std::span<const std::uint8_t> bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t block = 0;
    for (std::size_t k = 0; k < 3; ++k) block = block << 8 | (k < n ? bytes[i + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= n ? digits[block >> (18 - 6 * k) & 63u] : '=';
  }
  return text;
}

std::string with_unit(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

void copy_into(Image& sheet, const Image& picture, int left, int top) {
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      sheet.set(left + x, sheet.height - top - picture.height + y, picture.at(x, y));
    }
  }
}

/// A white line with a dot at its start; coordinates as Arrow's.
void draw_arrow(Image& image, const Arrow& arrow) {
  const auto put = [&](double x, double y) {
    const int column = static_cast<int>(x), row = image.height - 1 - static_cast<int>(y);
    if (column >= 0 && row >= 0 && column < image.width && row < image.height)
      image.set(column, row, {255, 255, 255, 255});
  };
  const double dx = arrow[2] - arrow[0], dy = arrow[3] - arrow[1], length = std::hypot(dx, dy);
  for (double s = 0.0; s <= length; s += 0.5)
    put(arrow[0] + dx * s / std::max(length, 1e-9), arrow[1] + dy * s / std::max(length, 1e-9));
  if (length < 3.0) return;
  const double head = std::min(6.0, 0.5 * length), ux = dx / length, uy = dy / length;
  for (double s = 0.0; s <= head; s += 0.5) {
    put(arrow[2] - s * (ux + 0.5 * uy), arrow[3] - s * (uy - 0.5 * ux));
    put(arrow[2] - s * (ux - 0.5 * uy), arrow[3] - s * (uy + 0.5 * ux));
  }
}

Image with_arrows(const Shot& shot) {
  Image both = rendering::overlay(shot.real, shot.drawn);
  for (const Arrow& arrow : shot.arrows) draw_arrow(both, arrow);
  return both;
}

}  // namespace

std::string file_stem(const ExperimentRow& row) {
  std::string stem = row.motion + '_' + variant_name(row) + '_' + std::string(name_of(row.eye)) + '_' +
                     std::string(name_of(row.lens)) + '_' + with_unit("%g", row.latency_ms) + "ms_" +
                     std::string(name_of(row.display));
  for (char& c : stem) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_';
    if (!plain) c = '-';
  }
  return stem;
}

void write_pictures(const std::filesystem::path& folder, const RowResult& result) {
  const std::string stem = file_stem(result.row);
  if (!result.contact.empty()) {
    constexpr int gap = 4;
    const int width = result.contact[0].whole.real.width, height = result.contact[0].whole.real.height;
    const int columns = static_cast<int>(result.contact.size()), rows = result.contact[0].detail ? 4 : 3;
    Image sheet(columns * (width + gap) - gap, rows * (height + gap) - gap, {250, 249, 246, 255});
    for (int column = 0; column < columns; ++column) {
      const PictureFrame& frame = result.contact[static_cast<std::size_t>(column)];
      const int left = column * (width + gap);
      copy_into(sheet, frame.whole.real, left, 0);
      copy_into(sheet, frame.whole.drawn, left, height + gap);
      copy_into(sheet, with_arrows(frame.whole), left, 2 * (height + gap));
      if (frame.detail) copy_into(sheet, with_arrows(*frame.detail), left, 3 * (height + gap));
    }
    io::write_png(folder / (stem + "_contact.png"), sheet);
  }
  if (!result.worst) return;
  io::write_png(folder / (stem + "_worst.png"),
                rendering::overlay(result.worst->whole.real, result.worst->whole.drawn));
  io::write_png(folder / (stem + "_worst_difference.png"),
                rendering::difference(result.worst->whole.real, result.worst->whole.drawn));
}

ResultJson page_picture(const Image& image, const std::string& caption, const std::vector<Arrow>* arrows) {
  ResultJson json = {{"src", "data:image/png;base64," + base64(io::encode_png(image))},
                     {"width", image.width},
                     {"height", image.height},
                     {"caption", caption}};
  if (arrows == nullptr) return json;
  json["arrows"] = ResultJson::array();
  for (const Arrow& arrow : *arrows) {
    ResultJson list = ResultJson::array();
    for (const double x : arrow) list.push_back(std::round(10.0 * x) / 10.0);
    json["arrows"].push_back(list);
  }
  return json;
}

ResultJson contact_sheet(const std::vector<const RowResult*>& rows) {
  ResultJson sheet;
  sheet["times_s"] = ResultJson::array();
  sheet["middles"] = ResultJson::array();
  sheet["rows"] = ResultJson::array();
  if (rows.empty()) return sheet;
  // Per row and moment: a detail (nothing where no disc is whole in view), the whole view, and the virtual alone.
  const auto add = [&](const std::string& label, const std::string& note) -> ResultJson& {
    sheet["rows"].push_back({{"label", label},
                             {"note", note},
                             {"detail", ResultJson::array()},
                             {"whole", ResultJson::array()},
                             {"alone", ResultJson::array()},
                             {"rms_px", ResultJson::array()}});
    return sheet["rows"].back();
  };
  ResultJson& real = add("Real", "the room, at the moment of display");
  for (const PictureFrame& frame : rows.front()->contact) {
    sheet["times_s"].push_back(std::round(100.0 * frame.t_s) / 100.0);
    sheet["middles"].push_back({std::round(frame.detail_middle[0]), std::round(frame.detail_middle[1])});
    real["detail"].push_back(frame.detail ? page_picture(frame.detail->real, "") : ResultJson(nullptr));
    real["whole"].push_back(page_picture(frame.whole.real, ""));
    real["alone"].push_back(nullptr);  // the same picture
  }
  for (const RowResult* row : rows) {
    const bool own = !is_ablation(row->row);
    ResultJson& entry = add(variant_name(row->row), own ? std::string(describe(row->row.pipeline)) : "an ablation");
    for (const PictureFrame& frame : row->contact) {
      entry["rms_px"].push_back(rounded(frame.rms_px));
      std::string words = with_unit("Error %.1f px RMS.", frame.rms_px);
      if (frame.missing_pct >= 0.05) words += with_unit(" %.1f %% of the view has no pixel.", frame.missing_pct);
      if (frame.guessed_pct >= 0.005) words += with_unit(" %.2f %% was hidden when it was drawn.", frame.guessed_pct);
      const auto both = [&](const Shot& shot) {
        return page_picture(rendering::overlay(shot.real, shot.drawn), words, &shot.arrows);
      };
      entry["detail"].push_back(frame.detail ? both(*frame.detail) : ResultJson(nullptr));
      entry["whole"].push_back(both(frame.whole));
      entry["alone"].push_back(page_picture(frame.whole.drawn, words));
    }
  }
  sheet["caption"] =
      "Grey is real, coloured is virtual. Arrows lead from each real disc to where its virtual twin is drawn, and the "
      "numbers are the error of all discs in view (RMS). The detail is the surroundings of the nearest disc, pixel by "
      "pixel; the close-up magnifies it four times. Select a picture to enlarge it.";
  return sheet;
}

ResultJson worst_picture(const RowResult& result) {
  const PictureFrame& frame = *result.worst;
  const int factor = frame.whole.real.width > 800 ? 2 : 1;
  std::vector<Arrow> arrows = frame.whole.arrows;
  for (Arrow& arrow : arrows) {
    for (double& x : arrow) x /= factor;
  }
  ResultJson json = page_picture(smaller(rendering::overlay(frame.whole.real, frame.whole.drawn), factor),
                                 with_unit("At %.2f s, when the error is largest: ", frame.t_s) +
                                     with_unit("%.1f px RMS. Grey is real, coloured is virtual.", frame.rms_px),
                                 &arrows);
  json["title"] = variant_title(result.row);
  return json;
}

}  // namespace swimlab

// Draws docs/pictures/swim.png: one moment of a recorded head, without prediction on the left and with it on the right.
//     build/release/bin/swimlab run --motion head.tum --pipeline P0,P1 --lens none --model engine.glb --out out/head
//     g++ -std=c++20 -O1 -Iinclude -I/usr/include/eigen3 docs/pictures/with_and_without.cpp -o /tmp/with_and_without
//     -lpng /tmp/with_and_without out/head/pictures/*_P0_*_contact.png out/head/pictures/*_P1_*_contact.png
//     docs/pictures/swim.png
// The recording is head/optitrack_head_120hz.tum, the model assimp's 2CylinderEngine.glb.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include <holdfast/io/png.hpp>

using holdfast::io::Image;

namespace {

// A contact sheet has five moments side by side and three rows: real, virtual, and (at the bottom) both with arrows.
constexpr int columns = 5, rows = 3, gap = 4;

void copy_overlay(const Image& sheet, int moment, Image& picture, int at_x) {
  const int width = (sheet.width - (columns - 1) * gap) / columns;
  const int height = (sheet.height - (rows - 1) * gap) / rows;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) picture.set(at_x + x, y, sheet.at(moment * (width + gap) + x, y));
  }
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fputs("usage: with_and_without P0_contact.png P1_contact.png OUT.png\n", stderr);
    return 2;
  }
  const Image without = holdfast::io::read_png(argv[1]);
  const Image with = holdfast::io::read_png(argv[2]);
  const int width = (without.width - (columns - 1) * gap) / columns;
  Image picture(2 * width + 2 * gap, (without.height - (rows - 1) * gap) / rows, {255, 255, 255, 255});
  copy_overlay(without, 1, picture, 0);
  copy_overlay(with, 1, picture, width + 2 * gap);
  holdfast::io::write_png(argv[3], picture);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}

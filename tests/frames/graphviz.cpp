#include <doctest/doctest.h>

#include <holdfast/frames/graphviz.hpp>

using namespace holdfast;

namespace {

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("the drawing has every frame and edge once, with kind, age and what is wrong") {
  FrameGraph g;
  const FrameId W = g.frame("W"), R = g.frame("R"), H = g.frame("H"), odd = g.frame("a \"b\" \\c");
  const EdgeId RW = g.add_dynamic(R, W).edge;
  g.add_dynamic(R, H);
  g.add_static(H, odd, Vqs());
  g.push(RW, time_at(1), Vqs());
  const std::string dot = to_dot(g, time_at(1.0035));
  CAPTURE(dot);
  CHECK(dot.substr(0, 16) == "digraph frames {");
  CHECK(has(dot, "f3 [label=\"a \\\"b\\\" \\\\c\"]"));
  // Hung from the first frame, whichever way the edge was added.
  CHECK(has(dot, "f0 -> f1 ["));
  CHECK(has(dot, "label=\" T_R_W \\n 3.5 ms \""));
  CHECK(has(dot, "f1 -> f2 ["));
  CHECK(has(dot, "style=dashed, label=\" T_R_H \\n no data \""));
  CHECK(has(dot, "f2 -> f3 [color=\"#8a94a6\""));
  std::size_t arrows = 0;
  for (std::size_t at = dot.find("->"); at != std::string::npos; at = dot.find("->", at + 1)) ++arrows;
  CHECK(arrows == 3);
  CHECK(dot.substr(dot.size() - 2) == "}\n");
}

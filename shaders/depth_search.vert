#version 450 core
// Late warp by depth, backward; with depth_search.frag, which explains it. The mesh is that of late_warp.vert: draw it over the
// panel's picture, with panel_* = place; or a mesh over the picture that the eye sees, with panel_* the place that is seen there.
layout(location = 0) in vec2 place;
layout(location = 1) in vec2 tangent_red;
layout(location = 2) in vec2 tangent_green;
layout(location = 3) in vec2 tangent_blue;
layout(location = 4) in vec2 panel_red;
layout(location = 5) in vec2 panel_green;
layout(location = 6) in vec2 panel_blue;
noperspective out vec4 red, green, blue;  // tangent, panel

void main() {
  red = vec4(tangent_red, panel_red);
  green = vec4(tangent_green, panel_green);
  blue = vec4(tangent_blue, panel_blue);
  gl_Position = vec4(2.0 * place - 1.0, 0.0, 1.0);
}

#version 450 core
// A mesh at its place in the world.
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec2 texture_uv;
layout(location = 3) in vec4 vertex_colour;
uniform mat4 clip_from_mesh;
uniform mat3 world_from_normal;  // inverse transpose of the mesh's turn and scale
out vec3 normal_W;
out vec2 uv;
out vec4 colour;

void main() {
  gl_Position = clip_from_mesh * vec4(position, 1.0);
  normal_W = world_from_normal * normal;
  uv = texture_uv;
  colour = vertex_colour;
}

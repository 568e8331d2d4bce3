/// Indexed triangles in GPU memory: vertices of any layout, of floats.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <holdfast/rendering/gl_object.hpp>

namespace holdfast::rendering {

class TriangleBuffers {
 public:
  /// stride: bytes a vertex; indices: three a triangle, each of a vertex that there is.
  TriangleBuffers(Context& context, std::span<const std::byte> vertices, std::size_t stride,
                  std::span<const std::uint32_t> indices)
      : context_(&context),
        vertices_(make_buffer(context)),
        indices_(make_buffer(context)),
        layout_(make_vertex_array(context)),
        vertex_count_(vertices.size() / stride),
        index_count_(static_cast<GLsizei>(indices.size())) {
    const GlFunctions& gl = context.gl();
    gl.NamedBufferStorage(vertices_.id(), static_cast<GLsizeiptr>(vertices.size()), vertices.data(), 0);
    gl.NamedBufferStorage(indices_.id(), static_cast<GLsizeiptr>(indices.size_bytes()), indices.data(), 0);
    gl.VertexArrayVertexBuffer(layout_.id(), 0, vertices_.id(), 0, static_cast<GLsizei>(stride));
    gl.VertexArrayElementBuffer(layout_.id(), indices_.id());
  }

  /// The vertex shader's input `index`: so many floats, `offset` bytes into a vertex.
  void attribute(GLuint index, GLint components, std::size_t offset) const {
    const GlFunctions& gl = context_->gl();
    gl.EnableVertexArrayAttrib(layout_.id(), index);
    gl.VertexArrayAttribFormat(layout_.id(), index, components, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
    gl.VertexArrayAttribBinding(layout_.id(), index, 0);
  }

  void draw() const {
    const GlFunctions& gl = context_->gl();
    gl.BindVertexArray(layout_.id());
    gl.DrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
  }

  [[nodiscard]] std::size_t vertex_count() const { return vertex_count_; }
  [[nodiscard]] std::size_t triangle_count() const { return static_cast<std::size_t>(index_count_) / 3; }

 private:
  Context* context_;
  GlObject vertices_, indices_, layout_;
  std::size_t vertex_count_;
  GLsizei index_count_;
};

}  // namespace holdfast::rendering

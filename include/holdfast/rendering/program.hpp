/// A vertex and a fragment shader linked into a program.
///
/// Errors: ShaderError with the shader's file name, the line when the driver's log tells it, and the whole log.
#pragma once

#include <array>
#include <cctype>
#include <optional>
#include <string>
#include <string_view>

#include <holdfast/geometry/types.hpp>
#include <holdfast/rendering/gl_object.hpp>
#include <holdfast/rendering/shader_source.hpp>

namespace holdfast::rendering {

class ShaderError : public RenderingError {
 public:
  ShaderError(std::string_view shader, std::optional<int> line, const std::string& log)
      : RenderingError("shader " + std::string(shader) + (line ? ", line " + std::to_string(*line) : std::string()) +
                       ": " + log),
        shader_(shader),
        line_(line) {}

  [[nodiscard]] const std::string& shader() const { return shader_; }
  [[nodiscard]] std::optional<int> line() const { return line_; }

 private:
  std::string shader_;
  std::optional<int> line_;
};

/// The line of the first complaint in a driver's log: Mesa writes "0:12(5): error", others "0(12) : error" or "ERROR:
/// 0:12:".
[[nodiscard]] inline std::optional<int> line_of_shader_log(std::string_view log) {
  const auto is_digit = [&](std::size_t i) {
    return i < log.size() && std::isdigit(static_cast<unsigned char>(log[i])) != 0;
  };
  for (std::size_t i = 0; i < log.size(); ++i) {
    if (!is_digit(i)) continue;
    while (is_digit(i)) ++i;
    if (i >= log.size() || (log[i] != ':' && log[i] != '(') || !is_digit(i + 1)) continue;
    int line = 0;
    for (++i; is_digit(i) && line < 1'000'000; ++i) line = 10 * line + (log[i] - '0');
    return line;
  }
  return std::nullopt;
}

class Program {
 public:
  /// define: a name that both shaders see as defined (`#ifdef NAME`); empty: none.
  Program(Context& context, const ShaderSource& vertex, const ShaderSource& fragment, std::string_view define = {})
      : context_(&context) {
    context.make_current();
    const GlFunctions& gl = context.gl();
    const GlObject vertex_shader = compile(GL_VERTEX_SHADER, vertex, define);
    const GlObject fragment_shader = compile(GL_FRAGMENT_SHADER, fragment, define);
    program_ = GlObject(context, gl.CreateProgram(), [](const GlFunctions& f, GLuint name) { f.DeleteProgram(name); });
    gl.AttachShader(id(), vertex_shader.id());
    gl.AttachShader(id(), fragment_shader.id());
    gl.LinkProgram(id());
    gl.DetachShader(id(), vertex_shader.id());
    gl.DetachShader(id(), fragment_shader.id());
    GLint linked = GL_FALSE;
    gl.GetProgramiv(id(), GL_LINK_STATUS, &linked);
    if (linked == GL_TRUE) return;
    GLint length = 0;
    gl.GetProgramiv(id(), GL_INFO_LOG_LENGTH, &length);
    std::string log(static_cast<std::size_t>(length), '\0');
    gl.GetProgramInfoLog(id(), length, nullptr, log.data());
    throw ShaderError(std::string(vertex.name) + " with " + std::string(fragment.name), std::nullopt,
                      "does not link: " + log);
  }

  [[nodiscard]] GLuint id() const { return program_.id(); }
  void use() const { context_->gl().UseProgram(id()); }

  /// Location of a uniform. Throws when the program has none of this name: a misspelt name must not pass in silence.
  [[nodiscard]] GLint uniform(const char* name) const {
    const GLint location = context_->gl().GetUniformLocation(id(), name);
    if (location < 0) throw RenderingError(std::string("the program has no uniform '") + name + "'");
    return location;
  }

  void set(GLint location, int value) const { context_->gl().ProgramUniform1i(id(), location, value); }
  void set(GLint location, float value) const { context_->gl().ProgramUniform1f(id(), location, value); }
  void set(GLint location, const Vector2& v) const {
    context_->gl().ProgramUniform2f(id(), location, float(v.x()), float(v.y()));
  }
  void set(GLint location, const Vector3& v) const {
    context_->gl().ProgramUniform3f(id(), location, float(v.x()), float(v.y()), float(v.z()));
  }
  void set(GLint location, const Vector4& v) const {
    context_->gl().ProgramUniform4f(id(), location, float(v.x()), float(v.y()), float(v.z()), float(v.w()));
  }
  void set(GLint location, const Matrix3& m) const {
    const MatrixOf<float, 3> f = m.cast<float>();
    context_->gl().ProgramUniformMatrix3fv(id(), location, 1, GL_FALSE, f.data());
  }
  template <std::size_t n>
  void set(GLint location, const std::array<Vector3, n>& vectors) const {
    std::array<VectorOf<float, 3>, n> f;
    for (std::size_t i = 0; i < n; ++i) f[i] = vectors[i].template cast<float>();
    context_->gl().ProgramUniform3fv(id(), location, static_cast<GLsizei>(n), f[0].data());
  }
  /// An array of three.
  void set(GLint location, const std::array<Matrix3, 3>& matrices) const {
    std::array<MatrixOf<float, 3>, 3> f;
    for (std::size_t i = 0; i < 3; ++i) f[i] = matrices[i].cast<float>();
    context_->gl().ProgramUniformMatrix3fv(id(), location, 3, GL_FALSE, f[0].data());
  }
  void set(GLint location, const Matrix4& m) const {
    const MatrixOf<float, 4> f = m.cast<float>();
    context_->gl().ProgramUniformMatrix4fv(id(), location, 1, GL_FALSE, f.data());
  }

 private:
  [[nodiscard]] GlObject compile(GLenum kind, const ShaderSource& source, std::string_view define) const {
    const GlFunctions& gl = context_->gl();
    GlObject shader(*context_, gl.CreateShader(kind), [](const GlFunctions& f, GLuint name) { f.DeleteShader(name); });
    // The definition must follow the line that tells the version; lines keep their numbers.
    const std::size_t first_line = define.empty() ? 0 : source.text.find('\n') + 1;
    const std::string definition = define.empty() ? "" : "#define " + std::string(define) + "\n#line 2\n";
    const std::array<std::string_view, 3> parts{source.text.substr(0, first_line), definition,
                                                source.text.substr(first_line)};
    const std::array texts{parts[0].data(), parts[1].data(), parts[2].data()};
    const std::array lengths{static_cast<GLint>(parts[0].size()), static_cast<GLint>(parts[1].size()),
                             static_cast<GLint>(parts[2].size())};
    gl.ShaderSource(shader.id(), 3, texts.data(), lengths.data());
    gl.CompileShader(shader.id());
    GLint compiled = GL_FALSE;
    gl.GetShaderiv(shader.id(), GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return shader;
    GLint log_length = 0;
    gl.GetShaderiv(shader.id(), GL_INFO_LOG_LENGTH, &log_length);
    std::string log(static_cast<std::size_t>(log_length), '\0');
    gl.GetShaderInfoLog(shader.id(), log_length, nullptr, log.data());
    throw ShaderError(source.name, line_of_shader_log(log), log);
  }

  Context* context_;
  GlObject program_;
};

}  // namespace holdfast::rendering

/// Draws solid meshes with simple light that is fixed in the world, so that real and virtual pictures of one thing
/// shade alike.
#pragma once

#include <Eigen/LU>

#include <holdfast/rendering/mesh.hpp>
#include <holdfast/rendering/program.hpp>
#include <holdfast/rendering/shaders.hpp>
#include <holdfast/rendering/texture.hpp>
#include <holdfast/rendering/view.hpp>

namespace holdfast::rendering {

/// How strong colours come out: real things as a camera sees them, virtual ones as a display adds them.
struct Toning {
  float saturation = 1.0f;         ///< 0 grey, 1 as the material is
  Vector3 tint = Vector3::Ones();  ///< multiplies the result
};

struct Material {
  Vector4 base_colour = Vector4::Ones();
  const Texture* base_texture = nullptr;  ///< not owned
  float alpha_cutoff = 0.0f;              ///< fragments less opaque are left out
  bool two_sided = true;
};

class LitPainter {
 public:
  explicit LitPainter(Context& context)
      : context_(&context),
        program_(context, shaders::lit_vert, shaders::lit_frag),
        clip_from_mesh_(program_.uniform("clip_from_mesh")),
        world_from_normal_(program_.uniform("world_from_normal")),
        base_colour_(program_.uniform("base_colour")),
        has_texture_(program_.uniform("has_texture")),
        alpha_cutoff_(program_.uniform("alpha_cutoff")),
        saturation_(program_.uniform("saturation")),
        tint_(program_.uniform("tint")) {}

  /// Once before a run of draw().
  void begin(const View& view, const Toning& toning) {
    const GlFunctions& gl = context_->gl();
    clip_from_world_ = clip_from_world(view);
    program_.use();
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.DepthMask(GL_TRUE);
    gl.Disable(GL_BLEND);
    program_.set(saturation_, toning.saturation);
    program_.set(tint_, toning.tint);
  }

  /// world_from_mesh: any invertible affine matrix; one that mirrors is drawn the right way round too.
  void draw(const Mesh& mesh, const Matrix4& world_from_mesh, const Material& material) const {
    const GlFunctions& gl = context_->gl();
    const Matrix3 turn_and_scale = world_from_mesh.topLeftCorner<3, 3>();
    const double determinant = turn_and_scale.determinant();
    if (determinant == 0.0) return;  // squashed flat: nothing to see, and normals without meaning
    gl.FrontFace(determinant > 0.0 ? GL_CCW : GL_CW);
    material.two_sided ? gl.Disable(GL_CULL_FACE) : gl.Enable(GL_CULL_FACE);
    program_.set(clip_from_mesh_, Matrix4(clip_from_world_ * world_from_mesh));
    program_.set(world_from_normal_, Matrix3(turn_and_scale.inverse().transpose()));
    program_.set(base_colour_, material.base_colour);
    program_.set(has_texture_, material.base_texture != nullptr ? 1 : 0);
    program_.set(alpha_cutoff_, material.alpha_cutoff);
    if (material.base_texture != nullptr) material.base_texture->bind(0);
    mesh.draw();
  }

 private:
  Context* context_;
  Program program_;
  GLint clip_from_mesh_, world_from_normal_, base_colour_, has_texture_, alpha_cutoff_, saturation_, tint_;
  Matrix4 clip_from_world_ = Matrix4::Identity();
};

}  // namespace holdfast::rendering

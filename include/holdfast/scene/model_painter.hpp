/// Uploads a model once and draws it any number of times.
#pragma once

#include <cstddef>
#include <vector>

#include <holdfast/rendering/lit_painter.hpp>
#include <holdfast/scene/model.hpp>

namespace holdfast::scene {

class ModelPainter {
 public:
  /// The model's data are copied to the GPU; `model` is not needed afterwards.
  ModelPainter(rendering::Context& context, const Model& model)
      : lit_(context), materials_(model.materials), parts_(model.parts) {
    for (const io::Image& image : model.textures) textures_.emplace_back(context, image);
    for (const ModelMesh& mesh : model.meshes) {
      mesh_of_.push_back(meshes_.size());
      material_of_.push_back(mesh.material);
      if (mesh.indices.empty()) continue;  // no part stands for it
      meshes_.emplace_back(context, mesh.vertices, mesh.indices);
    }
  }

  /// Into the bound target. Draw solid things before flat shapes (RegistrationScenePainter::draw_flat).
  void draw(const rendering::View& view, const Vqs& T_WM, const rendering::Toning& toning = {}) {
    lit_.begin(view, toning);
    const Matrix4 world_from_model = T_WM.matrix();
    for (const ModelPart& part : parts_) {
      const ModelMaterial& from = materials_[material_of_[part.mesh]];
      rendering::Material material;
      material.base_colour = from.base_colour;
      material.base_texture = from.texture ? &textures_[*from.texture] : nullptr;
      material.alpha_cutoff = from.alpha_cutoff;
      material.two_sided = from.two_sided;
      lit_.draw(meshes_[mesh_of_[part.mesh]], Matrix4(world_from_model * part.model_from_mesh), material);
    }
  }

 private:
  rendering::LitPainter lit_;
  std::vector<ModelMaterial> materials_;
  std::vector<ModelPart> parts_;
  std::vector<rendering::Texture> textures_;
  std::vector<rendering::Mesh> meshes_;
  std::vector<std::size_t> mesh_of_, material_of_;
};

}  // namespace holdfast::scene

/// Reads a model in any format that assimp knows (glTF, OBJ, Collada, FBX, PLY, ...), with its materials and textures.
///
/// Faces become triangles and missing normals are made smooth. Textures may be embedded in the file, coded or as bare
/// texels, or lie beside it (PNG, JPEG, TGA); one that cannot be read leaves its material in plain colour and a
/// warning. Animations, skins and lights are not read: a skinned model stands as its file poses it. Errors:
/// io::InputError with the file and what assimp said.
#pragma once

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <holdfast/io/input_error.hpp>
#include <holdfast/scene/model.hpp>
#include <holdfast/scene/texture_image.hpp>

namespace holdfast::scene {
namespace detail {

[[nodiscard]] inline std::string lower_case(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// The file that a material means: beside the model, as written (Windows separators and file:// allowed), else of the
/// same name in the model's folder, whatever the case of its letters. Empty when there is none.
[[nodiscard]] inline std::filesystem::path find_texture(const std::filesystem::path& folder, std::string name) {
  if (name.rfind("file://", 0) == 0) name.erase(0, 7);
  std::replace(name.begin(), name.end(), '\\', '/');
  std::error_code ignored;
  const std::filesystem::path as_written = folder / name;
  if (std::filesystem::is_regular_file(as_written, ignored)) return as_written;
  const std::string wanted = lower_case(std::filesystem::path(name).filename().string());
  for (const auto& entry : std::filesystem::directory_iterator(folder.empty() ? "." : folder, ignored)) {
    if (lower_case(entry.path().filename().string()) == wanted) return entry.path();
  }
  return {};
}

/// Turns assimp's scene into a Model.
class ModelBuilder {
 public:
  ModelBuilder(const aiScene& scene, std::filesystem::path path) : scene_(scene), path_(std::move(path)) {
    model_.name = path_.filename().string();
  }

  [[nodiscard]] Model build() {
    for (unsigned i = 0; i < scene_.mNumMaterials; ++i) add_material(*scene_.mMaterials[i]);
    if (model_.materials.empty()) model_.materials.emplace_back();
    for (unsigned i = 0; i < scene_.mNumMeshes; ++i) add_mesh(*scene_.mMeshes[i]);
    add_parts(*scene_.mRootNode, Matrix4::Identity());
    if (dropped_ > 0) {
      model_.warnings.push_back(std::to_string(dropped_) + " faces left out: not triangles, or with broken numbers");
    }
    return std::move(model_);
  }

 private:
  [[nodiscard]] static Matrix4 matrix_of(const aiMatrix4x4& m) {
    Matrix4 result;
    result << double(m.a1), double(m.a2), double(m.a3), double(m.a4), double(m.b1), double(m.b2), double(m.b3),
        double(m.b4), double(m.c1), double(m.c2), double(m.c3), double(m.c4), double(m.d1), double(m.d2), double(m.d3),
        double(m.d4);
    return result;
  }

  void add_material(const aiMaterial& from) {
    ModelMaterial material;
    material.name = from.GetName().C_Str();
    aiColor4D colour;
    if (from.Get(AI_MATKEY_BASE_COLOR, colour) == aiReturn_SUCCESS ||
        from.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == aiReturn_SUCCESS) {
      material.base_colour << double(colour.r), double(colour.g), double(colour.b), double(colour.a);
    }
    aiString mode;
    float cutoff = 0.5f;
    if (from.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) == aiReturn_SUCCESS && std::string(mode.C_Str()) == "MASK") {
      static_cast<void>(from.Get(AI_MATKEY_GLTF_ALPHACUTOFF, cutoff));
      material.alpha_cutoff = cutoff;
    }
    for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
      aiString name;
      if (from.GetTexture(type, 0, &name) != aiReturn_SUCCESS) continue;
      material.texture = texture(name.C_Str(), material.name);
      if (!material.texture) continue;
      // A diffuse colour of black beside a diffuse texture is an exporter's slip: the texture would vanish.
      if (material.base_colour.head<3>().isZero()) material.base_colour << 1.0, 1.0, 1.0, material.base_colour[3];
      break;
    }
    model_.materials.push_back(std::move(material));
  }

  /// Index of the texture of this name, read at first sight.
  [[nodiscard]] std::optional<std::size_t> texture(const std::string& name, const std::string& material) {
    const auto known = textures_.find(name);
    if (known != textures_.end()) return known->second;
    std::optional<std::size_t> index;
    try {
      model_.textures.push_back(read_picture(name));
      index = model_.textures.size() - 1;
    } catch (const io::InputError& error) {
      model_.warnings.push_back("material '" + material + "' is drawn without its texture: " + error.what());
    }
    textures_.emplace(name, index);
    return index;
  }

  [[nodiscard]] io::Image read_picture(const std::string& name) const {
    if (const aiTexture* embedded = scene_.GetEmbeddedTexture(name.c_str())) {
      return embedded_picture(*embedded, path_.string() + ": embedded texture " + name);
    }
    const std::filesystem::path file = find_texture(path_.parent_path(), name);
    if (file.empty()) throw io::InputError({.file = path_.string(), .problem = "texture not found", .value = name});
    return read_texture(file);
  }

  [[nodiscard]] static io::Image embedded_picture(const aiTexture& texture, const std::string& source) {
    if (texture.mHeight == 0) {  // coded: mWidth is the number of bytes
      return decode_texture({reinterpret_cast<const std::uint8_t*>(texture.pcData), texture.mWidth}, source);
    }
    io::Image image(static_cast<int>(texture.mWidth), static_cast<int>(texture.mHeight));
    const aiTexel* texel = texture.pcData;
    for (int y = image.height - 1; y >= 0; --y) {
      for (int x = 0; x < image.width; ++x, ++texel) image.set(x, y, {texel->r, texel->g, texel->b, texel->a});
    }
    return image;
  }

  void add_mesh(const aiMesh& from) {
    ModelMesh mesh;
    mesh.material = std::min<std::size_t>(from.mMaterialIndex, model_.materials.size() - 1);
    mesh.vertices.resize(from.mNumVertices);
    std::vector<bool> sound(from.mNumVertices);
    for (unsigned i = 0; i < from.mNumVertices; ++i) {
      rendering::MeshVertex& vertex = mesh.vertices[i];
      const aiVector3D p = from.mVertices[i];
      sound[i] = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
      if (!sound[i]) continue;  // stays at the mesh's origin, and no triangle uses it
      vertex.position = {p.x, p.y, p.z};
      if (from.HasNormals()) {
        const aiVector3D n = from.mNormals[i];
        if (std::isfinite(n.x) && std::isfinite(n.y) && std::isfinite(n.z)) vertex.normal = {n.x, n.y, n.z};
      }
      if (from.HasTextureCoords(0)) {
        vertex.uv = {from.mTextureCoords[0][i].x, from.mTextureCoords[0][i].y};
      }
      if (from.HasVertexColors(0)) {
        const aiColor4D c = from.mColors[0][i];
        vertex.colour = {c.r, c.g, c.b, c.a};
      }
    }
    for (unsigned i = 0; i < from.mNumFaces; ++i) {
      const aiFace& face = from.mFaces[i];
      const auto usable = [&](unsigned k) { return face.mIndices[k] < from.mNumVertices && sound[face.mIndices[k]]; };
      if (face.mNumIndices != 3 || !usable(0) || !usable(1) || !usable(2)) {
        ++dropped_;
        continue;
      }
      mesh.indices.insert(mesh.indices.end(), face.mIndices, face.mIndices + 3);
    }
    model_.meshes.push_back(std::move(mesh));
  }

  void add_parts(const aiNode& node, const Matrix4& model_from_parent) {
    const Matrix4 model_from_node = model_from_parent * matrix_of(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      const std::size_t mesh = node.mMeshes[i];
      if (mesh < model_.meshes.size() && !model_.meshes[mesh].indices.empty() && model_from_node.allFinite()) {
        model_.parts.push_back({mesh, model_from_node});
      }
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i) add_parts(*node.mChildren[i], model_from_node);
  }

  const aiScene& scene_;
  std::filesystem::path path_;
  Model model_;
  std::map<std::string, std::optional<std::size_t>> textures_;
  std::size_t dropped_ = 0;
};

}  // namespace detail

[[nodiscard]] inline Model load_model(const std::filesystem::path& path) {
  const auto fail = [&](const std::string& problem, const std::string& expected = {}) {
    throw io::InputError({.file = path.string(), .problem = problem, .expected = expected});
  };
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) fail("no such file", "a model that assimp reads (GLB, OBJ, DAE, ...)");
  if (!std::filesystem::is_regular_file(path, ignored)) fail("not a file", "a model that assimp reads");
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  const aiScene* scene = importer.ReadFile(path.string(), aiProcess_Triangulate | aiProcess_GenSmoothNormals |
                                                              aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                                                              aiProcess_TransformUVCoords | aiProcess_GenUVCoords);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    fail(std::string("assimp cannot read the model: ") + importer.GetErrorString());
  }
  Model model = detail::ModelBuilder(*scene, path).build();
  if (model.parts.empty()) fail("the model has no triangles to draw", "at least one");
  return model;
}

}  // namespace holdfast::scene

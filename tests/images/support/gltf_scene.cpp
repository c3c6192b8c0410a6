#include "images/support/gltf_scene.hpp"

#include <stb_image_write.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <stdexcept>

namespace regulus::test {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

json to_json(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}

json to_json(const glm::dmat4& m) {
  json values = json::array();
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row) values.push_back(m[column][row]);
  return values;
}

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char DIGITS[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    const size_t left = std::min<size_t>(3, bytes.size() - i);
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (k < left ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) text += k <= left ? DIGITS[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// Frame whose -z axis is `direction`, at `position`: how glTF aims lights and cameras.
glm::dmat4 aimed(const glm::dvec3& position, const glm::dvec3& direction, const glm::dvec3& up) {
  const glm::dvec3 z = -glm::normalize(direction), x = glm::normalize(glm::cross(up, z));
  return {{x, 0}, {glm::cross(z, x), 0}, {z, 0}, {position, 1}};
}

glm::dvec3 not_parallel_to(const glm::dvec3& v) {
  return std::abs(v.y) < 0.9 * glm::length(v) ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
}

json surface(const glm::dvec3& base, double metallic, double roughness, double specular) {
  return {{"pbrMetallicRoughness",
           {{"baseColorFactor", {base.x, base.y, base.z, 1}},
            {"metallicFactor", metallic},
            {"roughnessFactor", roughness}}},
          {"extensions", {{"KHR_materials_specular", {{"specularFactor", specular}}}}}};
}

}  // namespace

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "regulus-test-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder could be made");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

Polygon quad(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v) {
  return {corner, corner + u, corner + u + v, corner + v};
}

Polygon disk(const glm::dvec3& center, const glm::dvec3& normal, double radius, int corners) {
  const glm::dmat4 frame = aimed(center, -normal, not_parallel_to(normal));
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    polygon.emplace_back(frame * glm::dvec4(radius * std::cos(angle), radius * std::sin(angle), 0, 1));
  }
  return polygon;
}

Polygons box(const glm::dvec3& low, const glm::dvec3& high) {
  const glm::dvec3 size = high - low, x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z);
  return {quad(low, y, x),     quad(low + z, x, y), quad(low, x, z),
          quad(low + y, z, x), quad(low, z, y),     quad(low + x, y, z)};
}

Polygons sphere(const glm::dvec3& center, double radius, int rings) {
  const auto point = [&](int ring, int column) {
    const double theta = std::numbers::pi * ring / rings,
                 phi = std::numbers::pi * (column % (2 * rings)) / rings;
    // Exactly one point at each pole and one per meridian, so that neighbouring polygons share corners.
    const double s = ring == 0 || ring == rings ? 0 : std::sin(theta);
    return center + radius * glm::dvec3(s * std::cos(phi), std::cos(theta), s * std::sin(phi));
  };
  Polygons polygons;
  for (int ring = 0; ring < rings; ++ring)
    for (int column = 0; column < 2 * rings; ++column) {
      Polygon cell = {point(ring, column), point(ring, column + 1), point(ring + 1, column + 1),
                      point(ring + 1, column)};
      if (ring == 0) cell.erase(cell.begin() + 1);
      if (ring == rings - 1) cell.pop_back();
      polygons.push_back(std::move(cell));
    }
  return polygons;
}

Polygons turned(Polygons polygons) {
  for (Polygon& polygon : polygons) std::reverse(polygon.begin(), polygon.end());
  return polygons;
}

Polygons transformed(const glm::dmat4& matrix, Polygons polygons) {
  for (Polygon& polygon : polygons)
    for (glm::dvec3& corner : polygon) corner = glm::dvec3(matrix * glm::dvec4(corner, 1));
  return polygons;
}

glm::dmat4 look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up) {
  return aimed(eye, target - eye, up);
}

json lambert(const glm::dvec3& albedo) {
  return surface(albedo, 0, 1, 0);
}

json emitter(const glm::dvec3& radiance, bool is_double_sided) {
  json material = lambert({0, 0, 0});
  const double strength = std::max({radiance.x, radiance.y, radiance.z, 1e-30});
  material["emissiveFactor"] = to_json(radiance / strength);
  material["extensions"]["KHR_materials_emissive_strength"] = {{"emissiveStrength", strength}};
  material["doubleSided"] = is_double_sided;
  return material;
}

json metal(const glm::dvec3& base, double roughness) {
  return surface(base, 1, roughness, 1);
}

json plastic(const glm::dvec3& base, double roughness) {
  return surface(base, 0, roughness, 1);
}

json glass(double ior, double roughness, const glm::dvec3& attenuation) {
  json material = surface({1, 1, 1}, 0, roughness, 1);
  material["extensions"]["KHR_materials_ior"] = {{"ior", ior}};
  material["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 1}};
  material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
  if (attenuation != glm::dvec3(1, 1, 1)) {
    material["extensions"]["KHR_materials_volume"]["attenuationDistance"] = 1;
    material["extensions"]["KHR_materials_volume"]["attenuationColor"] = to_json(attenuation);
  }
  return material;
}

GltfScene::GltfScene() {
  gltf_["asset"] = {{"version", "2.0"}, {"generator", "Regulus image tests"}};
  gltf_["scene"] = 0;
  gltf_["scenes"] = json::array({{{"nodes", json::array()}}});
  gltf_["extensionsUsed"] = {
      "KHR_lights_punctual",    "KHR_materials_emissive_strength", "KHR_materials_ior",
      "KHR_materials_specular", "KHR_materials_transmission",      "KHR_materials_volume",
      "KHR_materials_unlit",    "KHR_materials_clearcoat",         "KHR_materials_anisotropy",
      "KHR_materials_sheen",    "KHR_materials_iridescence",       "KHR_materials_dispersion"};
  gltf_["nodes"] = json::array();
}

size_t GltfScene::add_buffer_view(const void* data, size_t bytes) {
  const auto* begin = static_cast<const unsigned char*>(data);
  gltf_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", buffer_.size()}, {"byteLength", bytes}});
  buffer_.insert(buffer_.end(), begin, begin + bytes);
  return gltf_["bufferViews"].size() - 1;
}

size_t GltfScene::add_accessor(const void* data, size_t elements, const char* type) {
  const size_t bytes = elements * static_cast<size_t>(type[3] - '0') * sizeof(float);
  gltf_["accessors"].push_back({{"bufferView", add_buffer_view(data, bytes)},
                                {"componentType", 5126},
                                {"count", elements},
                                {"type", type}});
  return gltf_["accessors"].size() - 1;
}

size_t GltfScene::add_texture(int width, const std::vector<uint8_t>& rgba, bool is_nearest) {
  std::vector<unsigned char> png;
  const auto append = [](void* context, void* data, int size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    auto* out = static_cast<std::vector<unsigned char>*>(context);
    out->insert(out->end(), bytes, bytes + size);
  };
  const int height = static_cast<int>(rgba.size()) / (4 * width);
  if (stbi_write_png_to_func(append, &png, width, height, 4, rgba.data(), 4 * width) == 0)
    throw std::runtime_error("a texture could not be encoded");
  gltf_["images"].push_back({{"uri", "data:image/png;base64," + base64(png)}});
  gltf_["samplers"].push_back({{"magFilter", is_nearest ? 9728 : 9729}});
  gltf_["textures"].push_back(
      {{"source", gltf_["images"].size() - 1}, {"sampler", gltf_["samplers"].size() - 1}});
  return gltf_["textures"].size() - 1;
}

void GltfScene::add(const Polygons& polygons, const json& material, const glm::dmat4& matrix,
                    const Corners& corners) {
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const Polygon& polygon : polygons) {
    const auto first = static_cast<uint32_t>(positions.size());
    for (const glm::dvec3& corner : polygon) {
      positions.emplace_back(corner);
      low = glm::min(low, positions.back());
      high = glm::max(high, positions.back());
    }
    for (uint32_t i = 2; i < polygon.size(); ++i)
      indices.insert(indices.end(), {first, first + i - 1, first + i});
  }
  const size_t position_view = add_buffer_view(positions.data(), positions.size() * sizeof(glm::vec3));
  const size_t index_view = add_buffer_view(indices.data(), indices.size() * sizeof(uint32_t));
  json& accessors = gltf_["accessors"];
  accessors.push_back({{"bufferView", position_view},
                       {"componentType", 5126},
                       {"count", positions.size()},
                       {"type", "VEC3"},
                       {"min", to_json(low)},
                       {"max", to_json(high)}});
  accessors.push_back(
      {{"bufferView", index_view}, {"componentType", 5125}, {"count", indices.size()}, {"type", "SCALAR"}});
  const size_t indices_accessor = accessors.size() - 1;
  json attributes = {{"POSITION", accessors.size() - 2}};
  const auto add_attribute = [&](const char* name, const auto& values, const char* type) {
    if (!values.empty()) attributes[name] = add_accessor(values.data(), values.size(), type);
  };
  add_attribute("NORMAL", corners.normals, "VEC3");
  add_attribute("TANGENT", corners.tangents, "VEC4");
  add_attribute("TEXCOORD_0", corners.uvs, "VEC2");
  add_attribute("COLOR_0", corners.colors, "VEC4");
  gltf_["materials"].push_back(material);
  gltf_["meshes"].push_back({{"primitives",
                              {{{"attributes", attributes},
                                {"indices", indices_accessor},
                                {"material", gltf_["materials"].size() - 1}}}}});
  gltf_["nodes"].push_back({{"mesh", gltf_["meshes"].size() - 1}, {"matrix", to_json(matrix)}});
}

void GltfScene::add_copy(const glm::dmat4& matrix) {
  gltf_["nodes"].push_back({{"mesh", gltf_["meshes"].size() - 1}, {"matrix", to_json(matrix)}});
}

void GltfScene::add_light(const json& light, const glm::dmat4& matrix) {
  json& lights = gltf_["extensions"]["KHR_lights_punctual"]["lights"];
  lights.push_back(light);
  gltf_["nodes"].push_back({{"matrix", to_json(matrix)},
                            {"extensions", {{"KHR_lights_punctual", {{"light", lights.size() - 1}}}}}});
}

void GltfScene::add_point_light(const glm::dvec3& position, const glm::dvec3& intensity) {
  const double strength = std::max({intensity.x, intensity.y, intensity.z});
  glm::dmat4 matrix(1);
  matrix[3] = {position, 1};
  add_light({{"type", "point"}, {"color", to_json(intensity / strength)}, {"intensity", strength}}, matrix);
}

void GltfScene::add_spot_light(const glm::dvec3& position, const glm::dvec3& direction, double intensity,
                               double inner, double outer) {
  add_light({{"type", "spot"},
             {"intensity", intensity},
             {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}},
            aimed(position, direction, not_parallel_to(direction)));
}

void GltfScene::add_directional_light(const glm::dvec3& direction, double illuminance) {
  add_light({{"type", "directional"}, {"intensity", illuminance}},
            aimed({0, 0, 0}, direction, not_parallel_to(direction)));
}

void GltfScene::set_perspective(const glm::dmat4& camera_to_world, double y_fov) {
  gltf_["cameras"] =
      json::array({{{"type", "perspective"}, {"perspective", {{"yfov", y_fov}, {"znear", 1e-7}}}}});
  gltf_["nodes"].push_back({{"camera", 0}, {"matrix", to_json(camera_to_world)}});
}

void GltfScene::set_orthographic(const glm::dmat4& camera_to_world, double half_width, double half_height) {
  gltf_["cameras"] = json::array(
      {{{"type", "orthographic"},
        {"orthographic", {{"xmag", half_width}, {"ymag", half_height}, {"znear", 1e-7}, {"zfar", 1e6}}}}});
  gltf_["nodes"].push_back({{"camera", 0}, {"matrix", to_json(camera_to_world)}});
}

void GltfScene::set_near_plane(double depth) {
  json& camera = gltf_["cameras"][0];
  camera[camera["type"].get<std::string>()]["znear"] = depth;
}

void GltfScene::set_setting(const std::string& name, const json& value) {
  gltf_["scenes"][0]["extras"]["regulus"][name] = value;
}

void GltfScene::write(const fs::path& path) const {
  json gltf = gltf_;
  if (!buffer_.empty())
    gltf["buffers"] = json::array({{{"byteLength", buffer_.size()},
                                    {"uri", "data:application/octet-stream;base64," + base64(buffer_)}}});
  json children = json::array();
  for (size_t i = 0; i < gltf["nodes"].size(); ++i) children.push_back(i);
  gltf["nodes"].push_back({{"matrix", to_json(root_)}, {"children", children}});
  gltf["scenes"][0]["nodes"] = json::array({gltf["nodes"].size() - 1});
  std::ofstream file(path);
  file << gltf.dump();
  if (!file.flush()) throw std::runtime_error(path.string() + " could not be written");
}

}  // namespace regulus::test

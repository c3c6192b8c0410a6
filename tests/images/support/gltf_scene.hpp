// Writes the small glTF scenes that image tests need. Geometry goes into a data URI, so a scene is one file.
#pragma once

#include <filesystem>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace regulus::test {

/// A folder of its own in the system's temporary folder, removed with the object.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// What the corners of polygons carry beside their positions, in their order; empty: not given.
struct Corners {
  std::vector<glm::vec3> normals;
  std::vector<glm::vec4> tangents;
  std::vector<glm::vec2> uvs;
  std::vector<glm::vec4> colors;
};

using Polygon = std::vector<glm::dvec3>;

/// A mesh as a list of convex polygons, each counter-clockwise seen from its front.
using Polygons = std::vector<Polygon>;

/// The parallelogram corner, corner + u, corner + u + v, corner + v; its front is the side of cross(u, v).
Polygon quad(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v);
/// A regular polygon of `corners` corners on the circle around `center`; front towards `normal`.
Polygon disk(const glm::dvec3& center, const glm::dvec3& normal, double radius, int corners);
/// The six sides of an axis-aligned box, fronts outwards.
Polygons box(const glm::dvec3& low, const glm::dvec3& high);
/// A sphere of latitude and longitude cells, fronts outwards, corners on the sphere.
Polygons sphere(const glm::dvec3& center, double radius, int rings);
/// The same polygons seen from the other side.
Polygons turned(Polygons polygons);
/// Every corner mapped by the matrix.
Polygons transformed(const glm::dmat4& matrix, Polygons polygons);

/// Camera to world for a camera at `eye` (looks down -z, y up).
glm::dmat4 look_at(const glm::dvec3& eye, const glm::dvec3& target, const glm::dvec3& up = {0, 1, 0});

/// Materials. All but `metal` are free of the specular layer unless they say so.
nlohmann::json lambert(const glm::dvec3& albedo);
nlohmann::json emitter(const glm::dvec3& radiance, bool is_double_sided = false);
nlohmann::json metal(const glm::dvec3& base, double roughness);
nlohmann::json plastic(const glm::dvec3& base, double roughness);
/// Glass with a volume; `attenuation` is what is left of white after one metre.
nlohmann::json glass(double ior, double roughness = 0, const glm::dvec3& attenuation = {1, 1, 1});

/// A glTF scene under construction.
class GltfScene {
 public:
  GltfScene();

  /// Adds the polygons (as flat-shaded triangle fans) under a node with the given matrix.
  void add(const Polygons& polygons, const nlohmann::json& material, const glm::dmat4& matrix = glm::dmat4(1),
           const Corners& corners = {});

  /// Places the mesh that was added last once more.
  void add_copy(const glm::dmat4& matrix);

  /// Adds a texture of 8-bit RGBA rows, top row first, and returns its index.
  size_t add_texture(int width, const std::vector<uint8_t>& rgba, bool is_nearest = false);

  void add_point_light(const glm::dvec3& position, const glm::dvec3& intensity);
  /// Angles in radians, from the axis.
  void add_spot_light(const glm::dvec3& position, const glm::dvec3& direction, double intensity, double inner,
                      double outer);
  void add_directional_light(const glm::dvec3& direction, double illuminance);

  void set_perspective(const glm::dmat4& camera_to_world, double y_fov);
  void set_orthographic(const glm::dmat4& camera_to_world, double half_width, double half_height);
  /// Of the camera that was set. m
  void set_near_plane(double depth);

  /// Puts a node with this matrix above everything.
  void set_root(const glm::dmat4& matrix) { root_ = matrix; }

  /// Entries of scenes[].extras.regulus.
  void set_setting(const std::string& name, const nlohmann::json& value);

  /// Preparing the scene fails the test unless the loader gives a warning with this text, and no other.
  void expect_warning(const std::string& text) { expected_warning_ = text; }
  const std::string& expected_warning() const { return expected_warning_; }

  void write(const std::filesystem::path& path) const;

 private:
  size_t add_accessor(const void* data, size_t elements, const char* type);
  size_t add_buffer_view(const void* data, size_t bytes);
  void add_light(const nlohmann::json& light, const glm::dmat4& matrix);

  nlohmann::json gltf_;
  std::vector<unsigned char> buffer_;
  glm::dmat4 root_{1};
  std::string expected_warning_;
};

}  // namespace regulus::test

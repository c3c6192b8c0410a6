#include "scene/emitter_overlap.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "scene/coplanar.hpp"
#include "scene/placement.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {
namespace {

using glm::dvec2;
using glm::dvec3;
using interface::Material;
using interface::Triangle;

// Pieces that one triangle may fall into; what would need more stays whole.
constexpr size_t MAX_PIECES = 4096;

/// Convex, in a triangle's barycentric coordinates (of its second and third corner).
using Piece = std::vector<dvec2>;

double cross2(const dvec2& a, const dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

/// The part of a piece on one side of the line through p along `edge`: left of it, or right.
Piece half_of(const Piece& piece, const dvec2& p, const dvec2& edge, bool is_left) {
  Piece half;
  const double sign = is_left ? 1 : -1;
  const auto side = [&](const dvec2& point) { return sign * cross2(edge, point - p); };
  for (size_t i = 0; i < piece.size(); ++i) {
    const dvec2 &a = piece[i], &b = piece[(i + 1) % piece.size()];
    const double from = side(a), to = side(b);
    if (from >= 0) half.push_back(a);
    if ((from > 0 && to < 0) || (from < 0 && to > 0)) half.push_back(a + (b - a) * (from / (from - to)));
  }
  return half;
}

double area_of(const Piece& piece) {
  double doubled = 0;
  for (size_t i = 2; i < piece.size(); ++i) doubled += cross2(piece[i - 1] - piece[0], piece[i] - piece[0]);
  return 0.5 * std::abs(doubled);
}

class EmitterCutter {
 public:
  explicit EmitterCutter(Scene& scene) : scene_(scene), distance_(distance_of_coincidence(scene)) {}

  size_t cut() {
    for (size_t i = first_placed_triangle(scene_); i < scene_.triangles.size(); ++i) {
      const auto index = static_cast<uint32_t>(i);
      if (!is_lamp(material_of(index))) continue;
      if (const std::optional<Face> face = face_of(scene_, index)) faces_.push_back(*face);
    }
    visit_coplanar_pairs(faces_, distance_, [&](const Face& a, const Face& b) {
      const Face &first = precedence(a) < precedence(b) ? a : b, &second = &first == &a ? b : a;
      if (hides(first, second) && overlap_in_plane(first, second, distance_))
        hidden_by_[second.triangle].push_back(first);
      return false;
    });
    for (const Face& face : faces_)
      if (const auto found = hidden_by_.find(face.triangle); found != hidden_by_.end())
        cut(face, found->second);
    if (!is_gone_.empty()) remove_gone();
    return hidden_by_.size();
  }

 private:
  const Material& material_of(uint32_t triangle) const {
    return scene_.materials[scene_.triangles[triangle].material];
  }

  static bool is_lamp(const Material& material) {
    return (material.flags & interface::MATERIAL_EMISSIVE) != 0 &&
           material.material_class != interface::MATERIAL_CLASS_TRANSMISSIVE;
  }

  static bool has(const Material& material, uint32_t flags) { return (material.flags & flags) != 0; }

  std::tuple<bool, bool, uint32_t> precedence(const Face& face) const {
    const Material& material = material_of(face.triangle);
    return {has(material, interface::MATERIAL_ALPHA_MASK | interface::MATERIAL_ALPHA_BLEND),
            !has(material, interface::MATERIAL_DOUBLE_SIDED), face.triangle};
  }

  /// Whether the first, where it is, leaves nothing of the second's light.
  bool hides(const Face& first, const Face& second) const {
    const Material &a = material_of(first.triangle), &b = material_of(second.triangle);
    if (has(a, interface::MATERIAL_ALPHA_MASK | interface::MATERIAL_ALPHA_BLEND)) return false;
    if (has(a, interface::MATERIAL_DOUBLE_SIDED)) return true;
    return !has(b, interface::MATERIAL_DOUBLE_SIDED) && dot(first.normal, second.normal) > 0;
  }

  void cut(const Face& face, const std::vector<Face>& others) {
    std::vector<Piece> pieces{{dvec2(0, 0), dvec2(1, 0), dvec2(0, 1)}};
    for (const Face& other : others) {
      std::vector<Piece> left;
      for (const Piece& piece : pieces) take_away(face, other, piece, left);
      pieces = std::move(left);
      if (pieces.size() > MAX_PIECES) return;
    }
    const Triangle whole = scene_.triangles[face.triangle];
    bool is_first = true;
    std::map<std::pair<double, double>, uint32_t> vertices{
        {{0, 0}, whole.v0}, {{1, 0}, whole.v1}, {{0, 1}, whole.v2}};
    for (const Piece& piece : pieces)
      for (size_t i = 2; i < piece.size(); ++i) {
        Triangle part = whole;
        part.v0 = vertex_at(whole, piece[0], vertices);
        part.v1 = vertex_at(whole, piece[i - 1], vertices);
        part.v2 = vertex_at(whole, piece[i], vertices);
        if (is_sliver(part)) continue;
        if (is_first)
          scene_.triangles[face.triangle] = part;
        else
          scene_.triangles.push_back(part);
        is_first = false;
      }
    if (is_first) is_gone_.push_back(face.triangle);
  }

  /// Appends what of a piece of `face` lies outside of the other triangle.
  void take_away(const Face& face, const Face& other, Piece piece, std::vector<Piece>& left) const {
    const std::array<dvec2, 3> corners = flat(face, other);
    const bool is_left = cross2(corners[1] - corners[0], corners[2] - corners[0]) > 0;
    const double least = 1e-9 * area_of(piece);
    const size_t before = left.size();
    const Piece whole = piece;
    for (size_t i = 0; i < 3 && piece.size() > 2; ++i) {
      const dvec2 edge = corners[(i + 1) % 3] - corners[i];
      Piece outside = half_of(piece, corners[i], edge, !is_left);
      if (outside.size() > 2 && area_of(outside) > least) left.push_back(std::move(outside));
      piece = half_of(piece, corners[i], edge, is_left);
    }
    if (piece.size() > 2 && area_of(piece) > least) return;
    // They do not overlap: uncut.
    left.resize(before);
    left.push_back(whole);
  }

  /// The corners of another triangle in the barycentric coordinates of a face.
  static std::array<dvec2, 3> flat(const Face& face, const Face& other) {
    const dvec3 u = face.corners[1] - face.corners[0], v = face.corners[2] - face.corners[0];
    const dvec3 across_u = cross(v, face.normal), across_v = cross(face.normal, u);
    std::array<dvec2, 3> result;
    for (size_t i = 0; i < 3; ++i) {
      const dvec3 to = other.corners[i] - face.corners[0];
      result[i] = {dot(to, across_u) / dot(u, across_u), dot(to, across_v) / dot(v, across_v)};
    }
    return result;
  }

  /// Number of the vertex at a point of a triangle; it is made if there is none.
  uint32_t vertex_at(const Triangle& whole, const dvec2& b,
                     std::map<std::pair<double, double>, uint32_t>& known) {
    const auto [found, is_new] = known.try_emplace({b.x, b.y}, static_cast<uint32_t>(scene_.vertices.size()));
    if (!is_new) return found->second;
    const auto mean = [&](const auto& of, uint32_t stride, uint32_t offset) {
      const auto at = [&](uint32_t vertex) { return of[size_t{vertex} * stride + offset]; };
      return at(whole.v0) * static_cast<float>(1 - b.x - b.y) + at(whole.v1) * static_cast<float>(b.x) +
             at(whole.v2) * static_cast<float>(b.y);
    };
    const auto& v0 = scene_.vertices[whole.v0];
    const auto &v1 = scene_.vertices[whole.v1], &v2 = scene_.vertices[whole.v2];
    interface::Vertex vertex {};
    vertex.position =
        glm::vec3((1 - b.x - b.y) * dvec3(v0.position) + b.x * dvec3(v1.position) + b.y * dvec3(v2.position));
    const dvec3 normal = (1 - b.x - b.y) * dvec3(v0.normal) + b.x * dvec3(v1.normal) + b.y * dvec3(v2.normal);
    vertex.normal = length(normal) > 1e-3 ? glm::vec3(normalize(normal)) : v0.normal;
    vertex.uv =
        glm::vec2((1 - b.x - b.y) * glm::dvec2(v0.uv) + b.x * glm::dvec2(v1.uv) + b.y * glm::dvec2(v2.uv));
    scene_.vertices.push_back(vertex);
    if (!scene_.vertex_colors.empty()) scene_.vertex_colors.push_back(mean(scene_.vertex_colors, 1, 0));
    for (uint32_t set = 0; set < scene_.vertex_uv_sets; ++set)
      scene_.vertex_uvs.push_back(mean(scene_.vertex_uvs, scene_.vertex_uv_sets, set));
    if (!scene_.vertex_tangents.empty()) {
      const glm::vec4 tangent = mean(scene_.vertex_tangents, 1, 0), first = scene_.vertex_tangents[whole.v0];
      const bool is_long = length(glm::vec3(tangent)) > 1e-3F;
      scene_.vertex_tangents.push_back(is_long ? glm::vec4(normalize(glm::vec3(tangent)), first.w) : first);
    }
    return found->second;
  }

  /// Too thin for single precision to tell its corners apart.
  bool is_sliver(const Triangle& part) const {
    const dvec3 a(scene_.vertices[part.v0].position), b(scene_.vertices[part.v1].position),
        c(scene_.vertices[part.v2].position);
    const double longest = std::max({distance(a, b), distance(b, c), distance(c, a)});
    return !(length(cross(b - a, c - a)) > distance_ * longest);
  }

  void remove_gone() {
    std::sort(is_gone_.begin(), is_gone_.end());
    std::vector<Triangle> kept;
    for (uint32_t i = 0; i < scene_.triangles.size(); ++i)
      if (!std::binary_search(is_gone_.begin(), is_gone_.end(), i)) kept.push_back(scene_.triangles[i]);
    scene_.triangles = std::move(kept);
  }

  Scene& scene_;
  double distance_;
  std::vector<Face> faces_;
  std::map<uint32_t, std::vector<Face>> hidden_by_;  // by triangle
  std::vector<uint32_t> is_gone_;
};

}  // namespace

size_t cut_overlapping_emitters(Scene& scene) {
  return EmitterCutter(scene).cut();
}

}  // namespace regulus::scene

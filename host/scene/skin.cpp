#include "scene/skin.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "scene/accessor.hpp"

namespace regulus::scene {
namespace {

// Sums of weights are divided by whatever they are, as exporters round them; further from 1 than rounding to
// bytes puts them they are worth a warning.
constexpr double NOTABLE_SUM_ERROR = 0.02;

bool is_finite(const glm::dmat4& matrix) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!std::isfinite(matrix[column][row])) return false;
  return true;
}

/// Affine by specification: a last row that is not 0 0 0 1 but for rounding is warned of, and never used.
glm::dmat4 affine(Document& document, glm::dmat4 matrix, const std::string& element) {
  const glm::dvec4 row(matrix[0][3], matrix[1][3], matrix[2][3], matrix[3][3]);
  if (glm::length(row - glm::dvec4(0, 0, 0, 1)) > 1e-5)
    document.warn(element + ": the last row of an inverse bind matrix is not 0 0 0 1; it is taken to be");
  for (int column = 0; column < 4; ++column) matrix[column][3] = column == 3 ? 1 : 0;
  return matrix;
}

/// Four joints per vertex and their weights.
struct JointSet {
  AccessorReader joints, weights;
};

std::vector<JointSet> open_sets(const Document& document, const tinygltf::Primitive& primitive,
                                uint64_t vertices, const std::string& element) {
  const auto open = [&](const std::string& name) {
    AccessorReader reader(document, primitive.attributes.at(name), TINYGLTF_TYPE_VEC4, element + " " + name);
    if (reader.count() != vertices)
      document.fail(fmt::format("{} has {} elements, POSITION has {}; export the file again",
                                reader.element(), reader.count(), vertices));
    return reader;
  };
  std::vector<JointSet> sets;
  while (true) {
    const std::string joints = fmt::format("JOINTS_{}", sets.size()),
                      weights = fmt::format("WEIGHTS_{}", sets.size());
    if (primitive.attributes.count(joints) == 0 || primitive.attributes.count(weights) == 0) return sets;
    sets.push_back({open(joints), open(weights)});
    sets.back().joints.require_indices(document);
  }
}

glm::dmat4 vertex_transform(const std::vector<JointSet>& sets, const JointMatrices& matrices, uint64_t vertex,
                            SkinTally& tally) {
  glm::dmat4 sum(0.0);
  double total = 0;
  for (const JointSet& set : sets)
    for (uint64_t i = 0; i < 4; ++i) {
      const double weight = set.weights.component_at(vertex, i);
      const uint32_t joint = set.joints.index_at(vertex, i);
      if (!(weight > 0) || !std::isfinite(weight)) continue;
      if (joint >= matrices.size()) {
        ++tally.foreign_joints;
        continue;
      }
      sum += weight * matrices[joint];
      total += weight;
    }
  if (total == 0) {
    ++tally.unbound;
    return matrices[std::min<size_t>(sets.front().joints.index_at(vertex), matrices.size() - 1)];
  }
  if (std::abs(total - 1) > NOTABLE_SUM_ERROR) ++tally.unnormalized;
  return sum / total;
}

}  // namespace

JointMatrices joint_matrices(Document& document, size_t skin, const std::vector<glm::dmat4>& transforms) {
  const nlohmann::json& source = document.skins[skin];
  const std::string element = element_name("skin", skin, source.value("name", ""));
  const auto joints = source.value("joints", std::vector<size_t>());
  if (joints.empty()) document.fail(element + " has no joints; export the file again");
  std::optional<AccessorReader> bind;
  if (source.contains("inverseBindMatrices")) {
    bind.emplace(document, source["inverseBindMatrices"].get<int>(), TINYGLTF_TYPE_MAT4,
                 element + " inverseBindMatrices");
    if (bind->count() < joints.size())
      document.fail(fmt::format("{}: {} inverse bind matrices for {} joints; export the file again", element,
                                bind->count(), joints.size()));
  }
  JointMatrices matrices;
  for (size_t i = 0; i < joints.size(); ++i) {
    const size_t node = joints[i];
    glm::dmat4 matrix = transforms[node];
    if (bind) matrix *= affine(document, glm::dmat4(bind->mat4_at(i)), element);
    if (!is_finite(matrix))
      document.fail(fmt::format("{}: the matrix of its joint {} is not finite; correct it", element,
                                element_name("node", node, document.model.nodes[node].name)));
    matrices.push_back(matrix);
  }
  return matrices;
}

void warn_of(const SkinTally& tally, Document& document) {
  if (tally.foreign_joints != 0)
    document.warn(
        fmt::format("{} weights are of joints that their skin does not have and are left out; export again",
                    tally.foreign_joints));
  if (tally.unbound != 0)
    document.warn(
        fmt::format("{} skinned vertices have no weight; the first joint of each moves it", tally.unbound));
  if (tally.unnormalized != 0)
    document.warn(
        fmt::format("the weights of {} skinned vertices do not sum to 1; they are divided by their sum",
                    tally.unnormalized));
}

bool has_joints(const tinygltf::Primitive& primitive) {
  return primitive.attributes.count("JOINTS_0") != 0 && primitive.attributes.count("WEIGHTS_0") != 0;
}

std::vector<glm::dmat4> skin_vertices(const Document& document, const tinygltf::Primitive& primitive,
                                      const JointMatrices& joints, uint64_t vertices,
                                      const std::string& element, SkinTally& tally) {
  const std::vector<JointSet> sets = open_sets(document, primitive, vertices, element);
  std::vector<glm::dmat4> transforms;
  transforms.reserve(vertices);
  for (uint64_t vertex = 0; vertex < vertices; ++vertex)
    transforms.push_back(vertex_transform(sets, joints, vertex, tally));
  return transforms;
}

}  // namespace regulus::scene

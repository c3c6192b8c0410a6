#include "reference/walk_guide.hpp"

#include <numbers>

#include "reference/guide_tree.hpp"
#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec3;
using namespace interface;

GuideCell guide_cell(const scene::WalkGuide& guide, const dvec3& position, const dvec3& normal) {
  const dvec3 place = (position - dvec3(guide.corner)) * dvec3(guide.scale);
  dvec3 lower(0);
  dvec3 upper(1);
  const GuideNode* node = guide.nodes.data();
  while ((node->next & WALK_GUIDE_AXIS_MASK) != WALK_GUIDE_CELL) {
    const auto axis = static_cast<int>(node->next & WALK_GUIDE_AXIS_MASK);
    bool is_lower = false;
    if (axis < static_cast<int>(WALK_GUIDE_NORMALS)) {
      const double middle = (lower[axis] + upper[axis]) / 2;
      is_lower = place[axis] < middle;
      (is_lower ? upper : lower)[axis] = middle;
    } else if (axis < static_cast<int>(WALK_GUIDE_REVERSES)) {
      is_lower = normal[axis - static_cast<int>(WALK_GUIDE_NORMALS)] < WALK_GUIDE_SIDE / 100.0;
    } else {
      is_lower = normal[axis - static_cast<int>(WALK_GUIDE_REVERSES)] < WALK_GUIDE_SIDE / -100.0;
    }
    node = &guide.nodes[(node->next >> WALK_GUIDE_AXIS_BITS) + (is_lower ? 0 : 1)];
  }
  return {node->first_share, node->next >> WALK_GUIDE_AXIS_BITS};
}

dvec3 guided_direction(const scene::WalkGuide& guide, const GuideCell& cell, const glm::dvec2& u) {
  return sample_sphere(glm::dvec2(tree_start(guide.nodes, cell.root, {u, 0, 0})));
}

double guided_pdf(const scene::WalkGuide& guide, const GuideCell& cell, const dvec3& w) {
  return tree_density(guide.nodes, cell.root, {sphere_numbers(w), 0, 0}) / (4 * std::numbers::pi);
}

}  // namespace regulus::reference

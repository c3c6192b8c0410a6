#include "reference/guide_tree.hpp"

#include "reference/sampling.hpp"

namespace regulus::reference {

using glm::dvec4;
using namespace interface;

double tree_density(const std::vector<GuideNode>& nodes, uint32_t root, const dvec4& numbers) {
  dvec4 lower(0);
  dvec4 upper(1);
  double share = 1;
  uint32_t index = root;
  for (const GuideNode* node = &nodes[index]; node->next != GUIDE_LEAF; node = &nodes[index]) {
    const auto axis = static_cast<int>(node->next & GUIDE_AXIS_MASK);
    const double middle = (lower[axis] + upper[axis]) / 2;
    const bool is_lower = numbers[axis] < middle;
    (is_lower ? upper : lower)[axis] = middle;
    share *= is_lower ? double{node->first_share} : 1 - double{node->first_share};
    index = (node->next >> GUIDE_AXIS_BITS) + (is_lower ? 0 : 1);
  }
  const dvec4 size = upper - lower;
  return share / (size.x * size.y * size.z * size.w);
}

dvec4 tree_start(const std::vector<GuideNode>& nodes, uint32_t root, const dvec4& u) {
  dvec4 lower(0);
  dvec4 upper(1);
  glm::vec4 first(0);  // the numbers that lead into the box
  glm::vec4 last(1);
  const glm::vec4 number(u);
  uint32_t index = root;
  for (const GuideNode* node = &nodes[index]; node->next != GUIDE_LEAF; node = &nodes[index]) {
    const auto axis = static_cast<int>(node->next & GUIDE_AXIS_MASK);
    const float middle = first[axis] + node->first_share * (last[axis] - first[axis]);
    const bool is_lower = number[axis] < middle;
    (is_lower ? last : first)[axis] = middle;
    (is_lower ? upper : lower)[axis] = (lower[axis] + upper[axis]) / 2;
    index = (node->next >> GUIDE_AXIS_BITS) + (is_lower ? 0 : 1);
  }
  const dvec4 place = (u - dvec4(first)) / (dvec4(last) - dvec4(first));
  return lower + (upper - lower) * clamp(place, 0.0, BELOW_ONE);
}

}  // namespace regulus::reference

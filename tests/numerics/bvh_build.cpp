// The acceleration structure is a valid, conservative and repeatable tree over all triangles.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <functional>

#include "bvh/binary_tree.hpp"
#include "bvh/bvh.hpp"
#include "support/random.hpp"

namespace regulus::test {

namespace {

using bvh::Box;
using bvh::Bvh;
using bvh::InputTriangle;

std::vector<InputTriangle> make_soup(uint64_t stream, uint32_t count, double scale, glm::dvec3 shift) {
  Random random(stream);
  std::vector<InputTriangle> triangles;
  for (uint32_t i = 0; i < count; ++i) {
    const glm::dvec3 center = 2.0 * random.cube() - 1.0;
    const double size = random.log_uniform(1e-4, 0.3);
    const auto vertex = [&] { return glm::vec3(scale * (center + size * random.direction()) + shift); };
    const glm::vec3 v0 = vertex();
    const glm::vec3 v1 = vertex();
    triangles.push_back({{v0, v1, vertex()}, i});
  }
  return triangles;
}

/// Clusters nested at all scales that floats know: the deepest tree a scene can ask for.
std::vector<InputTriangle> make_nest(uint32_t count) {
  Random random(1);
  std::vector<InputTriangle> triangles;
  for (uint32_t i = 0; i < count; ++i) {
    const double size = random.log_uniform(1e-30, 1e6);
    const auto vertex = [&] { return glm::vec3(size * (random.cube() + 0.5)); };
    const glm::vec3 v0 = vertex();
    const glm::vec3 v1 = vertex();
    triangles.push_back({{v0, v1, vertex()}, i});
  }
  return triangles;
}

uint32_t plane(const interface::BvhNode& node, int axis, bool is_upper, uint32_t slot) {
  return node.planes[4 * axis + (is_upper ? 2 : 0) + slot / 4] >> (8 * (slot % 4)) & 0xFFu;
}

/// What the walk over a tree finds.
struct Walk {
  const Bvh& bvh;
  std::vector<uint32_t> triangle_visits = std::vector<uint32_t>(bvh.triangles.size());
  std::vector<uint32_t> node_visits = std::vector<uint32_t>(bvh.nodes.size());
  uint32_t depth = 0;
  double smallest_margin = INFINITY;  ///< of decoded boxes around the triangles below, in quanta

  /// Checks the boxes of the node's children; returns the bounds of all triangles below it.
  Box visit(uint32_t index, uint32_t level) {
    const interface::BvhNode& node = bvh.nodes.at(index);
    ++node_visits[index];
    depth = std::max(depth, level);
    Box bounds;
    for (uint32_t slot = 0; slot < 8; ++slot) {
      if (plane(node, 0, false, slot) > plane(node, 0, true, slot)) continue;
      const uint32_t child = node.children[slot];
      const Box box = child & interface::BVH_LEAF_BIT ? leaf(child) : visit(child, level + 1);
      check(node, slot, box);
      bounds.extend(box);
    }
    return bounds;
  }

  Box leaf(uint32_t reference) {
    Box bounds;
    const uint32_t first = reference & interface::BVH_LEAF_FIRST_MASK;
    const uint32_t count = ((reference & ~interface::BVH_LEAF_BIT) >> interface::BVH_LEAF_COUNT_SHIFT) + 1;
    EXPECT_LE(count, interface::BVH_MAX_LEAF_SIZE);
    for (uint32_t i = first; i < first + count; ++i) {
      ++triangle_visits.at(i);
      const interface::BvhTriangle& triangle = bvh.triangles[i];
      for (const glm::vec3& vertex : {triangle.v0, triangle.v1, triangle.v2}) bounds.extend({vertex, vertex});
    }
    return bounds;
  }

  void check(const interface::BvhNode& node, uint32_t slot, const Box& box) {
    for (int axis = 0; axis < 3; ++axis) {
      const double quantum = std::ldexp(1.0, static_cast<int>(node.exponents >> (8 * axis) & 0xFFu) - 127);
      const double lower = node.origin[axis] + plane(node, axis, false, slot) * quantum;
      const double upper = node.origin[axis] + plane(node, axis, true, slot) * quantum;
      smallest_margin = std::min(
          {smallest_margin, (box.lower[axis] - lower) / quantum, (upper - box.upper[axis]) / quantum});
    }
  }
};

void expect_valid(const std::vector<InputTriangle>& triangles) {
  const Bvh bvh = bvh::build(triangles);
  Walk walk{bvh};
  walk.visit(0, 1);
  ASSERT_EQ(bvh.triangles.size(), triangles.size());
  ASSERT_EQ(bvh.order.size(), triangles.size());
  std::vector<uint32_t> uses(triangles.size());
  for (size_t i = 0; i < bvh.order.size(); ++i) {
    ++uses.at(bvh.order[i]);
    EXPECT_EQ(bvh.triangles[i].tag, triangles[bvh.order[i]].tag);
    EXPECT_EQ(bvh.triangles[i].v0, triangles[bvh.order[i]].vertices[0]);
  }
  for (uint32_t count : uses) ASSERT_EQ(count, 1u) << "order is a permutation";
  for (uint32_t count : walk.triangle_visits) ASSERT_EQ(count, 1u) << "every triangle stands in one leaf";
  for (uint32_t count : walk.node_visits) ASSERT_EQ(count, 1u) << "every node has one parent";
  EXPECT_EQ(walk.depth, bvh.depth);
  EXPECT_LE(bvh.depth, interface::BVH_MAX_DEPTH);
  // Slab tests err by up to 3 roundoffs of 255 quanta beyond what is relative to the distance.
  const double needed = 3 * 0x1p-24 * 255;
  std::printf("%zu triangles, %zu nodes, depth %u, smallest margin %.2g quanta (needed %.2g)\n",
              triangles.size(), bvh.nodes.size(), bvh.depth, walk.smallest_margin, needed);
  EXPECT_GT(walk.smallest_margin, needed);
}

/// FNV-1a over nodes and order.
uint64_t hash_of(const Bvh& bvh) {
  uint64_t hash = 0xCBF29CE484222325u;
  const auto add = [&](const void* data, size_t bytes) {
    for (size_t i = 0; i < bytes; ++i) hash = (hash ^ static_cast<const uint8_t*>(data)[i]) * 0x100000001B3u;
  };
  add(bvh.nodes.data(), bvh.nodes.size() * sizeof(interface::BvhNode));
  add(bvh.order.data(), bvh.order.size() * sizeof(uint32_t));
  return hash;
}

/// The result of `work` in a process of its own that is confined to `cores` cores.
uint64_t in_process_with_cores(int cores, const std::function<uint64_t()>& work) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    cpu_set_t allowed, all;
    CPU_ZERO(&allowed);
    sched_getaffinity(0, sizeof all, &all);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&allowed) < cores; ++cpu)
      if (CPU_ISSET(cpu, &all)) CPU_SET(cpu, &allowed);
    sched_setaffinity(0, sizeof allowed, &allowed);
    bool is_sent = false;
    try {
      const uint64_t result = work();
      is_sent = write(ends[1], &result, sizeof result) == sizeof result;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
    _exit(is_sent ? 0 : 1);
  }
  close(ends[1]);
  uint64_t result = 0;
  EXPECT_EQ(read(ends[0], &result, sizeof result), static_cast<ssize_t>(sizeof result));
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_EQ(status, 0);
  close(ends[0]);
  return result;
}

}  // namespace

TEST(BvhBuild, RepeatsOnAnyNumberOfCores) {
  // Duplicates leave the heuristic without a choice, so that ties are broken by order alone. The children
  // build first: Embree's threads of this process would not survive a fork.
  const auto build = [] {
    std::vector<InputTriangle> triangles = make_soup(2, 20000, 1, glm::dvec3(0));
    triangles.insert(triangles.end(), triangles.begin(), triangles.begin() + 5000);
    triangles.insert(triangles.end(), 1000, triangles[0]);
    return hash_of(bvh::build(triangles)) ^ 3 * hash_of(bvh::build(make_nest(50000)));
  };
  const uint64_t serial = in_process_with_cores(1, build);
  for (int run = 0; run < 4; ++run) EXPECT_EQ(in_process_with_cores(64, build), serial) << "run " << run;
}

TEST(BvhBuild, IsValidAndConservative) {
  expect_valid(make_soup(3, 20000, 1, glm::dvec3(0)));
  expect_valid(make_soup(4, 3000, 1e-4, glm::dvec3(0)));
  expect_valid(make_soup(5, 3000, 1e6, glm::dvec3(0)));
  expect_valid(make_soup(6, 3000, 1, glm::dvec3(1e6, -1e6, 3e5)));
}

TEST(BvhBuild, CopesWithFewTriangles) {
  for (uint32_t count = 1; count <= 20; ++count) expect_valid(make_soup(7, count, 1, glm::dvec3(0)));
}

TEST(BvhBuild, CopesWithNothing) {
  const Bvh bvh = bvh::build({});
  Walk walk{bvh};
  walk.visit(0, 1);
  EXPECT_EQ(bvh.nodes.size(), 1u);
  EXPECT_EQ(walk.depth, 1u);
  EXPECT_TRUE(bvh.triangles.empty());
}

TEST(BvhBuild, CopesWithFlatAndCoincidentTriangles) {
  std::vector<InputTriangle> triangles = make_soup(8, 2000, 1, glm::dvec3(0));
  for (InputTriangle& triangle : triangles)
    for (glm::vec3& vertex : triangle.vertices) vertex.z = 0;
  expect_valid(triangles);
  expect_valid(std::vector<InputTriangle>(3000, triangles[0]));
}

TEST(BvhBuild, CopesWithNestedScales) {
  expect_valid(make_nest(50000));
}

}  // namespace regulus::test

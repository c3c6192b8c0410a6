#include "images/support/media_cases.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

namespace regulus::test {
namespace {

using glm::dmat4;
using glm::dvec3;
using nlohmann::json;

json grey(double ior, double left_after_one_metre) {
  return glass(ior, 0, dvec3(left_after_one_metre));
}

json with_priority(json material, double priority) {
  material["extras"] = {{"regulus", {{"priority", priority}}}};
  return material;
}

/// White surroundings, and a narrow bundle of rays along `towards - eye`.
GltfScene view(const dvec3& eye, const dvec3& towards, double half_size = 0.3) {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {1, 1, 1}}});
  scene.set_orthographic(
      look_at(eye, towards, std::abs(eye.y - towards.y) > 1e-6 ? dvec3(0, 0, 1) : dvec3(0, 1, 0)), half_size,
      half_size);
  return scene;
}

/// A camera at the origin that sees an emitter of radiance 1, two metres away.
GltfScene inside_view() {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-4, -4, -2}, {8, 0, 0}, {0, 8, 0})}, emitter(dvec3(1)));
  scene.set_perspective(look_at({0, 0, 0}, {0, 0, -1}), 0.01);
  return scene;
}

MediaCase in_a_block(const char* name, double ior) {
  GltfScene scene = inside_view();
  scene.add(box({-5, -5, -5}, {5, 5, 5}), grey(ior, 0.5));
  return {name, scene, 0.25, 1e-4, false};
}

// A metre of air around the camera, then a metre of fog up to the emitter; the camera's solid is added last.
MediaCase in_a_bubble() {
  GltfScene scene = inside_view();
  scene.add(box({-5, -5, -5}, {5, 5, 5}), grey(1, 0.5));
  scene.add(box({-1, -1, -1}, {1, 1, 1}), grey(1, 1));
  return {"camera in a bubble in fog", scene, 0.5, 1e-4, false};
}

// Half of the film, which is as wide as the block's half, lies in it.
MediaCase half_in_a_block() {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-4, -4, -2}, {8, 0, 0}, {0, 8, 0})}, emitter(dvec3(1)));
  scene.add(box({-5, -5, -5}, {0, 5, 5}), grey(1, 0.5));
  scene.set_orthographic(look_at({0, 0, 0}, {0, 0, -1}), 0.5, 0.5);
  return {"film half in fog", scene, 0.5 * (1 + 0.25), 1e-4, false};
}

// 3 m of .5 with a metre of nothing in it, seen from both ends.
MediaCase hollow(const char* name, double side) {
  GltfScene scene = view({0, 0, side}, {0, 0, 0});
  scene.add(box({-1, -1, -1.5}, {1, 1, 1.5}), grey(1, 0.5));
  scene.add(box({-0.9, -0.9, -0.5}, {0.9, 0.9, 0.5}), grey(1, 1));
  return {name, scene, 0.25};
}

// .5 for 2 m, air for 1 m, .25 for 1 m: each in the one before.
MediaCase three_deep() {
  GltfScene scene = view({0, 0, 6}, {0, 0, 0});
  scene.add(box({-0.8, -0.8, -0.5}, {0.8, 0.8, 0.5}), grey(1, 0.25));
  scene.add(box({-1, -1, -2}, {1, 1, 2}), grey(1, 0.5));
  scene.add(box({-0.9, -0.9, -1}, {0.9, 0.9, 1}), grey(1, 1));
  return {"three deep", scene, 0.25 * 0.25};
}

// A cavity that is modelled as such: its surface faces inwards and belongs to the block's mesh.
MediaCase cavity() {
  GltfScene scene = view({0, 0, 6}, {0, 0, 0});
  Polygons block = box({-1, -1, -1.5}, {1, 1, 1.5});
  for (const Polygon& side : turned(box({-0.9, -0.9, -0.5}, {0.9, 0.9, 0.5}))) block.push_back(side);
  scene.add(block, grey(1, 0.5));
  return {"cavity", scene, 0.25};
}

// Two blocks of one index that share a face, white all around.
MediaCase touching(const char* name, const dmat4& matrix, double second_ior, double relative) {
  GltfScene scene = view(dvec3(matrix * glm::dvec4(0, 0, 6, 1)), dvec3(matrix * glm::dvec4(0, 0, 1, 1)));
  scene.add(transformed(matrix, box({-1, -1, 0}, {1, 1, 1})), grey(1.5, 1));
  // The shared face in four, so that no triangle is the other's.
  Polygons second = box({-1, -1, 1}, {1, 1, 2});
  std::erase_if(second, [](const Polygon& side) {
    return std::all_of(side.begin(), side.end(), [](const dvec3& p) { return p.z == 1; });
  });
  for (const double x : {-1.0, 0.25})
    for (const double y : {-1.0, 0.1})
      second.push_back(quad({x, y, 1}, {0, y < 0 ? 1.1 : 0.9, 0}, {x < 0 ? 1.25 : 0.75, 0, 0}));
  scene.add(transformed(matrix, second), grey(second_ior, 1));
  return {name, scene, 1, relative, false};
}

// The same of no index that absorb: what each takes is counted once, in both orders.
MediaCase touching_fog(const char* name, double side) {
  GltfScene scene = view({0, 0, side}, {0, 0, 1});
  scene.add(box({-1, -1, 0}, {1, 1, 1}), grey(1, 0.5));
  scene.add(box({-1, -1, 1}, {1, 1, 2}), grey(1, 0.8));
  return {name, scene, 0.4};
}

// A clear block up to z = 1.1 and a liquid of .5 from z = 1 to 2, which is the smaller one unless told
// otherwise.
MediaCase overlap(const char* name, double side, double glass_priority, double expected) {
  GltfScene scene = view({0, 0, side}, {0, 0, 1});
  scene.add(box({-1, -1, 0}, {1, 1, 1.1}), with_priority(grey(1, 1), glass_priority));
  scene.add(box({-0.9, -0.9, 1}, {0.9, 0.9, 2}), grey(1, 0.5));
  return {name, scene, expected};
}

// Two absorbing twins that overlap by half: of one volume the first node's decides, and both are the same.
MediaCase twins() {
  GltfScene scene = view({0, 0, 6}, {0, 0, 1});
  scene.add(box({-1, -1, 0}, {1, 1, 1}), grey(1.5, 1));
  scene.add(box({-1, -1, 0.5}, {1, 1, 1.5}), grey(1.5, 1));
  return {"twins that overlap", scene, 1, 1e-4, false};
}

// A block of glass on an emitter: what is seen of it has crossed the glass' top alone, twice for what that
// reflects.
MediaCase block_on_emitter() {
  GltfScene scene = view({0, 3, 0}, {0, 0, 0});
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-2, 0, -2}, {0, 0, 4}, {4, 0, 0})}, emitter(dvec3(1)));
  scene.add(box({-1, 0, -1}, {1, 1, 1}), grey(1, 0.5));
  return {"block on an emitter", scene, 0.5};
}

/// A slab as thick as its floats are at height `bottom`, half of it absorbed per `nominal` metres.
MediaCase slab(const char* name, double bottom, double nominal, double ior) {
  GltfScene scene = view({0, 2, 0}, {0, 0, 0});
  const auto low = static_cast<float>(bottom), high = static_cast<float>(bottom + nominal);
  json material = grey(ior, 0.5);
  material["extensions"]["KHR_materials_volume"]["attenuationDistance"] = nominal;
  scene.add(box({-1, low, -1}, {1, high, 1}), material);
  const double t = std::pow(0.5, (double{high} - double{low}) / nominal);
  const double f = std::pow((ior - 1) / (ior + 1), 2);
  const double seen = f + (1 - f) * (1 - f) * t / (1 - f * t);  // white on both sides: what is reflected, too
  return {name, scene, seen, 2e-3, ior != 1};
}

}  // namespace

std::vector<MediaCase> media_cases() {
  const dmat4 turn = glm::rotate(dmat4(1), 0.7, glm::normalize(dvec3(0.3, 1, 0.4))) *
                     glm::translate(dmat4(1), dvec3(0.123, -0.456, 0.789));
  return {in_a_block("camera in fog", 1),
          in_a_block("camera in glass", 1.5),
          in_a_bubble(),
          half_in_a_block(),
          hollow("hollow block", 6),
          hollow("hollow block from behind", -6),
          three_deep(),
          cavity(),
          touching("touching glass", dmat4(1), 1.5, 1e-4),
          touching("touching glass, turned", turn, 1.5, 1e-4),
          touching("glass on water", turn, 1.33, 1e-4),
          touching_fog("touching fog", 6),
          touching_fog("touching fog from behind", -6),
          overlap("overlap", 6, 0, 0.5),
          overlap("overlap from behind", -6, 0, 0.5),
          overlap("overlap with priority", 6, 1, std::pow(0.5, 0.9)),
          overlap("overlap with priority from behind", -6, 1, std::pow(0.5, 0.9)),
          twins(),
          block_on_emitter()};
}

std::vector<MediaCase> thin_slabs() {
  return {slab("slab of 1e-5 m", 0.5, 1e-5, 1), slab("slab of 1e-6 m", 0.5, 1e-6, 1),
          slab("slab of 1e-7 m", 0.5, 1e-7, 1), slab("slab of 1e-7 m at .9", 0.9, 1e-7, 1),
          slab("slab of 1e-7 m with an index", 0.5, 1e-7, 1.5)};
}

GltfScene lamp_in_block() {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-3, 0, 3}, {6, 0, 0}, {0, 0, -6})}, lambert(dvec3(0.8)));
  scene.add(box({-1, 1, -1}, {1, 3, 1}), grey(1, 0.5));
  scene.add_point_light({0, 2, 0}, dvec3(10));
  scene.set_orthographic(look_at({0, 0.5, 0}, {0, 0, 0}, {0, 0, -1}), 0.9, 0.9);
  return scene;
}

GltfScene panel_across_block() {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-3, 0, 3}, {6, 0, 0}, {0, 0, -6})}, lambert(dvec3(0.8)));
  scene.add(box({0, 1, -1}, {1.5, 3, 1}), grey(1, 0.2));
  scene.add({quad({-0.8, 2, 0.8}, {0, 0, -1.6}, {1.6, 0, 0})}, emitter(dvec3(3)));
  scene.set_orthographic(look_at({0, 0.5, 0}, {0, 0, 0}, {0, 0, -1}), 0.9, 0.9);
  return scene;
}

double floor_below_lamp(const dvec3& point) {
  const dvec3 way = dvec3(0, 2, 0) - point;
  const double distance = glm::length(way);
  const dvec3 direction = glm::abs(way) / distance;
  const double in_block = 1 / std::max({direction.x, direction.y, direction.z});
  return 0.8 / std::numbers::pi * 10 * direction.y / (distance * distance) * std::pow(0.5, in_block);
}

}  // namespace regulus::test

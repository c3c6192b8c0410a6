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

// A slab whose fronts face inwards, alone or placed by a mirror: someone forgot to turn it.
MediaCase inside_out(const char* name, const dmat4& matrix, double side) {
  GltfScene scene = view({0, 0, side}, {0, 0, 0});
  scene.add(turned(box({-1, -1, -0.5}, {1, 1, 0.5})), grey(1, 0.5), matrix);
  scene.expect_warning("have their fronts inwards and are turned");
  return {name, scene, 0.5};
}

// Fronts inwards in a block of the same substance: a cavity, though it is a mesh of its own. Of another: a
// solid.
MediaCase inside_out_in_block(const char* name, double left_after_one_metre, double expected) {
  GltfScene scene = view({0, 0, 6}, {0, 0, 0});
  scene.add(box({-1, -1, -1.5}, {1, 1, 1.5}), grey(1, 0.5));
  scene.add(turned(box({-0.9, -0.9, -0.5}, {0.9, 0.9, 0.5})), grey(1, left_after_one_metre));
  if (left_after_one_metre != 0.5) scene.expect_warning("have their fronts inwards and are turned");
  return {name, scene, expected};
}

// A slab and its mirrored copy that overlap by half a metre, as one mesh placed twice.
MediaCase mirrored_copy() {
  GltfScene scene = view({0, 0, 6}, {0, 0, 0});
  scene.add(box({-1, -1, -0.5}, {1, 1, 0.5}), grey(1, 0.5), glm::translate(dmat4(1), dvec3(0, 0, -0.25)));
  scene.add_copy(glm::scale(glm::translate(dmat4(1), dvec3(0, 0, 0.25)), dvec3(-1, 1, 1)));
  return {"slab and its mirrored copy", scene, std::pow(0.5, 1.5)};
}

// Ice in water in glass, all faces flush on one side: clear to white surroundings, or each taking its share.
MediaCase ice_in_water(const char* name, double side, bool is_fog) {
  GltfScene scene = view({0, 0, side}, {0, 0, 0});
  scene.add(box({-1, -1, -1.5}, {1, 1, 1}), is_fog ? grey(1, 0.9) : grey(1.5, 1));
  scene.add(box({-0.9, -0.9, -1}, {0.9, 0.9, 1}), is_fog ? grey(1, 0.8) : grey(1.33, 1));
  scene.add(box({-0.8, -0.8, -0.5}, {0.8, 0.8, 1}), is_fog ? grey(1, 0.7) : grey(1.31, 1));
  const double left = is_fog ? std::sqrt(0.9 * 0.8) * std::pow(0.7, 1.5) : 1;
  return {name, scene, left, 1e-4, is_fog};
}

// Water that fills the cavity of a glass to its walls.
MediaCase filled_cavity(const char* name, double side) {
  GltfScene scene = view({0, 0, side}, {0, 0, 0});
  Polygons block = box({-1, -1, -1.5}, {1, 1, 1.5});
  for (const Polygon& wall : turned(box({-0.9, -0.9, -1}, {0.9, 0.9, 1}))) block.push_back(wall);
  scene.add(block, grey(1, 0.8));
  scene.add(box({-0.9, -0.9, -1}, {0.9, 0.9, 1}), grey(1, 0.7));
  return {name, scene, 0.8 * 0.49};
}

// A block before an emitter, seen from three metres in front of its middle through a near plane: what that
// cuts away takes no light.
MediaCase cut_block(const char* name, bool is_orthographic, double near, double expected) {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-4, -4, -2}, {8, 0, 0}, {0, 8, 0})}, emitter(dvec3(1)));
  scene.add(box({-5, -5, -5}, {5, 5, 1}), grey(1, 0.5));
  const dmat4 camera = look_at({0, 0, 3}, {0, 0, 0});
  is_orthographic ? scene.set_orthographic(camera, 0.3, 0.3) : scene.set_perspective(camera, 0.01);
  scene.set_near_plane(near);
  return {name, scene, expected};
}

// A camera in fog, whose near plane cuts away something that hides nothing then.
MediaCase cut_in_fog() {
  GltfScene scene = inside_view();
  scene.add(box({-5, -5, -5}, {5, 5, 5}), grey(1, 0.5));
  scene.add({quad({-4, -4, -0.5}, {8, 0, 0}, {0, 8, 0})}, lambert(dvec3(0)));
  scene.set_near_plane(1);
  return {"near plane in fog", scene, 0.25, 1e-4, false};
}

// Paper that lies in a table's plane, or a hair above it, level and tilted, is what is seen. The first one in
// the file is there in one plane.
MediaCase paper_on_table(const char* name, const dmat4& matrix, double gap) {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {1, 1, 1}}});
  const dvec3 eye(matrix * glm::dvec4(0, 2, 0, 1)), middle(matrix * glm::dvec4(0, 0, 0, 1));
  scene.set_orthographic(look_at(eye, middle, {0, 0, 1}), 0.2, 0.2);
  scene.add(transformed(matrix, {quad({-0.5, gap, 0.5}, {1, 0, 0}, {0, 0, -1})}), emitter(dvec3(0.7)));
  scene.add(transformed(matrix, {quad({-2, 0, 2}, {4, 0, 0}, {0, 0, -4})}), lambert(dvec3(0)));
  return {name, scene, 0.7, 1e-4, false};
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

MediaCase half_in_a_block() {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-4, -4, -2}, {8, 0, 0}, {0, 8, 0})}, emitter(dvec3(1)));
  scene.add(box({-5, -5, -5}, {0, 5, 5}), grey(1, 0.5));
  scene.set_orthographic(look_at({0, 0, 0}, {0, 0, -1}), 0.5, 0.5);
  return {"film half in fog", scene, 0.5 * (1 + 0.25), 1e-4, false};
}

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
          inside_out("inside out", dmat4(1), 6),
          inside_out("inside out from behind", dmat4(1), -6),
          inside_out("inside out in a mirror", glm::scale(dmat4(1), dvec3(-1, 1, 1)), 6),
          inside_out_in_block("cavity of its own", 0.5, 0.25),
          inside_out_in_block("inside out in a block", 0.25, 0.25 * 0.25),
          mirrored_copy(),
          ice_in_water("ice in water in glass", 6, false),
          ice_in_water("ice in water in glass from behind", -6, false),
          ice_in_water("fogs in fog", 6, true),
          ice_in_water("fogs in fog from behind", -6, true),
          filled_cavity("filled cavity", 6),
          filled_cavity("filled cavity from behind", -6),
          cut_block("near plane in a block", true, 3, 0.25),
          cut_block("near plane in a block, perspective", false, 3, 0.25),
          cut_block("near plane in the block's face", true, 2, 0.125),
          cut_block("near plane before a block", false, 1, 0.125),
          cut_in_fog(),
          paper_on_table("glowing paper in a table's plane", dmat4(1), 0),
          paper_on_table("glowing paper in a tilted table's plane", turn, 0),
          paper_on_table("glowing paper on a tilted table", turn, 1e-4),
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

GltfScene overlapping_lamps() {
  GltfScene scene;
  scene.set_setting("environment", {{"color", {0, 0, 0}}});
  scene.add({quad({-2, 0, 2}, {4, 0, 0}, {0, 0, -4})}, lambert(dvec3(0.5)));
  scene.add({quad({-2, 2, -2}, {4, 0, 0}, {0, 0, 4})}, lambert(dvec3(0)));
  scene.add({quad({-0.5, 2, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter(dvec3(10)));
  scene.add({quad({0, 2, 0}, {1, 0, 0}, {0, 0, 1})}, emitter(dvec3(30)));
  scene.set_orthographic(look_at({0, 1, 0}, {0, 0, 0}, {0, 0, -1}), 0.5, 0.5);
  scene.expect_warning("each point shines once");
  return scene;
}

double floor_below_lamps() {
  // Share of the hemisphere above a point, by cosine, of a rectangle with a corner above it, per height.
  const auto corner = [](double x, double y) {
    const double a = std::sqrt(1 + x * x), b = std::sqrt(1 + y * y);
    return (x / a * std::atan(y / a) + y / b * std::atan(x / b)) / (2 * std::numbers::pi);
  };
  constexpr int CELLS = 32;
  double sum = 0;
  for (int i = 0; i < CELLS * CELLS; ++i) {
    const double x = (i % CELLS + 0.5) / CELLS - 0.5, z = (i / CELLS + 0.5) / CELLS - 0.5;
    const auto rectangle = [&](double low, double high) {
      const double x0 = (low - x) / 2, x1 = (high - x) / 2, z0 = (low - z) / 2, z1 = (high - z) / 2;
      return corner(x1, z1) - corner(x0, z1) - corner(x1, z0) + corner(x0, z0);
    };
    sum += 0.5 * (10 * rectangle(-0.5, 0.5) + 30 * (rectangle(0, 1) - rectangle(0, 0.5)));
  }
  return sum / (CELLS * CELLS);
}

}  // namespace regulus::test

// The scenes that tests of the command line share.
#pragma once

#include <string>

#include "images/support/gltf_scene.hpp"

namespace regulus::test {

/// Writes a floor under a lamp that looks down: noise of moderate size in every pixel, without outliers.
inline void write_lit_floor(const std::string& path) {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}));
  scene.add({quad({-0.5, 1.5, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({10, 10, 10}));
  scene.set_perspective(look_at({0, 1, 0}, {0, 0, 0.001}), 1.0);
  scene.write(path);
}

/// Writes a grey square of 2 m, 2 m in front of the camera, under a point light 1 m before its middle, which
/// the camera sees as albedo / pi = .159 W / (m^2 sr).
inline void write_lit_square(const std::string& path) {
  GltfScene scene;
  scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
  scene.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.8);
  scene.add_point_light({0, 0, 1}, {1, 1, 1});
  scene.write(path);
}

}  // namespace regulus::test

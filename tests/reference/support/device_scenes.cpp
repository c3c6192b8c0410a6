#include "reference/support/device_scenes.hpp"

#include "images/support/room.hpp"

namespace regulus::test {

image::Image striped_sky() {
  image::Image sky{32, 16, {}};
  for (uint32_t i = 0; i < 32 * 16; ++i)
    for (const float channel : {0.2F, 0.4F, 0.8F})
      sky.rgb.push_back(i == 5 * 32 + 20 ? 50 : i < 256 ? channel * static_cast<float>(i % 7) : 0);
  return sky;
}

PreparedScene guided_scene() {
  GltfScene scene;
  scene.add({quad({-20, 0, 20}, {40, 0, 0}, {0, 0, -40})}, lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.6, 0, -0.4}, {-0.1, 0.7, 0.1}), plastic({0.3, 0.6, 0.4}, 0.5));
  scene.add(box({0.2, 0.1, -0.2}, {0.6, 0.5, 0.2}), glass(1.5, 0, {0.5, 0.7, 0.9}));
  scene.add({quad({-0.3, 1, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.add({quad({-1.5, 1, -1.3}, {0.1, 0.5, 0}, {0, 0.5, 0.1})}, emitter({20, 10, 1}));
  scene.add_point_light({3, 2, 1}, {5, 3, 4});
  scene.add_spot_light({1, 4, 1}, {-0.3, -1, -0.4}, 20, 0.2, 1.2);
  scene.add_directional_light({0.4, -1, -0.3}, 2);
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  return prepare(scene, striped_sky(), 40);
}

GltfScene dispersive_scene() {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.7, 0.6, 0.5}));
  scene.add({quad({-1, 0, -1}, {2, 0, 0}, {0, 2, 0})}, plastic({0.5, 0.5, 0.6}, 0.3));
  scene.add(box({-0.7, 0.1, -0.4}, {-0.1, 0.8, 0.2}), dispersive(glass(1.6, 0, {0.5, 0.7, 0.9}), 2));
  scene.add(box({-0.6, 0.2, -0.3}, {-0.3, 0.5, 0.1}), dispersive(glass(1.3, 0.3), 1));
  scene.add({quad({-0.28, 0.3, -0.2}, {0.15, 0, 0}, {0, 0.3, 0.1})}, lambert({0.6, 0.7, 0.5}));
  scene.add(box({0.2, 0.1, -0.2}, {0.6, 0.5, 0.2}), dispersive(glass(1.5, 0.4), 5));
  scene.add(box({0.1, 0.02, 0.4}, {0.5, 0.3, 0.7}), coated(dispersive(glass(2.4, 0), 0.36), 0.3));
  scene.add({quad({-0.3, 1, 0.3}, {0.6, 0, 0}, {0, 0.1, -0.6})}, emitter({2, 2, 1}, true));
  scene.add_directional_light({0.4, -1, -0.3}, 2);
  scene.set_perspective(look_at({0, 1.2, 2.2}, {0, 0.2, 0}), 0.9);
  return scene;
}

}  // namespace regulus::test

// Parts of a render from the outside: what tests of them share.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {

/// A lamp over a floor, rendered small into a folder of its own.
class RenderParts : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    GltfScene scene;
    scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}));
    scene.add({quad({-0.5, 1.5, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({10, 10, 10}));
    scene.set_perspective(look_at({0, 1, 0}, {0, 0, 0.001}), 1.0);
    scene.write(file("scene.gltf"));
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Arguments command(const std::string& output, const Arguments& more) const {
    Arguments arguments = {"render", file("scene.gltf"), "-o", file(output), "--size", "24x16", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void render(const std::string& output, const Arguments& more) const {
    const Finished finished = run(command(output, more));
    ASSERT_EQ(finished.status, 0) << finished.err;
  }
  image::ExrContents contents(const std::string& name) const { return image::read_exr_contents(file(name)); }

  TemporaryFolder folder_;
};

}  // namespace regulus::test

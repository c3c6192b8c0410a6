// Renders a scene from two sides, each until it is done or Ctrl+C is pressed:
//
//     render SCENE.gltf FOLDER
#include <csignal>
#include <cstdio>
#include <regulus/regulus.hpp>
#include <string>

volatile std::sig_atomic_t is_interrupted = 0;

int main(int, char** arguments) try {
  using namespace regulus;
  std::signal(SIGINT, [](int) { is_interrupted = 1; });
  Scene scene = load(arguments[1]);
  Device device = open_device();
  Settings settings;
  settings.set("spp", 8).set("size", "48x48").set("integrator", "bpt").set("aov", "albedo,Z");
  for (const double side : {-1.0, 1.0}) {
    Camera camera = scene.cameras().front();
    camera.position[0] += 0.2 * side;
    scene.set_camera(0, camera);
    Renderer renderer(make_plan(prepare(scene), settings), device);
    const Outcome outcome = renderer.render([](uint64_t done, uint64_t all) {
      std::fprintf(stderr, "\r%3.0f %%", 100.0 * static_cast<double>(done) / static_cast<double>(all));
      return is_interrupted == 0;
    });
    const std::string name = std::string(arguments[2]) + (side < 0 ? "/left" : "/right");
    write_picture(name + ".exr", renderer.picture());
    write_picture(name + ".png", renderer.picture());
    std::printf("%s: %s\n", device.name().c_str(), outcome.summary.c_str());
  }
} catch (const regulus::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}

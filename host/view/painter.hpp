// Renders what the page of `regulus view` asks for, finer and finer, and posts it.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "denoise/denoise.hpp"
#include "gpu/gpu.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/noise.hpp"
#include "render/renderer.hpp"
#include "view/board.hpp"
#include "view/wanted.hpp"

namespace regulus::view {

class Painter {
 public:
  /// @param prepared whose camera is moved; must outlive the object
  /// @param base of the settings of both sides: size, camera, samples at most
  /// @param home the orbit of the scene's own camera
  /// @param oidn file of Open Image Denoise, see denoise::by_open_image_denoise; where it cannot be loaded
  /// the cross
  ///   filter denoises
  Painter(gpu::Device& device, PreparedScene& prepared, const render::RenderSettings& base, const Orbit& home,
          const std::string& oidn, Mailbox& mailbox, Board& board);

  /// Renders until `is_over`; nothing while nobody watches. A side that cannot be rendered says why on the
  /// page. @throws regulus::Error (NoDevice) if the device is lost
  void run(const std::function<bool()>& is_over, const std::function<bool()>& is_watched);

 private:
  /// A picture on its way.
  struct Canvas {
    std::unique_ptr<render::Renderer> renderer;  ///< null until it is painted
    render::NoiseEstimate noise;
    uint64_t posted_paths = 0;
    double seconds = 0;  ///< of rendering
    bool has_failed = false;
    image::Channels surfaces{};  ///< albedo and normals, once they have been traced
  };

  void take(const Wanted& wanted);
  bool is_done(size_t side) const;
  std::optional<size_t> next_side() const;
  void paint(size_t side);
  void begin(size_t side);
  image::Image denoised(Canvas& canvas);
  void post_state(size_t side);
  void post_picture(size_t side, const image::Image& image);
  void post_status(const std::string& text);
  bool is_outdated(size_t side) const;
  uint64_t samples(size_t side) const;

  gpu::Device& device_;
  PreparedScene& prepared_;
  render::RenderSettings base_;
  Orbit home_;
  std::string oidn_;
  denoise::Method denoiser_;
  scene::SceneCamera own_camera_;
  Mailbox& mailbox_;
  Board& board_;
  std::function<bool()> is_over_;
  Wanted wanted_;
  uint64_t number_ = 0;
  std::array<Canvas, 2> canvases_;
};

}  // namespace regulus::view

// Shows a render while it runs in a viewer that speaks tev's protocol, as pbrt-v4 does.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/tcp_client.hpp"
#include "image/image.hpp"
#include "render/film.hpp"

namespace regulus::session {

/// The messages of the protocol (tev, src/Ipc.cpp): length of the whole as int32, type, values one after the
/// other, all little-endian; texts end with a 0.
namespace tev {

/// CreateImage: an image of float channels R, G and B.
std::string create_image(const std::string& name, uint32_t width, uint32_t height);

/// UpdateImage of channel 0, 1 or 2 of some rows of a picture that lies at `placement` on the film.
std::string update_image(const std::string& name, const image::Image& image, uint32_t channel,
                         uint32_t first_row, uint32_t rows, const image::Placement& placement);

}  // namespace tev

/// Sends states of a film from a thread of its own. What comes while one is being sent is dropped, so that a
/// render never waits, whatever the viewer does. A viewer that is absent, or goes away, is looked for once a
/// second; it gets the whole picture then.
class DisplayServer {
 public:
  /// @param name of the picture in the viewer
  /// @param placement with the film's size
  DisplayServer(const HostAndPort& address, const std::string& name, const image::Placement& placement);
  ~DisplayServer() { close(); }
  DisplayServer(const DisplayServer&) = delete;
  DisplayServer& operator=(const DisplayServer&) = delete;

  /// Takes a copy of the state if the last one is on its way and it is newer.
  void offer(const render::Film& film);
  /// The picture as it is in the end: sent after what is on its way.
  void finish(const image::Image& image);

  /// Gives what is on its way two seconds to arrive, and ends. Nothing is taken any more.
  void close();

  /// One line, once, if the viewer could not be reached or went away.
  std::optional<std::string> take_warning();

 private:
  struct State;
  std::shared_ptr<State> state_;  // shared with the thread, which may outlive the object
};

}  // namespace regulus::session

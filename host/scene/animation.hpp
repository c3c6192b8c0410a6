// Animations: which values the channels of one give to properties of the document at a time (glTF 2.0, 3.11
// and appendix C; KHR_animation_pointer).
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scene/document.hpp"
#include "scene/keyframes.hpp"
#include "scene/property.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// All animations of the file; what is broken in one is no error here.
std::vector<AnimationSummary> list_animations(const Document& document);

/// Index of the animation of that name, else of that index.
/// @throws Error that lists those there are
size_t find_animation(const Document& document, const std::string& wanted);

/// Its name, or its index if it has none.
std::string animation_name(const Document& document, size_t index);

/// An animation that is ready to pose its document.
class Animation {
 public:
  /// Warns of channels that are broken or move what is not read: their properties stay as they are.
  /// Precondition: the document has an animation of this index.
  Animation(Document& document, size_t index);

  /// Gives the document's properties their values at a time, in seconds from the animation's start; keys at
  /// its ends hold beyond them. @throws Error if a value is not finite
  void pose(Document& document, double seconds) const;

 private:
  struct Channel {
    Property property;
    Keyframes keyframes;
  };

  void add_channel(Document& document, const nlohmann::json& animation, const nlohmann::json& channel,
                   const std::string& element);

  std::string element_;
  std::vector<Channel> channels_;
  std::vector<std::string> not_read_;  // pointers
};

}  // namespace regulus::scene

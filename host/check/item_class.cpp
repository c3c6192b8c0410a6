#include "check/item_class.hpp"

#include "interface/scene.h"

namespace regulus::check {

using namespace interface;

std::string lobes_of(const reference::Bsdf& bsdf) {
  const reference::BsdfParameters& p = bsdf.parameters();
  std::string text = bsdf.is_delta() ? "smooth " : "rough ";
  if (p.transmission > 0)
    text += p.is_volume ? "glass" : "pane";
  else
    text += p.metallic > 0.5 ? "metal" : bsdf.is_delta() && p.specular == 0 ? "matte" : "dielectric";
  if (p.clearcoat > 0) text += bsdf.is_coat_delta() ? " under a smooth coat" : " under a rough coat";
  return text;
}

std::string vertex_class(const reference::WalkVertex& vertex) {
  return lobes_of(vertex.bsdf) + (vertex.medium == INVALID_INDEX ? "" : " in a medium");
}

std::string light_class(uint32_t kind) {
  switch (kind) {
    case LIGHT_TRIANGLE:
      return "lamp";
    case LIGHT_POINT:
      return "point light";
    case LIGHT_SPOT:
      return "spot light";
    case LIGHT_DIRECTIONAL:
      return "sun";
    default:
      return "environment";
  }
}

}  // namespace regulus::check

// AOVs as channels of an image.
#pragma once

#include <string>
#include <vector>

#include "image/image.hpp"
#include "interface/wavefront.h"
#include "render/film.hpp"

namespace regulus::render {

/// The names of all AOVs.
std::vector<std::string> known_aovs();

/// AOV_* bits of a comma-separated list of known_aovs(); 0 if it is empty. @throws regulus::Error (BadUsage)
/// naming the one that is unknown
uint32_t parse_aovs(const std::string& list);

/// The list of names.
std::string aov_names(uint32_t aovs);

/// Channels of those SURFACE_AOVS that `aovs` asks for: albedo.R, N.X, Ng.X, P.X and so on, Z, and the
/// integers material and instance: 1 + index, 0 where there is nothing. P is in the world of the file:
/// `origin` (Scene::origin) is added where there is a surface.
void add_surface_channels(const std::vector<interface::AovPixel>& pixels, uint32_t aovs,
                          const glm::dvec3& origin, image::Channels& channels);

/// Channels sigma.position (m) and sigma.angle (rad) of footprints as Renderer::surface_footprints() finds
/// them: standard deviations of one coordinate.
void add_sigma_channels(const std::vector<interface::vec3>& footprints, image::Channels& channels);

/// Channels NAME.R, NAME.G and NAME.B.
void add_colors(const image::Image& image, const std::string& name, image::Channels& channels);

/// Channels of the film: those of its layers (direct.R, light_Lamp.R and so on), variance.R and so on, of the
/// mean of the samples, and the integer samples.
void add_film_channels(const Film& film, uint32_t aovs, image::Channels& channels);

}  // namespace regulus::render

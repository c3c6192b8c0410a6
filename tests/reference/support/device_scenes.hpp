// Scenes with much in them, for the comparison of the device's stages and connections with the reference's.
#pragma once

#include "image/image.hpp"
#include "images/support/prepared_scene.hpp"

namespace regulus::test {

/// A sky of 32 x 16 texels: stripes above the horizon, a small sun, and nothing below.
image::Image striped_sky();

/// A light of every kind, far more of whose light is lost than is seen.
PreparedScene guided_scene();

/// Dispersive glass of all kinds: smooth with a block of another index within, rough, and under a clearcoat.
/// What lies in it is seen and lit through it.
GltfScene dispersive_scene();

}  // namespace regulus::test

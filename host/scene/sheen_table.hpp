// What sheen reflects: part of the model, as the data of textures are.
#pragma once

#include <vector>

namespace regulus::scene {

/// The words of interface/sheen.h: the shares of light that white sheen reflects, by quadrature, with
/// relative errors below 3e-5. About a fifth of a second of processor time.
std::vector<float> make_sheen_table();

}  // namespace regulus::scene

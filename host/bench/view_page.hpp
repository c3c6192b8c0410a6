// The page of `regulus view`.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace regulus::bench {

/// @param view title, state (view/wanted.hpp), home (the orbit of the scene's camera), techniques to choose
/// from, width and height in pixels, exposure in stops
std::string view_page(const nlohmann::json& view);

}  // namespace regulus::bench

// What `-i auto` chose and among what, as `plan --json` and reports have it.
#pragma once

#include <nlohmann/json.hpp>

#include "render/technique_choice.hpp"

namespace regulus::cli {

nlohmann::json choice_json(const render::TechniqueChoice& choice);

}  // namespace regulus::cli

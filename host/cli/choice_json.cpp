#include "cli/choice_json.hpp"

#include "render/names.hpp"

namespace regulus::cli {

nlohmann::json choice_json(const render::TechniqueChoice& choice) {
  nlohmann::json candidates = nlohmann::json::array();
  const auto named = [](uint32_t techniques, uint32_t regularization) {
    return nlohmann::json{{"techniques", render::technique_set_name(techniques)},
                          {"regularized", regularization != 0}};
  };
  for (const render::Candidate& candidate : choice.candidates) {
    nlohmann::json entry = named(candidate.techniques, candidate.regularization);
    entry["relative_squared_error"] = candidate.error;
    entry["cost"] = candidate.cost;
    candidates.push_back(std::move(entry));
  }
  nlohmann::json result = named(choice.techniques, choice.regularization);
  result["why"] = choice.why;
  result["candidates"] = std::move(candidates);
  return result;
}

}  // namespace regulus::cli

// Names of what settings can be, one table each: for the command line and its help, scene files, statistics,
// headers and errors.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "interface/wavefront.h"
#include "render/technique_sets.hpp"

namespace regulus::render {

struct Name {
  const char* name;
  uint32_t value;
};
using Names = std::span<const Name>;

namespace names {
using namespace interface;
inline constexpr std::array<Name, 5> TECHNIQUES = {{{"hit", TECHNIQUE_HIT},
                                                    {"nee", TECHNIQUE_NEE},
                                                    {"splat", TECHNIQUE_SPLAT},
                                                    {"connect", TECHNIQUE_CONNECT},
                                                    {"merge", TECHNIQUE_MERGE}}};
/// Named sets of techniques; no technique: those that suit the scene.
inline constexpr std::array<Name, 6> INTEGRATORS = {{{"auto", 0},
                                                     {"pt", technique_sets::PT},
                                                     {"lt", technique_sets::LT},
                                                     {"bpt", technique_sets::BPT},
                                                     {"bpm", technique_sets::BPM},
                                                     {"vcm", technique_sets::VCM}}};
inline constexpr std::array<Name, 4> LIGHT_SAMPLING = {{{"auto", LIGHT_SAMPLING_AUTO},
                                                        {"bvh", LIGHT_SAMPLING_BVH},
                                                        {"power", LIGHT_SAMPLING_POWER},
                                                        {"uniform", LIGHT_SAMPLING_UNIFORM}}};
inline constexpr std::array<Name, 3> LIGHT_GUIDE = {
    {{"auto", LIGHT_GUIDE_AUTO}, {"on", LIGHT_GUIDE_ON}, {"off", LIGHT_GUIDE_OFF}}};
inline constexpr std::array<Name, 4> RAYS = {
    {{"auto", RAYS_AUTO}, {"hardware", RAYS_HARDWARE}, {"software", RAYS_SOFTWARE}, {"host", RAYS_HOST}}};
/// Kinds of regularization, without the modes that may be added: REGULARIZATION_CONSISTENT, _DIFFUSION.
inline constexpr std::array<Name, 4> REGULARIZATION = {
    {{"none", REGULARIZATION_NONE},
     {"roughness", REGULARIZATION_ROUGHNESS},
     {"virtual-merge", REGULARIZATION_ROUGHNESS | REGULARIZATION_VIRTUAL_MERGE},
     {"both", REGULARIZATION_ROUGHNESS | REGULARIZATION_BOTH}}};
inline constexpr uint32_t REGULARIZATION_MODES = REGULARIZATION_CONSISTENT | REGULARIZATION_DIFFUSION;
inline constexpr std::array<Name, 2> TAU_SCHEDULE = {
    {{"fixed", 0}, {"consistent", REGULARIZATION_CONSISTENT}}};
inline constexpr std::array<Name, 2> DIFFUSION = {{{"off", 0}, {"on", REGULARIZATION_DIFFUSION}}};
inline constexpr std::array<Name, 3> SAMPLER_QUALITY = {
    {{"off", SAMPLER_QUALITY_OFF}, {"on", SAMPLER_QUALITY_ON}, {"smooth", SAMPLER_QUALITY_SMOOTH}}};
inline constexpr std::array<Name, 3> BOUND = {
    {{"peak", BOUND_PEAK}, {"smith", BOUND_SMITH}, {"directional", BOUND_DIRECTIONAL}}};
inline constexpr std::array<Name, 3> MIS = {
    {{"blended", MIS_BLENDED}, {"corrected", MIS_CORRECTED}, {"unmodified", MIS_UNMODIFIED}}};
inline constexpr std::array<Name, 3> NDF = {
    {{"ggx", NDF_GGX}, {"beckmann", NDF_BECKMANN}, {"cosine", NDF_COSINE}}};
inline constexpr std::array<Name, 3> SHADOWING = {{{"smith", SHADOWING_SMITH},
                                                   {"smith-uncorrelated", SHADOWING_SMITH_UNCORRELATED},
                                                   {"v-cavity", SHADOWING_V_CAVITY}}};
inline constexpr std::array<Name, 3> FILTER = {
    {{"box", FILTER_BOX}, {"gaussian", FILTER_GAUSSIAN}, {"blackman-harris", FILTER_BLACKMAN_HARRIS}}};
inline constexpr std::array<Name, 2> SAMPLER = {{{"sobol", SAMPLER_SOBOL}, {"hash", SAMPLER_HASH}}};
inline constexpr std::array<Name, 3> MATERIAL_CLASS = {{{"diffuse", MATERIAL_CLASS_DIFFUSE},
                                                        {"opaque", MATERIAL_CLASS_OPAQUE},
                                                        {"transmissive", MATERIAL_CLASS_TRANSMISSIVE}}};
static_assert(MATERIAL_CLASS.size() == MATERIAL_CLASS_COUNT);
}  // namespace names

/// The name of a value. @throws std::logic_error if it is not in the table
inline const char* name_of(Names names, uint32_t value) {
  for (const Name& entry : names)
    if (entry.value == value) return entry.name;
  throw std::logic_error("a setting without a name");
}

/// All names of a table, in its order.
inline std::vector<std::string> names_of(Names names) {
  std::vector<std::string> result;
  result.reserve(names.size());
  for (const Name& entry : names) result.emplace_back(entry.name);
  return result;
}

/// The entry of that name; nullptr if there is none.
inline const Name* find_name(Names names, std::string_view name) {
  for (const Name& entry : names)
    if (name == entry.name) return &entry;
  return nullptr;
}

/// A set of techniques by its own name, or by theirs: bpt, or hit,nee,splat.
inline std::string technique_set_name(uint32_t techniques) {
  for (const Name& entry : names::INTEGRATORS)
    if (entry.value == techniques) return entry.name;
  std::string list;
  for (const Name& technique : names::TECHNIQUES)
    if ((techniques & technique.value) != 0) list += (list.empty() ? "" : ",") + std::string(technique.name);
  return list;
}

}  // namespace regulus::render

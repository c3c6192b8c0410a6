#include "render/layers.hpp"

#include <algorithm>
#include <cctype>
#include <map>

#include "render/settings.hpp"
#include "scene/light_groups.hpp"

namespace regulus::render {

using namespace interface;

namespace {

struct Kind {
  uint32_t aov, kind;
  const char* name;
};
// By name.
constexpr Kind KINDS[] = {{AOV_CAUSTICS, LIGHT_CAUSTICS, "caustics"},
                          {AOV_DIRECT, LIGHT_DIRECT, "direct"},
                          {AOV_EMISSION, LIGHT_EMISSION, "emission"},
                          {AOV_INDIRECT, LIGHT_INDIRECT, "indirect"}};

/// Nuke makes whatever is no letter and no digit an underscore, and a dot would begin the component. Blender
/// has room for 63 bytes of a channel's name (imbuf's openexr_api.cpp); no letter of UTF-8 is cut.
std::string channel_of_group(const std::string& name) {
  constexpr size_t MOST_BYTES = 63 - 2;  // without ".R"
  std::string channel = "light_" + name;
  std::ranges::replace_if(
      channel, [](unsigned char c) { return c < 0x80 && std::isalnum(c) == 0; }, '_');
  if (channel.size() <= MOST_BYTES) return channel;
  size_t end = MOST_BYTES;
  while ((static_cast<unsigned char>(channel[end]) & 0xC0) == 0x80) --end;
  return channel.substr(0, end);
}

void add_groups(const scene::Scene& scene, Layers& layers) {
  const scene::LightGroups groups = scene::light_groups(scene);
  if (groups.names.empty()) return;
  std::map<std::string, uint32_t> numbers;  // groups that the channels do not tell apart are one
  for (const std::string& name : groups.names) numbers[channel_of_group(name)] = 0;
  layers.first_group = static_cast<uint32_t>(layers.names.size());
  uint32_t number = 0;
  for (auto& [name, own] : numbers) {
    own = number++;
    layers.names.push_back(name);
  }
  for (const uint32_t group : groups.of_light)
    layers.group_of_light.push_back(numbers.at(channel_of_group(groups.names[group])));
}

}  // namespace

Layers choose_layers(const scene::Scene& scene, uint32_t aovs) {
  Layers layers;
  layers.of_kind.fill(INVALID_INDEX);
  for (const Kind& kind : KINDS) {
    if ((aovs & kind.aov) == 0) continue;
    layers.of_kind[kind.kind] = static_cast<uint32_t>(layers.names.size());
    layers.names.emplace_back(kind.name);
  }
  if ((aovs & AOV_LIGHTS) != 0)
    add_groups(scene, layers);
  else
    layers.group_of_light.assign(scene.lights.size(), 0);
  return layers;
}

}  // namespace regulus::render

// One camera path from both backends, side by side.
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "check/check.hpp"
#include "reference/estimator.hpp"

namespace regulus::check {

using glm::dvec3;
using namespace interface;

namespace {

std::string digits_of(const dvec3& v) {
  return fmt::format("({:.7g} {:.7g} {:.7g})", v.x, v.y, v.z);
}

std::string name_of(const reference::Technique& technique) {
  switch (technique.kind) {
    case TECHNIQUE_HIT:
      return "hit";
    case TECHNIQUE_NEE:
      return "nee";
    case TECHNIQUE_SPLAT:
      return "splat";
    case TECHNIQUE_CONNECT:
      return fmt::format("connect s={}", technique.vertex);
    default:
      return fmt::format("merge at {}", technique.vertex);
  }
}

/// What the device has at vertex `index` of the path in slot 0, if its path came so far.
std::string device_vertex(const Subject& subject, const render::Recording& recording, size_t index) {
  if (index >= recording.bounces.size()) return "the device's path has ended";
  const render::RecordedBounce& bounce = recording.bounces[index];
  if (std::find(bounce.slots.begin(), bounce.slots.end(), 0u) == bounce.slots.end())
    return "the device's path has ended";
  const Hit& hit = bounce.hits[0];
  if (hit.triangle == INVALID_INDEX) return "the device's ray hit nothing";
  const reference::Surface surface = subject.world.surface_at(hit.triangle, {hit.u, hit.v});
  return fmt::format("triangle {:>8}  position {}  arrives with {}", hit.triangle,
                     digits_of(surface.position), digits_of(dvec3(bounce.before[0].throughput)));
}

std::string describe_vertex(const Subject& subject, const reference::WalkVertex& vertex, size_t index,
                            const render::Recording& recording) {
  const reference::BsdfParameters& bsdf = vertex.bsdf.parameters();
  const uint32_t material = vertex.surface.material;
  std::string text = fmt::format("vertex {}: material {} \"{}\"{}\n", index + 1, material,
                                 subject.prepared.scene.material_names[material],
                                 vertex.surface.light == INVALID_INDEX ? "" : ", emits");
  text += fmt::format("  reference  triangle {:>8}  position {}  arrives with {}\n", vertex.surface.triangle,
                      digits_of(vertex.surface.position),
                      digits_of(vertex.throughput / vertex.edge.transmittance));
  text += fmt::format("  device     {}\n", device_vertex(subject, recording, index));
  text += fmt::format("  distance {:.7g}  normal {}  shading normal {}\n", vertex.edge.distance,
                      digits_of(vertex.surface.geometric_normal), digits_of(vertex.surface.shading_normal));
  text += fmt::format("  bsdf: base {} metallic {:.4g} alpha {:.4g} ior {:.4g} transmission {:.4g}\n",
                      digits_of(bsdf.base_color), bsdf.metallic, bsdf.alpha.x, bsdf.ior, bsdf.transmission);
  const reference::VertexScattering& step = vertex.scattering;
  if (vertex.sample.is_valid)
    text += fmt::format("  step: {}{}, value {} pdf to light {:.7g} to camera {:.7g}\n",
                        step.is_delta ? "delta " : "",
                        vertex.sample.is_transmitted ? "transmission" : "reflection", digits_of(step.value),
                        step.reverse, step.forward);
  return text;
}

std::string describe_contribution(const reference::Contribution& found) {
  const reference::SampledPath& sampled = found.sampled;
  const reference::Technique* used = find_technique(found.techniques, sampled.technique, sampled.vertex);
  std::string text =
      fmt::format("path of {} edges by {}: contributes {} = weight {:.6g} times {}\n", sampled.path.length(),
                  name_of(*used), digits_of(found.value()), found.weight, digits_of(found.unweighted));
  for (const reference::Technique& technique : found.techniques)
    text +=
        fmt::format("    {:<14} n p {:>12.5g}  weight {:.6g}\n", name_of(technique),
                    static_cast<double>(technique.weight_density), mis_weight(found.techniques, technique));
  return text;
}

}  // namespace

std::string describe_path(const Subject& subject, uint32_t pixel, uint32_t sample,
                          const render::Recording& recording) {
  const reference::Settings& settings = subject.reference_settings;
  const reference::Estimator estimator(subject.world, subject.camera, settings);
  const auto walk = walk_from_camera(subject.world, subject.camera, settings, pixel, sample);
  const interface::Path& generated = recording.generated.front();
  std::string text = fmt::format("pixel {}, sample {}: film point ({:.6f}, {:.6f})\n", pixel, sample,
                                 walk.film.x, walk.film.y);
  text += fmt::format("  reference  origin {}  direction {}\n", digits_of(walk.ray.origin),
                      digits_of(walk.ray.direction));
  text += fmt::format("  device     origin {}  direction {}\n", digits_of(dvec3(generated.origin)),
                      digits_of(dvec3(generated.direction)));
  for (size_t i = 0; i < walk.vertices.size(); ++i)
    text += describe_vertex(subject, walk.vertices[i], i, recording);

  std::unique_ptr<reference::LightCache> cache;
  if (estimator.needs_light_subpaths()) {
    std::vector<reference::LightSubpath> subpaths(settings.paths_per_iteration());
    for (uint32_t i = 0; i < subpaths.size(); ++i)
      subpaths[i] = walk_from_light(subject.world, settings, i, sample);
    cache = std::make_unique<reference::LightCache>(estimator.light_cache(std::move(subpaths), sample));
  }
  dvec3 sum(0);
  estimator.camera_sample(pixel, sample, cache.get(), [&](const reference::Contribution& found) {
    text += describe_contribution(found);
    sum += found.value();
  });
  text += fmt::format("sum of the reference: {}\n", digits_of(sum));
  // The recorder walks without connections and merges: only then are its sums the same thing.
  if ((settings.techniques & (TECHNIQUE_CONNECT | TECHNIQUE_MERGE)) == 0)
    text += fmt::format("sum of the device:    {}\n", digits_of(dvec3(recording.bounces.back().radiance[0])));
  return text;
}

}  // namespace regulus::check

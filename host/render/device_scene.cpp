#include "render/device_scene.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "render/device_images.hpp"
#include "render/energy_tables.hpp"

namespace regulus::render {

namespace {

const scene::Environment NO_ENVIRONMENT;
const scene::LightTree NO_LIGHT_TREE;

const scene::Environment& environment_of(const scene::Scene& scene) {
  return scene.environment ? *scene.environment : NO_ENVIRONMENT;
}

const scene::LightTree& light_tree_of(const scene::Scene& scene, const Plan& plan) {
  return plan.light_sampling == interface::LIGHT_SAMPLING_BVH ? scene.light_tree : NO_LIGHT_TREE;
}

const scene::LightGuide NO_LIGHT_GUIDE;

const scene::LightGuide& light_guide_of(const Plan& plan) {
  return plan.light_guide ? *plan.light_guide : NO_LIGHT_GUIDE;
}

const scene::WalkGuide NO_WALK_GUIDE;

const scene::WalkGuide& walk_guide_of(const Plan& plan) {
  return plan.walk_guide ? *plan.walk_guide : NO_WALK_GUIDE;
}

const scene::Solids NO_SOLIDS;

const scene::Solids& solids_of(const scene::Scene& scene) {
  return scene.solids.has_contacts ? scene.solids : NO_SOLIDS;
}

gpu::Buffer energy_tables_of(gpu::Device& device, const PreparedScene& prepared, const Plan& plan) {
  const uint32_t bits = prepared.features.bits;
  const EnergyUses uses{
      .has_compensation = plan.has_energy_compensation && (bits & interface::FEATURE_ROUGH_SPECULAR) != 0,
      .has_rough_bases = !plan.has_energy_compensation && (bits & interface::FEATURE_ROUGH_BASE) != 0,
      .raises_lobes = (plan.regularization & interface::REGULARIZATION_ROUGHNESS) != 0};
  if (!uses.has_compensation && !uses.has_rough_bases && !uses.raises_lobes) return {};
  return make_energy_tables(device, prepared.scene.materials, plan, uses, prepared.scene.solids.has_contacts);
}

double mebibytes(uint64_t bytes) {
  return static_cast<double>(bytes) / (1 << 20);
}

template <typename T>
uint64_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

/// Returns the scene, or refuses it before anything is allocated.
const scene::Scene& require_memory(const gpu::Device& device, const PreparedScene& prepared) {
  const scene::Scene& scene = prepared.scene;
  const bvh::Bvh& bvh = prepared.bvh;
  const uint64_t textures = texture_bytes(scene);
  uint64_t bytes = textures + bytes_of(bvh.nodes) + bytes_of(bvh.triangles) + bytes_of(scene.vertices) +
                   bytes_of(scene.vertex_colors) + bytes_of(scene.vertex_uvs) +
                   bytes_of(scene.vertex_tangents) + bytes_of(scene.triangles) + bytes_of(scene.instances) +
                   bytes_of(scene.materials) + bytes_of(scene.lights);
  if (scene.environment) bytes += bytes_of(scene.environment->texels) + bytes_of(scene.environment->cdf);
  if (bytes > device.free_bytes())
    throw Error(ErrorCode::Failed,
                fmt::format("{}: the scene needs {:.1f} MiB of device memory, {:.1f} MiB of them for "
                            "textures, and {:.1f} MiB are free or allowed; make its textures smaller "
                            "or reduce it",
                            scene.path.string(), mebibytes(bytes), mebibytes(textures),
                            mebibytes(device.free_bytes())));
  return scene;
}

}  // namespace

DeviceScene::DeviceScene(gpu::Device& device, const PreparedScene& prepared, const Plan& plan, uint32_t rays)
    : DeviceScene(device, prepared, require_memory(device, prepared), plan, rays) {}

DeviceScene::DeviceScene(gpu::Device& device, const PreparedScene& prepared, const scene::Scene& scene,
                         const Plan& plan, uint32_t rays)
    : bvh_nodes_(rays == interface::RAYS_HARDWARE ? gpu::Buffer()
                                                  : gpu::upload_new(device, prepared.bvh.nodes, "bvh nodes")),
      bvh_triangles_(gpu::upload_new(device, prepared.bvh.triangles, "bvh triangles")),
      vertices_(gpu::upload_new(device, scene.vertices, "vertices")),
      vertex_colors_(gpu::upload_new(device, scene.vertex_colors, "vertex colours")),
      vertex_uvs_(gpu::upload_new(device, scene.vertex_uvs, "further texture coordinates")),
      vertex_tangents_(gpu::upload_new(device, scene.vertex_tangents, "vertex tangents")),
      triangles_(gpu::upload_new(device, scene.triangles, "triangles")),
      instances_(gpu::upload_new(device, scene.instances, "instances")),
      instance_blocks_(gpu::upload_new(device, scene.instance_blocks, "instance blocks")),
      materials_(gpu::upload_new(device, scene.materials, "materials")),
      lights_(gpu::upload_new(device, scene.lights, "lights")),
      light_aliases_(gpu::upload_new(device, scene.light_aliases, "light aliases")),
      light_pairs_(gpu::upload_new(device, light_tree_of(scene, plan).pairs, "light pairs")),
      light_trails_(gpu::upload_new(device, light_tree_of(scene, plan).trails, "light trails")),
      guided_lights_(gpu::upload_new(device, light_guide_of(plan).lights, "guided lights")),
      guided_light_aliases_(gpu::upload_new(device, light_guide_of(plan).aliases, "guided light aliases")),
      guide_nodes_(gpu::upload_new(device, light_guide_of(plan).nodes, "guide nodes")),
      walk_guide_nodes_(gpu::upload_new(device, walk_guide_of(plan).nodes, "nodes of the walk's guide")),
      environment_texels_(gpu::upload_new(device, environment_of(scene).texels, "environment texels")),
      environment_cdf_(gpu::upload_new(device, environment_of(scene).cdf, "environment distribution")),
      energy_tables_(energy_tables_of(device, prepared, plan)),
      sheen_table_(gpu::upload_new(device, prepared.sheen_table, "sheen table")),
      wavelengths_(gpu::upload_new(device, prepared.wavelengths, "wavelengths")),
      solids_(gpu::upload_new(device, solids_of(scene).records, "solids")),
      media_sets_(gpu::upload_new(device, solids_of(scene).media_sets, "media sets")),
      light_media_(gpu::upload_new(device, solids_of(scene).of_light, "media of lights")),
      environment_(environment_of(scene).parameters),
      light_tree_{interface::device_address(light_pairs_.address()),
                  interface::device_address(light_trails_.address()), scene.light_tree.center,
                  scene.light_tree.radius},
      light_count_(static_cast<uint32_t>(scene.lights.size())),
      vertex_uv_sets_(scene.vertex_uv_sets),
      stored_triangles_(static_cast<uint32_t>(scene.triangles.size())),
      instance_block_shift_(scene.instance_block_shift),
      center_(0.5f * (scene.bounds_min + scene.bounds_max)),
      radius_(0.5f * glm::length(scene.bounds_max - scene.bounds_min)),
      walk_guide_corner_(walk_guide_of(plan).corner),
      walk_guide_scale_(walk_guide_of(plan).scale),
      camera_media_(scene.solids.has_contacts ? scene.solids.of_camera.at(plan.camera) : 0),
      lens_medium_(scene.solids.has_contacts ? medium_of_lens(scene, plan.camera)
                                             : interface::INVALID_INDEX) {
  std::vector<interface::Texture> textures = scene.textures;
  images_ = upload_images(device, scene.images, device.info().max_allocation_bytes, textures);
  textures_ = gpu::upload_new(device, textures, "textures");
  if (rays == interface::RAYS_HARDWARE)
    structure_ = std::make_unique<SceneStructure>(device, prepared, vertices_);
}

void DeviceScene::fill(interface::Frame& frame) const {
  const auto address = [](const gpu::Buffer& buffer) { return interface::device_address(buffer.address()); };
  frame.bvh_nodes = address(bvh_nodes_);
  frame.bvh_triangles = address(bvh_triangles_);
  frame.vertices = address(vertices_);
  frame.vertex_colors = address(vertex_colors_);
  frame.vertex_uvs = address(vertex_uvs_);
  frame.vertex_uv_sets = vertex_uv_sets_;
  frame.vertex_tangents = address(vertex_tangents_);
  frame.triangles = address(triangles_);
  frame.instances = address(instances_);
  frame.instance_blocks = address(instance_blocks_);
  frame.stored_triangles = stored_triangles_;
  frame.instance_block_shift = instance_block_shift_;
  frame.materials = address(materials_);
  frame.textures = address(textures_);
  frame.lights = address(lights_);
  frame.light_aliases = address(light_aliases_);
  frame.light_tree = light_tree_;
  frame.guided_lights = address(guided_lights_);
  frame.guided_light_aliases = address(guided_light_aliases_);
  frame.guide_nodes = address(guide_nodes_);
  frame.walk_guide_nodes = address(walk_guide_nodes_);
  frame.walk_guide_corner = walk_guide_corner_;
  frame.walk_guide_scale = walk_guide_scale_;
  frame.environment_texels = address(environment_texels_);
  frame.environment_cdf = address(environment_cdf_);
  frame.energy_tables = address(energy_tables_);
  frame.sheen_table = address(sheen_table_);
  frame.wavelengths = address(wavelengths_);
  frame.solids = address(solids_);
  frame.media_sets = address(media_sets_);
  frame.light_media = address(light_media_);
  frame.camera_media = camera_media_;
  frame.lens_medium = lens_medium_;
  frame.environment = environment_;
  frame.light_count = light_count_;
  frame.scene_center = center_;
  frame.scene_radius = radius_;
  if (structure_) structure_->fill(frame);
}

}  // namespace regulus::render

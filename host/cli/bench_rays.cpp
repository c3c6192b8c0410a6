#include "cli/bench_rays.hpp"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include "base/error.hpp"

namespace regulus::cli {

namespace {

constexpr float RAY_LENGTH_MAX = 3.0e38f;

/// Calls work(begin, end) for pieces of [0, count) on all cores.
template <typename Work>
void for_all(size_t count, const Work& work) {
  constexpr size_t PIECE = 4096;
  std::atomic<size_t> next{0};
  const auto run = [&] {
    for (size_t begin = next.fetch_add(PIECE); begin < count; begin = next.fetch_add(PIECE))
      work(begin, std::min(begin + PIECE, count));
  };
  std::vector<std::jthread> threads;
  for (unsigned i = 1; i < std::thread::hardware_concurrency(); ++i) threads.emplace_back(run);
  run();
}

RTCRay embree_ray(const interface::BenchRay& ray) {
  RTCRay result{};
  result.org_x = ray.origin.x;
  result.org_y = ray.origin.y;
  result.org_z = ray.origin.z;
  result.dir_x = ray.direction.x;
  result.dir_y = ray.direction.y;
  result.dir_z = ray.direction.z;
  result.tfar = ray.t_max;
  result.mask = 0xFFFFFFFFu;
  return result;
}

/// A direction in the cosine distribution about a unit normal (Malley's method).
glm::vec3 cosine_direction(glm::vec3 normal, float u, float v) {
  const glm::vec3 helper = std::abs(normal.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 tangent = glm::normalize(glm::cross(normal, helper));
  const glm::vec3 bitangent = glm::cross(normal, tangent);
  const float phi = 2 * std::numbers::pi_v<float> * u;
  const glm::vec3 local(std::sqrt(v) * std::cos(phi), std::sqrt(v) * std::sin(phi), std::sqrt(1 - v));
  return glm::normalize(local.x * tangent + local.y * bitangent + local.z * normal);
}

std::vector<interface::BenchRay> primary_rays(const interface::Camera& camera, uint32_t width,
                                              uint32_t height) {
  std::vector<interface::BenchRay> rays;
  for (uint32_t y = 0; y < height; ++y) {
    for (uint32_t x = 0; x < width; ++x) {
      const glm::vec2 p = 2.0f * (glm::vec2(x, y) + 0.5f) / glm::vec2(width, height) - 1.0f;
      const glm::vec3 shift = p.x * camera.right - p.y * camera.up;
      const bool is_perspective = camera.kind == interface::CAMERA_PERSPECTIVE;
      rays.push_back({is_perspective ? camera.position : camera.position + shift, RAY_LENGTH_MAX,
                      is_perspective ? glm::normalize(camera.forward + shift) : camera.forward, 0});
    }
  }
  return rays;
}

}  // namespace

struct EmbreeScene::Impl {
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  ~Impl() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

EmbreeScene::EmbreeScene(std::span<const bvh::InputTriangle> triangles) : impl_(std::make_unique<Impl>()) {
  RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), 3 * triangles.size()));
  auto* indices = static_cast<uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), triangles.size()));
  if (vertices == nullptr || indices == nullptr)
    throw Error(ErrorCode::Failed, "bench: Embree is out of memory; use a smaller scene");
  for (size_t i = 0; i < triangles.size(); ++i)
    std::copy_n(triangles[i].vertices.begin(), 3, vertices + 3 * i);
  for (uint32_t i = 0; i < 3 * triangles.size(); ++i) indices[i] = i;
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(impl_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl_->scene);
}

EmbreeScene::~EmbreeScene() = default;

void EmbreeScene::trace_closest(std::span<const interface::BenchRay> rays,
                                std::span<interface::Hit> hits) const {
  for_all(rays.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRayHit query{};
      query.ray = embree_ray(rays[i]);
      query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(impl_->scene, &context, &query);
      const bool is_hit = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
      hits[i] = {query.ray.tfar, query.hit.u, query.hit.v,
                 is_hit ? query.hit.primID : interface::INVALID_INDEX};
    }
  });
}

void EmbreeScene::trace_any(std::span<const interface::BenchRay> rays, std::span<uint32_t> is_hit) const {
  for_all(rays.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRay ray = embree_ray(rays[i]);
      rtcOccluded1(impl_->scene, &context, &ray);
      is_hit[i] = ray.tfar < 0 ? 1 : 0;
    }
  });
}

BenchRays make_bench_rays(const BenchScene& scene, const EmbreeScene& embree, uint32_t width,
                          uint32_t height) {
  BenchRays rays;
  rays.primary = primary_rays(scene.camera, width, height);
  std::vector<interface::Hit> hits(rays.primary.size());
  embree.trace_closest(rays.primary, hits);
  std::mt19937 engine(1);
  std::uniform_real_distribution<float> uniform;
  for (size_t i = 0; i < hits.size(); ++i) {
    if (hits[i].triangle == interface::INVALID_INDEX) continue;
    const interface::BenchRay& ray = rays.primary[i];
    const auto& v = scene.triangles[hits[i].triangle].vertices;
    const glm::vec3 normal = glm::normalize(glm::cross(v[1] - v[0], v[2] - v[0]));
    const glm::vec3 facing = glm::dot(normal, ray.direction) < 0 ? normal : -normal;
    // Off the surface by far more than the rounding of the hit point.
    const glm::vec3 point = ray.origin + hits[i].t * ray.direction + 1e-4f * hits[i].t * facing;
    const float u = uniform(engine);
    rays.diffuse.push_back({point, RAY_LENGTH_MAX, cosine_direction(facing, u, uniform(engine)), 0});
    const glm::vec3 to_light = scene.light - point;
    const float distance = glm::length(to_light);
    rays.shadow.push_back({point, 0.999f * distance, to_light / distance, 0});
  }
  return rays;
}

}  // namespace regulus::cli

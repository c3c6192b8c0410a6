// No input may give a value that is not finite or a negative density: roughness from 0 through 1e-7 to 1,
// grazing and normal incidence, half vectors at the horizon, indices next to 1 and far from it, the critical
// angle. And pairs of directions keep reciprocity.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "kernels/bsdf_cases.hpp"

namespace regulus::test {
namespace {

using glm::vec3;
using namespace interface;

bool is_sound(float x) {
  return std::isfinite(x) && x >= 0;
}
bool is_sound(const vec3& v) {
  return is_sound(v.x) && is_sound(v.y) && is_sound(v.z);
}

std::string describe(const BsdfCase& c, const Model& model) {
  char text[320];
  std::snprintf(
      text, sizeof text,
      "%s: roughness %g ior %.9g metallic %g t %g flags %u front %u wo (%g %g %g) wi (%g %g %g) u %g %g %g",
      model.name().c_str(), c.material.roughness, c.material.ior, c.material.metallic,
      c.material.transmission, c.material.flags, c.is_front, c.wo.x, c.wo.y, c.wo.z, c.wi.x, c.wi.y, c.wi.z,
      c.u_lobe, c.u.x, c.u.y);
  return text;
}

TEST(BsdfRobustness, EverythingIsFinite) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  size_t evaluations = 0;
  size_t alive = 0;  // valid samples and values above 0: the test must not be about nothing
  int unsound = 0;
  for (uint32_t material_class = 0; material_class < MATERIAL_CLASS_COUNT; ++material_class) {
    const std::vector<BsdfCase> cases = extreme_cases(material_class);
    for (const Model& model : models_of_class(material_class)) {
      const auto evaluated = map_on_device<BsdfEvaluated>(create_kernel("bsdf_evaluate", model), cases);
      const auto sampled = map_on_device<BsdfSampled>(create_kernel("bsdf_sample", model), cases);
      evaluations += 2 * cases.size();
      for (size_t i = 0; i < cases.size(); ++i) {
        const BsdfEvaluated& e = evaluated[i];
        const BsdfSampled& s = sampled[i];
        const bool evaluation_ok = is_sound(e.value) && is_sound(e.pdf_forward) && is_sound(e.pdf_reverse);
        const bool is_valid = (s.flags & BSDF_SAMPLED_VALID) != 0;
        const bool sample_ok =
            !is_valid || (is_sound(s.weight) && is_sound(s.pdf_forward) && is_sound(s.pdf_reverse) &&
                          s.pdf_forward > 0 && std::abs(length(s.wi) - 1) < 1e-5f);
        alive += (is_valid ? 1 : 0) + (e.value.x > 0 ? 1 : 0);
        const bool below_ok = cases[i].wo.z > 0 || (e.value == vec3(0) && !is_valid);
        if (evaluation_ok && sample_ok && below_ok) continue;
        if (++unsound > 10) continue;
        ADD_FAILURE() << describe(cases[i], model) << "\n value " << e.value.x << " pdfs " << e.pdf_forward
                      << " " << e.pdf_reverse << " weight " << s.weight.x << " pdfs " << s.pdf_forward << " "
                      << s.pdf_reverse << " wi " << s.wi.x << " " << s.wi.y << " " << s.wi.z << " flags "
                      << s.flags;
      }
    }
  }
  std::printf("%zu evaluations and samples, %zu of them above zero, %d unsound (bound 0)\n", evaluations,
              alive, unsound);
  EXPECT_EQ(unsound, 0);
  EXPECT_GT(alive, evaluations / 3);
}

TEST(BsdfRobustness, ValuesAreReciprocalAndPdfsSwap) {
  // rho(o, i) n_i^2 = rho(i, o) n_o^2 for radiance; the pdfs change places. Both evaluations see the same
  // rounded directions, so only their own rounding differs: 2e-4, twice the accuracy bound.
  REGULUS_SKIP_WITHOUT_DEVICE();
  Random random(31);
  double worst = 0;
  for (const uint32_t material_class : {MATERIAL_CLASS_OPAQUE, MATERIAL_CLASS_TRANSMISSIVE})
    for (const Model& model : models_of_class(material_class)) {
      std::vector<BsdfCase> forward, backward;
      for (int i = 0; i < 1000; ++i) {
        const Kind kind = material_class == MATERIAL_CLASS_OPAQUE ? Kind::Plastic
                          : i % 2 == 0                            ? Kind::Thin
                                                                  : Kind::Solid;
        BsdfCase c{};
        c.material = random_material(kind, random);
        c.material.roughness = static_cast<float>(std::sqrt(random.uniform(0.1, 1)));
        c.alpha = vec3(-1);
        c.is_front = random.index(2);
        c.wo = random.direction();
        c.wo.z = std::abs(c.wo.z);
        c.wi = random.direction();
        if (material_class == MATERIAL_CLASS_OPAQUE) c.wi.z = std::abs(c.wi.z);
        BsdfCase swapped = c;
        const float side = c.wi.z < 0 ? -1.0f : 1.0f;
        swapped.wo = {c.wi.x, c.wi.y, side * c.wi.z};
        swapped.wi = {c.wo.x, c.wo.y, side * c.wo.z};
        swapped.is_front = c.wi.z < 0 ? 1 - c.is_front : c.is_front;
        forward.push_back(c);
        backward.push_back(swapped);
      }
      const gpu::Kernel kernel = create_kernel("bsdf_evaluate", model);
      const auto there = map_on_device<BsdfEvaluated>(kernel, forward);
      const auto back = map_on_device<BsdfEvaluated>(kernel, backward);
      for (size_t i = 0; i < forward.size(); ++i) {
        const BsdfCase& c = forward[i];
        const bool refracts = (c.material.flags & MATERIAL_VOLUME) != 0 && c.wi.z < 0;
        const float eta = c.is_front != 0 ? c.material.ior : 1 / c.material.ior;
        const double scale = refracts ? eta * eta : 1;
        const auto compare = [&](double a, double b) {
          const double error = std::abs(a - b) / std::max({std::abs(a), std::abs(b), 1e-6});
          worst = std::max(worst, error);
          EXPECT_LT(error, 2e-4) << describe(c, model);
        };
        compare(there[i].value.y * scale, back[i].value.y);
        compare(there[i].pdf_forward, back[i].pdf_reverse);
        compare(there[i].pdf_reverse, back[i].pdf_forward);
      }
    }
  std::printf("largest relative difference %.1e (bound 2e-4)\n", worst);
}

}  // namespace
}  // namespace regulus::test

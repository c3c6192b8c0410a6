// The device held against the scalar reference: for those who doubt a picture, and for research.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "regulus/render.hpp"

namespace regulus {

/// What is compared in one line of a check: a stage, whole paths, an image.
struct CheckLine {
  std::string name;        ///< such as "bsdf", "image by vcm"
  uint64_t items = 0;      ///< compared
  bool is_passed = false;  ///< the device is within the line's bound of the reference
  std::string text;        ///< errors, bound and classes of items, as `regulus check` prints them
};

/// Every stage, whole paths, connections, merges and images of a plan's settings on a device, each against
/// the scalar reference on the same data. Takes minutes for films of more than 10^4 pixels. A line that fails
/// does not end the check, but broken lists of light vertices leave out the lines that would read them.
/// @param on_line told of each line when it is known
std::vector<CheckLine> check_device(const Plan& plan, const Device& device,
                                    const std::function<void(const CheckLine&)>& on_line = {});

/// A vertex of a camera path. World space: metres, the file's frame. Directions are units.
struct TracedVertex {
  // Of the reference, in double precision:
  std::array<double, 3> position{};          ///< metres
  std::array<double, 3> geometric_normal{};  ///< of the triangle's front
  std::array<double, 3> shading_normal{};    ///< interpolated and mapped
  uint32_t triangle = 0;                     ///< index in the scene
  uint32_t material = 0;                     ///< index in the file
  std::array<double, 3> throughput{};        ///< on arrival
  std::array<double, 3> bsdf{};              ///< of the step that was sampled, 1/sr; 0 at the last vertex
  double pdf_to_light = 0;                   ///< of that step, 1/sr
  double pdf_to_camera = 0;                  ///< of the same step walked from the light, 1/sr
  bool is_delta = false;                     ///< a mirror's or clear glass's: pdfs are then its probability
  // Of the device, in single precision:
  bool is_on_device = false;                  ///< its path reaches this vertex, too
  std::array<double, 3> device_position{};    ///< as position
  std::array<double, 3> device_throughput{};  ///< as throughput
  uint32_t device_triangle = 0;               ///< as triangle
  double device_mis_a = 0;  ///< first accumulator of the weights, as the ray to here sets out
  double device_mis_b = 0;  ///< second accumulator (docs/mathematics.md 3)
};

/// One of the techniques that can find a path.
struct TracedTechnique {
  std::string name;    ///< such as "nee", "connect s=3"
  double density = 0;  ///< expected samples per unit of path measure, as weights compare it
  double weight = 0;   ///< of multiple importance sampling; those of a path sum to 1
};

/// A path that the reference found on its camera path, and what it is worth.
struct TracedContribution {
  std::string technique;                    ///< the one that found it
  uint32_t edges = 0;                       ///< of the path
  double weight = 0;                        ///< of multiple importance sampling
  std::array<double, 3> unweighted{};       ///< f / (n p), linear RGB; the contribution is weight times this
  std::vector<TracedTechnique> techniques;  ///< all that can find it
};

/// A camera path in full.
struct TracedPath {
  std::array<double, 2> film{};                   ///< pixels, from the top left
  std::array<double, 3> origin{};                 ///< of the ray from the camera, metres
  std::array<double, 3> direction{};              ///< of that ray
  std::array<double, 3> device_origin{};          ///< of the device's
  std::array<double, 3> device_direction{};       ///< likewise
  std::vector<TracedVertex> vertices;             ///< from the camera on
  std::vector<TracedContribution> contributions;  ///< of all techniques that end on this camera path
  std::array<double, 3> radiance{};               ///< sum of the reference's contributions
  std::array<double, 3> device_radiance{};        ///< of hits and light samples alone
};

/// Traces one sample of a pixel by both sides with the same random numbers.
/// @param x,y pixel of the film, from the top left
/// @throws Error (BadUsage) if there is no such pixel, or the device is the reference
TracedPath trace_path(const Plan& plan, const Device& device, uint32_t x, uint32_t y, uint32_t sample);

}  // namespace regulus

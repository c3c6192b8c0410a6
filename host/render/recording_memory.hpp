// What a watched render leaves in device memory.
#pragma once

#include <vector>

#include "render/film.hpp"
#include "render/wavefront.hpp"

namespace regulus::render {

/// A film's fixed-point sums as numbers.
inline std::vector<glm::dvec3> film_values(const std::vector<uint32_t>& words, int exponent) {
  std::vector<glm::dvec3> values(words.size() / interface::FILM_WORDS_PER_PIXEL, glm::dvec3(0));
  for (size_t i = 0; i < values.size(); ++i)
    for (int channel = 0; channel < 3; ++channel)
      values[i][channel] =
          film_sum(&words[i * interface::FILM_WORDS_PER_PIXEL + 3 * static_cast<size_t>(channel)], exponent);
  return values;
}

/// What a watched render leaves in device memory.
class RecordingMemory {
 public:
  RecordingMemory(Wavefront& wavefront, uint32_t paths) : wavefront_(wavefront), paths_(paths) {}

  const WavefrontBuffers& buffers() const { return wavefront_.buffers; }

  template <typename T>
  std::vector<T> download(const gpu::Buffer& buffer, size_t count, size_t first = 0) const {
    return gpu::download_all<T>(wavefront_.device, buffer, count, first * sizeof(T));
  }
  /// By path slot.
  template <typename T>
  std::vector<T> by_slot(const gpu::Buffer& buffer) const {
    return download<T>(buffer, paths_);
  }
  /// Empty without interface::FEATURE_CONTACTS.
  std::vector<interface::PathMedia> media(const gpu::Buffer& buffer, size_t count) const {
    return buffer.size() == 0 ? std::vector<interface::PathMedia>()
                              : download<interface::PathMedia>(buffer, count);
  }
  std::vector<interface::PathMedia> path_media() const { return media(buffers().path_media, paths_); }

  uint32_t queue_count(uint32_t bounce, Queue queue) const {
    const gpu::Buffer& heads = buffers().queue_heads;
    return download<interface::QueueHead>(heads, 1,
                                          QueueHeads::offset_of(bounce, queue) / sizeof(interface::QueueHead))
        .front()
        .count;
  }
  std::vector<uint32_t> ray_queue(uint32_t bounce) const {
    return download<uint32_t>(buffers().ray_queues, queue_count(bounce, Queue::Rays),
                              size_t{bounce & 1u} * buffers().frame().wave_capacity);
  }
  std::vector<interface::ConnectionPair> pairs(uint32_t bounce) const {
    std::vector<interface::ConnectionPair> all;
    for (uint32_t c = 0; c < interface::MATERIAL_CLASS_COUNT; ++c) {
      const auto own = download<interface::ConnectionPair>(
          buffers().pairs, queue_count(bounce, pair_queue(c)), size_t{c} * buffers().frame().pair_capacity);
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }
  /// By pixel of a film.
  std::vector<glm::dvec3> film(const gpu::Buffer& film) const {
    return film_values(download<uint32_t>(film, film.size() / sizeof(uint32_t)),
                       wavefront_.plan.features.film_exponents.radiance);
  }

  void fill(const gpu::Buffer& buffer, uint32_t word) const {
    wavefront_.work.room_for(1).fill(buffer, 0, buffer.size(), word);
    wavefront_.work.finish();
  }
  template <typename Values>
  void upload(const gpu::Buffer& buffer, const Values& values, uint64_t offset = 0) const {
    wavefront_.device.upload(buffer, offset, gpu::bytes_of(values));
  }

  /// Runs a stage of the camera pass over its queue once more.
  void run_again(Stage stage, const interface::StageArguments& arguments) const {
    for (const PipelineStep& entry : wavefront_.pipeline)
      if (entry.step.pass == Pass::Camera && entry.step.stage == stage)
        record_over_queue(wavefront_.work.room_for(1), entry, arguments, buffers().queue_heads);
    wavefront_.work.finish();
  }

 private:
  Wavefront& wavefront_;
  uint32_t paths_;
};

}  // namespace regulus::render

#include "gpu/pipeline_cache.hpp"

#include <fmt/format.h>
#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>

#include "base/process.hpp"
#include "gpu/limits.hpp"
#include "gpu/machine.hpp"

namespace regulus::gpu {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view EXTENSION = ".pipeline";
constexpr std::array<char, 8> MAGIC = {'R', 'G', 'L', 'S', 'P', 'I', 'P', '3'};

/// Stands in the file before the specialized module and the driver's data.
struct FileHeader {
  std::array<char, 8> magic = MAGIC;
  uint64_t key = 0;
  uint64_t spirv_words = 0;
  uint64_t data_bytes = 0;  ///< of both
  uint64_t data_hash = 0;   ///< with spirv_words
};

/// FNV-1a, 64 bit (Fowler, Noll, Vo).
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t hash = 0xcbf29ce484222325u) {
  for (std::byte b : bytes) hash = (hash ^ static_cast<uint64_t>(b)) * 0x100000001b3u;
  return hash;
}

/// A driver need not check what it is given, so the header that every driver's data begins with is checked
/// here.
bool is_from(const DriverIdentity& driver, std::span<const std::byte> data) {
  VkPipelineCacheHeaderVersionOne header;
  if (data.size() < sizeof(header)) return false;
  std::memcpy(&header, data.data(), sizeof(header));
  return header.headerSize >= sizeof(header) && header.headerSize <= data.size() &&
         header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE && header.vendorID == driver.vendor &&
         header.deviceID == driver.device &&
         std::equal(driver.cache_uuid.begin(), driver.cache_uuid.end(), header.pipelineCacheUUID);
}

std::vector<std::byte> read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) return {};
  std::vector<std::byte> bytes(static_cast<size_t>(std::max<std::streamoff>(file.tellg(), 0)));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file) return {};
  return bytes;
}

}  // namespace

uint64_t kernel_key(const DriverIdentity& driver, const KernelDescription& kernel) {
  uint64_t key = hash_bytes(bytes_of(driver));
  key = hash_bytes(std::as_bytes(kernel.spirv), key);
  for (const auto& [id, value] : kernel.constants) {
    key = hash_bytes(bytes_of(id), key);
    key = hash_bytes(bytes_of(value), key);
  }
  return key;
}

fs::path cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache && *cache) return fs::path(cache) / "regulus";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".cache" / "regulus";
  return {};
}

KernelCache find_kernel_cache() {
  KernelCache cache{.folder = cache_folder(), .most_kernels = CACHED_KERNELS};
  std::error_code error;
  for (fs::directory_iterator it(cache.folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() != EXTENSION) continue;
    std::error_code gone;
    const uint64_t bytes = it->file_size(gone);
    if (gone) continue;
    ++cache.kernels;
    cache.bytes += bytes;
  }
  return cache;
}

PipelineCacheFile::PipelineCacheFile(const fs::path& folder, const DriverIdentity& driver,
                                     const KernelDescription& kernel)
    : driver_(driver), key_(kernel_key(driver, kernel)) {
  if (!folder.empty()) path_ = folder / fmt::format("{:016x}{}", key_, EXTENSION);
}

CachedKernel PipelineCacheFile::load() const {
  if (path_.empty()) return {};
  const std::vector<std::byte> file = read_file(path_);
  FileHeader header;
  if (file.size() < sizeof(header)) return {};
  std::memcpy(&header, file.data(), sizeof(header));
  const std::span<const std::byte> data = std::span(file).subspan(sizeof(header));
  const bool is_whole = header.magic == MAGIC && header.key == key_ && header.data_bytes == data.size() &&
                        header.spirv_words <= data.size() / sizeof(uint32_t) &&
                        header.data_hash == hash_bytes(data, hash_bytes(bytes_of(header.spirv_words)));
  if (!is_whole) return {};
  const std::span<const std::byte> spirv = data.first(header.spirv_words * sizeof(uint32_t));
  const std::span<const std::byte> driver_data = data.subspan(spirv.size());
  if (!is_from(driver_, driver_data)) return {};
  CachedKernel kernel{std::vector<uint32_t>(header.spirv_words), {driver_data.begin(), driver_data.end()}};
  std::memcpy(kernel.spirv.data(), spirv.data(), spirv.size());
  return kernel;
}

void PipelineCacheFile::store(const CachedKernel& kernel) const {
  if (path_.empty()) return;
  std::error_code ignored;
  fs::create_directories(path_.parent_path(), ignored);
  const fs::path temporary = fmt::format("{}.{}", path_.string(), process_number());
  const auto spirv = std::as_bytes(std::span(kernel.spirv));
  std::vector<std::byte> data(spirv.begin(), spirv.end());
  data.insert(data.end(), kernel.driver_data.begin(), kernel.driver_data.end());
  const uint64_t words = kernel.spirv.size();
  const FileHeader header{.key = key_,
                          .spirv_words = words,
                          .data_bytes = data.size(),
                          .data_hash = hash_bytes(data, hash_bytes(bytes_of(words)))};
  std::ofstream file(temporary, std::ios::binary);
  file.write(reinterpret_cast<const char*>(&header), sizeof(header));
  file.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
  file.close();
  if (file)
    fs::rename(temporary, path_, ignored);
  else
    fs::remove(temporary, ignored);
}

void prune_cache(const fs::path& folder, size_t keep) {
  struct Entry {
    fs::file_time_type written;
    fs::path path;
  };
  std::vector<Entry> entries;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->path().extension() != EXTENSION) continue;
    std::error_code gone;
    const auto written = it->last_write_time(gone);
    if (!gone) entries.push_back({written, it->path()});
  }
  if (entries.size() <= keep) return;
  std::sort(entries.begin(), entries.end(), [](auto& a, auto& b) { return a.written < b.written; });
  entries.resize(entries.size() - keep);
  for (const Entry& entry : entries) fs::remove(entry.path, error);
}

}  // namespace regulus::gpu

// regulus doctor: whether this machine can render, and what would mend what is wrong.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/machine_memory.hpp"
#include "base/printable.hpp"
#include "base/standard_streams.hpp"
#include "base/version.hpp"
#include "cli/commands.hpp"
#include "gpu/gpu.hpp"
#include "gpu/machine.hpp"

namespace regulus::cli {

namespace {

namespace fs = std::filesystem;

constexpr double GIBIBYTE = 1 << 30;

/// Prints findings, and counts those that should be mended.
class Findings {
 public:
  void topic(const char* name) { say("{}\n", name); }
  void good(const std::string& text) { say("  good  {}\n", printable(text)); }
  void note(const std::string& text) { say("  note  {}\n", printable(text)); }
  void fault(const std::string& text, const std::string& remedy) {
    ++faults_;
    say("  FAULT {}\n        mend: {}\n", printable(text), printable(remedy));
  }
  int faults() const { return faults_; }

 private:
  int faults_ = 0;
};

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : value;
}

/// The non-empty entries of a list with colons.
std::vector<std::string> entries_of(const std::string& list) {
  std::vector<std::string> entries;
  std::istringstream stream(list);
  for (std::string entry; std::getline(stream, entry, ':');)
    if (!entry.empty()) entries.push_back(entry);
  return entries;
}

std::string shortened(const std::string& text) {
  constexpr size_t MOST = 120;
  return text.size() <= MOST ? text : text.substr(0, MOST) + "...";
}

/// What is wrong with a driver's manifest; empty: nothing that could be found without loading it.
std::string fault_of_manifest(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) return "cannot be read";
  const auto json = nlohmann::json::parse(stream, nullptr, false);
  const auto at = nlohmann::json::json_pointer("/ICD/library_path");
  if (!json.is_object() || !json.contains(at) || !json[at].is_string()) return "is no manifest of a driver";
  const fs::path library = json[at].get<std::string>();
  std::error_code error;
  if (library.has_parent_path() && !fs::exists(file.parent_path() / library, error))
    return fmt::format("names the library {}, which is not there", library.string());
  return {};
}

/// The manifests in a folder, or the file itself.
std::vector<fs::path> manifests_at(const fs::path& place) {
  std::vector<fs::path> found;
  std::error_code error;
  if (fs::is_directory(place, error)) {
    for (fs::directory_iterator it(place, error), end; !error && it != end; it.increment(error))
      if (it->path().extension() == ".json") found.push_back(it->path());
  } else if (fs::exists(place, error)) {
    found.push_back(place);
  }
  return found;
}

/// Where the Vulkan loader looks for drivers by itself (LoaderDriverInterface.md of Vulkan-Loader).
std::vector<fs::path> driver_folders() {
  const auto or_else = [](const std::string& value, const std::string& other) {
    return value.empty() ? other : value;
  };
  const std::string home = variable("HOME");
  std::vector<std::string> roots;
  const auto add = [&](const std::string& list) {
    for (const std::string& entry : entries_of(list)) roots.push_back(entry);
  };
  add(or_else(variable("XDG_CONFIG_HOME"), home + "/.config"));
  add(or_else(variable("XDG_CONFIG_DIRS"), "/etc/xdg"));
  add("/etc");
  add(or_else(variable("XDG_DATA_HOME"), home + "/.local/share"));
  add(or_else(variable("XDG_DATA_DIRS"), "/usr/local/share:/usr/share"));
  std::vector<fs::path> folders;
  folders.reserve(roots.size());
  for (const std::string& root : roots) folders.push_back(fs::path(root) / "vulkan/icd.d");
  return folders;
}

size_t look_at_manifests(Findings& findings) {
  const char* by = "VK_DRIVER_FILES";
  std::vector<std::string> named = entries_of(variable(by));
  if (named.empty()) named = entries_of(variable(by = "VK_ICD_FILENAMES"));
  std::vector<fs::path> places(named.begin(), named.end());
  if (places.empty()) {
    places = driver_folders();
    for (const std::string& more : entries_of(variable("VK_ADD_DRIVER_FILES"))) places.emplace_back(more);
  }
  size_t count = 0;
  for (const fs::path& place : places) {
    const std::vector<fs::path> found = manifests_at(place);
    if (found.empty() && !named.empty())
      findings.fault(
          fmt::format("{} names {}, which is not there", by, shortened(place.string())),
          fmt::format("unset {}, or name the manifest of a driver, as in /usr/share/vulkan/icd.d", by));
    for (const fs::path& file : found) {
      const std::string fault = fault_of_manifest(file);
      if (fault.empty()) {
        ++count;
        findings.good(fmt::format("driver {}", file.string()));
      } else {
        findings.fault(fmt::format("{} {}", file.string(), fault),
                       "install that driver again, or remove the file");
      }
    }
  }
  return count;
}

void look_at_device(const gpu::DeviceInfo& device, Findings& findings) {
  const std::string title = fmt::format("device {}: {} ({})", device.index, device.name, device.driver);
  if (!device.usable()) {
    findings.note(
        fmt::format("{} cannot be used: {}; a newer driver may", title, fmt::join(device.missing, "; ")));
    return;
  }
  findings.good(title);
  findings.good(fmt::format(
      "  Vulkan {}.{}.{}, subgroups of {}, {:.1f} GiB of memory, at most {:.1f} GiB at once, "
      "64-bit integers: {}, times of stages: {}",
      device.api_version >> 22 & 0x7F, device.api_version >> 12 & 0x3FF, device.api_version & 0xFFF,
      device.subgroup_size, static_cast<double>(device.heap_bytes) / GIBIBYTE,
      static_cast<double>(device.max_allocation_bytes) / GIBIBYTE, device.has_int64 ? "yes" : "no",
      device.timestamp_ns > 0 ? "yes" : "no"));
}

/// A card that is there but may not be opened, or has no driver for Vulkan.
void look_at_cards(const std::vector<gpu::DeviceInfo>& devices, Findings& findings) {
  std::error_code error;
  bool has_card = fs::exists("/dev/nvidia0", error);
  for (fs::directory_iterator it("/dev/dri", error), end; !error && it != end; it.increment(error)) {
    if (!it->path().filename().string().starts_with("renderD")) continue;
    has_card = true;
    if (!std::ifstream(it->path()))
      findings.fault(fmt::format("{} may not be opened by this user", it->path().string()),
                     "add the user to the group render, and log in again");
  }
  const bool is_used = std::ranges::any_of(devices, [](const gpu::DeviceInfo& device) {
    return device.usable() && device.kind != gpu::DeviceKind::Software;
  });
  if (has_card && !is_used)
    findings.note(
        "there is a graphics card, but no driver that can use it; rendering is done by the processor");
}

/// Whether there is a device to render with.
bool look_at_vulkan(Findings& findings) {
  findings.topic("Vulkan");
  if (!gpu::has_vulkan_loader()) {
    findings.fault("there is no Vulkan loader (libvulkan.so.1)", "install it (Debian: libvulkan1)");
    return false;
  }
  const size_t manifests = look_at_manifests(findings);
  const std::vector<gpu::DeviceInfo> devices = gpu::list_devices();
  for (const gpu::DeviceInfo& device : devices) look_at_device(device, findings);
  look_at_cards(devices, findings);
  if (std::ranges::any_of(devices, &gpu::DeviceInfo::usable)) return true;
  findings.fault(manifests == 0 ? "no driver is installed" : "no device can be used",
                 "install the driver of the graphics card, or one that renders on the processor (Debian: "
                 "mesa-vulkan-drivers); until then --backend reference works without");
  return false;
}

/// The folder, or of one that does not exist yet the nearest above it that does.
fs::path existing_part(fs::path folder) {
  std::error_code error;
  while (!fs::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

void look_at_cache(Findings& findings) {
  findings.topic("Cache of compiled kernels");
  const gpu::KernelCache cache = gpu::find_kernel_cache();
  if (cache.folder.empty()) {
    findings.fault("there is no place for it, so every render compiles its kernels",
                   "set HOME or XDG_CACHE_HOME");
    return;
  }
  const std::string folder = shortened(cache.folder.string());
  const fs::path existing = existing_part(cache.folder);
  try {
    require_writable(existing / "regulus-doctor");
  } catch (const Error& error) {
    findings.fault(fmt::format("{} cannot be written, so every render compiles its kernels: {}", folder,
                               shortened(error.what())),
                   "make the folder writable, or set XDG_CACHE_HOME to one that is");
    return;
  }
  findings.good(existing == cache.folder
                    ? fmt::format("{}: {} kernels of at most {}, {:.1f} MiB", folder, cache.kernels,
                                  cache.most_kernels, static_cast<double>(cache.bytes) / (1 << 20))
                    : fmt::format("{}: empty; the first render makes it", folder));
  std::error_code error;
  const fs::space_info space = fs::space(existing, error);
  constexpr uint64_t LEAST_FREE = uint64_t{64} << 20;
  if (!error && space.available < LEAST_FREE)
    findings.fault(fmt::format("{}: only {:.1f} MiB are free on that disk", folder,
                               static_cast<double>(space.available) / (1 << 20)),
                   "make room there, or set XDG_CACHE_HOME to another disk");
}

/// A variable that changes what the driver or this program does.
struct Influence {
  const char* name;
  const char* effect;
};

constexpr Influence INFLUENCES[] = {
    {"VK_DRIVER_FILES", "only these drivers are used"},
    {"VK_ICD_FILENAMES", "only these drivers are used, unless VK_DRIVER_FILES is set"},
    {"VK_ADD_DRIVER_FILES", "more drivers are used"},
    {"VK_LOADER_DRIVERS_SELECT", "only some drivers are used"},
    {"VK_LOADER_DRIVERS_DISABLE", "some drivers are not used"},
    {"VK_INSTANCE_LAYERS", "layers stand between Regulus and the driver; those that validate are slow"},
    {"VK_LOADER_LAYERS_ENABLE", "layers stand between Regulus and the driver; those that validate are slow"},
    {"MESA_VK_DEVICE_SELECT", "Mesa puts another device first"},
    {"MESA_SHADER_CACHE_DISABLE", "Mesa compiles kernels anew"},
    {"MESA_SHADER_CACHE_DIR", "Mesa's own cache lies there"},
    {"LP_NUM_THREADS", "lavapipe uses that many threads; 0 is the calling one alone"},
    {"LP_NATIVE_VECTOR_WIDTH",
     "lavapipe works with vectors of that many bits; its cache does not tell them apart"},
    {"LP_DEBUG", "lavapipe's ways of debugging are slow"},
    {"GALLIVM_DEBUG", "lavapipe's ways of debugging are slow"},
    {"GALLIVM_PERF", "lavapipe compiles otherwise, with other rounding"},
    {"LD_PRELOAD", "libraries are put before those that Regulus was built with"},
    {"LD_LIBRARY_PATH", "libraries are looked for there first"},
};

void look_at_environment(Findings& findings) {
  findings.topic("Environment");
  bool is_plain = true;
  for (const auto& [name, effect] : INFLUENCES) {
    const std::string value = variable(name);
    if (value.empty()) continue;
    is_plain = false;
    findings.note(fmt::format("{}={}: {}", name, shortened(value), effect));
  }
  if (const std::string cache = variable("XDG_CACHE_HOME"); !cache.empty() && fs::path(cache).is_relative())
    findings.fault(fmt::format("XDG_CACHE_HOME={} depends on the folder one is in", shortened(cache)),
                   "give the whole path");
  std::error_code error;
  const std::string temporary = variable("TMPDIR");
  if (!temporary.empty() && !fs::is_directory(temporary, error))
    findings.fault(fmt::format("TMPDIR={} is no folder: what cannot be written where it should be is lost",
                               shortened(temporary)),
                   "make it, or unset TMPDIR");
  if (is_plain) findings.good("nothing that changes what a driver does");
}

void look_at_machine(Findings& findings) {
  findings.topic("Machine");
  findings.good(fmt::format("{} cores, {:.1f} GiB of memory, of which a scene may take {:.1f} (--memory)",
                            std::thread::hardware_concurrency(),
                            static_cast<double>(machine_memory_bytes()) / GIBIBYTE,
                            static_cast<double>(default_memory_bytes()) / GIBIBYTE));
}

void examine() {
  Findings findings;
  say("regulus {} (commit {}, {}, {})\n", VERSION, COMMIT, COMPILER, BUILD_TYPE);
  const bool can_render = look_at_vulkan(findings);
  look_at_cache(findings);
  look_at_environment(findings);
  look_at_machine(findings);
  if (!can_render)
    throw Error(ErrorCode::NoDevice, "no device can be used; what would mend that stands above");
  if (findings.faults() != 0)
    throw Error(ErrorCode::Failed,
                fmt::format("rendering works, with {} {} to mend (above)", findings.faults(),
                            findings.faults() == 1 ? "fault" : "faults"));
  say("Rendering works.\n");
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  app.add_subcommand("doctor",
                     "What this machine renders with: drivers, limits, cache; and how to mend what is wrong")
      ->callback(examine);
}

}  // namespace regulus::cli

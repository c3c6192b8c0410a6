#include "gpu/selection.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>

#include "base/error.hpp"
#include "gpu/limits.hpp"

namespace regulus::gpu {
namespace {

std::string lower_case(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return lower;
}

std::string describe(const DeviceInfo& device) {
  std::string text = fmt::format("{}: {}", device.index, device.name);
  if (!device.usable()) text += fmt::format(" (lacks {})", fmt::join(device.missing, ", "));
  return text;
}

std::string describe_all(std::span<const DeviceInfo> devices) {
  std::vector<std::string> lines;
  for (const DeviceInfo& device : devices) lines.push_back(describe(device));
  return fmt::format("{}", fmt::join(lines, "; "));
}

[[noreturn]] void fail(const std::string& message) {
  throw Error(ErrorCode::NoDevice, message);
}

/// The digits behind "uuid:", without dashes; empty if the text does not begin so.
std::string uuid_of(std::string_view text) {
  constexpr std::string_view PREFIX = "uuid:";
  if (!text.starts_with(PREFIX)) return {};
  std::string digits(text.substr(PREFIX.size()));
  std::erase(digits, '-');
  return digits.empty() ? "none" : digits;
}

/// The positions that `select` can mean. A number is an index if there is a device of that index, otherwise
/// it is looked for in the names ("3090").
std::vector<size_t> matches(std::span<const DeviceInfo> devices, std::string_view select) {
  size_t index = 0;
  const auto [end, status] = std::from_chars(select.data(), select.data() + select.size(), index);
  const bool is_number = status == std::errc() && end == select.data() + select.size();
  if (is_number && index < devices.size()) return {index};

  std::vector<size_t> found;
  const std::string wanted = lower_case(select);
  const std::string uuid = uuid_of(wanted);
  for (size_t i = 0; i < devices.size(); ++i)
    if (uuid.empty() ? lower_case(devices[i].name).find(wanted) != std::string::npos
                     : devices[i].uuid == uuid)
      found.push_back(i);
  return found;
}

}  // namespace

int preference(DeviceKind kind) {
  switch (kind) {
    case DeviceKind::Discrete:
      return 0;
    case DeviceKind::Integrated:
      return 1;
    case DeviceKind::Virtual:
      return 2;
    case DeviceKind::Other:
      return 3;
    case DeviceKind::Software:
      return 4;
  }
  return 3;
}

size_t select_device(std::span<const DeviceInfo> devices, std::string_view select) {
  if (devices.empty())
    fail("no Vulkan device: install a Vulkan driver (on Debian: mesa-vulkan-drivers, libvulkan1)");

  if (select.empty()) {
    const auto usable = std::find_if(devices.begin(), devices.end(), [](auto& d) { return d.usable(); });
    if (usable == devices.end()) fail("no usable Vulkan device; there is " + describe_all(devices));
    return static_cast<size_t>(usable - devices.begin());
  }

  const std::vector<size_t> found = matches(devices, select);
  if (found.empty())
    fail(fmt::format("device {}: no such device; there is {}", select, describe_all(devices)));
  if (found.size() > 1)
    fail(fmt::format("device {}: more than one device has this name, give the index or uuid; there is {}",
                     select, describe_all(devices)));
  const DeviceInfo& chosen = devices[found.front()];
  if (!chosen.usable())
    fail(fmt::format("device {}: {} cannot be used, it lacks {}", select, chosen.name,
                     fmt::join(chosen.missing, ", ")));
  return found.front();
}

std::vector<size_t> select_devices(std::span<const DeviceInfo> devices, std::string_view select) {
  std::vector<size_t> chosen;
  if (select == "all") {
    for (size_t i = 0; i < devices.size(); ++i)
      if (devices[i].usable()) chosen.push_back(i);
    if (chosen.empty()) chosen.push_back(select_device(devices, ""));  // says why there is none
    return chosen;
  }
  if (matches(devices, select).size() == 1) return {select_device(devices, select)};
  for (size_t begin = 0; begin <= select.size();) {
    const size_t end = std::min(select.find(',', begin), select.size());
    const std::string_view one = select.substr(begin, end - begin);
    if (one.empty())
      fail(fmt::format("device {}: an empty name; there is {}", select, describe_all(devices)));
    chosen.push_back(select_device(devices, one));
    if (std::ranges::count(chosen, chosen.back()) > 1)
      fail(fmt::format("device {}: {} is given twice", select, devices[chosen.back()].name));
    begin = end + 1;
  }
  return chosen;
}

std::string lost_message(const std::string& device, std::span<const std::string> stages, int completed) {
  const auto count = static_cast<int>(stages.size());
  std::string when;
  if (stages.empty()) {
    when = "while copying memory";
  } else if (completed >= count) {
    when = fmt::format("after stage {}", stages.back());
  } else if (completed >= 0) {
    when = fmt::format("while running stage {}", stages[static_cast<size_t>(completed)]);
  } else {
    std::vector<std::string> distinct;
    for (const std::string& stage : stages)
      if (std::find(distinct.begin(), distinct.end(), stage) == distinct.end()) distinct.push_back(stage);
    when = fmt::format("while running stage {}", fmt::join(distinct, " or "));
  }
  return fmt::format("device {} lost {}; try another one or a newer driver", device, when);
}

std::vector<const char*> extensions_to_enable(std::span<const std::string> has, bool with_statistics,
                                              bool with_ray_queries) {
  std::vector<const char*> wanted = {"VK_EXT_memory_budget", "VK_KHR_portability_subset"};
  if (with_statistics) wanted.push_back("VK_KHR_pipeline_executable_properties");
  if (with_ray_queries) wanted.insert(wanted.end(), RAY_QUERY_EXTENSIONS.begin(), RAY_QUERY_EXTENSIONS.end());
  std::erase_if(wanted, [&](const char* name) { return std::ranges::find(has, name) == has.end(); });
  return wanted;
}

}  // namespace regulus::gpu

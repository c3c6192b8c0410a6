// Device choice and the wording of device loss: pure functions, no Vulkan needed.
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "gpu/selection.hpp"

namespace regulus::gpu {
namespace {

DeviceInfo device(uint32_t index, std::string name, DeviceKind kind, std::vector<std::string> missing = {}) {
  DeviceInfo info;
  info.index = index;
  info.name = std::move(name);
  info.kind = kind;
  info.missing = std::move(missing);
  return info;
}

const std::vector<DeviceInfo> machine = {
    device(0, "Old Card 3090", DeviceKind::Discrete, {"scalarBlockLayout", "limit maxFoo is 1, needs 2"}),
    device(1, "Radeon Alpha", DeviceKind::Discrete),
    device(2, "Radeon Beta", DeviceKind::Integrated),
    device(3, "llvmpipe", DeviceKind::Software),
};

/// The message of the Error (NoDevice) that choosing throws; empty if it throws none.
std::string complaint(std::span<const DeviceInfo> devices, std::string_view select) {
  try {
    select_device(devices, select);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::NoDevice);
    return error.what();
  }
  return {};
}

bool contains(const std::string& text, std::string_view part) {
  return text.find(part) != std::string::npos;
}

TEST(GpuSelection, KindsArePreferredInTheOrderOfTheirSpeed) {
  EXPECT_LT(preference(DeviceKind::Discrete), preference(DeviceKind::Integrated));
  EXPECT_LT(preference(DeviceKind::Integrated), preference(DeviceKind::Virtual));
  EXPECT_LT(preference(DeviceKind::Virtual), preference(DeviceKind::Other));
  EXPECT_LT(preference(DeviceKind::Other), preference(DeviceKind::Software));
}

TEST(GpuSelection, EmptyChoiceIsTheFirstUsableDevice) {
  EXPECT_EQ(select_device(machine, ""), 1u);
}

TEST(GpuSelection, ChoosesByIndex) {
  for (const char* index : {"1", "2", "3"}) EXPECT_EQ(select_device(machine, index), size_t(index[0] - '0'));
}

TEST(GpuSelection, ChoosesByPartOfTheNameInAnyCase) {
  EXPECT_EQ(select_device(machine, "bETa"), 2u);
  EXPECT_EQ(select_device(machine, "PIPE"), 3u);
}

TEST(GpuSelection, NumberBeyondTheListIsLookedForInNames) {
  EXPECT_TRUE(contains(complaint(machine, "3090"), "cannot be used"));
}

TEST(GpuSelection, UnknownChoiceListsAllDevices) {
  for (const char* unknown : {"geforce", "4", "-1"}) {
    const std::string message = complaint(machine, unknown);
    EXPECT_TRUE(contains(message, std::string("device ") + unknown)) << message;
    for (const DeviceInfo& info : machine) EXPECT_TRUE(contains(message, info.name)) << message;
  }
}

TEST(GpuSelection, AmbiguousChoiceAsksForTheIndex) {
  EXPECT_TRUE(contains(complaint(machine, "radeon"), "more than one"));
}

TEST(GpuSelection, ChoosesAmongEqualNamesByUuid) {
  std::vector<DeviceInfo> equal = {device(0, "Card", DeviceKind::Discrete),
                                   device(1, "Card", DeviceKind::Discrete)};
  equal[0].uuid = "00112233445566778899aabbccddeeff";
  equal[1].uuid = "00112233445566778899aabbccddee00";
  EXPECT_EQ(select_device(equal, "uuid:00112233445566778899aabbccddee00"), 1u);
  EXPECT_EQ(select_device(equal, "UUID:00112233-4455-6677-8899-AABBCCDDEEFF"), 0u);
  EXPECT_TRUE(contains(complaint(equal, "uuid:0011"), "no such device"));
  EXPECT_TRUE(contains(complaint(equal, "uuid:"), "no such device"));
  EXPECT_TRUE(contains(complaint(equal, "card"), "uuid"));
}

TEST(GpuSelection, ListsChooseSeveral) {
  using Places = std::vector<size_t>;
  EXPECT_EQ(select_devices(machine, "all"), (Places{1, 2, 3}));  // 0 cannot be used
  EXPECT_EQ(select_devices(machine, "3,beta"), (Places{3, 2}));
  EXPECT_EQ(select_devices(machine, "pipe"), Places{3});
  const std::vector<DeviceInfo> with_comma = {
      device(0, "llvmpipe (LLVM 15, 256 bits)", DeviceKind::Software)};
  EXPECT_EQ(select_devices(with_comma, "LLVM 15, 256"), Places{0});
  for (const auto& [list, mention] :
       {std::pair("1,1", "twice"), std::pair("1,,2", "empty"), std::pair("1,7", "no such device"),
        std::pair("1,0", "scalarBlockLayout")})
    try {
      select_devices(machine, list);
      ADD_FAILURE() << list;
    } catch (const Error& error) {
      EXPECT_TRUE(contains(error.what(), mention)) << error.what();
    }
}

TEST(GpuExtensions, AreThoseThatTheDeviceHas) {
  const auto enabled = [](const std::vector<std::string>& has, bool statistics, bool ray_queries) {
    const std::vector<const char*> names = extensions_to_enable(has, statistics, ray_queries);
    return std::vector<std::string>(names.begin(), names.end());
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(enabled({}, true, false), Names());
  // A layered driver refuses to be opened without.
  EXPECT_EQ(enabled({"VK_KHR_x", "VK_KHR_portability_subset"}, false, false),
            Names{"VK_KHR_portability_subset"});
  const Names all = {"VK_EXT_memory_budget", "VK_KHR_pipeline_executable_properties", "VK_KHR_ray_query",
                     "VK_KHR_acceleration_structure", "VK_KHR_deferred_host_operations"};
  EXPECT_EQ(enabled(all, true, true), all);
  EXPECT_EQ(enabled(all, false, false), Names{"VK_EXT_memory_budget"});
}

TEST(GpuSelection, UnusableDeviceIsRefusedWithWhatItLacks) {
  const std::string message = complaint(machine, "0");
  EXPECT_TRUE(contains(message, "scalarBlockLayout, limit maxFoo is 1, needs 2")) << message;
}

TEST(GpuSelection, NoUsableDeviceSaysWhatEachLacks) {
  const std::string message = complaint(std::span(machine).first(1), "");
  EXPECT_TRUE(contains(message, "no usable")) << message;
  EXPECT_TRUE(contains(message, "scalarBlockLayout")) << message;
}

TEST(GpuSelection, NoDeviceAtAllIsAnError) {
  EXPECT_TRUE(contains(complaint({}, ""), "no Vulkan device"));
}

TEST(GpuDeviceLoss, NamesTheStageThatRan) {
  const std::vector<std::string> stages = {"camera_generate", "trace_closest", "trace_closest"};
  EXPECT_TRUE(contains(lost_message("X", stages, 1), "device X lost while running stage trace_closest;"));
  EXPECT_TRUE(contains(lost_message("X", stages, 0), "while running stage camera_generate;"));
  EXPECT_TRUE(contains(lost_message("X", stages, 3), "after stage trace_closest;"));
}

TEST(GpuDeviceLoss, NamesEachPossibleStageOnceIfTheOneIsUnknown) {
  const std::vector<std::string> stages = {"camera_generate", "trace_closest", "trace_closest"};
  EXPECT_TRUE(contains(lost_message("X", stages, -1), "running stage camera_generate or trace_closest;"));
  EXPECT_TRUE(contains(lost_message("X", {}, -1), "while copying memory"));
}

}  // namespace
}  // namespace regulus::gpu

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

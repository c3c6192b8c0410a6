// `regulus bench kernels`: how many rays per second the traversal kernels trace, beside Embree on the same
// rays.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace regulus::cli {

struct BenchKernelsOptions {
  std::vector<std::filesystem::path> scenes;  ///< glTF files, besides the procedural scenes
  std::filesystem::path json;                 ///< results as a JSON array; empty: none
  std::string device;                         ///< as gpu::DeviceOptions::select
  uint32_t repeats = 7;                       ///< measurements of each query; their median counts
};

/// Measures, prints a table and writes the JSON file.
/// @returns 0. @throws regulus::Error
int run_bench_kernels(const BenchKernelsOptions& options);

/// Registers `bench` with its suites.
void add_bench_command(CLI::App& app);

}  // namespace regulus::cli

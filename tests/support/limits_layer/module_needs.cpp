#include "module_needs.hpp"

#include <map>

namespace regulus::test {

namespace {

// Numbers of the SPIR-V specification, section 3.
enum Operation : uint32_t {
  OP_EXECUTION_MODE = 16,
  OP_CAPABILITY = 17,
  OP_TYPE_BOOL = 20,
  OP_TYPE_INT = 21,
  OP_TYPE_FLOAT = 22,
  OP_TYPE_VECTOR = 23,
  OP_TYPE_MATRIX = 24,
  OP_TYPE_ARRAY = 28,
  OP_TYPE_STRUCT = 30,
  OP_TYPE_POINTER = 32,
  OP_CONSTANT = 43,
  OP_SPEC_CONSTANT = 50,
  OP_VARIABLE = 59,
};
constexpr uint32_t HEADER_WORDS = 5, CAPABILITY_INT64 = 11, CAPABILITY_INT64_ATOMICS = 12,
                   MODE_LOCAL_SIZE = 17, CLASS_WORKGROUP = 4;

class Reader {
 public:
  void read(uint32_t operation, std::span<const uint32_t> words) {
    switch (operation) {
      case OP_CAPABILITY:
        needs_.int64 |= words[0] == CAPABILITY_INT64 || words[0] == CAPABILITY_INT64_ATOMICS;
        break;
      case OP_EXECUTION_MODE:
        if (words[1] == MODE_LOCAL_SIZE) needs_.workgroup_size = uint64_t{words[2]} * words[3] * words[4];
        break;
      case OP_TYPE_BOOL:
        bytes_[words[0]] = 4;
        break;
      case OP_TYPE_INT:
      case OP_TYPE_FLOAT:
        bytes_[words[0]] = words[1] / 8;
        break;
      case OP_TYPE_VECTOR:
      case OP_TYPE_MATRIX:
        bytes_[words[0]] = bytes_[words[1]] * words[2];
        break;
      case OP_TYPE_ARRAY:
        bytes_[words[0]] = bytes_[words[1]] * constants_[words[2]];
        break;
      case OP_TYPE_STRUCT:
        for (const uint32_t member : words.subspan(1)) bytes_[words[0]] += bytes_[member];
        break;
      case OP_TYPE_POINTER:
        bytes_of_target_[words[0]] = bytes_[words[2]];
        break;
      case OP_CONSTANT:
      case OP_SPEC_CONSTANT:
        constants_[words[1]] = words[2];
        break;
      case OP_VARIABLE:
        if (words[2] == CLASS_WORKGROUP) needs_.shared_bytes += bytes_of_target_[words[0]];
        break;
      default:
        break;
    }
  }
  const ModuleNeeds& needs() const { return needs_; }

 private:
  ModuleNeeds needs_;
  std::map<uint32_t, uint64_t> bytes_, bytes_of_target_, constants_;
};

}  // namespace

ModuleNeeds needs_of(std::span<const uint32_t> module) {
  Reader reader;
  for (size_t at = HEADER_WORDS; at < module.size();) {
    const uint32_t count = module[at] >> 16;
    if (count == 0 || at + count > module.size()) break;
    reader.read(module[at] & 0xFFFF, module.subspan(at + 1, count - 1));
    at += count;
  }
  return reader.needs();
}

}  // namespace regulus::test

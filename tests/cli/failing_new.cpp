// Linked into regulus, makes a program that gets no memory when the environment says so: of the calls of
// operator new for at least REGULUS_TEST_LEAST_BYTES, that number REGULUS_TEST_FAILING_ALLOCATION fails.
// Their number is written to the file REGULUS_TEST_COUNT_ALLOCATIONS.
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <new>

namespace {

std::atomic<unsigned long> allocations{0};

unsigned long number_of(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? 0 : std::strtoul(text, nullptr, 10);
}

bool is_to_fail(std::size_t size) {
  static const unsigned long least_bytes = number_of("REGULUS_TEST_LEAST_BYTES");
  static const unsigned long failing = number_of("REGULUS_TEST_FAILING_ALLOCATION");
  return size >= least_bytes && ++allocations == failing;
}

void write_count() {
  std::FILE* file = std::fopen(std::getenv("REGULUS_TEST_COUNT_ALLOCATIONS"), "w");
  if (file == nullptr) return;
  std::fprintf(file, "%lu\n", allocations.load());
  std::fclose(file);
}

const bool is_counting =
    std::getenv("REGULUS_TEST_COUNT_ALLOCATIONS") != nullptr && std::atexit(write_count) == 0;

}  // namespace

void* operator new(std::size_t size) {
  void* memory = is_to_fail(size) ? nullptr : std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void* operator new[](std::size_t size) {
  return operator new(size);
}

void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

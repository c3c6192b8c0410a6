// Linked into regulus, makes a program on whose disk there is little room: while REGULUS_TEST_DISK/full
// exists, files below the folder REGULUS_TEST_DISK hold at most REGULUS_TEST_DISK_ROOM bytes each. Takes the
// place of the C library's write().
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

/// How many bytes the file of a descriptor may still take.
size_t room_of(int fd) {
  const char* disk = std::getenv("REGULUS_TEST_DISK");
  const char* room = std::getenv("REGULUS_TEST_DISK_ROOM");
  if (disk == nullptr || room == nullptr) return SIZE_MAX;
  char name[PATH_MAX];
  const ssize_t length = readlink(("/proc/self/fd/" + std::to_string(fd)).c_str(), name, sizeof name);
  const std::string folder = std::string(disk) + "/";
  if (length < 0 || !std::string_view(name, static_cast<size_t>(length)).starts_with(folder)) return SIZE_MAX;
  if (access((folder + "full").c_str(), F_OK) != 0) return SIZE_MAX;
  const size_t most = std::strtoul(room, nullptr, 10);
  const off_t written = lseek(fd, 0, SEEK_CUR);
  return written < 0 || static_cast<size_t>(written) > most ? 0 : most - static_cast<size_t>(written);
}

}  // namespace

// As on a disk: what there is room for is written, the next write says that there is none.
extern "C" ssize_t write(int fd, const void* bytes, size_t size) {
  const int before = errno;
  const size_t room = room_of(fd);
  errno = before;
  if (size > 0 && room == 0) {
    errno = ENOSPC;
    return -1;
  }
  return syscall(SYS_write, fd, bytes, size < room ? size : room);
}

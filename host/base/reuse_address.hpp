// Ports that were in use a moment ago.
#pragma once

#include <sys/socket.h>

namespace regulus {

/// Lets a socket listen on a port whose last owner has ended but whose connections the system still
/// remembers. Two that listen at once stay impossible.
inline void reuse_address(int socket) {
  const int yes = 1;
  ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

}  // namespace regulus

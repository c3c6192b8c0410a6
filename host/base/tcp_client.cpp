#include "base/tcp_client.hpp"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <system_error>

#include "base/error.hpp"

namespace regulus {

namespace {

using std::chrono::milliseconds;

std::string reason(int error) {
  return std::generic_category().message(error);
}

/// Whether the socket can be written to within the time.
bool wait_until_writable(int socket, milliseconds time) {
  pollfd wait{socket, POLLOUT, 0};
  return ::poll(&wait, 1, static_cast<int>(time.count())) > 0;
}

/// Connects a new socket that does not block, and returns it; -1 and errno if it cannot.
int connect_to(const addrinfo& address, milliseconds patience) {
  const int socket =
      ::socket(address.ai_family, address.ai_socktype | SOCK_NONBLOCK | SOCK_CLOEXEC, address.ai_protocol);
  if (socket < 0) return -1;
  int error = ::connect(socket, address.ai_addr, address.ai_addrlen) == 0 ? 0 : errno;
  if (error == EINPROGRESS) {
    socklen_t size = sizeof error;
    if (!wait_until_writable(socket, patience))
      error = ETIMEDOUT;
    else if (::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size) != 0)
      error = errno;
  }
  if (error == 0) return socket;
  ::close(socket);
  errno = error;
  return -1;
}

}  // namespace

HostAndPort parse_host_and_port(const std::string& text) {
  const size_t colon = text.rfind(':');
  HostAndPort result;
  if (colon != std::string::npos) result = {text.substr(0, colon), text.substr(colon + 1)};
  const bool is_bracketed = result.host.starts_with('[') && result.host.ends_with(']');
  if (is_bracketed) result.host = result.host.substr(1, result.host.size() - 2);
  uint32_t port = 0;
  const char* end = result.port.data() + result.port.size();
  const auto [after, error] = std::from_chars(result.port.data(), end, port);
  const bool is_port = error == std::errc{} && after == end && port >= 1 && port <= 65535;
  const bool is_host = !result.host.empty() && (is_bracketed || result.host.find(':') == std::string::npos);
  if (!is_host || !is_port)
    throw Error(ErrorCode::BadUsage,
                "\"" + text + "\" is not HOST:PORT with a port from 1 to 65535, such as localhost:14158");
  return result;
}

std::string TcpClient::connect(const HostAndPort& server, milliseconds patience) {
  close();
  addrinfo hints{}, *found = nullptr;
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  const int error = ::getaddrinfo(server.host.c_str(), server.port.c_str(), &hints, &found);
  if (error != 0) return ::gai_strerror(error);
  for (const addrinfo* address = found; address != nullptr && socket_ < 0; address = address->ai_next)
    socket_ = connect_to(*address, patience);
  const int last_error = errno;
  ::freeaddrinfo(found);
  return socket_ >= 0 ? "" : reason(last_error);
}

std::string TcpClient::send(std::string_view bytes, milliseconds patience,
                            const std::function<bool()>& wants_to_stop) {
  constexpr milliseconds STEP{100};
  milliseconds waited{0};
  std::string failure;
  while (!bytes.empty() && failure.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes.remove_prefix(static_cast<size_t>(sent));
      waited = milliseconds{0};
    } else if (sent < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) {
      failure = reason(errno);
    } else if (wants_to_stop()) {
      failure = "the render is over";
    } else if (waited >= patience) {
      failure = "it takes nothing";
    } else {
      if (!wait_until_writable(socket_, STEP)) waited += STEP;
    }
  }
  if (!failure.empty()) close();
  return failure;
}

void TcpClient::close() {
  if (socket_ >= 0) ::close(socket_);
  socket_ = -1;
}

}  // namespace regulus

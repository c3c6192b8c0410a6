// A connection to a server that may be slow, absent, or go away at any time.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace regulus {

/// HOST:PORT, or [ADDRESS]:PORT of IPv6.
struct HostAndPort {
  std::string host, port;
};

/// @throws regulus::Error (BadUsage) that quotes the text if it is anything else
HostAndPort parse_host_and_port(const std::string& text);

/// Nothing here raises a signal or waits longer than it is allowed to, but for the search of a host's
/// address.
class TcpClient {
 public:
  TcpClient() = default;
  ~TcpClient() { close(); }
  TcpClient(const TcpClient&) = delete;
  TcpClient& operator=(const TcpClient&) = delete;

  /// Connects anew. Returns why it cannot; empty if it has.
  std::string connect(const HostAndPort& server, std::chrono::milliseconds patience);

  bool is_connected() const { return socket_ >= 0; }

  /// Sends all of it. Returns why that failed; the connection is closed then.
  /// @param patience with a server that takes nothing at all
  /// @param wants_to_stop asked a few times a second while nothing is taken
  std::string send(std::string_view bytes, std::chrono::milliseconds patience,
                   const std::function<bool()>& wants_to_stop);

  void close();

 private:
  int socket_ = -1;
};

}  // namespace regulus

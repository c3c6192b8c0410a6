// The server of `regulus view`: its page, what the page asks for, and the pictures that it gets.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "view/board.hpp"
#include "view/wanted.hpp"

namespace regulus::view {

/// Listens on 127.0.0.1 alone, in threads of its own. Every address begins with a token that is drawn anew,
/// and who does not know it gets nothing: GET the page, GET events (server-sent: "status" and "picture"),
/// POST state. Whatever a client sends, or does not read, is an error of that client.
class Server {
 public:
  /// @param port 0: any that is free
  /// @param page in HTML
  /// @throws regulus::Error (Failed) if the port cannot be had
  Server(uint16_t port, std::string page, Mailbox& mailbox, Board& board);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  std::string address() const;  ///< of the page
  int watchers() const;         ///< who get pictures now

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace regulus::view

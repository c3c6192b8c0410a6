#include "view/server.hpp"

#include <fmt/format.h>
#include <httplib.h>

#include <atomic>
#include <random>
#include <thread>

#include "base/error.hpp"
#include "base/reuse_address.hpp"

namespace regulus::view {

namespace {

using namespace std::chrono_literals;

constexpr const char* HOST = "127.0.0.1";
constexpr int MOST_WATCHERS = 8;
constexpr size_t THREADS = 32, MOST_BODY_BYTES = 1u << 16;
constexpr std::chrono::milliseconds READ_PATIENCE = 2s, WRITE_PATIENCE = 2s, HEARTBEAT = 1s;

/// 128 bits that nobody guesses.
std::string draw_token() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", static_cast<uint32_t>(random()));
  return token;
}

}  // namespace

struct Server::Impl {
  Mailbox& mailbox;
  Board& board;
  std::string page;
  std::string token = draw_token();
  httplib::Server http{};
  int port = 0;
  std::atomic<int> watchers = 0;
  std::atomic<bool> is_over = false, has_ended = false;
  std::thread thread{};

  void set_up() {
    http.new_task_queue = [] { return new httplib::ThreadPool(THREADS); };
    http.set_socket_options([](socket_t socket) { reuse_address(socket); });  // by default ports are shared
    http.set_read_timeout(READ_PATIENCE);
    http.set_write_timeout(WRITE_PATIENCE);
    http.set_keep_alive_timeout(1);
    http.set_payload_max_length(MOST_BODY_BYTES);
    http.set_default_headers({{"Cache-Control", "no-store"},
                              {"Referrer-Policy", "no-referrer"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Content-Security-Policy",
                               "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
                               "img-src data:; connect-src 'self'"}});
    http.set_exception_handler([](const httplib::Request&, httplib::Response& response,
                                  const std::exception_ptr&) { response.status = 500; });
    const std::string base = "/" + token + "/";
    http.Get(base, [this](const httplib::Request&, httplib::Response& response) {
      response.set_content(page, "text/html; charset=utf-8");
    });
    http.Post(base + "state", [this](const httplib::Request& request, httplib::Response& response) {
      take_state(request.body, response);
    });
    http.Get(base + "events",
             [this](const httplib::Request&, httplib::Response& response) { watch(response); });
  }

  void take_state(const std::string& body, httplib::Response& response) {
    try {
      const uint64_t number = mailbox.put(parse_wanted(body));
      response.set_content(fmt::format("{{\"number\":{}}}", number), "application/json");
    } catch (const Error& error) {
      response.status = 400;
      response.set_content(std::string(error.what()) + "\n", "text/plain; charset=utf-8");
    }
  }

  void watch(httplib::Response& response) {
    if (++watchers > MOST_WATCHERS) {
      --watchers;
      response.status = 503;
      response.set_content("there are too many pages already; close one\n", "text/plain");
      return;
    }
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, seen = std::make_shared<Board::Seen>()](size_t, httplib::DataSink& sink) {
          if (is_over) return false;
          const auto messages = board.wait(*seen, HEARTBEAT);
          // A comment finds out whether somebody is there.
          if (messages.empty()) return sink.write(":\n\n", 3);
          for (const auto& message : messages)
            if (is_over || !sink.write(message->data(), message->size())) return false;
          return true;
        },
        [this](bool) { --watchers; });
  }
};

Server::Server(uint16_t port, std::string page, Mailbox& mailbox, Board& board)
    : impl_(new Impl{mailbox, board, std::move(page)}) {
  impl_->set_up();
  impl_->port = port == 0                              ? impl_->http.bind_to_any_port(HOST)
                : impl_->http.bind_to_port(HOST, port) ? port
                                                       : -1;
  if (impl_->port <= 0)
    throw Error(ErrorCode::Failed,
                fmt::format("--port {}: cannot be listened on; another program has it, name another one or 0 "
                            "for any that is free",
                            port));
  impl_->thread = std::thread([impl = impl_.get()] {
    impl->http.listen_after_bind();
    impl->has_ended = true;
  });
}

Server::~Server() {
  impl_->is_over = true;
  if (!impl_->thread.joinable()) return;
  while (!impl_->http.is_running() && !impl_->has_ended) std::this_thread::sleep_for(1ms);
  impl_->http.stop();
  impl_->thread.join();
}

std::string Server::address() const {
  return fmt::format("http://{}:{}/{}/", HOST, impl_->port, impl_->token);
}

int Server::watchers() const {
  return impl_->watchers;
}

}  // namespace regulus::view

#include "cli/browser.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace regulus::test {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int ANSWER_MS = 60'000;

// The descriptors where Chromium reads and writes with --remote-debugging-pipe.
constexpr int BROWSER_READS = 3, BROWSER_WRITES = 4;

std::string decode_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  uint32_t group = 0, bits = 0;
  for (const char c : text) {
    const size_t digit = digits.find(c);
    if (digit == std::string::npos) break;
    group = group << 6 | static_cast<uint32_t>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(group >> bits & 255);
  }
  return bytes;
}

}  // namespace

bool Browser::is_installed() {
  return std::system("command -v chromium >/dev/null") == 0;
}

Browser::Browser(const std::filesystem::path& folder) {
  int commands[2], answers[2];
  if (pipe(commands) != 0 || pipe(answers) != 0) throw std::runtime_error("no pipe for the browser");
  const std::string profile = "--user-data-dir=" + (folder / "profile").string();
  const std::string log = (folder / "chromium.txt").string();
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ == 0) {
    // Out of the way of 3 and 4 first.
    const int in = fcntl(commands[0], F_DUPFD, 10), out = fcntl(answers[1], F_DUPFD, 10);
    for (const int end : {commands[0], commands[1], answers[0], answers[1]}) close(end);
    dup2(in, BROWSER_READS);
    dup2(out, BROWSER_WRITES);
    dup2(::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
    execlp("chromium", "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe",
           "--window-size=1280,1000", profile.c_str(), "about:blank", nullptr);
    _exit(127);
  }
  close(commands[0]);
  close(answers[1]);
  to_ = commands[1];
  from_ = answers[0];
  const std::string target = call("Target.createTarget", {{"url", "about:blank"}}).at("targetId");
  session_ = call("Target.attachToTarget", {{"targetId", target}, {"flatten", true}}).at("sessionId");
  for (const char* domain : {"Page.enable", "Runtime.enable", "Log.enable", "Network.enable"}) call(domain);
}

Browser::~Browser() {
  close(to_);  // which ends it
  close(from_);
  for (int i = 0; i < 50; ++i) {
    if (waitpid(pid_, nullptr, WNOHANG) == pid_) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

void Browser::send(const json& message) {
  const std::string text = message.dump() + '\0';
  for (size_t sent = 0; sent < text.size();) {
    const ssize_t count = write(to_, text.data() + sent, text.size() - sent);
    if (count <= 0) throw std::runtime_error("the browser is gone");
    sent += static_cast<size_t>(count);
  }
}

json Browser::receive(int timeout_ms) {
  const auto deadline = Clock::now() + std::chrono::milliseconds(timeout_ms);
  size_t end = received_.find('\0');
  while (end == std::string::npos) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    pollfd wait{from_, POLLIN, 0};
    if (left <= 0 || poll(&wait, 1, static_cast<int>(left)) <= 0) return nullptr;
    char buffer[65536];
    const ssize_t count = read(from_, buffer, sizeof buffer);
    if (count <= 0) throw std::runtime_error("the browser is gone");
    const size_t before = received_.size();
    received_.append(buffer, static_cast<size_t>(count));
    end = received_.find('\0', before);
  }
  json message = json::parse(received_.substr(0, end));
  received_.erase(0, end + 1);
  return message;
}

void Browser::note(const json& event) {
  const std::string method = event.value("method", "");
  if (method == "Page.loadEventFired") is_loaded_ = true;
  if (method == "Runtime.consoleAPICalled" || method == "Runtime.exceptionThrown" ||
      method == "Log.entryAdded")
    console_.push_back(event.at("params").dump());
  if (method == "Network.requestWillBeSent") requests_.push_back(event["params"]["request"]["url"]);
}

json Browser::call(const std::string& method, json parameters) {
  const int id = ++last_id_;
  json message = {{"id", id}, {"method", method}, {"params", std::move(parameters)}};
  if (!session_.empty()) message["sessionId"] = session_;
  send(message);
  while (true) {
    json answer = receive(ANSWER_MS);
    if (answer.is_null()) throw std::runtime_error("the browser does not answer " + method);
    if (answer.value("id", 0) != id) {
      note(answer);
      continue;
    }
    if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
    return answer.at("result");
  }
}

void Browser::open(const std::string& address) {
  is_loaded_ = false;
  call("Page.navigate", {{"url", address}});
  const auto deadline = Clock::now() + std::chrono::seconds(30);
  while (!is_loaded_ && Clock::now() < deadline) {
    const json event = receive(1000);
    if (!event.is_null()) note(event);
  }
  if (!is_loaded_) throw std::runtime_error(address + " is not loaded in half a minute");
}

json Browser::evaluate(const std::string& expression) {
  const json result =
      call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (result.contains("exceptionDetails")) console_.push_back(result["exceptionDetails"].dump());
  return result.at("result").value("value", json());
}

bool Browser::wait_for(const std::string& expression) {
  const auto deadline = Clock::now() + std::chrono::seconds(30);
  while (Clock::now() < deadline) {
    if (evaluate("Boolean(" + expression + ")") == true) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

void Browser::drag(double from_x, double from_y, double to_x, double to_y) {
  const auto mouse = [&](const char* type, double x, double y, int buttons) {
    call("Input.dispatchMouseEvent",
         {{"type", type}, {"x", x}, {"y", y}, {"button", "left"}, {"buttons", buttons}, {"clickCount", 1}});
  };
  mouse("mousePressed", from_x, from_y, 1);
  for (int step = 1; step <= 4; ++step)
    mouse("mouseMoved", from_x + (to_x - from_x) * step / 4, from_y + (to_y - from_y) * step / 4, 1);
  mouse("mouseReleased", to_x, to_y, 0);
}

void Browser::take_screenshot(const std::filesystem::path& file) {
  std::ofstream(file, std::ios::binary)
      << decode_base64(call("Page.captureScreenshot", {{"captureBeyondViewport", true}}).at("data"));
}

}  // namespace regulus::test

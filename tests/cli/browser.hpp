// A headless Chromium that a test drives by the DevTools protocol.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace regulus::test {

/// One browser with one page. Throws std::runtime_error if the browser does not answer.
class Browser {
 public:
  static bool is_installed();

  /// @param folder for its profile
  explicit Browser(const std::filesystem::path& folder);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  /// Loads a page and waits until it says that it is loaded.
  void open(const std::string& address);
  /// The value of an expression, of a promise what it comes to. An exception becomes a console message.
  nlohmann::json evaluate(const std::string& expression);
  /// Evaluates until the value is true, for half a minute at most.
  bool wait_for(const std::string& expression);
  /// Presses the mouse at one place of the page, moves, and lets go at another.
  void drag(double from_x, double from_y, double to_x, double to_y);
  /// A PNG of the page.
  void take_screenshot(const std::filesystem::path& file);

  /// Everything that reached the console so far: messages, exceptions, what could not be loaded.
  const std::vector<std::string>& console() const { return console_; }
  /// The addresses of everything that was asked for.
  const std::vector<std::string>& requests() const { return requests_; }

 private:
  nlohmann::json call(const std::string& method, nlohmann::json parameters = nlohmann::json::object());
  void send(const nlohmann::json& message);
  nlohmann::json receive(int timeout_ms);
  void note(const nlohmann::json& event);

  pid_t pid_ = -1;
  int to_ = -1, from_ = -1;
  std::string received_, session_;
  int last_id_ = 0;
  bool is_loaded_ = false;
  std::vector<std::string> console_, requests_;
};

}  // namespace regulus::test

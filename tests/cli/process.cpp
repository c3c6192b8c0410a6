#include "cli/process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace regulus::test {

namespace fs = std::filesystem;

namespace {

fs::path temporary_file() {
  std::string name = (fs::temp_directory_path() / "regulus-output-XXXXXX").string();
  const int fd = mkstemp(name.data());
  if (fd < 0) throw std::runtime_error("no temporary file could be made");
  close(fd);
  return name;
}

std::string take_contents(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  fs::remove(path);
  return text.str();
}

void redirect(const fs::path& path, int to) {
  const int fd = open(path.c_str(), O_WRONLY | O_TRUNC);
  if (fd < 0 || dup2(fd, to) < 0) _exit(126);
}

}  // namespace

Process::Process(const Arguments& arguments, const Environment& environment, const Preparation& preparation)
    : out_(temporary_file()), err_(temporary_file()) {
  std::vector<std::string> words = {REGULUS_BINARY};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ > 0) return;
  for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
  redirect("/dev/null", STDIN_FILENO);
  redirect(out_, STDOUT_FILENO);
  redirect(err_, STDERR_FILENO);
  for (const int caught : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ}) signal(caught, SIG_DFL);
  if (preparation) preparation();
  execv(argv[0], argv.data());
  _exit(127);
}

Process::~Process() {
  if (pid_ <= 0) return;
  send(SIGKILL);
  wait();
}

bool Process::catches(int signal) const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind("SigCgt:", 0) == 0)
      return (std::stoull(line.substr(7), nullptr, 16) >> (signal - 1) & 1) != 0;
  return false;
}

double Process::processor_seconds() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/stat");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  // Behind the name, which may hold anything, in parentheses: state, ten numbers, then both times (proc(5)).
  std::istringstream fields(text.substr(std::min(text.rfind(')') + 1, text.size())));
  std::string skipped;
  for (int i = 0; i < 11; ++i) fields >> skipped;
  double user = 0, system = 0;
  fields >> user >> system;
  return (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));
}

bool Process::wait_for_handler(int signal) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (std::chrono::steady_clock::now() < deadline) {
    if (catches(signal)) return true;
    siginfo_t ended{};
    if (waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
        ended.si_pid == pid_)
      return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

std::string Process::said() const {
  std::ifstream file(out_);
  return {std::istreambuf_iterator<char>(file), {}};
}

void Process::send(int signal) {
  kill(pid_, signal);
}

Finished Process::wait() {
  int status = 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  Finished finished;
  if (WIFEXITED(status)) finished.status = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) finished.signal = WTERMSIG(status);
  finished.out = take_contents(out_);
  finished.err = take_contents(err_);
  return finished;
}

Finished run(const Arguments& arguments, const Environment& environment, const Preparation& preparation) {
  return Process(arguments, environment, preparation).wait();
}

size_t count_lines(const std::string& text) {
  return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

void expect_error(const Finished& finished, int status, const std::vector<std::string>& mentions) {
  EXPECT_EQ(finished.signal, 0);
  EXPECT_EQ(finished.status, status) << finished.err;
  EXPECT_EQ(finished.out, "");
  // A machine that is slow has lines of progress before it.
  const size_t error = finished.err.find("regulus: error: ");
  ASSERT_NE(error, std::string::npos) << finished.err;
  EXPECT_EQ(count_lines(finished.err.substr(error)), 1u) << finished.err;
  std::istringstream before(finished.err.substr(0, error));
  for (std::string line; std::getline(before, line);)
    EXPECT_EQ(line.rfind("regulus: progress: ", 0), 0u) << line;
  for (const std::string& mention : mentions)
    EXPECT_NE(finished.err.find(mention), std::string::npos) << "\"" << mention << "\" in: " << finished.err;
}

}  // namespace regulus::test

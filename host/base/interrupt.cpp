#include "base/interrupt.hpp"

#include <csignal>
#include <ctime>

namespace regulus {

namespace {

// A signal that follows the first of its kind within this time is its echo: timeout(1), for one, signals its
// child and then the group the child is in.
constexpr std::time_t ECHO_SECONDS = 1;

volatile std::sig_atomic_t interrupted = 0;

std::time_t monotonic_seconds() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);  // may be called from a signal handler, as std::chrono may not
  return now.tv_sec;
}

// Asks for an orderly end.
extern "C" void handle_interrupt(int) {
  interrupted = 1;
}

// The first signal of a kind asks for an orderly end, a later one ends the process at once.
extern "C" void handle_request(int signal) {
  static volatile std::time_t first_interrupt = 0, first_termination = 0;
  volatile std::time_t& first = signal == SIGINT ? first_interrupt : first_termination;
  const std::time_t now = monotonic_seconds();
  interrupted = 1;
  if (first == 0) {
    first = now;
  } else if (now - first > ECHO_SECONDS) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, handle_request);
  std::signal(SIGTERM, handle_request);
  // Of a terminal that closes, and of a limit of CPU time: they come again while the picture is written.
  std::signal(SIGXCPU, handle_interrupt);
  if (std::signal(SIGHUP, handle_interrupt) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup(1)
}

bool is_interrupted() {
  return interrupted != 0;
}

}  // namespace regulus

#include "cli/interrupt.hpp"

#include <csignal>
#include <ctime>

namespace regulus::cli {

namespace {

// A signal that follows the first within this time is its echo: timeout(1), for one, signals its child and
// then the group the child is in.
constexpr std::time_t ECHO_SECONDS = 1;

volatile std::sig_atomic_t interrupted = 0;
volatile std::time_t first_seconds = 0;

// The first signal asks for an orderly end, a later one ends the process at once.
extern "C" void handle_interrupt(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);  // may be called from a signal handler, as std::chrono may not
  if (interrupted == 0) {
    first_seconds = now.tv_sec;
    interrupted = 1;
  } else if (now.tv_sec - first_seconds > ECHO_SECONDS) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, handle_interrupt);
  std::signal(SIGTERM, handle_interrupt);
}

bool is_interrupted() {
  return interrupted != 0;
}

}  // namespace regulus::cli

#include "cli/interrupt.hpp"

#include <csignal>

namespace regulus::cli {

namespace {

volatile std::sig_atomic_t interrupted = 0;

extern "C" void handle_interrupt(int signal) {
  interrupted = 1;
  std::signal(signal, SIG_DFL);
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

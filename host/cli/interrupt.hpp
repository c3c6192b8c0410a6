// Ctrl-C and SIGTERM: ask a render to stop and write what it has.
#pragma once

namespace regulus::cli {

/// Installs handlers for SIGINT and SIGTERM. The first signal sets the flag; the second ends the process.
void catch_interrupts();

/// True once a signal has arrived.
bool is_interrupted();

}  // namespace regulus::cli

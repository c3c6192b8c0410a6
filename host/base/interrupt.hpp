// Ctrl-C, SIGTERM, a terminal that closes, CPU time that is used up: ask a render to stop and write what it
// has.
#pragma once

namespace regulus {

/// Installs handlers for SIGINT, SIGTERM, SIGHUP (unless it is ignored, as under nohup) and SIGXCPU. The
/// first signal sets the flag; a second SIGINT, or a second SIGTERM, ends the process.
void catch_interrupts();

/// True once a signal has arrived.
bool is_interrupted();

}  // namespace regulus

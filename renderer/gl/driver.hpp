// What drivers say: KHR_debug messages become log lines.
#pragma once

namespace furnace::gl {

// For the current context: errors and undefined behaviour are logged as `gl.error`; chatter is off.
void install_debug_output();

}  // namespace furnace::gl

// Changes that reach behind what plain changes of bytes break: checksums, lengths, the syntax of JSON.
#pragma once

#include "tests/fuzz/targets.hpp"

namespace furnace::fuzz {

Mutate mutate_bytes;      // libFuzzer's own
Mutate mutate_png;        // then right checksums
Mutate mutate_json;       // values, members and elements of a JSON document
Mutate mutate_json_pair;  // of the first of two texts (`split`), or the bytes behind it
Mutate mutate_glb;        // of the JSON chunk, or bytes anywhere, then right lengths

}  // namespace furnace::fuzz

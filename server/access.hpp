// Who may use a route.
#pragma once

namespace furnace {

// What a key opens, and what a route asks for: any one of its scopes will do.
using Scopes = unsigned;

namespace scope {
inline constexpr Scopes kOpen = 0;  // needs no key
inline constexpr Scopes kRender = 1, kAssets = 2, kAdmin = 4;
inline constexpr Scopes kAll = kRender | kAssets | kAdmin;
// A signed URL where the operator has set secrets for them; else a key that may render.
inline constexpr Scopes kImageUrl = 8;
}  // namespace scope

}  // namespace furnace

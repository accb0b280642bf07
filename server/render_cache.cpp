#include "server/render_cache.hpp"

#include <utility>

#include "renderer/base/deadline.hpp"

namespace furnace {

namespace {

std::int64_t size_of(const api::StoredRender& render) {
  std::size_t bytes = sizeof render + render.bytes.size() + render.report.size();
  for (const Note& note : render.notes)
    bytes += sizeof note + note.code.size() + note.pointer.size() + note.message.size();
  return std::int64_t(bytes);
}

}  // namespace

RenderCache::RenderCache(const RenderCacheConfig& config)
    : memory_(config.memory_bytes, size_of),
      files_({config.folder / "renders", "renders", "render", api::kStoredRenderLayout,
              config.folder.empty() ? 0 : config.disk_bytes, config.disk_bytes}) {}

RenderCache::Found RenderCache::get_or_draw(const ContentHash& tag, const Deadline& deadline,
                                            const std::function<api::StoredRender()>& draw) {
  Found found;
  CacheOutcome outcome = CacheOutcome::kLoaded;
  found.render = memory_.get_or_load(
      tag, deadline,
      [&] {
        if (auto kept = files_.load(tag, api::decode_stored_render)) {
          found.origin = RenderOrigin::kDisk;
          return *std::move(kept);
        }
        api::StoredRender drawn = draw();
        files_.save(tag, [&] { return api::encode_stored_render(drawn); });
        return drawn;
      },
      &outcome);
  if (outcome == CacheOutcome::kHit) found.origin = RenderOrigin::kMemory;
  if (outcome == CacheOutcome::kJoined) found.origin = RenderOrigin::kJoined;
  return found;
}

bool RenderCache::keeps(const ContentHash& tag) {
  return memory_.find(tag) != nullptr || files_.contains(tag);
}

RenderCache::Pointer RenderCache::find(const ContentHash& tag, const Deadline& deadline) {
  // A picture that is being drawn has no address yet: nobody waits for it here.
  if (Pointer kept = memory_.find(tag)) return kept;
  if (auto kept = files_.load(tag, api::decode_stored_render)) {
    check_deadline(deadline, "read");
    return memory_.get_or_load(tag, deadline, [&] { return *std::move(kept); });
  }
  return nullptr;
}

}  // namespace furnace

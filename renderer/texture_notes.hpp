// What was told of textures when they were decoded: a render that finds them on the GPU tells it again.
#pragma once

#include <mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "renderer/base/content_hash.hpp"
#include "renderer/scene/scene.hpp"

namespace furnace {

// Threads: any. Owns: its notes, of few textures: most have none.
class TextureNotes {
 public:
  void remember(const ContentHash& texture, const std::vector<Note>& notes) {
    const std::lock_guard lock(mutex_);
    if (notes.empty()) {
      notes_.erase(texture);
      return;
    }
    // So many faulty textures are no one's scene: begin anew instead of growing.
    constexpr std::size_t kMost = 4096;
    if (notes_.size() >= kMost) notes_.clear();
    notes_[texture] = notes;
  }

  // `pointer`: where the texture is this time.
  std::vector<Note> recall(const ContentHash& texture, const std::string& pointer) const {
    const std::lock_guard lock(mutex_);
    const auto known = notes_.find(texture);
    if (known == notes_.end()) return {};
    std::vector<Note> notes = known->second;
    for (Note& note : notes) note.pointer = pointer;
    return notes;
  }

 private:
  mutable std::mutex mutex_;
  std::unordered_map<ContentHash, std::vector<Note>> notes_;
};

}  // namespace furnace

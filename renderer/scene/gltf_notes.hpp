// Collects what the importer mended or left out, each thing once.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "renderer/scene/scene.hpp"

namespace furnace {

// Threads: one. Owns: its notes.
class GltfNotes {
 public:
  void add(std::string code, std::string pointer, std::string message) {
    if (notes_.size() > kMaxNotes || !seen_.emplace(code, pointer).second) return;
    if (notes_.size() == kMaxNotes) {
      code = "notes-omitted";
      pointer.clear();
      message = "there are more than " + std::to_string(kMaxNotes) + " notes; the others were left out";
    }
    notes_.push_back({std::move(code), std::move(pointer), std::move(message)});
  }
  std::vector<Note> take() { return std::move(notes_); }

 private:
  // A report is read by people; a model with more faults than this has one fault.
  static constexpr std::size_t kMaxNotes = 200;

  std::set<std::pair<std::string, std::string>> seen_;
  std::vector<Note> notes_;
};

}  // namespace furnace

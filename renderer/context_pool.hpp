// The GL contexts, each on a thread of its own: which of them draws a scene, and when one is made anew.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "renderer/base/confined_thread.hpp"
#include "renderer/base/content_hash.hpp"
#include "renderer/frame/render_world.hpp"
#include "renderer/context_stats.hpp"

namespace furnace {

struct ContextUse {
  std::int64_t renders = 0;
  std::chrono::milliseconds age{0};
};

// Why a context that was used so is to be made anew. For memory not within a minute of the last time: what it did not free
// then it does not free now.
std::optional<RenewalReason> worn_by(const ContextUse& use, const ContextLife& life,
                                     std::int64_t process_bytes);

// Each scene has an order of its own among the contexts (Thaler, Ravishankar, "Using name-based mappings to increase hit
// rates", 1998), so that what it needs is uploaded once; the first there that has at most one caller more than the least.
// `callers`: of each context, at least one.
std::size_t choose_context(const ContentHash& scene, std::span<const int> callers);

struct ContextPoolConfig {
  RenderWorldConfig world;           // its device aside
  std::vector<std::string> devices;  // a context each; see gl::ContextConfig::device
  ContextLife life;
};

// Threads: any. Owns: the contexts and their threads.
class ContextPool {
 public:
  using Thread = ConfinedThread<RenderWorld>;

  // A place on one context, from before the work for it is prepared until it is drawn.
  // Threads: any, one at a time. The pool outlives it.
  class Lease {
   public:
    ~Lease();
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;

    Thread& thread() const;
    const ResidentKeys& resident() const;
    // To be called before a drawing: counts it, and makes a context anew that has served long enough.
    // Errors: as Thread::rebuild.
    void begin(const Deadline& deadline);
    // After a reset of the GPU. Errors: as Thread::rebuild.
    void rebuild(const Deadline& deadline);

   private:
    friend class ContextPool;
    Lease(ContextPool& pool, std::size_t index) : pool_(pool), index_(index) {}
    ContextPool& pool_;
    const std::size_t index_;
  };

  // Errors: kGpuUnavailable: as gl::Context::create, or when two contexts would not draw the same bytes.
  explicit ContextPool(const ContextPoolConfig& config);
  ~ContextPool();

  Lease lease(const ContentHash& scene);
  Lease lease(std::size_t index);
  std::size_t size() const { return contexts_.size(); }

  const gl::Limits& limits() const { return limits_; }             // what every context can do
  const std::string& description() const { return description_; }  // GL_RENDERER / GL_VERSION, of all alike
  const ContentHash& shaders() const { return shaders_; }
  // The longest of all: see ConfinedThread::overdue.
  Clock::duration overdue() const;
  ContextPoolStats stats() const;

 private:
  struct Context;
  void renew(Context& context, RenewalReason reason, const Deadline& deadline);

  const ContextLife life_;
  mutable std::mutex mutex_;  // callers, use and renewals of all
  std::array<std::int64_t, kRenewalReasons> renewals_{};
  std::vector<std::unique_ptr<Context>> contexts_;
  gl::Limits limits_;
  std::string description_;
  ContentHash shaders_;
};

}  // namespace furnace

#include "renderer/context_pool.hpp"

#include <algorithm>
#include <fstream>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "renderer/base/error.hpp"
#include "renderer/base/log.hpp"

namespace furnace {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kMemoryPause{60'000};

// 0 where the kernel does not tell.
std::int64_t process_bytes() {
  std::ifstream file("/proc/self/status");
  std::int64_t kibibytes = 0;
  for (std::string word; file >> word;)
    if (word == "VmRSS:" && file >> kibibytes) break;
  return kibibytes << 10;
}

}  // namespace

std::string_view name_of(RenewalReason reason) {
  switch (reason) {
    case RenewalReason::kLost:
      return "lost";
    case RenewalReason::kRenders:
      return "renders";
    case RenewalReason::kAge:
      return "age";
    case RenewalReason::kMemory:
      return "memory";
  }
  return "";
}

std::optional<RenewalReason> worn_by(const ContextUse& use, const ContextLife& life,
                                     std::int64_t process_bytes) {
  if (life.renders > 0 && use.renders >= life.renders) return RenewalReason::kRenders;
  if (life.age.count() > 0 && use.age >= life.age) return RenewalReason::kAge;
  if (life.process_bytes > 0 && process_bytes > life.process_bytes && use.age >= kMemoryPause)
    return RenewalReason::kMemory;
  return std::nullopt;
}

std::size_t choose_context(const ContentHash& scene, std::span<const int> callers) {
  constexpr int kPatience = 1;
  const int least = *std::min_element(callers.begin(), callers.end());
  std::size_t chosen = 0;
  ContentHash best;
  for (std::size_t i = 0; i < callers.size(); ++i) {
    if (callers[i] > least + kPatience) continue;
    const ContentHash weight = HashBuilder().add(scene).add(std::int64_t(i)).finish();
    if (weight < best) continue;
    best = weight;
    chosen = i;
  }
  return chosen;
}

struct ContextPool::Context {
  Context(const std::string& name, const RenderWorldConfig& world)
      : resident(std::make_shared<ResidentKeys>()),
        thread(name, [world, keys = resident] { return std::make_unique<RenderWorld>(world, keys); }) {}

  const std::shared_ptr<ResidentKeys> resident;
  Thread thread;
  int callers = 0;
  std::int64_t renders = 0;
  Clock::time_point made = Clock::now();
};

ContextPool::ContextPool(const ContextPoolConfig& config) : life_(config.life) {
  for (const std::string& device : config.devices) {
    RenderWorldConfig world = config.world;
    world.gl.device = device;
    contexts_.push_back(std::make_unique<Context>(fmt::format("gl-{}", contexts_.size()), world));

    gl::Limits limits;
    std::string description;
    contexts_.back()->thread.call(Deadline{}, [&](RenderWorld& made) {
      limits = made.context().limits();
      description = made.context().renderer() + " / " + made.context().version();
      shaders_ = made.programs().shaders().hash();
    });
    if (contexts_.size() == 1) {
      limits_ = limits;
      description_ = description;
    } else if (description != description_) {
      fail(
          ErrorCode::kGpuUnavailable,
          fmt::format("device \"{}\" is {}, and \"{}\" is {}: they would draw one request differently; run a "
                      "server for each kind",
                      config.devices.front(), description_, device, description));
    }
    limits_.max_texture_px = std::min(limits_.max_texture_px, limits.max_texture_px);
  }
}

ContextPool::~ContextPool() = default;

ContextPool::Lease ContextPool::lease(const ContentHash& scene) {
  const std::lock_guard lock(mutex_);
  std::vector<int> callers;
  for (const auto& context : contexts_) callers.push_back(context->callers);
  const std::size_t index = choose_context(scene, callers);
  ++contexts_[index]->callers;
  return {*this, index};
}

ContextPool::Lease ContextPool::lease(std::size_t index) {
  const std::lock_guard lock(mutex_);
  ++contexts_[index]->callers;
  return {*this, index};
}

Clock::duration ContextPool::overdue() const {
  Clock::duration longest{};
  for (const auto& context : contexts_) longest = std::max(longest, context->thread.overdue());
  return longest;
}

ContextPoolStats ContextPool::stats() const {
  ContextPoolStats stats;
  const std::lock_guard lock(mutex_);
  for (const auto& context : contexts_) {
    stats.callers.push_back(context->callers);
    stats.gpu_bytes.push_back(context->resident->bytes());
  }
  stats.renewals = renewals_;
  return stats;
}

void ContextPool::renew(Context& context, RenewalReason reason, const Deadline& deadline) {
  log::info("gl.renewed", {{"reason", name_of(reason)}});
  context.thread.rebuild(deadline);
}

ContextPool::Lease::~Lease() {
  const std::lock_guard lock(pool_.mutex_);
  --pool_.contexts_[index_]->callers;
}

ContextPool::Thread& ContextPool::Lease::thread() const {
  return pool_.contexts_[index_]->thread;
}

const ResidentKeys& ContextPool::Lease::resident() const {
  return *pool_.contexts_[index_]->resident;
}

void ContextPool::Lease::begin(const Deadline& deadline) {
  Context& context = *pool_.contexts_[index_];
  const std::int64_t bytes = pool_.life_.process_bytes > 0 ? process_bytes() : 0;
  std::optional<RenewalReason> reason;
  {
    const std::lock_guard lock(pool_.mutex_);
    const auto age = std::chrono::duration_cast<milliseconds>(Clock::now() - context.made);
    reason = worn_by({context.renders, age}, pool_.life_, bytes);
    if (reason) {
      // At once, so that whoever comes meanwhile does not do it again.
      context.renders = 0;
      context.made = Clock::now();
      ++pool_.renewals_[std::size_t(*reason)];
    }
    ++context.renders;
  }
  if (reason) pool_.renew(context, *reason, deadline);
}

void ContextPool::Lease::rebuild(const Deadline& deadline) {
  Context& context = *pool_.contexts_[index_];
  {
    const std::lock_guard lock(pool_.mutex_);
    context.renders = 0;
    context.made = Clock::now();
    ++pool_.renewals_[std::size_t(RenewalReason::kLost)];
  }
  pool_.renew(context, RenewalReason::kLost, deadline);
}

}  // namespace furnace

// Spec in, file out: what HTTP, the command line and the golden tests all call.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "renderer/base/worker_pool.hpp"
#include "api/render_report.hpp"
#include "api/stored_render.hpp"
#include "server/admission.hpp"
#include "server/painter.hpp"
#include "server/render_cache.hpp"
#include "server/render_progress.hpp"
#include "server/sequence_render.hpp"

namespace furnace {

struct Rendered {
  RenderCache::Pointer image;
  RenderOrigin origin = RenderOrigin::kDrawn;
  StageTimes times;  // of what was drawn for this call; of a sequence: sums
};

// As in reports and in Server-Timing.
std::vector<api::RenderReport::Stage> stages_of(const StageTimes& times);

// Threads: any. Owns: nothing; Renderer, Admission, WorkerPool and RenderCache outlive it.
class RenderService {
 public:
  // Takes the frames of a sequence in their order.
  using TakeFrame = std::function<void(int frame, int frames, const api::StoredRender& image)>;

  RenderService(Painter painter, Admission& admission, WorkerPool& pool, RenderCache& cache,
                const SequenceLimits& limits = {});

  // Strong entity tag of the file that `spec` describes on this build and driver.
  ContentHash etag(const RenderSpec& spec) const;

  // The file that `spec` asks for: a picture, or a sequence in its container; drawn, unless it is kept or another is drawing
  // it. Errors: kOverloaded at once when the queue is full; those of Renderer::render and of draw_frames; kUnprocessable with
  // one problem per Note under spec.strict.
  Rendered render(const RenderSpec& spec, const Deadline& deadline, const TellProgress& progress = {});

  // Each frame of a sequence as a file of its own, drawn in any case. Errors: as render; what `take` throws.
  void render_frames(const RenderSpec& spec, const Deadline& deadline, const TakeFrame& take);

  // What was drawn before under that tag; null when it is not kept.
  RenderCache::Pointer find(const ContentHash& etag, const Deadline& deadline) {
    return cache_.find(etag, deadline);
  }

  bool keeps(const ContentHash& etag) { return cache_.keeps(etag); }

  const std::string& fingerprint() const { return painter_.fingerprint; }

 private:
  api::StoredRender draw(const RenderSpec& spec, const Deadline& deadline, const TellProgress& progress,
                         StageTimes& times);
  api::StoredRender finish(const RenderSpec& spec, Film film, const Deadline& deadline, StageTimes& times);
  api::StoredRender draw_sequence(const RenderSpec& spec, const Deadline& deadline,
                                  const TellProgress& progress, StageTimes& times);
  std::string report_of(const RenderSpec& spec, const api::StoredRender& image,
                        const StageTimes& times) const;
  std::vector<TextField> metadata_of(const RenderSpec& spec) const;

  Painter painter_;
  Admission& admission_;
  WorkerPool& pool_;
  RenderCache& cache_;
  const SequenceLimits limits_;
};

}  // namespace furnace

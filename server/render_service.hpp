// Spec in, file out: what HTTP, the command line and the golden tests all call.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "renderer/base/worker_pool.hpp"
#include "renderer/renderer.hpp"
#include "server/admission.hpp"

namespace furnace {

struct EncodedImage {
  std::string bytes;
  std::string_view media_type;  // of api::kFormats
  std::vector<Note> notes;
  StageTimes times;
  double exposure_ev = 0;  // stops by which radiance was multiplied
};

// Who draws: a Renderer in the product; tests that need no GL bring their own.
struct Painter {
  std::function<Film(const RenderSpec&, const Deadline&)> render;
  std::string fingerprint;  // what makes pixels besides the request
};

inline Painter painter_of(Renderer& renderer) {
  return {[&renderer](const RenderSpec& spec, const Deadline& deadline) {
            return renderer.render(spec, deadline);
          },
          renderer.fingerprint().text()};
}

// Threads: any. Owns: nothing; Renderer, Admission and WorkerPool outlive it.
class RenderService {
 public:
  RenderService(Renderer& renderer, Admission& admission, WorkerPool& pool)
      : RenderService(painter_of(renderer), admission, pool) {}
  RenderService(Painter painter, Admission& admission, WorkerPool& pool);

  // Strong entity tag of the picture that `spec` describes on this build and driver, without quotes.
  std::string etag(const RenderSpec& spec) const;

  // Errors: kOverloaded at once when the queue is full; those of Renderer::render; kUnprocessable with one
  // problem per Note under spec.strict.
  EncodedImage render(const RenderSpec& spec, const Deadline& deadline);

  const std::string& fingerprint() const { return painter_.fingerprint; }

 private:
  Painter painter_;
  Admission& admission_;
  WorkerPool& pool_;
};

}  // namespace furnace

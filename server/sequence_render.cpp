#include "server/sequence_render.hpp"

#include <utility>
#include <vector>

#include <fmt/format.h>

#include "renderer/base/error.hpp"

namespace furnace {

namespace {

void check_limits(const RenderSpec& spec, int frames, const SequenceLimits& limits) {
  if (frames > limits.max_frames)
    fail(ErrorCode::kTooLarge,
         fmt::format("{} frames are more than the {} of a sequence; ask for fewer frames, or fewer a second",
                     frames, limits.max_frames),
         "/output/sequence");
  const std::int64_t px = Extent{spec.output.width, spec.output.height}.area() * frames;
  if (px > limits.max_px)
    fail(ErrorCode::kTooLarge,
         fmt::format("{} frames of {} x {} px are more than the {} px of a sequence", frames,
                     spec.output.width, spec.output.height, limits.max_px),
         "/output/sequence");
}

}  // namespace

void draw_frames(const Painter& painter, const RenderSpec& spec, const SequenceLimits& limits,
                 const Deadline& deadline, const TellStage& tell, const TakeFilm& take) {
  const Sequence& sequence = *spec.output.sequence;
  const double longest_s = sequence.frames ? 0 : painter.outline(spec, deadline).longest_clip_s;
  const int count = frame_count(sequence, longest_s);
  check_limits(spec, count, limits);

  std::vector<RenderSpec> frames = frames_of(spec, count);
  if (needs_outlines(spec)) {
    std::vector<FrameOutline> outlines;
    for (const RenderSpec& frame : frames) {
      check_deadline(deadline, "outline");
      outlines.push_back(painter.outline(frame, deadline).frame);
    }
    hold_still(spec, outlines, frames);
  }
  for (int i = 0; i < count; ++i) {
    RenderSpec& frame = frames[std::size_t(i)];
    Film film = painter.render(frame, deadline, tell);
    if (i == 0 && std::holds_alternative<AutoExposure>(spec.camera.metering)) {
      for (RenderSpec& later : frames) {
        later.camera.metering = UnmeteredExposure{};
        later.camera.exposure_ev = film.exposure_ev;
      }
    }
    take(i, count, frame, std::move(film));
  }
}

}  // namespace furnace

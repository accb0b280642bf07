#include "server/render_service.hpp"

#include <gtest/gtest.h>

#include "tests/http/fake_painter.hpp"
#include "api/render_request.hpp"
#include "renderer/base/error.hpp"

namespace furnace {
namespace {

class RenderServiceTest : public ::testing::Test {
 protected:
  RenderSpec small() {
    RenderSpec spec;
    spec.output.width = spec.output.height = 8;
    return spec;
  }

  testing::FakePainter fake_;
  WorkerPool pool_{1};
  Admission admission_{1, 0};
  // Draws each time.
  RenderCache none_{{0, {}, 0}};
  RenderService service_{fake_.painter(), admission_, pool_, none_};
};

RenderSpec turning(RenderSpec spec, int frames) {
  spec.output.sequence = Sequence{};
  spec.output.sequence->frames = frames;
  spec.output.sequence->turntable_rad = 1;
  return spec;
}

TEST_F(RenderServiceTest, EncodesInTheFormatAskedFor) {
  RenderSpec spec = small();
  const api::StoredRender png = *service_.render(spec, {}).image;
  EXPECT_EQ(png.media_type, "image/png");
  EXPECT_TRUE(png.bytes.starts_with("\x89PNG"));
  spec.output.format = OutputFormat::kExr;
  const api::StoredRender exr = *service_.render(spec, {}).image;
  EXPECT_EQ(exr.media_type, "image/x-exr");
  EXPECT_TRUE(exr.bytes.starts_with("\x76\x2f\x31\x01"));
  spec.output.format = OutputFormat::kJpeg;
  const api::StoredRender jpeg = *service_.render(spec, {}).image;
  EXPECT_EQ(jpeg.media_type, "image/jpeg");
  EXPECT_TRUE(jpeg.bytes.starts_with("\xff\xd8\xff"));
  spec.output.format = OutputFormat::kWebp;
  const api::StoredRender webp = *service_.render(spec, {}).image;
  EXPECT_EQ(webp.media_type, "image/webp");
  EXPECT_EQ(webp.bytes.substr(8, 4), "WEBP");
}

TEST_F(RenderServiceTest, EveryFileNamesWhatMadeIt) {
  for (const api::FormatRow& row : api::kFormats) {
    RenderSpec spec = row.format == OutputFormat::kWebm ? turning(small(), 2) : small();
    spec.output.format = row.format;
    const std::string bytes = service_.render(spec, {}).image->bytes;
    EXPECT_NE(bytes.find(spec_hash(spec).hex()), std::string::npos) << row.name;
    EXPECT_NE(bytes.find("fake/1"), std::string::npos) << row.name;
  }
}

TEST_F(RenderServiceTest, WhatAFormatCannotHoldIsRefusedBeforeDrawing) {
  RenderSpec spec = small();
  spec.output.format = OutputFormat::kJpeg;
  spec.environment.background = TransparentBackground{};
  EXPECT_THROW(service_.render(spec, {}), Error);
  EXPECT_EQ(fake_.drawn, 0);
}

TEST_F(RenderServiceTest, ASequenceIsOneFileOrOneForEachFrame) {
  RenderSpec spec = turning(small(), 3);
  EXPECT_EQ(service_.render(spec, {}).image->media_type, "image/apng");
  EXPECT_EQ(fake_.drawn, 3);
  spec.output.format = OutputFormat::kWebp;
  std::vector<int> progress;
  const Rendered webp = service_.render(spec, {}, [&](const RenderProgress& now) {
    if (now.stage.empty())
      progress.push_back(now.frames_done);
    else
      EXPECT_EQ(now.stage, "bake");
  });
  EXPECT_EQ(webp.image->media_type, "image/webp");
  EXPECT_EQ(webp.image->frames, 3);
  EXPECT_EQ(webp.times.draw_ms, 3);
  EXPECT_EQ(progress, (std::vector{1, 2, 3}));

  spec.output.format = OutputFormat::kWebm;
  const Rendered webm = service_.render(spec, {});
  EXPECT_EQ(webm.image->media_type, "video/webm");
  EXPECT_TRUE(webm.image->bytes.starts_with("\x1A\x45\xDF\xA3"));

  spec.output.sequence->container = Sequence::Container::kArchive;
  spec.output.format = OutputFormat::kExr;
  const api::StoredRender archive = *service_.render(spec, {}).image;
  EXPECT_EQ(archive.media_type, "application/zip");
  EXPECT_TRUE(archive.bytes.starts_with("PK"));
  EXPECT_NE(archive.bytes.find("frame_0003.exr"), std::string::npos);
  EXPECT_EQ(service_.render(spec, {}).image->bytes, archive.bytes);

  int files = 0;
  service_.render_frames(spec, {}, [&](int frame, int frames, const api::StoredRender& image) {
    EXPECT_EQ(frame, files++);
    EXPECT_EQ(frames, 3);
    EXPECT_NE(archive.bytes.find(image.bytes), std::string::npos) << "stored as it is";
  });
  EXPECT_EQ(files, 3);
}

TEST_F(RenderServiceTest, ASequenceWithoutAFrameCountIsAsLongAsItsClip) {
  RenderSpec spec = small();
  spec.scene.animations = {{0, {}}};
  spec.output.sequence = Sequence{};
  spec.output.sequence->frames_per_second = 10;
  EXPECT_EQ(service_.render(spec, {}).image->frames, 10) << "the fake's clips last a second";
  RenderService narrow(fake_.painter(), admission_, pool_, none_, {9, 1 << 20});
  EXPECT_THROW(narrow.render(spec, {}), Error);
  RenderService small_pictures(fake_.painter(), admission_, pool_, none_, {100, 639});
  EXPECT_THROW(small_pictures.render(spec, {}), Error);
}

TEST_F(RenderServiceTest, NotesOfASequenceAreToldOnce) {
  fake_.notes = {{"extension-ignored", "/extensionsUsed/0", "KHR_x is not supported"}};
  RenderSpec spec = turning(small(), 4);
  EXPECT_EQ(service_.render(spec, {}).image->notes.size(), 1u);
  spec.strict = true;
  EXPECT_THROW(service_.render(spec, {}), Error);
}

TEST_F(RenderServiceTest, SameRequestSameBytesAndTag) {
  EXPECT_EQ(service_.render(small(), {}).image->bytes, service_.render(small(), {}).image->bytes);
  EXPECT_EQ(service_.etag(small()), service_.etag(small()));
}

TEST_F(RenderServiceTest, TheTagTellsRequestsAndBuildsApart) {
  RenderSpec other = small();
  other.output.width = 9;
  EXPECT_NE(service_.etag(small()), service_.etag(other));
  const RenderService elsewhere(fake_.painter("fake/2"), admission_, pool_, none_);
  EXPECT_NE(service_.etag(small()), elsewhere.etag(small()));
}

TEST_F(RenderServiceTest, StrictTurnsNotesIntoProblems) {
  fake_.notes = {{"extension-ignored", "/extensionsUsed/0", "KHR_x is not supported"},
                 {"image-missing", "/images/1", "b.png"}};
  RenderSpec spec = small();
  EXPECT_EQ(service_.render(spec, {}).image->notes.size(), 2u);
  spec.strict = true;
  try {
    service_.render(spec, {});
    FAIL() << "rendered";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kUnprocessable);
    ASSERT_EQ(error.problems.size(), 2u);
    EXPECT_EQ(error.problems[1].pointer, "/images/1");
    EXPECT_EQ(error.problems[1].message, "image-missing: b.png");
  }
}

TEST_F(RenderServiceTest, ASeatIsHeldWhileDrawingAndGivenBackOnFailure) {
  fake_.before_drawing = [this](const Deadline&) {
    EXPECT_EQ(admission_.seats_in_use(), 1);
    fail(ErrorCode::kGpuUnavailable, "lost");
  };
  EXPECT_THROW(service_.render(small(), {}), Error);
  EXPECT_EQ(admission_.seats_in_use(), 0);
}

TEST_F(RenderServiceTest, NoSeatNoPicture) {
  const auto seat = admission_.enter({});
  try {
    service_.render(small(), {});
    FAIL() << "rendered";
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::kOverloaded);
  }
  EXPECT_EQ(fake_.drawn, 0);
}

}  // namespace
}  // namespace furnace

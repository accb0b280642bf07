// One exact (reproducible) software context per test program.
#pragma once

#include <gtest/gtest.h>

#include "renderer/gl/gl.hpp"

namespace furnace::test {

// Created on first use, on the test's thread. A machine without any EGL fails the test: CI must have Mesa.
gl::Context& shared_context();

class GlTest : public testing::Test {
 protected:
  gl::Context& context_ = shared_context();
  void TearDown() override { EXPECT_EQ(glGetError(), GLenum(GL_NO_ERROR)); }
};

}  // namespace furnace::test

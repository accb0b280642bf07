#include "tests/support/gl_fixture.hpp"

namespace furnace::test {

gl::Context& shared_context() {
  static const std::unique_ptr<gl::Context> context = [] {
    gl::apply_determinism(gl::Determinism::kExact);
    return gl::Context::create({"software", gl::Determinism::kExact});
  }();
  return *context;
}

}  // namespace furnace::test

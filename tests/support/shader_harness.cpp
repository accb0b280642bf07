#include "tests/support/shader_harness.hpp"

#include "renderer/gl/program.hpp"

namespace furnace::test {

std::vector<glm::vec4> evaluate_glsl(gl::Context& context, const std::vector<std::string>& includes,
                                     const std::string& body, const std::vector<glm::vec4>& inputs) {
  std::string source;
  for (const std::string& include : includes) source += "#include \"" + include + "\"\n";
  source +=
      "layout(local_size_x = 64) in;\n"
      "layout(std430, binding = 0) readonly buffer Inputs { vec4 inputs[]; };\n"
      "layout(std430, binding = 1) writeonly buffer Results { vec4 results[]; };\n"
      "void main() {\n"
      "  uint i = gl_GlobalInvocationID.x;\n"
      "  if (i >= inputs.length()) return;\n"
      "  vec4 x = inputs[i];\n"
      "  vec4 result = vec4(0.0);\n" +
      body +
      "\n  results[i] = result;\n"
      "}\n";
  gl::ShaderLibrary library({});
  library.add("harness.comp", source);
  const gl::Program program = gl::build_program(context, library, {"harness.comp", "", 0});

  const std::size_t bytes = inputs.size() * sizeof(glm::vec4);
  const gl::Buffer in = gl::create_buffer(context, inputs.data(), bytes);
  std::vector<glm::vec4> results(inputs.size());
  const gl::Buffer out = gl::create_buffer(context, results.data(), bytes);
  glUseProgram(program.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.id());
  glDispatchCompute(GLuint((inputs.size() + 63) / 64), 1, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(out.id(), 0, GLsizeiptr(bytes), results.data());
  return results;
}

}  // namespace furnace::test

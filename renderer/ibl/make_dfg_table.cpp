// Build-time generator: the DFG table as C++ source. It depends on nothing that a user chooses, so no start-up pays for it.
#include <cstdio>

#include "renderer/ibl/dfg.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::FILE* file = std::fopen(argv[1], "w");
  if (file == nullptr) return 1;
  const furnace::DfgTable table = furnace::compute_dfg_table(furnace::kDfgTableSize);
  std::fprintf(file, "#include \"renderer/ibl/dfg.hpp\"\n\nnamespace furnace {\n\n");
  std::fprintf(file, "std::span<const DfgTexel> dfg_table() {\n  static constexpr DfgTexel kTexels[] = {\n");
  for (const furnace::DfgTexel& texel : table.texels) {
    // Hexadecimal: every bit survives.
    std::fprintf(file, "      {%af, %af, %af, %af},\n", double(texel.scale), double(texel.bias),
                 double(texel.lean_rad), double(texel.sheen));
  }
  std::fprintf(file, "  };\n  return kTexels;\n}\n\n}  // namespace furnace\n");
  return std::fclose(file) == 0 ? 0 : 1;
}

// Build-time generator: the tables of the GGX lobe as C++ source. They depend on nothing that a user chooses, so no start-up
// pays for them.
#include <cstdio>

#include "renderer/ibl/dfg.hpp"
#include "renderer/ibl/ltc.hpp"

namespace furnace {
namespace {

constexpr int kLtcFits = 32;  // linear between: the lobes' widths change by less than their fits err

void begin_table(std::FILE* file, const char* type, const char* name) {
  std::fprintf(file, "std::span<const %s> %s() {\n  static constexpr %s kTexels[] = {\n", type, name, type);
}
// Hexadecimal: every bit survives.
void write_row(std::FILE* file, float x, float y, float z, float w) {
  std::fprintf(file, "      {%af, %af, %af, %af},\n", double(x), double(y), double(z), double(w));
}
void end_table(std::FILE* file) {
  std::fprintf(file, "  };\n  return kTexels;\n}\n\n");
}

void write_tables(std::FILE* file) {
  std::fprintf(
      file,
      "#include \"renderer/ibl/dfg.hpp\"\n#include \"renderer/ibl/ltc.hpp\"\n\nnamespace furnace {\n\n");
  begin_table(file, "DfgTexel", "dfg_table");
  for (const DfgTexel& t : compute_dfg_table(kDfgTableSize).texels)
    write_row(file, t.scale, t.bias, t.lean_rad, t.sheen);
  end_table(file);
  begin_table(file, "LtcTexel", "ltc_table");
  for (const LtcTexel& t : compute_ltc_table(kDfgTableSize, kLtcFits)) write_row(file, t.a, t.b, t.c, t.d);
  end_table(file);
  std::fprintf(file, "}  // namespace furnace\n");
}

}  // namespace
}  // namespace furnace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::FILE* file = std::fopen(argv[1], "w");
  if (file == nullptr) return 1;
  furnace::write_tables(file);
  return std::fclose(file) == 0 ? 0 : 1;
}

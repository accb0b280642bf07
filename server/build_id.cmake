# Writes OUTPUT, the definitions of build_id.hpp: VERSION and a SHA-256 over the names and contents of FILES.
# The same sources give the same id on every machine, with or without version control.
set(digests "")
file(STRINGS ${FILES} files)
foreach(path ${files})
  file(SHA256 ${ROOT}/${path} digest)
  string(APPEND digests "${path} ${digest}\n")
endforeach()
string(SHA256 hash "${digests}")
string(SUBSTRING ${hash} 0 12 hash)
file(WRITE ${OUTPUT} "#include \"server/build_id.hpp\"

namespace furnace {

std::string_view version() { return \"${VERSION}\"; }
std::string_view build_id() { return \"${VERSION}+${hash}\"; }

}  // namespace furnace
")

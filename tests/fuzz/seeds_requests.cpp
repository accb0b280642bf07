// Documents of the request's tests, forms, heads, answers of a decoder.
#include <algorithm>
#include <filesystem>

#include "renderer/decode/in_process_decoder.hpp"
#include "renderer/decode/messages.hpp"
#include "api/stored_render.hpp"
#include "server/zip_archive.hpp"
#include "tests/api/request_fixture.hpp"
#include "tests/fuzz/seeds.hpp"
#include "tests/support/model_files.hpp"

namespace furnace::fuzz {
namespace {

std::string form(const std::string& boundary, const std::string& parts) {
  return "multipart/form-data; boundary=" + boundary + '\0' + parts;
}

std::vector<std::string> forms() {
  const std::string request = "--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{}\r\n";
  const std::string file =
      "--B\r\nContent-Type: image/png\r\nContent-Disposition: form-data; name=\"f\"; filename=\"a "
      "b.png\"\r\n\r\n"
      "\x89PNG\r\n-\r\n--\r\n";
  return {form("B", request + "--B--"), form("B", "preamble\r\n" + request + file + "--B--\r\nepilogue"),
          form("\"B\"", file + file + "--B  \r\n\r\n--B--"), std::string("application/json") + '\0' + "{}"};
}

std::vector<std::string> heads() {
  return {
      "Host: a\nContent-Length: 5, 5\nAccept: image/*;q=0.5, image/png;q=0.1\nIf-None-Match: \"x\", "
      "W/\"0123\"\n",
      "Host: a\nTransfer-Encoding: chunked\nExpect: 100-continue\nX-Request-Id: abc-1\n",
      "Content-Encoding: gzip\nContent-Type: multipart/form-data; boundary=\"a;b\\\"c\"; x=y\n"};
}

std::vector<std::string> image_urls() {
  return {"model=file:a%20b.glb&width=640&azimuth=-30.5e0&eye=1,2,3&ground=true&format=webp",
          "r=eyJvdXRwdXQiOnsid2lkdGgiOjh9fQ&height=6", "preset=shop&kid=k&exp=1800000060&sig=AAAA"};
}

std::vector<std::string> key_files() {
  const std::string hash(64, 'a'), secret(64, '7');
  return {"# ours\nshop:render:" + hash + ":60:1000\nci:render,assets,admin:" + std::string(64, 'b') +
              "\r\n" + '\0' + "k1:" + secret + "\n\nk2:" + secret + secret + "\n",
          std::string(1, '\0') + "june:whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw\n"};
}

std::vector<std::string> outbound_urls() {
  const auto pair = [](const std::string& list, const std::string& url) { return list + '\0' + url; };
  return {pair("example.com, *.example.org", "https://a.example.org:443/m/a%20b.glb?v=1#x"),
          pair("http://127.0.0.1:9000", "HTTP://0x7f.1:9000/../x"), pair("../a b.bin", "https://[::1]:8443/"),
          pair("*", "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01")};
}

// The fields of run_reply (request_targets.cpp): an answer as a decoder's process writes it.
template <class Result>
std::string reply_input(unsigned job, const Result& result) {
  constexpr std::size_t kBlockBytes = 4096;
  std::vector<std::byte> block(kBlockBytes);
  decode::WireWriter head, body(block);
  fields(head, decode::Reply());
  fields(body, result);
  const std::string message = head.bytes() + body.bytes();
  return number(job, 1) + number(std::uint32_t(message.size()), 2) + message +
         std::string(reinterpret_cast<const char*>(block.data()), block.size());
}

Image even_image(Extent extent, int channels, SampleType type, ColorSpace space) {
  return make_image(extent, channels, type, space);
}

std::vector<std::string> replies() {
  DecodedTexture texture;
  for (const Extent extent : {Extent{8, 4}, Extent{4, 2}})
    texture.levels.push_back(even_image(extent, 3, SampleType::kUint8, ColorSpace::kSrgb));
  texture.remarks = {{"a-code", "says something"}};
  const DecodedEnvironment environment{even_image({16, 8}, 3, SampleType::kFloat32, ColorSpace::kLinear), {}};
  const DracoMesh mesh{{0, 1, 2, 2, 1, 7}, {std::vector<std::byte>(96)}};
  PlainModelLimits limits;
  limits.max_materials = 20;
  std::vector<std::string> inputs = {reply_input(0, texture), reply_input(1, environment),
                                     reply_input(2, mesh),
                                     reply_input(3, decode::MeshoptElements{std::vector<std::byte>(64)})};
  for (const auto& [document, format] :
       {std::pair{test::obj_corner(), ModelFormat::kObj}, std::pair{test::text_stl(), ModelFormat::kStl}}) {
    inputs.push_back(
        reply_input(4, decode_model(std::as_bytes(std::span(document)), test::mtl_corner(), format, limits)));
  }
  return inputs;
}

// One file "m.obj" of 26 times "a", deflated; by hand, as the project writes stored ones only.
std::string deflated_zip() {
  constexpr std::uint32_t kChecksum = 0xe8b53ab8;
  const std::string packed("KL\xc4\x05\x00", 5), name = "m.obj";
  const std::string fields = number(20, 2) + number(0, 2) + number(8, 2) + number(0, 4) +
                             number(kChecksum, 4) + number(std::uint32_t(packed.size()), 4) + number(26, 4) +
                             number(std::uint32_t(name.size()), 2) + number(0, 2);
  const std::string local = "PK\3\4" + fields + name + packed;
  const std::string central = "PK\1\2" + number(20, 2) + fields + number(0, 2) + number(0, 2) + number(0, 2) +
                              number(0, 4) + number(0, 4) + name;
  return local + central + "PK\5\6" + number(0, 4) + number(1, 2) + number(1, 2) +
         number(std::uint32_t(central.size()), 4) + number(std::uint32_t(local.size()), 4) + number(0, 2);
}

}  // namespace

void add_request_seeds(Seeds& seeds) {
  for (const api::FieldRow& row : api::field_rows())
    seeds["request"].push_back(api::with_value(row, row.one));
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator("tests/api/requests"))
    if (!entry.path().string().ends_with(".problem.json")) paths.push_back(entry.path().string());
  std::ranges::sort(paths);
  for (const std::string& path : paths) seeds["request"].push_back(file_text(path));
  seeds["inspect_request"] = {R"({"model":"part:model.gltf"})",
                              R"({"model":"part:model.gltf","gltfScene":1,"variant":"a"})",
                              R"({"model":"data:model/gltf+json;base64,e30="})"};
  seeds["batch"] = {
      R"({"items":[{"name":"a","changes":{"/camera/orbit/azimuthDegrees":0}},{}]})",
      R"({"request":{"output":{"width":9}},"vary":[{"pointer":"/output/width","values":[1,2]},{"pointer":"/strict","values":[true]}]})"};
  const api::StoredRender render{"bytes", "image/png", 0.5, 2, {{"code", "/p", "what"}}, "{}"};
  constexpr std::size_t kChecksumLine = 65;
  seeds["stored_render"] = {api::encode_stored_render(render).substr(kChecksumLine)};
  seeds["zip"] = {zip_archive({{"a/model.gltf", "{}"}, {"a/b.bin", std::string(64, 'x')}}), deflated_zip()};
  seeds["multipart"] = forms();
  seeds["head"] = heads();
  seeds["image_url"] = image_urls();
  seeds["keys"] = key_files();
  seeds["outbound_url"] = outbound_urls();
  seeds["traceparent"] = {"00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
                          "cc-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01-what-comes-later"};
  seeds["preset"] = {
      R"({"furnace:open":["width","model"],"output":{"height":480},"scene":{"model":"builtin:torus"}})"};
  seeds["reply"] = replies();
}

}  // namespace furnace::fuzz

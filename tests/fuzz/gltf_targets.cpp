// glTF: documents with their buffer, GLB files, accessors against a reader of their own, reports.
#include <array>
#include <cmath>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include "renderer/base/check.hpp"
#include "renderer/base/error.hpp"
#include "renderer/scene/gltf_accessor.hpp"
#include "renderer/scene/model_report.hpp"
#include "tests/fuzz/checked_decoder.hpp"
#include "tests/fuzz/expectations.hpp"
#include "tests/fuzz/mutators.hpp"

namespace furnace::fuzz {
namespace {

// Enough of a picture to be taken for one: importing does not decode.
constexpr std::string_view kPngStart = "\x89PNG\r\n\x1a\n";

// Input: the document; behind a zero byte the bytes of its "data.bin".
ModelBundle bundle_of(Input input) {
  const TextPair texts = split(input);
  ModelBundle bundle;
  bundle.document = Blob(std::string(texts.first));
  bundle.siblings["data.bin"] = Blob(std::string(texts.second));
  bundle.siblings["a.png"] = Blob(std::string(kPngStart));
  bundle.seal();
  return bundle;
}

// Two clips at once, one of them looped; what is not there moves nothing.
ImportOptions all_options() {
  ImportOptions options;
  options.variant = "a";
  options.animations = {{0, {0.4, true}}, {1, {1.6, false}}};
  return options;
}

void import(const ModelBundle& bundle) {
  CheckedDecoder decoder;
  gltf_external_uris(bundle.document, small_import_limits());
  expect_whole(import_gltf(decoder, bundle, all_options(), small_import_limits(), Deadline()));
}

void run_gltf(Input input) {
  import(bundle_of(input));
}

void run_glb(Input input) {
  ModelBundle bundle;
  bundle.document = Blob(std::string(text_of(input)));
  bundle.seal();
  import(bundle);
}

template <class Body>
std::optional<Error> error_of(Body&& body) {
  try {
    body();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

// What cannot be drawn has no report, and the other way round.
void run_inspect(Input input) {
  const ModelBundle bundle = bundle_of(input);
  CheckedDecoder decoder;
  const ImportLimits limits = small_import_limits();
  const auto import_error = error_of([&] { import_gltf(decoder, bundle, {}, limits, Deadline()); });
  const auto report_error = error_of([&] { inspect_gltf(decoder, bundle, {}, limits, Deadline()); });
  FURNACE_CHECK(import_error.has_value() == report_error.has_value(), "import: \"{}\", report: \"{}\"",
                import_error ? import_error->message : "", report_error ? report_error->message : "");
  if (!import_error) return;
  FURNACE_CHECK(import_error->code == report_error->code && import_error->pointer == report_error->pointer,
                "import fails at {}, the report at {}", import_error->pointer, report_error->pointer);
  throw *import_error;
}

// --- accessors

constexpr std::array kComponentCodes = {5120, 5121, 5122, 5123, 5125, 5126, 5124};
constexpr std::array<std::string_view, 8> kTypes = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                                    "MAT2",   "MAT3", "MAT4", "VEC5"};

std::string view_json(Taker& taker, bool may_stride) {
  const std::uint32_t offset = taker.number(2), length = taker.number(2), stride = taker.number(1);
  std::string json = fmt::format(R"({{"buffer":0,"byteOffset":{},"byteLength":{})", offset, length);
  if (may_stride && stride != 0) json += fmt::format(R"(,"byteStride":{})", stride);
  return json + "}";
}

// Input: flags, component type, element type, count, offsets and the three views that an accessor may have; the buffer.
ModelBundle accessor_bundle(Input input) {
  Taker taker(input);
  const std::uint32_t flags = taker.number(1);
  const int component = kComponentCodes[taker.number(1) % kComponentCodes.size()];
  const std::string_view type = kTypes[taker.number(1) % kTypes.size()];
  std::string accessor =
      fmt::format(R"({{"componentType":{},"type":"{}","count":{})", component, type, taker.number(2));
  if (flags & 1) accessor += fmt::format(R"(,"bufferView":0,"byteOffset":{})", taker.number(2));
  if (flags & 2) accessor += R"(,"normalized":true)";
  if (flags & 4) {
    const std::uint32_t count = taker.number(2);
    const int index_type = kComponentCodes[taker.number(1) % kComponentCodes.size()];
    const std::uint32_t indices_offset = taker.number(2), values_offset = taker.number(2);
    accessor += fmt::format(R"(,"sparse":{{"count":{},"indices":{{"bufferView":1,"componentType":{},)"
                            R"("byteOffset":{}}},"values":{{"bufferView":2,"byteOffset":{}}}}})",
                            count, index_type, indices_offset, values_offset);
  }
  std::string views;
  for (int i = 0; i < 3; ++i) views += (i > 0 ? "," : "") + view_json(taker, i == 0 || (flags & 8) != 0);
  ModelBundle bundle;
  bundle.siblings["data.bin"] = Blob(std::string(text_of(taker.rest())));
  bundle.document = Blob(fmt::format(
      R"({{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"data.bin","byteLength":{}}}],"bufferViews":[{}],)"
      R"("accessors":[{}}}]}})",
      taker.rest().size(), views, accessor));
  bundle.seal();
  return bundle;
}

// One component as the specification says (glTF 2.0, sections 3.6.2.2 and 3.6.2.3), from bytes that must be there.
double component_at(std::span<const std::byte> bytes, std::uint64_t at, const GltfAccessor& accessor) {
  const auto read = [&]<class T>(T value) {
    FURNACE_CHECK(at + sizeof value <= bytes.size(), "reads {} of {} bytes", at + sizeof value, bytes.size());
    std::memcpy(&value, bytes.data() + at, sizeof value);
    if (!accessor.normalized) return double(value);
    return std::max(double(value) / double(std::numeric_limits<T>::max()), -1.0);
  };
  switch (accessor.component) {
    case ComponentType::kByte:
      return read(std::int8_t{});
    case ComponentType::kUnsignedByte:
      return read(std::uint8_t{});
    case ComponentType::kShort:
      return read(std::int16_t{});
    case ComponentType::kUnsignedShort:
      return read(std::uint16_t{});
    case ComponentType::kUnsignedInt:
      return read(std::uint32_t{});
    case ComponentType::kFloat:
      return read(float{});
  }
  return 0;
}

// Where element `i` begins, and in which view; none: it is zero.
struct Place {
  int view;
  std::uint64_t at;
};
std::optional<Place> place_of(const GltfDocument& document, std::span<const std::byte> bytes,
                              std::uint64_t i) {
  const GltfAccessor& accessor = document.accessors[0];
  const std::uint64_t element = element_bytes(accessor.type, accessor.component);
  if (accessor.sparse) {
    const GltfSparse& sparse = *accessor.sparse;
    GltfAccessor index;
    index.component = sparse.indices_type;
    const std::uint64_t begin =
        document.buffer_views[std::size_t(sparse.indices_view)].byte_offset + sparse.indices_offset;
    for (std::uint64_t k = 0; k < sparse.count; ++k)
      if (component_at(bytes, begin + k * component_bytes(index.component), index) == double(i))
        return Place{sparse.values_view, sparse.values_offset + k * element};
  }
  if (!accessor.buffer_view) return std::nullopt;
  const GltfBufferView& view = document.buffer_views[std::size_t(*accessor.buffer_view)];
  const std::uint64_t stride = view.byte_stride != 0 ? view.byte_stride : element;
  return Place{*accessor.buffer_view, accessor.byte_offset + i * stride};
}

bool same_number(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) || a == b || std::abs(a - b) <= 1e-6 * std::abs(b);
}

void run_accessor(Input input) {
  const ModelBundle bundle = accessor_bundle(input);
  const GltfDocument document = read_gltf_document(bundle.document, small_import_limits());
  CheckedDecoder decoder;
  const GltfData data(document, bundle, small_import_limits(), decoder, Deadline());
  const GltfAccessor& accessor = document.accessors[0];
  const std::vector<float> numbers = data.read_numbers(0);
  const int components = component_count(accessor.type);
  FURNACE_CHECK(numbers.size() == accessor.count * std::uint64_t(components), "{} numbers", numbers.size());
  // Columns of small matrices are padded: nothing that is drawn is stored as such.
  const std::uint64_t packed_bytes = std::uint64_t(components) * component_bytes(accessor.component);
  if (element_bytes(accessor.type, accessor.component) != packed_bytes) return;
  const std::span<const std::byte> bytes = bundle.siblings.at("data.bin").bytes();
  const std::uint64_t looked_at = std::min<std::uint64_t>(accessor.count, 64);
  for (std::uint64_t i = 0; i < looked_at; ++i) {
    const auto place = place_of(document, bytes, i);
    for (int c = 0; c < components; ++c) {
      double expected = 0;
      if (place) {
        const GltfBufferView& view = document.buffer_views[std::size_t(place->view)];
        const std::uint64_t at = place->at + std::uint64_t(c) * component_bytes(accessor.component);
        FURNACE_CHECK(at < view.byte_length, "{} of a view of {} bytes", at, view.byte_length);
        expected = component_at(bytes, view.byte_offset + at, accessor);
      }
      const double got = numbers[std::size_t(i) * std::size_t(components) + std::size_t(c)];
      FURNACE_CHECK(same_number(got, expected), "element {}, component {}: {}, not {}", i, c, got, expected);
    }
  }
  if (accessor.type == ElementType::kScalar && accessor.component != ComponentType::kFloat)
    data.read_indices(0);
}

constexpr std::size_t kMostModelBytes = 16 << 10, kMostAccessorBytes = 1 << 10;

constexpr std::array kTargets = {
    Target{"gltf", run_gltf, kMostModelBytes, mutate_json_pair},
    Target{"glb", run_glb, kMostModelBytes, mutate_glb},
    Target{"inspect", run_inspect, kMostModelBytes, mutate_json_pair},
    Target{"accessor", run_accessor, kMostAccessorBytes, mutate_bytes},
};

}  // namespace

std::span<const Target> gltf_targets() {
  return kTargets;
}

}  // namespace furnace::fuzz

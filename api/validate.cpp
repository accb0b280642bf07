#include "api/validate.hpp"

#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include <utility>

namespace furnace::api {
namespace {

valijson::adapters::NlohmannJsonAdapter adapter(const Document& document) {
  return valijson::adapters::NlohmannJsonAdapter(
      *static_cast<const nlohmann::json*>(document.root().native()));
}

}  // namespace

struct Schema::State {
  explicit State(Document parsed) : document(std::move(parsed)) {}

  Document document;
  valijson::Schema rules;
};

Schema::Schema(std::string_view text) {
  auto state = std::make_shared<State>(Document::parse(text, {}));
  try {
    // The keywords we use mean in draft 7 what they mean in 2020-12, of which valijson does not know.
    valijson::SchemaParser(valijson::SchemaParser::kDraft7)
        .populateSchema(adapter(state->document), state->rules);
  } catch (const std::exception& exception) {
    fail(ErrorCode::kInternal, "a built-in schema is broken", {}, exception.what());
  }
  state_ = std::move(state);
}

const Document& Schema::document() const {
  return state_->document;
}

std::vector<Problem> Schema::problems(const Document& document) const {
  // Without a list of results valijson stops at the first violation, so a large wrong document costs little.
  if (valijson::Validator().validate(state_->rules, adapter(document), nullptr)) return {};
  std::vector<Problem> problems = explain(state_->document.root(), document.root());
  if (problems.empty()) problems.push_back({"", "does not fit the schema"});
  return problems;
}

}  // namespace furnace::api

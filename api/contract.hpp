// The contract as the server publishes it: the request's JSON Schema and the OpenAPI document that contains
// it.
#pragma once

#include <string>
#include <string_view>

namespace furnace::api {

// JSON Schema 2020-12 of a render request; the text that also validates.
std::string_view render_request_schema();

// The same of POST /v1/inspect's document: the place in openapi.json where it stands.
std::string_view inspect_request_schema();

// OpenAPI 3.1 with the schema put in place of its reference and `version` as info.version.
std::string openapi_document(std::string_view version);

}  // namespace furnace::api

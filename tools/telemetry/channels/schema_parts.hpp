#pragma once

#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace colift::telemetry::schema {

// Pieces of JSON schemas, as far as channels.cpp needs them. For .cpp files of this folder only.

using Json = nlohmann::ordered_json;

inline Json type(const char* name) {
  return {{"type", name}};
}
inline Json number(const std::string& what = "") {
  Json j = type("number");
  if (!what.empty()) j["description"] = what;
  return j;
}
/// A number, or null where there is none.
inline Json maybe(const std::string& what = "") {
  Json j = {{"type", {"number", "null"}}};
  if (!what.empty()) j["description"] = what;
  return j;
}
inline Json integer(const std::string& what = "") {
  Json j = type("integer");
  if (!what.empty()) j["description"] = what;
  return j;
}
inline Json text(const std::string& what = "") {
  Json j = type("string");
  if (!what.empty()) j["description"] = what;
  return j;
}
inline Json boolean(const std::string& what = "") {
  Json j = type("boolean");
  if (!what.empty()) j["description"] = what;
  return j;
}
inline Json bytes() {
  return {{"type", "string"}, {"contentEncoding", "base64"}};
}
inline Json list(Json items) {
  return {{"type", "array"}, {"items", std::move(items)}};
}
inline Json object(std::initializer_list<std::pair<const char*, Json>> properties) {
  Json all = Json::object();
  for (const auto& [name, value] : properties) all[name] = value;
  return {{"type", "object"}, {"properties", std::move(all)}};
}
inline Json titled(const char* title, Json schema) {
  Json j = {{"title", title}};
  j.update(schema);
  return j;
}
inline Json time() {
  return titled("time", object({{"sec", integer()}, {"nsec", integer()}}));
}
inline Json duration() {
  return titled("duration", object({{"sec", integer()}, {"nsec", integer()}}));
}
inline Json vector3() {
  return object({{"x", number()}, {"y", number()}, {"z", number()}});
}
inline Json quaternion() {
  return object({{"x", number()}, {"y", number()}, {"z", number()}, {"w", number()}});
}
inline Json pose() {
  return object({{"position", vector3()}, {"orientation", quaternion()}});
}
inline Json colour() {
  return object({{"r", number()}, {"g", number()}, {"b", number()}, {"a", number()}});
}

}  // namespace colift::telemetry::schema

#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

namespace backbend::validate {

/// A JSON object, field by field: `JsonObject<json>().with("code", code).with("value", value)`.
///
/// The library's own way, a list of pairs, makes an array of two for each field, copies it, and
/// takes several times as long to compile.
template <class Json>
class JsonObject {
 public:
  template <class Value>
  JsonObject&& with(const char* key, Value&& value) && {
    object_[key] = Json(std::forward<Value>(value));
    return std::move(*this);
  }
  JsonObject&& with(const char* key, JsonObject&& value) && {
    object_[key] = std::move(value.object_);
    return std::move(*this);
  }

  operator Json() && { return std::move(object_); }  // NOLINT: it is one

 private:
  Json object_ = Json::object();
};

}  // namespace backbend::validate

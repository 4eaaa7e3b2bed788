// Reads the JSON of both forms of a priors file (priors_file.h).
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>

#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/text/names.h"

namespace sweepstake {

// The store's maximum; the ledger's next number cannot wrap to 0.
inline constexpr uint64_t kMaxSequence = std::numeric_limits<int64_t>::max();

// Returns false for NaN.
inline bool IsIncrement(double value) { return value >= 0 && value <= 1e15; }

// Reads the fields of one object; keeps the first error.
class FieldReader {
 public:
  explicit FieldReader(const nlohmann::json& object) : object_(object) {}

  void Name(const char* key, std::string& value, bool required) {
    const nlohmann::json* field = Find(key, required);
    if (field == nullptr) return;
    if (!field->is_string()) return SetError(key, "is not a string");
    value = field->get_ref<const std::string&>();
    if (required && value.empty()) return SetError(key, "is empty");
    if (!text::IsOptionalName(value)) {
      SetError(key, "is over 128 bytes or holds a control character");
    }
  }

  void MeasuredBy(const char* key, std::string& value) {
    Name(key, value, false);
    if (!decision::IsMeasuredBy(value)) SetError(key, "must be absent or \"lane\"");
  }

  // An absent field keeps its value.
  void Flag(const char* key, bool& value) {
    const nlohmann::json* field = Find(key, /*required=*/false);
    if (field == nullptr) return;
    if (!field->is_boolean()) return SetError(key, "must be true or false");
    value = field->get<bool>();
  }

  template <typename Integer>
  void Count(const char* key, Integer& value, bool required,
             Integer max = std::numeric_limits<Integer>::max()) {
    const nlohmann::json* field = Find(key, required);
    if (field == nullptr) return;
    if (!field->is_number_unsigned()) return SetError(key, "is not a whole number >= 0");
    const uint64_t number = field->get<uint64_t>();
    if (number > max) return SetError(key, "is too large");
    if (required && number == 0) return SetError(key, "is 0");
    value = static_cast<Integer>(number);
  }

  void Increment(const char* key, double& value) {
    const nlohmann::json* field = Find(key, true);
    if (field == nullptr) return;
    if (!field->is_number()) return SetError(key, "is not a number");
    value = field->get<double>();
    if (!IsIncrement(value)) SetError(key, "must be from 0 to 1e15");
  }

  // Returns the array or object, or null if the field is absent.
  const nlohmann::json* Structured(const char* key, bool array) {
    const nlohmann::json* field = Find(key, true);
    if (field == nullptr) return nullptr;
    if (array ? field->is_array() : field->is_object()) return field;
    SetError(key, array ? "is not an array" : "is not an object");
    return nullptr;
  }

  // Call it after all fields were read.
  void RejectUnknown() {
    for (const auto& item : object_.items()) {
      if (!known_.contains(item.key())) return SetError(item.key(), "is an unknown field");
    }
  }

  const std::optional<std::string>& error() const { return error_; }

 private:
  const nlohmann::json* Find(const char* key, bool required) {
    known_.insert(key);
    const auto found = object_.find(key);
    if (found != object_.end()) return &*found;
    if (required) SetError(key, "is missing");
    return nullptr;
  }

  void SetError(const std::string& key, const char* what) {
    if (!error_) error_ = key.substr(0, text::kMaxNameBytes) + " " + what;
  }

  const nlohmann::json& object_;
  std::set<std::string> known_;
  std::optional<std::string> error_;
};

}  // namespace sweepstake

#include "engine_client/telemetry/conversion/audit_conversion.h"

#include <string_view>
#include <type_traits>

namespace sweepstake {
namespace {

using decision::AuditStruct;
using decision::kIsList;
using decision::kIsOptional;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

const FieldDescriptor& FieldOf(const Message& message, std::string_view name) {
  return *message.GetDescriptor()->FindFieldByName(std::string(name));
}

class Writer {
 public:
  explicit Writer(Message& message) : message_(message), reflection_(*message.GetReflection()) {}

  template <typename T>
  void operator()(std::string_view name, const T& value) {
    Put(FieldOf(message_, name), value);
  }

 private:
  template <typename T>
  void Put(const FieldDescriptor& field, const T& value) {
    if constexpr (kIsOptional<T>) {
      if (value) Put(field, *value);
    } else if constexpr (kIsList<T>) {
      for (const auto& item : value) Put(field, item);
    } else if constexpr (AuditStruct<const T>) {
      decision::VisitFields(
          value, Writer(field.is_repeated() ? *reflection_.AddMessage(&message_, &field)
                                            : *reflection_.MutableMessage(&message_, &field)));
    } else if constexpr (std::is_enum_v<T>) {
      reflection_.SetEnumValue(&message_, &field, static_cast<int>(value));
    } else if constexpr (std::is_same_v<T, bool>) {
      reflection_.SetBool(&message_, &field, value);
    } else if constexpr (std::is_same_v<T, int64_t>) {
      reflection_.SetInt64(&message_, &field, value);
    } else if constexpr (std::is_same_v<T, uint64_t>) {
      reflection_.SetUInt64(&message_, &field, value);
    } else if constexpr (std::is_same_v<T, uint32_t>) {
      field.is_repeated() ? reflection_.AddUInt32(&message_, &field, value)
                          : reflection_.SetUInt32(&message_, &field, value);
    } else if constexpr (std::is_same_v<T, double>) {
      if (field.cpp_type() == FieldDescriptor::CPPTYPE_FLOAT) {  // a field of SceneDescriptor
        reflection_.SetFloat(&message_, &field, static_cast<float>(value));
      } else {
        field.is_repeated() ? reflection_.AddDouble(&message_, &field, value)
                            : reflection_.SetDouble(&message_, &field, value);
      }
    } else {
      field.is_repeated() ? reflection_.AddString(&message_, &field, value)
                          : reflection_.SetString(&message_, &field, value);
    }
  }

  Message& message_;
  const Reflection& reflection_;
};

class Reader {
 public:
  explicit Reader(const Message& message)
      : message_(message), reflection_(*message.GetReflection()) {}

  template <typename T>
  void operator()(std::string_view name, T& value) {
    const FieldDescriptor& field = FieldOf(message_, name);
    if constexpr (kIsOptional<T>) {
      if (reflection_.HasField(message_, &field)) Get(field, value.emplace());
    } else if constexpr (kIsList<T>) {
      for (int i = 0; i < reflection_.FieldSize(message_, &field); ++i)
        GetItem(field, i, value.emplace_back());
    } else {
      Get(field, value);
    }
  }

 private:
  template <typename T>
  void Get(const FieldDescriptor& field, T& value) {
    if constexpr (AuditStruct<T>) {
      decision::VisitFields(value, Reader(reflection_.GetMessage(message_, &field)));
    } else if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(reflection_.GetEnumValue(message_, &field));
    } else if constexpr (std::is_same_v<T, bool>) {
      value = reflection_.GetBool(message_, &field);
    } else if constexpr (std::is_same_v<T, uint32_t>) {
      value = reflection_.GetUInt32(message_, &field);
    } else if constexpr (std::is_same_v<T, int64_t>) {
      value = reflection_.GetInt64(message_, &field);
    } else if constexpr (std::is_same_v<T, uint64_t>) {
      value = reflection_.GetUInt64(message_, &field);
    } else if constexpr (std::is_same_v<T, double>) {
      value = field.cpp_type() == FieldDescriptor::CPPTYPE_FLOAT
                  ? double{reflection_.GetFloat(message_, &field)}
                  : reflection_.GetDouble(message_, &field);
    } else {
      value = reflection_.GetString(message_, &field);
    }
  }

  template <typename T>
  void GetItem(const FieldDescriptor& field, int index, T& value) {
    if constexpr (AuditStruct<T>) {
      decision::VisitFields(value, Reader(reflection_.GetRepeatedMessage(message_, &field, index)));
    } else if constexpr (std::is_same_v<T, uint32_t>) {
      value = reflection_.GetRepeatedUInt32(message_, &field, index);
    } else if constexpr (std::is_same_v<T, double>) {
      value = reflection_.GetRepeatedDouble(message_, &field, index);
    } else {
      value = reflection_.GetRepeatedString(message_, &field, index);
    }
  }

  const Message& message_;
  const Reflection& reflection_;
};

}  // namespace

v1::AuditRow ToProto(const decision::AuditRow& row) {
  v1::AuditRow message;
  decision::VisitFields(row, Writer(message));
  return message;
}

std::string EncodeAuditRow(const decision::AuditRow& row) {
  return ToProto(row).SerializeAsString();
}

decision::AuditRow FromProto(const v1::AuditRow& message) {
  decision::AuditRow row;
  decision::VisitFields(row, Reader(message));
  return row;
}

}  // namespace sweepstake

// Protobuf messages with random content, by reflection: a field that is added to proto/ is filled
// without a change here.
#pragma once

#include <google/protobuf/message.h>

#include <cstdint>
#include <string>

#include "engine_client/math/hash.h"

namespace sweepstake::test_support {

class RandomMessages {
 public:
  // Sets a share of the fields (0–1); repeated numbers get `column_length` elements.
  RandomMessages(uint64_t seed, double share, int column_length)
      : random_{seed}, share_(share), column_length_(column_length) {}

  // Sets the fields of `message`. In a oneof it sets the field `chosen`.
  void Fill(google::protobuf::Message& message,
            const google::protobuf::FieldDescriptor* chosen = nullptr) {
    const google::protobuf::Descriptor& type = *message.GetDescriptor();
    for (int i = 0; i < type.field_count(); ++i) {
      const google::protobuf::FieldDescriptor& field = *type.field(i);
      const bool of_oneof = field.real_containing_oneof() != nullptr;
      if (of_oneof ? &field == chosen : Chance()) Set(message, field);
    }
  }

 private:
  using Field = google::protobuf::FieldDescriptor;

  bool Chance() { return static_cast<double>(random_.Next() >> 11) * 0x1p-53 < share_; }
  // Returns a number of any varint length.
  uint64_t Number() { return (random_.Next() | 1) >> (random_.Next() % 63); }
  double Real() { return static_cast<double>(Number()) / 1024; }
  std::string Text() { return "text" + std::to_string(random_.Next()); }

  void Set(google::protobuf::Message& message, const Field& field) {
    const bool of_messages = field.cpp_type() == Field::CPPTYPE_MESSAGE;
    const int count = !field.is_repeated() ? 1 : of_messages ? 3 : column_length_;
    for (int i = 0; i < count; ++i) SetOne(message, field);
  }

  void SetOne(google::protobuf::Message& message, const Field& field) {
    const google::protobuf::Reflection& to = *message.GetReflection();
    const bool add = field.is_repeated();
    switch (field.cpp_type()) {
      case Field::CPPTYPE_MESSAGE:
        return Fill(add ? *to.AddMessage(&message, &field) : *to.MutableMessage(&message, &field));
      case Field::CPPTYPE_UINT64:
        return add ? to.AddUInt64(&message, &field, Number())
                   : to.SetUInt64(&message, &field, Number());
      case Field::CPPTYPE_UINT32: {
        const auto value = static_cast<uint32_t>(Number() | 1);
        return add ? to.AddUInt32(&message, &field, value) : to.SetUInt32(&message, &field, value);
      }
      case Field::CPPTYPE_ENUM: {
        // Returns a value of this protocol version or of a newer one.
        const int value = static_cast<int>(1 + random_.Next() % 9);
        return add ? to.AddEnumValue(&message, &field, value)
                   : to.SetEnumValue(&message, &field, value);
      }
      case Field::CPPTYPE_BOOL:
        return to.SetBool(&message, &field, true);
      case Field::CPPTYPE_DOUBLE:
        return to.SetDouble(&message, &field, Real());
      case Field::CPPTYPE_FLOAT: {
        const auto value = static_cast<float>(Real());
        return add ? to.AddFloat(&message, &field, value) : to.SetFloat(&message, &field, value);
      }
      case Field::CPPTYPE_STRING:
        return to.SetString(&message, &field, Text());
      default:
        GOOGLE_LOG(FATAL) << field.full_name() << " has an unsupported type";
    }
  }

  math::SplitMix64 random_;
  const double share_;
  const int column_length_;
};

}  // namespace sweepstake::test_support

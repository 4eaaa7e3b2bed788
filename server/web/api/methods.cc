#include "server/web/api/methods.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/util/json_util.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"

namespace sweepstake::web {
namespace {

using google::protobuf::Message;

constexpr char kPackage[] = "sweepstake.v1.";

const Message* PrototypeOf(const google::protobuf::Descriptor* type) {
  return google::protobuf::MessageFactory::generated_factory()->GetPrototype(type);
}

}  // namespace

Methods::Methods(std::span<const std::string> names) {
  const auto* pool = google::protobuf::DescriptorPool::generated_pool();
  for (const std::string& name : names) {
    const std::string full_name = absl::StrCat(kPackage, name);
    const auto* method = pool->FindMethodByName(absl::StrReplaceAll(full_name, {{"/", "."}}));
    if (method == nullptr || method->client_streaming()) continue;
    methods_[full_name] = {.request = PrototypeOf(method->input_type()),
                           .response = PrototypeOf(method->output_type()),
                           .streams = method->server_streaming()};
  }
}

const Method* Methods::Find(std::string_view name) const {
  const auto found = methods_.find(name);
  return found == methods_.end() ? nullptr : &found->second;
}

absl::StatusOr<std::unique_ptr<Message>> FromJson(std::string_view json, const Message& prototype) {
  std::unique_ptr<Message> message(prototype.New());
  if (json.empty()) return message;
  const auto read =
      google::protobuf::util::JsonStringToMessage({json.data(), json.size()}, message.get());
  if (read.ok()) return message;
  return absl::InvalidArgumentError(
      absl::StrCat("the request is not a ", std::string(prototype.GetTypeName()),
                   " in the JSON form of protobuf: ", std::string(read.message())));
}

absl::StatusOr<std::string> ToJson(const Message& message) {
  std::string json;
  if (google::protobuf::util::MessageToJsonString(message, &json).ok()) return json;
  return absl::InternalError("an answer of the daemon cannot be written as JSON");
}

std::string Serialize(const Message& message) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

}  // namespace sweepstake::web

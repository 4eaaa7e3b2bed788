// The methods of the daemon's services that can be called over HTTP, and their messages as bytes
// and as JSON (protobuf's mapping). Safe from any thread.
#pragma once

#include <google/protobuf/message.h>
#include <grpcpp/support/byte_buffer.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::web {

struct Method {
  std::string path;  // as gRPC has it: "/sweepstake.v1.PosteriorsService/ListPosteriors"
  const google::protobuf::Message* request = nullptr;  // an empty one
  const google::protobuf::Message* response = nullptr;
  bool streams = false;  // has any number of responses
};

class Methods {
 public:
  // `names` are "PosteriorsService/ListPosteriors" and the like, of methods that this program is
  // linked with. Those with a stream of requests are left out.
  explicit Methods(std::span<const std::string> names);

  // Returns the method, or null. `name` has the package: "sweepstake.v1.SERVICE/METHOD".
  const Method* Find(std::string_view name) const;

 private:
  std::map<std::string, Method, std::less<>> methods_;
};

// Reads a message from JSON; an empty text is an empty message. Error: INVALID_ARGUMENT.
absl::StatusOr<std::unique_ptr<google::protobuf::Message>> FromJson(
    std::string_view json, const google::protobuf::Message& prototype);
// Error: INTERNAL.
absl::StatusOr<std::string> ToJson(const google::protobuf::Message& message);

// Equal messages have equal bytes.
std::string Serialize(const google::protobuf::Message& message);
grpc::ByteBuffer BufferOf(const std::string& bytes);
// Returns false if the bytes are not a message of this type.
bool Parse(grpc::ByteBuffer bytes, google::protobuf::Message& message);
// Parses a message of the prototype's type and makes JSON of it. Error: INTERNAL.
absl::StatusOr<std::string> ToJson(grpc::ByteBuffer bytes,
                                   const google::protobuf::Message& prototype);

}  // namespace sweepstake::web

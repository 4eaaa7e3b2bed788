// The methods of the daemon's services that can be called over HTTP, and their messages as bytes
// and as JSON (the mapping of protobuf). Thread-safe.
#pragma once

#include <google/protobuf/message.h>

#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::web {

struct Method {
  const google::protobuf::Message* request = nullptr;  // an empty message
  const google::protobuf::Message* response = nullptr;
  bool streams = false;  // has any number of responses
};

class Methods {
 public:
  // `names` have the form "PosteriorsService/ListPosteriors". Methods with a stream of requests are
  // omitted.
  explicit Methods(std::span<const std::string> names);

  // Returns the method, or null. `name` contains the package: "sweepstake.v1.SERVICE/METHOD".
  const Method* Find(std::string_view name) const;

 private:
  std::map<std::string, Method, std::less<>> methods_;
};

// Reads a message from JSON; an empty text is an empty message of the request's type. Error:
// INVALID_ARGUMENT.
absl::StatusOr<std::unique_ptr<google::protobuf::Message>> FromJson(
    std::string_view json, const google::protobuf::Message& prototype);
// Returns the message as JSON. Error: INTERNAL (it cannot be converted).
absl::StatusOr<std::string> ToJson(const google::protobuf::Message& message);

// Returns the message as bytes. Equal messages have equal bytes.
std::string Serialize(const google::protobuf::Message& message);

}  // namespace sweepstake::web

// What the messages of a Watch method say together: the state as it is, for who comes later. One
// for each method that has events. Not thread-safe.
#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/web/api/methods.h"

namespace sweepstake::web {

class TopicState {
 public:
  // A message of the stream.
  struct Told {
    std::string id;         // of its stamp: BOOT:SEQUENCE, the boot as 16 hexadecimal digits
    std::string json = {};  // empty if all_told
    bool all_told = false;  // all as it was when the stream began has been told
  };

  virtual ~TopicState() = default;

  // Takes a message in. Error: INTERNAL (it is none of the method's).
  virtual absl::StatusOr<Told> Take(grpc::ByteBuffer bytes) = 0;
  // Calls `tell` with messages, as JSON, that say all of the state.
  virtual void Tell(const std::function<void(const std::string& json)>& tell) const = 0;
  // Returns what Tell tells, about.
  virtual size_t bytes() const = 0;
};

// What a topic begins with.
struct TopicStart {
  grpc::ByteBuffer request;  // which also asks for the mark that all has been told
  std::unique_ptr<TopicState> state;
};

// Returns the start of the stream that the request, one of any method, asks for; without a state
// where its method has no events.
TopicStart StartOfTopic(const google::protobuf::Message& request);

}  // namespace sweepstake::web

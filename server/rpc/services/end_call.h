// How a function that answers one request reads the store and ends the call.
#pragma once

#include <functional>
#include <utility>

#include "absl/status/status.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// Ends the call. Called once, on any thread. The response must be complete before this call.
// Request and response live until the call has ended.
using EndCall = std::function<void(const absl::Status&)>;

// The status of a call whose job the store has refused, because its queue is full.
inline absl::Status StoreBusy() {
  return Refused(v1::ERROR_REASON_STORE_BUSY, "the prior store is overloaded; try again later");
}

// Runs `read` on the store's reading thread and then `answer(result)` on the loop. The status that
// `answer` returns ends the call.
template <typename Read, typename Answer>
void ReadAndAnswer(ServiceContext& context, const EndCall& end, Read read, Answer answer) {
  const bool submitted =
      context.store.Read([&loop = context.loop, end, read = std::move(read),
                          answer = std::move(answer)](priors::PriorReader& store) {
        loop.Post([end, answer, result = read(store)] {
          end(result.ok() ? answer(*result) : StoreFailed(result.status()));
        });
      });
  if (!submitted) end(StoreBusy());
}

}  // namespace sweepstake::rpc

// The answer to a call with a stream of responses: one JSON message per line, as fast as the client
// reads. An error before the first line is the status of the answer; a later error is the last
// line. Used on the server's thread only.
#pragma once

#include <memory>

#include "server/web/api/methods.h"
#include "server/web/api/upstream.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

// Calls the method and answers with its responses. The method must outlive the call.
void AnswerWithLines(Upstream& upstream, const Method& method, UpstreamRequest request,
                     std::shared_ptr<Exchange> exchange);

}  // namespace sweepstake::web

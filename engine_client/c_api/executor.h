// Makes the executor of a world, a session or a set of proxies: the caller's own executor, or a
// thread pool of the library.
//
// Thread safety: as Executor (sweepstake/executor.h).
#pragma once

#include <cstdint>
#include <memory>

#include "engine_client/c_api/boundary.h"
#include "sweepstake/executor.h"

namespace sweepstake::c_api {

// Sets `executor`, or leaves it null if only the calling thread is requested. SWP_INVALID_ARGUMENT
// if a value is out of range, or if `thread_count` contradicts `given`.
swp_result MakeExecutor(uint32_t thread_count, const swp_executor* given,
                        std::unique_ptr<Executor>& executor);

}  // namespace sweepstake::c_api

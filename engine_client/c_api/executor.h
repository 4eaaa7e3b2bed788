// The threads of a world, a session or a set of proxies: the caller's executor, or a pool of the
// library.
//
// Thread safety: as Executor (sweepstake/executor.h).
#pragma once

#include <cstdint>
#include <memory>

#include "engine_client/c_api/boundary.h"
#include "sweepstake/executor.h"

namespace sweepstake::c_api {

// Leaves `executor` null if only the calling thread is requested. SWP_INVALID_ARGUMENT for values
// that are out of range or contradict each other.
swp_result MakeExecutor(uint32_t thread_count, const swp_executor* given,
                        std::unique_ptr<Executor>& executor);

}  // namespace sweepstake::c_api

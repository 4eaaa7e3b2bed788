// The threads of a world, a session or a set of proxies: the caller's own, or a pool of ours.
//
// Thread safety: as Executor (sweepstake/executor.h).
#pragma once

#include <cstdint>
#include <memory>

#include "engine_client/c_api/boundary.h"
#include "sweepstake/executor.h"

namespace sweepstake::c_api {

// Null in `executor` where the calling thread alone is asked for. SWP_INVALID_ARGUMENT for values
// that are none or exclude one another.
swp_result MakeExecutor(uint32_t thread_count, const swp_executor* given,
                        std::unique_ptr<Executor>& executor);

}  // namespace sweepstake::c_api

// Independent pieces of work spread over threads.
#pragma once

#include <cstdint>
#include <functional>

namespace sweepstake::cli {

// Runs work(0) … work(count − 1), in any order, on `thread_count` threads, at least one, and
// returns when all are done. `on_done` hears from the calling thread how many are.
void RunParallel(uint64_t count, uint32_t thread_count, const std::function<void(uint64_t)>& work,
                 const std::function<void(uint64_t done)>& on_done);

}  // namespace sweepstake::cli

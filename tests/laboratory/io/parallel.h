// Runs independent pieces of work on several threads.
#pragma once

#include <cstdint>
#include <functional>

namespace sweepstake::cli {

// Runs work(0) … work(count − 1) in any order on `thread_count` threads (0 counts as 1) and returns
// when all are done. `on_done` is called on the calling thread with the number of pieces done.
void RunParallel(uint64_t count, uint32_t thread_count, const std::function<void(uint64_t)>& work,
                 const std::function<void(uint64_t done)>& on_done);

}  // namespace sweepstake::cli

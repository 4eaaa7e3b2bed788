// The file of a cost trace, FILE.costs:
//
//   at  bytes
//    0      8  "SWPCOSTS"
//    8      4  version, now 1
//   12      4  0
//   16      8  size of the rest, P
//   24      8  FNV-1a, 64 bits, of the rest
//   32      P  a sweepstake.costs.CostTrace (costs.proto)
//
// Numbers are little-endian; the file has exactly 32 + P bytes. Reading checks all of it, the
// trace's own shape included, before anything is handed out: what was read needs no checks. Memory
// while reading: some ten times the file, which may have kMostCostsBytes. Functions are safe from
// any thread on different files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "engine_client/cli/trace/cost_trace.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

inline constexpr uint64_t kMostCostsBytes = uint64_t{256} << 20;
inline constexpr uint32_t kMostTracedArms = 64;
inline constexpr uint32_t kMostTracedFrames = 1'000'000;
inline constexpr uint32_t kMostBurstFrames = 64;
inline constexpr uint64_t kMostTracedNs = 3'600'000'000'000;  // an hour for one frame

// The file appears whole or not at all. REQUIRES: a trace that ReadCosts would accept, but for its
// size. The errors of WholeFile; kResourceExhausted: more than kMostCostsBytes.
Status WriteCosts(const std::filesystem::path& path, const CostTrace& trace);

// kNotFound: no such file. kDataLoss: not a sound cost trace. Every message names the file, what is
// wrong and what to do.
Result<CostTrace> ReadCosts(const std::filesystem::path& path);

// What makes `trace` unfit for a file, or nothing: a column of another length than its frames and
// arms ask for, a number out of bounds, bursts or descriptors out of order.
std::string FlawOf(const CostTrace& trace);

}  // namespace sweepstake::cli

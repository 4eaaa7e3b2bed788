// The machine, the build and the libraries of a bench run. Thread-safe.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

struct LibraryVersion {
  std::string name;
  std::string version;
};

// Where and with what the run was made.
struct BenchMachine {
  std::string date_utc;     // of the start, as 2026-01-31T12:00:00Z
  std::string program;      // version of Sweepstake
  std::string cpu;          // the processor's own name
  uint32_t core_count = 0;  // hardware threads
  std::string system;       // kernel and architecture
  std::string compiler;
  std::string simd_target;                // the one Highway chose on this machine
  std::vector<LibraryVersion> libraries;  // Highway, then those of the peers that took part
  std::vector<std::string> absent_peers;  // a line each: library, and the package that brings it
};

// With Highway among the libraries; `peers` adds their versions and what is absent.
BenchMachine DescribeMachine(std::span<const PeerLibrary> peers);

// As the documents of bench and experiment hold it.
nlohmann::ordered_json MachineJson(const BenchMachine& machine);

}  // namespace sweepstake::cli

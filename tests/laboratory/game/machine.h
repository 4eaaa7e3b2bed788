// Describes the machine, the build and its libraries. Thread-safe.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace sweepstake::cli {

struct LibraryVersion {
  std::string name;
  std::string version;
};

// The machine, system and software that a run was made with.
struct Machine {
  std::string date_utc;     // the start, as 2026-01-31T12:00:00Z
  std::string program;      // Sweepstake's version
  std::string cpu;          // the processor's own name
  uint32_t core_count = 0;  // hardware threads
  std::string system;       // kernel and architecture
  std::string compiler;
  std::string simd_target;                // SimdTarget() (simd.h)
  std::vector<LibraryVersion> libraries;  // Highway's, then those of the peers that were run
  // Per peer library that this build leaves out: its name and Debian package.
  std::vector<std::string> absent_peers;
};

// Describes this machine. Lists Highway as the only library; RunBench adds the libraries of the
// peers.
Machine DescribeMachine();

// Returns the object that the JSON documents of bench and experiment contain.
nlohmann::ordered_json MachineJson(const Machine& machine);

}  // namespace sweepstake::cli

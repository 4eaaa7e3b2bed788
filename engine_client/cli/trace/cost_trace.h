// What every arm costs on every frame of a scene: the full information that policies are judged
// against (`sweepstake trace` measures it, `sweepstake replay` reads it), and its file FILE.costs.
//
// Times are nanoseconds on the measuring machine. "Frame-major" columns hold frame_count ×
// arm_count values: that of arm a in frame f is at f · arm_count + a. How they were measured:
// trace_run.h. The file:
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
// while reading: some ten times the file, which may have kMaxCostsBytes. Functions are safe from
// any thread on different files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sweepstake/frame_sample.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

inline constexpr uint64_t kMaxCostsBytes = uint64_t{256} << 20;
inline constexpr uint32_t kMaxTracedArms = 64;
inline constexpr uint32_t kMaxTracedFrames = 1'000'000;
inline constexpr uint32_t kMaxBurstFrames = 64;
inline constexpr uint64_t kMaxTracedNs = 3'600'000'000'000;  // an hour for one frame

struct TracedArm {
  std::string name;
  uint32_t version = 0;
};

// A short visit to every arm by structures that do not run along with the scene: built on the
// burst's first frame, updated on the frames after it. It says what a switch costs, and it is what
// the shadow lane of a game sees. An arm that is held in the burst's first frame ran frames 0 and 1
// at most; its last measured time stands for the others.
struct TraceBurst {
  uint32_t first_frame = 0;
  // Arm-major: of arm a in the burst's frame k, at a · burst_frame_count + k. k = 0: Build and
  // search; else Update and search.
  std::vector<uint64_t> detection_ns;
};

struct TracedDescriptor {
  uint32_t frame = 0;  // measured over the frames before it
  SceneDescriptor descriptor;
};

struct CostTrace {
  std::string scene;    // as given to --scene, without folders
  uint64_t seed = 0;    // of the scene
  std::string machine;  // class of the machine that measured
  std::vector<TracedArm> arms;
  uint32_t frame_count = 0;
  uint32_t repeat_count = 1;  // runs of the scene; every time is their lower quartile

  // Per frame.
  std::vector<uint32_t> object_count;
  std::vector<uint32_t> pair_count;
  std::vector<uint64_t> step_ns;     // the scene's own motion
  std::vector<uint64_t> control_ns;  // a second structure of control_arm: the A/A control
  // Frame-major.
  std::vector<uint64_t> detection_ns;
  std::vector<uint64_t> aabb_check_count;
  std::vector<uint64_t> native_bytes;
  // 1: the arm is very slow and was not measured in this frame; its values are another frame's.
  std::vector<uint8_t> held;

  uint32_t control_arm = 0;
  uint32_t burst_frame_count = 0;             // frames of each burst
  std::vector<TraceBurst> bursts;             // ordered by first_frame, at least one
  std::vector<TracedDescriptor> descriptors;  // ordered by frame

  uint32_t arm_count() const { return static_cast<uint32_t>(arms.size()); }
  uint64_t detection(uint32_t frame, uint32_t arm) const {
    return detection_ns[size_t{frame} * arms.size() + arm];
  }
};

// What makes `trace` unfit for a file; empty where nothing does. Flaws are a column of another
// length than its frames and arms ask for, a number out of bounds, and bursts or descriptors out of
// order.
std::string FlawOf(const CostTrace& trace);

// The file appears whole or not at all. REQUIRES: FlawOf(trace).empty(). The errors of WholeFile;
// kResourceExhausted: the file would have more than kMaxCostsBytes.
Status WriteCosts(const std::filesystem::path& path, const CostTrace& trace);

// kNotFound: there is no such file. kDataLoss: it holds no valid cost trace. Every message names
// the file, what is wrong and what to do.
Result<CostTrace> ReadCosts(const std::filesystem::path& path);

}  // namespace sweepstake::cli

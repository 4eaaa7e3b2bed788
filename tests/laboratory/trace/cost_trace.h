// The cost of every arm on every frame of a scene, and its file FILE.costs. `sweepstake-lab trace`
// measures it; `sweepstake-lab replay` judges policies by it.
//
// Times are nanoseconds on the measuring machine; trace_run.h says how they are measured.
// "Frame-major" columns hold frame_count × arm_count values: arm a has its value of frame f at
// index f · arm_count + a. The file is a CBOR document (io/document_file.h) with the fields of
// CostTrace. A trace that was read is valid. All functions are thread-safe on different files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sweepstake/frame_sample.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

inline constexpr uint32_t kMaxTracedFrames = 1'000'000;
inline constexpr uint32_t kMaxBurstFrames = 64;
inline constexpr uint64_t kMaxTracedNs = 3'600'000'000'000;  // one hour, the maximum of a frame

struct TracedArm {
  std::string name;
  uint32_t version = 0;
};

// A burst shows the cost of a switch, and the times that the shadow lane of a game measures. For
// this, every arm gets a fresh structure, which is built on the burst's first frame and updated on
// the frames after it. A very slow arm (`held` in the burst's first frame) runs only frames 0 and
// 1, or none. Its last measured time is used for the other frames.
struct TraceBurst {
  uint32_t first_frame = 0;
  // Arm-major: the value of arm a in the burst's frame k is at a · burst_frame_count + k. It is the
  // time of Build and search for k = 0, else of Update and search.
  std::vector<uint64_t> detection_ns;
};

struct TracedDescriptor {
  uint32_t frame = 0;  // the descriptor was measured over the frames before this one
  SceneDescriptor descriptor;
};

struct CostTrace {
  std::string scene;    // as given to --scene, without folders
  uint64_t seed = 0;    // of the scene
  std::string machine;  // machine class
  std::vector<TracedArm> arms;
  uint32_t frame_count = 0;
  uint32_t repeat_count = 1;  // runs of the scene; every time is the lower quartile over them

  // One value per frame.
  std::vector<uint32_t> object_count;
  std::vector<uint32_t> pair_count;
  std::vector<uint64_t> step_ns;     // time of the scene's own motion
  std::vector<uint64_t> control_ns;  // times of the A/A control: a second structure of control_arm
  // The columns from detection_ns to held are frame-major: arm_count values per frame.
  std::vector<uint64_t> detection_ns;
  std::vector<uint64_t> aabb_check_count;
  std::vector<uint64_t> native_bytes;
  // 1 if the arm is very slow and was not measured in this frame. Its values in this frame are
  // copies from another frame.
  std::vector<uint8_t> held;

  uint32_t control_arm = 0;
  uint32_t burst_frame_count = 0;             // frames per burst
  std::vector<TraceBurst> bursts;             // ordered by first_frame, at least one
  std::vector<TracedDescriptor> descriptors;  // ordered by frame

  uint32_t arm_count() const { return static_cast<uint32_t>(arms.size()); }
  uint64_t detection(uint32_t frame, uint32_t arm) const {
    return detection_ns[size_t{frame} * arms.size() + arm];
  }
};

// Returns why the trace is invalid, or an empty text if it is valid.
std::string ErrorOf(const CostTrace& trace);

// Writes and reads the file, as WriteDocument and ReadDocument do. WriteCosts REQUIRES:
// ErrorOf(trace).empty().
Status WriteCosts(const std::filesystem::path& path, const CostTrace& trace);
Result<CostTrace> ReadCosts(const std::filesystem::path& path);

}  // namespace sweepstake::cli

// Runs one backend over a scene's frames and writes a line before and after each frame.
// neon_instructions.py counts the instructions between the two lines, because times under an
// emulator are meaningless.
//
//   frames BACKEND SCENE OBJECTS FRAMES        FRAMES: 2 or more; the first frame builds
//
// Lines: "begin" and "end PAIRS CHECKS" for each frame after the first one, then the instruction
// set that ran. Exit status 1: bad usage.
#include <charconv>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "sweepstake/simd.h"

namespace sweepstake {
namespace {

uint32_t NumberOf(std::string_view text) {
  uint32_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

int Run(std::string_view backend, std::string_view scene_name, uint32_t objects, uint32_t frames) {
  const auto scene =
      MakeScene(scene_name, {.object_count = objects, .spawn_seed = 7, .motion_seed = 8});
  const auto broad_phase = MakeBroadPhase(backend);
  if (!scene.ok() || !broad_phase.ok() || frames < 2) return 1;
  // Flush each line at once, because its position among the instructions matters.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  PairBuffer pairs;
  (*broad_phase)->Build((*scene)->aabbs());
  (*broad_phase)->FindPairs(pairs);
  for (uint32_t frame = 1; frame < frames; ++frame) {
    (*scene)->Step();
    pairs.Clear();
    std::puts("begin");
    (*broad_phase)->Update((*scene)->aabbs());
    (*broad_phase)->FindPairs(pairs);
    std::printf("end %zu %" PRIu64 "\n", pairs.size(), (*broad_phase)->aabb_check_count());
  }
  const std::string_view simd = SimdTarget();
  std::printf("%.*s\n", static_cast<int>(simd.size()), simd.data());
  return 0;
}

}  // namespace
}  // namespace sweepstake

int main(int argc, char** argv) {
  using sweepstake::NumberOf;
  if (argc == 5 && sweepstake::Run(argv[1], argv[2], NumberOf(argv[3]), NumberOf(argv[4])) == 0)
    return 0;
  std::fprintf(stderr, "usage: frames BACKEND SCENE OBJECTS FRAMES\n");
  return 1;
}

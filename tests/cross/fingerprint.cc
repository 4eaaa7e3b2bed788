// Writes data that must be equal on every platform: a line per scene, object count, backend, number
// of threads and frame, with hashes of the boxes' bits and of the sorted pairs, and a line per
// reference scene with a hash of its recording. tests/cross.sh compares the outputs byte by byte.
//
//   fingerprint OUT
//
// Exit status 1: something could not be created or written; 2: bad usage.
#include <algorithm>
#include <bit>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/math/hash.h"
#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/changing_scenes.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

constexpr uint64_t kSeed = 7;
constexpr size_t kPoolThreads = 3;

// FNV-1a of words. Their bytes enter in little-endian order on every machine.
class Hash {
 public:
  void Add(uint32_t word) { value_ = math::Fnv1aOfWord(value_, word); }
  uint64_t value() const { return value_; }

 private:
  uint64_t value_ = math::kFnv1aStart;
};

template <typename T>
T Need(Result<T> result) {
  if (!result.ok()) {
    std::fprintf(stderr, "fingerprint: %s\n", result.status().message().c_str());
    std::exit(1);
  }
  return std::move(*result);
}

uint64_t BoxesHash(std::span<const Aabb> boxes) {
  Hash hash;
  for (const Aabb& box : boxes) {
    for (const float value : box.min) hash.Add(std::bit_cast<uint32_t>(value));
    for (const float value : box.max) hash.Add(std::bit_cast<uint32_t>(value));
  }
  return hash.value();
}

// Sorts the pairs and returns their hash.
uint64_t PairsHash(std::span<OverlapPair> pairs) {
  std::ranges::sort(pairs);
  Hash hash;
  for (const OverlapPair& pair : pairs) {
    hash.Add(pair.a);
    hash.Add(pair.b);
  }
  return hash.value();
}

struct Backend {
  std::unique_ptr<BroadPhase> broad_phase;
  size_t thread_count;
};

// Returns every backend twice: with one thread, and with the threads of `pool`.
std::vector<Backend> MakeBackends(Executor& pool) {
  std::vector<Backend> backends;
  for (const std::string_view name : BroadPhaseNames()) {
    backends.push_back({Need(MakeBroadPhase(name)), 1});
    backends.push_back({Need(MakeBroadPhase(name, {.executor = &pool})), kPoolThreads});
  }
  return backends;
}

class Fingerprint {
 public:
  Fingerprint(std::FILE* out, Executor& pool) : out_(out), pool_(pool) {}

  void AddScene(Scene& scene, int frame_count) {
    const std::vector<Backend> backends = MakeBackends(pool_);
    for (int frame = 0; frame < frame_count; ++frame) {
      if (frame > 0) scene.Step();
      for (const Backend& backend : backends) AddFrame(scene, frame, backend);
    }
  }

  void AddRecording(Scene& scene, int frame_count, const std::filesystem::path& path) {
    const Status recorded = RecordScene(scene, static_cast<uint64_t>(frame_count), path.string());
    if (!recorded.ok()) {
      std::fprintf(stderr, "fingerprint: %s\n", recorded.message().c_str());
      std::exit(1);
    }
    Hash hash;
    std::ifstream file(path, std::ios::binary);
    for (std::istreambuf_iterator<char> byte(file), end; byte != end; ++byte) {
      hash.Add(static_cast<unsigned char>(*byte));
    }
    file.close();
    std::filesystem::remove(path);
    std::fprintf(out_, "%s file %016" PRIx64 "\n", std::string(scene.name()).c_str(), hash.value());
  }

 private:
  void AddFrame(const Scene& scene, int frame, const Backend& backend) {
    const std::span<const Aabb> boxes = scene.aabbs();
    BroadPhase& broad_phase = *backend.broad_phase;
    if (frame == 0) {
      broad_phase.Build(boxes);
    } else {
      broad_phase.Update(boxes);
    }
    pairs_.Clear();
    broad_phase.FindPairs(pairs_);
    std::fprintf(out_, "%s objects %zu frame %d boxes %016" PRIx64,
                 std::string(scene.name()).c_str(), boxes.size(), frame, BoxesHash(boxes));
    std::fprintf(out_, " %s threads %zu pairs %zu %016" PRIx64 "\n",
                 std::string(broad_phase.name()).c_str(), backend.thread_count, pairs_.size(),
                 PairsHash(pairs_.pairs()));
  }

  std::FILE* out_;
  Executor& pool_;
  PairBuffer pairs_;
};

std::unique_ptr<Scene> NamedScene(std::string_view name, uint32_t object_count) {
  return Need(MakeScene(
      name, {.object_count = object_count, .spawn_seed = kSeed, .motion_seed = kSeed + 1}));
}

void AddAll(Fingerprint& fingerprint, const std::filesystem::path& scratch) {
  for (const std::string_view name : SceneNames(SceneGroup::kReference)) {
    fingerprint.AddScene(*NamedScene(name, 1000), 20);
    fingerprint.AddRecording(*NamedScene(name, 100), 20, scratch);
  }
  // With 10,000 objects the work is divided among several threads.
  for (const std::string_view name : {"suite-b", "suite-g"}) {
    fingerprint.AddScene(*NamedScene(name, 10'000), 3);
  }
  for (const std::string_view name : SceneNames(SceneGroup::kChanging)) {
    constexpr uint32_t kRegimeFrames = 5;
    fingerprint.AddScene(*MakeChangingScene(name, 300, kSeed, kRegimeFrames), 20);
  }
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    fingerprint.AddScene(*MakeDegenerateScene(name, 300, kSeed), 8);
  }
}

int Main(const char* path) {
  std::FILE* out = std::fopen(path, "wb");
  if (out == nullptr) {
    std::fprintf(stderr, "fingerprint: cannot write %s\n", path);
    return 1;
  }
  const std::unique_ptr<Executor> pool = MakeThreadPool(kPoolThreads);
  Fingerprint fingerprint(out, *pool);
  AddAll(fingerprint, std::string(path) + ".aabbs");
  if (std::fclose(out) == 0) return 0;
  std::fprintf(stderr, "fingerprint: cannot write %s\n", path);
  return 1;
}

}  // namespace
}  // namespace sweepstake

int main(int argc, char** argv) {
  if (argc == 2) return sweepstake::Main(argv[1]);
  std::fprintf(stderr, "usage: fingerprint OUT\n");
  return 2;
}

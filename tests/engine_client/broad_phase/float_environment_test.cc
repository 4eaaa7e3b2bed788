// Runs the library in every floating-point environment that a game may have set, and compares the
// results with those in the default one. The conformance tests compare the latter with the
// definition of overlap.
//
// Code between KeepsMode's braces runs in the game's environment. It must not compute with
// floating-point numbers itself, because even an exact comparison may trap.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine_client/scene/box_scenes.h"
#include "sweepstake/proxy_set.h"
#include "sweepstake/scene.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/float_modes.h"

namespace sweepstake {
namespace {

using test_support::FloatMode;
using test_support::FloatModes;
using test_support::KeepsMode;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kTiny = std::numeric_limits<float>::denorm_min();

using Frames = std::vector<std::vector<Aabb>>;
using Sequence = std::vector<std::vector<OverlapPair>>;

Frames FramesOf(std::string_view scene_name, uint32_t count, int frame_count) {
  const auto made = MakeScene(scene_name, {.object_count = count});
  Frames frames;
  for (int frame = 0; frame < frame_count; ++frame) {
    const auto boxes = (*made)->aabbs();
    frames.emplace_back(boxes.begin(), boxes.end());
    (*made)->Step();
  }
  return frames;
}

// Boxes whose coordinates are subnormal: they are distinct only if these are kept.
Frames SubnormalFrames(uint32_t count) {
  Frames frames(3);
  for (size_t frame = 0; frame < frames.size(); ++frame) {
    for (uint32_t k = 0; k < count; ++k) {
      const auto place = static_cast<uint32_t>(frame) + k * 5 % count;
      const float low = std::bit_cast<float>(3 * place);
      const float high = std::bit_cast<float>(3 * place + k % 7);
      frames[frame].push_back({{low, low, 0}, {high, high, 0}});
    }
  }
  return frames;
}

// The backend's pairs in each frame, in their order.
Sequence PairsOf(BroadPhase& backend, const Frames& frames) {
  Sequence sequence;
  PairBuffer pairs;
  for (const std::vector<Aabb>& boxes : frames) {
    sequence.empty() ? backend.Build(boxes) : backend.Update(boxes);
    pairs.Clear();
    backend.FindPairs(pairs);
    sequence.emplace_back(pairs.pairs().begin(), pairs.pairs().end());
  }
  return sequence;
}

struct Case {
  std::string name;
  Frames frames;
  std::map<std::string_view, Sequence> expected;  // by arm
};

// Made once, in the default environment.
const std::vector<Case>& Cases() {
  static const std::vector<Case> cases = [] {
    std::vector<Case> made;
    for (const std::string_view scene : SceneNames(SceneGroup::kDegenerate)) {
      made.push_back({std::string(scene), FramesOf(scene, 100, 3), {}});
    }
    made.push_back({"suite-g", FramesOf("suite-g", 700, 3), {}});
    made.push_back({"subnormal", SubnormalFrames(200), {}});
    for (Case& one : made) {
      for (const std::string_view arm : BroadPhaseNames()) {
        one.expected[arm] = PairsOf(*test_support::MakeOrThrow(arm), one.frames);
      }
    }
    return made;
  }();
  return cases;
}

class InEachFloatMode : public testing::TestWithParam<FloatMode> {};

TEST_P(InEachFloatMode, EachArmFindsTheSamePairsInTheSameOrder) {
  for (const Case& one : Cases()) {
    for (const std::string_view arm : BroadPhaseNames()) {
      Sequence found;
      EXPECT_TRUE(KeepsMode(GetParam(), [&] {
        const auto backend = test_support::MakeOrThrow(arm);
        found = PairsOf(*backend, one.frames);
      }));
      EXPECT_TRUE(found == one.expected.at(arm)) << arm << " in " << one.name;
    }
  }
}

TEST(FloatEnvironment, SubnormalBoxesHaveThePairsOfTheDefinition) {
  const Frames frames = SubnormalFrames(200);
  for (const std::string_view arm : BroadPhaseNames()) {
    const auto backend = test_support::MakeOrThrow(arm);
    PairBuffer pairs;
    for (const std::vector<Aabb>& boxes : frames) {
      backend->Build(boxes);
      EXPECT_EQ(test_support::FindPairsError(*backend, boxes, pairs), "") << arm;
    }
  }
}

// The job system of a game: each part runs on a thread of its own, which has the game's mode.
class ThreadsInMode final : public Executor {
 public:
  explicit ThreadsInMode(const FloatMode& mode) : mode_(mode) {}
  size_t thread_count() const noexcept override { return 3; }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    for (size_t part = 0; part < part_count; ++part) {
      std::thread([&] { kept_mode_ &= KeepsMode(mode_, [&] { run_part(context, part); }); }).join();
    }
  }
  bool kept_mode() const { return kept_mode_; }

 private:
  const FloatMode& mode_;
  bool kept_mode_ = true;
};

TEST_P(InEachFloatMode, PartsOnOtherThreadsFindTheSamePairs) {
  const Frames frames = FramesOf("suite-g", 10'000, 2);
  for (const std::string_view arm : BroadPhaseNames()) {
    const auto alone = test_support::MakeOrThrow(arm);
    const Sequence expected = PairsOf(*alone, frames);
    ThreadsInMode threads(GetParam());
    const auto spread = std::move(*MakeBroadPhase(arm, {.executor = &threads}));
    EXPECT_TRUE(PairsOf(*spread, frames) == expected) << arm;
    EXPECT_TRUE(threads.kept_mode()) << arm;
    Sequence found;
    EXPECT_TRUE(KeepsMode(GetParam(), [&] {
      const auto pool = MakeThreadPool(2);  // its thread starts in the mode of this one
      const auto pooled = std::move(*MakeBroadPhase(arm, {.executor = pool.get()}));
      found = PairsOf(*pooled, frames);
    }));
    EXPECT_TRUE(found == expected) << arm;
  }
}

TEST_P(InEachFloatMode, ScenesMoveAlike) {
  for (const std::string_view scene : SceneNames()) {
    const Frames expected = FramesOf(scene, 60, 4);
    Frames found;
    EXPECT_TRUE(KeepsMode(GetParam(), [&] { found = FramesOf(scene, 60, 4); }));
    ASSERT_EQ(found.size(), expected.size());
    for (size_t frame = 0; frame < found.size(); ++frame) {
      ASSERT_EQ(found[frame].size(), expected[frame].size());
      if (found[frame].empty()) continue;  // memcmp accepts no null pointer
      EXPECT_EQ(std::memcmp(found[frame].data(), expected[frame].data(),
                            found[frame].size() * sizeof(Aabb)),
                0)
          << scene << " in frame " << frame;
    }
  }
}

// Everything that a game reads from a ProxySet, as words.
class ProxyScript {
 public:
  explicit ProxyScript(const Frames& frames) : frames_(frames), set_(Options()) {}

  std::vector<uint32_t> Run() {
    AddAll();
    for (size_t frame = 1; frame < frames_.size(); ++frame) {
      set_.Move(handles_, frames_[frame]);
      ChangeSome(frame);
      Resolve(frame);
      Query(frame);
    }
    Refuse();
    return std::move(words_);
  }

 private:
  static ProxySetOptions Options() {
    ProxySetOptions options;
    options.pair_events = true;
    options.event_margin = 0.05F;
    return options;
  }

  void AddAll() {
    const auto& boxes = frames_.front();
    handles_.resize(boxes.size());
    std::vector<ProxyOptions> options(boxes.size());
    for (size_t k = 0; k < boxes.size(); ++k) options[k].is_static = k % 5 == 0;
    set_.AddMany(boxes, options, handles_);
  }

  void ChangeSome(size_t frame) {
    for (size_t k = frame; k < handles_.size(); k += 9) {
      set_.SetSleeping(handles_[k], k % 2 == 0);
      if (k % 4 == 0) set_.SetStatic(handles_[k], k % 8 == 0);
    }
    set_.Remove(handles_[frame]);
    handles_[frame] = set_.Add(frames_[frame][frame], {.is_static = frame % 2 == 0});
    constexpr float kOffset[3] = {0.3F, -0.7F, 1e-40F};
    constexpr float kBroken[3] = {kNan, 0, 0};
    Add(set_.ShiftOrigin(kOffset).ok());
    Add(set_.ShiftOrigin(kBroken).ok());
  }

  void Resolve(size_t frame) {
    frame == 1 ? backend_->Build(set_.moving_boxes()) : backend_->Update(set_.moving_boxes());
    pairs_.Clear();
    backend_->FindPairs(pairs_);
    for (const OverlapPair pair : set_.Resolve(pairs_.pairs())) {
      Add(pair.a);
      Add(pair.b);
    }
    for (const ProxyPair& pair : set_.added()) Add(pair.a.index ^ pair.b.index << 16);
    for (const ProxyPair& pair : set_.removed()) Add(pair.a.index ^ pair.b.index << 16);
  }

  void Query(size_t frame) {
    const Aabb box = frames_[frame][3];
    std::vector<ProxyHandle> found;
    std::vector<RayHit> hits;
    RayHit nearest;
    set_.QueryBox(box, {}, found);
    Add(found);
    Add(set_.QuerySphere({{box.min[0], box.min[1], box.min[2]}, 3.3F}, {}, found).ok());
    Add(found);
    const Ray ray = {{box.min[0], box.min[1], box.min[2]}, {0.1F, 0, -0.3F}, 1e6F};
    Add(set_.CastRay(ray, {}, hits).ok());
    Add(hits);
    Add(set_.CastRayNearest(ray, {}, nearest).ok());
    Add({nearest});
    const BoxSweep sweep = {box, {1.7F, 1e-41F, -2.3F}};
    Add(set_.SweepBox(sweep, {}, hits).ok());
    Add(hits);
    Add(set_.SweepBoxNearest(sweep, {}, nearest).ok());
    Add({nearest});
    QueryMany(ray, sweep);
  }

  void QueryMany(const Ray& ray, const BoxSweep& sweep) {
    set_.PrepareQueries();
    std::array<RayHit, 1> hits;
    Add(std::as_const(set_).CastRays({&ray, 1}, {}, hits).ok());
    Add({hits[0]});
    Add(std::as_const(set_).SweepBoxes({&sweep, 1}, {}, hits).ok());
    Add({hits[0]});
    std::vector<ProxyHandle> found(300);
    size_t end = 0;
    Add(std::as_const(set_).QueryBoxes({&sweep.box, 1}, {}, found, {&end, 1}).ok());
    Add(static_cast<uint32_t>(end));
    Add(found);
  }

  // Calls that must be refused, or find nothing, because a value is NaN or infinite.
  void Refuse() {
    constexpr Aabb kBroken = {{kNan, 0, -kInfinity}, {1, kNan, kInfinity}};
    std::vector<ProxyHandle> found;
    std::vector<RayHit> hits;
    RayHit nearest;
    set_.Move(handles_[0], kBroken);
    set_.QueryBox(kBroken, {}, found);
    Add(found);
    Add(set_.QuerySphere({{kNan, 0, 0}, kNan}, {}, found).ok());
    Add(set_.QuerySphere({{0, 0, 0}, kInfinity}, {}, found).ok());
    Add(set_.CastRay({{kNan, 0, 0}, {kInfinity, 0, 0}, kNan}, {}, hits).ok());
    Add(set_.SweepBox({kBroken, {kNan, 0, 0}}, {}, hits).ok());
    Add(set_.CastRayNearest({{0, 0, 0}, {1, 0, 0}, kNan}, {}, nearest).ok());
    Add(set_.SweepBoxNearest({kBroken, {0, 0, 0}}, {}, nearest).ok());
  }

  void Add(uint32_t word) { words_.push_back(word); }
  void Add(const std::vector<ProxyHandle>& found) {
    for (const ProxyHandle handle : found) Add(handle.index);
  }
  void Add(const std::vector<RayHit>& hits) {
    for (const RayHit& hit : hits) {
      Add(hit.proxy.index);
      Add(std::bit_cast<uint32_t>(hit.distance));
    }
  }

  const Frames& frames_;
  ProxySet set_;
  std::unique_ptr<BroadPhase> backend_ = test_support::MakeOrThrow("SAP");
  PairBuffer pairs_;
  std::vector<ProxyHandle> handles_;
  std::vector<uint32_t> words_;
};

TEST_P(InEachFloatMode, ProxiesGiveTheSamePairsEventsAndHits) {
  int case_count = 0;
  for (const Case& one : Cases()) {
    const auto has_few = [](const std::vector<Aabb>& boxes) { return boxes.size() < 100; };
    if (std::ranges::any_of(one.frames, has_few)) continue;
    ++case_count;
    const std::vector<uint32_t> expected = ProxyScript(one.frames).Run();
    std::vector<uint32_t> found;
    EXPECT_TRUE(KeepsMode(GetParam(), [&] { found = ProxyScript(one.frames).Run(); }));
    EXPECT_TRUE(found == expected) << one.name;
  }
  EXPECT_GT(case_count, 10);
}

// The inline functions of aabb.h, which run in the game's environment.
std::vector<uint32_t> InlineResults() {
  constexpr std::array<float, 11> kValues = {-kInfinity, -3.5F,    -1e-40F, -kTiny,    -0.0F, 0,
                                             kTiny,      1.5e-38F, 1e38F,   kInfinity, kNan};
  constexpr std::array<double, 10> kDoubles = {-1e300, -3.4028236e38, -1.1, -1e-39, -5e-324,
                                               5e-324, 1e-46,         1.1,  1e39,   1e300};
  std::vector<uint32_t> words;
  for (const float low : kValues) {
    for (const float high : kValues) {
      const Aabb box = {{low, low, low}, {high, high, high}};
      words.push_back(IsValid(box) ? 1 : 0);
      for (const float other : kValues) {
        words.push_back(Overlap(box, {{other, other, -1}, {other, other, 1}}) ? 1 : 0);
      }
    }
  }
  for (const double low : kDoubles) {
    for (const double high : kDoubles) {
      const double min[3] = {low, low, low};
      const double max[3] = {high, high, high};
      const Aabb box = RoundOutward(min, max);
      words.push_back(std::bit_cast<uint32_t>(box.min[0]));
      words.push_back(std::bit_cast<uint32_t>(box.max[0]));
    }
  }
  return words;
}

TEST_P(InEachFloatMode, InlineFunctionsOfBoxesGiveTheSame) {
  const std::vector<uint32_t> expected = InlineResults();
  std::vector<uint32_t> found;
  EXPECT_TRUE(KeepsMode(GetParam(), [&] { found = InlineResults(); }));
  EXPECT_TRUE(found == expected);
}

INSTANTIATE_TEST_SUITE_P(, InEachFloatMode, testing::ValuesIn(FloatModes()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace sweepstake

// A frame costs what lives: after many proxies came and went, the broad phase gets as many boxes as
// before and makes as many checks, and the set has as much memory and as large a snapshot. "As
// many" means up to a tenth more.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

#include "engine_client/scene/random.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {
namespace {

constexpr size_t kBurst = 20'000;
constexpr float kSide = 40;
constexpr float kWideSide = 400;
// Debris collides with everything except debris.
constexpr CollisionFilter kDebrisFilter = {.category = 4, .mask = ~4U};
// More Resolves than until unused memory is freed.
constexpr int kManyResolves = 520;

// What remains of the burst. kNoneOfAWideOne: nothing, and it was ten times as wide as the world.
enum class Survivors { kNone, kNoneOfAWideOne, kTheLast, kAnyTwoThousand };

struct FrameCost {
  size_t searched_count;
  uint64_t checks;  // of eight frames
  size_t pair_count;
  size_t native_bytes;
  size_t snapshot_bytes;
};

class BurstGame {
 public:
  explicit BurstGame(std::string_view backend)
      : backend_(std::move(*MakeBroadPhase(backend))), proxies_({.pair_events = true}) {
    backend_->Build({});
    for (size_t k = 0; k < 2000; ++k) Add(ProxyOptions{});
    for (size_t k = 0; k < 600; ++k) Add(OptionsOf(k));
    for (size_t k = 0; k < 200; ++k)
      EXPECT_TRUE(proxies_.SetSleeping(living_[10 * k].handle, true));
  }

  // Resolves until all unused memory has been freed, and returns the cost of the last frames.
  FrameCost Settle() {
    for (int k = 0; k < 24 || frame_ % 8 != 0; ++k) Step();
    const Aabb* const boxes = proxies_.moving_boxes().data();
    for (int k = 0; k < kManyResolves; ++k) proxies_.Resolve(found_.pairs());
    EXPECT_EQ(proxies_.moving_boxes().data(), boxes);  // no change has moved them
    EXPECT_TRUE(proxies_.Remove(proxies_.Add({})));
    Step();  // in which backends may search more, since the number of boxes may have changed
    uint64_t checks = 0;
    size_t pair_count = 0;
    for (int k = 0; k < 8; ++k) {
      pair_count = Step();
      checks += backend_->aabb_check_count();
    }
    return {proxies_.moving_boxes().size(), checks, pair_count, proxies_.native_bytes(),
            proxies_.snapshot_bytes()};
  }

  // Adds many proxies of each sort and removes them a few frames later. If any of them survive, as
  // many others are removed.
  void Burst(Survivors survivors) {
    const size_t before = living_.size();
    side_ = survivors == Survivors::kNoneOfAWideOne ? kWideSide : kSide;
    for (size_t k = 0; k < kBurst; ++k) {
      Add(OptionsOf(k));
      EXPECT_TRUE(proxies_.SetSleeping(living_.back().handle, k % 8 == 0));
    }
    for (int k = 0; k < 3; ++k) Step();
    // The survivors and those that they replace are searched by the broad phase.
    if (survivors == Survivors::kTheLast) Replace(living_.size() - 3, 1);
    for (size_t k = 0; survivors == Survivors::kAnyTwoThousand && k < 2000; ++k) {
      if (k % 10 != 0) Replace(before + 8 * k + 1, k);
    }
    std::vector<ProxyHandle> gone;
    for (size_t k = before; k < living_.size(); ++k) gone.push_back(living_[k].handle);
    EXPECT_TRUE(proxies_.RemoveMany(gone));
    living_.resize(before);
  }

  // Continues with a new set that is restored from a snapshot.
  void Restore() {
    std::vector<std::byte> snapshot(proxies_.snapshot_bytes());
    EXPECT_TRUE(proxies_.Save(snapshot).ok());
    proxies_ = ProxySet({.pair_events = true});
    EXPECT_TRUE(proxies_.Restore(snapshot).ok());
  }

 private:
  struct Object {
    ProxyHandle handle;
    Aabb box;
    bool moves;
  };

  static ProxyOptions OptionsOf(size_t k) {
    return {.filter = k % 4 == 2 ? kDebrisFilter : CollisionFilter{}, .is_static = k % 4 == 3};
  }

  void Add(const ProxyOptions& options) {
    Aabb box;
    for (int axis = 0; axis < 3; ++axis) {
      box.min[axis] = random_.Between(0, side_);
      box.max[axis] = box.min[axis] + 1;
    }
    living_.push_back({proxies_.Add(box, options), box, !options.is_static});
  }

  // Exchanges two objects in the list. The second one takes the box of the first one.
  void Replace(size_t survivor, size_t replaced) {
    std::swap(living_[survivor], living_[replaced]);
    living_[replaced].box = living_[survivor].box;
    EXPECT_TRUE(proxies_.Move(living_[replaced].handle, living_[replaced].box));
  }

  // Moves the boxes a little, the same way every eighth frame.
  size_t Step() {
    ++frame_;
    for (size_t k = 0; k < living_.size(); ++k) {
      const Object& object = living_[k];
      if (!object.moves || proxies_.is_sleeping(object.handle)) continue;
      const float along = 0.01F * static_cast<float>((frame_ + k) % 8);
      Aabb box = object.box;
      box.min[k % 3] += along;
      box.max[k % 3] += along;
      EXPECT_TRUE(proxies_.Move(object.handle, box));
    }
    backend_->Update(proxies_.moving_boxes());
    found_.Clear();
    backend_->FindPairs(found_);
    const size_t pair_count = proxies_.Resolve(found_.pairs()).size();
    proxies_.QueryBox({{1, 1, 1}, {5, 5, 5}}, {}, queried_);
    return pair_count;
  }

  std::unique_ptr<BroadPhase> backend_;
  ProxySet proxies_;
  SequentialRandom random_{77};
  std::vector<Object> living_;
  PairBuffer found_;
  std::vector<ProxyHandle> queried_;
  float side_ = kSide;
  size_t frame_ = 0;
};

class Bursts : public testing::TestWithParam<std::tuple<std::string_view, Survivors>> {};

TEST_P(Bursts, LeaveTheCostOfAFrameAsItWas) {
  const Survivors survivors = std::get<1>(GetParam());
  BurstGame game(std::get<0>(GetParam()));
  const FrameCost before = game.Settle();
  const auto expect_the_same = [&](const FrameCost& after) {
    EXPECT_LE(31 * after.searched_count, 32 * before.searched_count);
    // Fewer checks do not mean less work: AxisSweep has repaired its orders, and counts few.
    EXPECT_NEAR(static_cast<double>(after.checks), static_cast<double>(before.checks),
                0.1 * static_cast<double>(before.checks));
    EXPECT_EQ(after.pair_count, before.pair_count);
    EXPECT_LE(10 * after.snapshot_bytes, 11 * before.snapshot_bytes);
    // Two thousand ids of 23,000 are spread over all pages of ids.
    const size_t pages = survivors == Survivors::kAnyTwoThousand ? 22 * 4400 : 0;
    EXPECT_LE(10 * after.native_bytes, 11 * (before.native_bytes + pages));
  };
  game.Burst(survivors);
  expect_the_same(game.Settle());
  game.Restore();
  expect_the_same(game.Settle());
}

std::string NameOfBurst(const testing::TestParamInfo<Bursts::ParamType>& test) {
  const Survivors survivors = std::get<1>(test.param);
  const std::string_view name = survivors == Survivors::kNone             ? "WithoutSurvivors"
                                : survivors == Survivors::kNoneOfAWideOne ? "FarAround"
                                : survivors == Survivors::kTheLast        ? "WithOneSurvivor"
                                                                          : "WithManySurvivors";
  return std::string(std::get<0>(test.param)).append(name);
}

INSTANTIATE_TEST_SUITE_P(
    , Bursts,
    testing::Combine(testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                     testing::Values(Survivors::kNone, Survivors::kNoneOfAWideOne,
                                     Survivors::kTheLast, Survivors::kAnyTwoThousand)),
    NameOfBurst);

// No search and no query updates the trees after the burst, so only Resolve can free their memory.
TEST(ABurstThatIsQueriedOnce, LeavesTheMemoryAsItWas) {
  for (const bool is_static : {false, true}) {
    ProxySet proxies({.pair_events = true});
    SequentialRandom random(7);
    const auto add = [&] {
      const float x = random.Between(0, kSide);
      const float y = random.Between(0, kSide);
      return proxies.Add({{x, y, 0}, {x + 1, y + 1, 1}}, {.is_static = is_static});
    };
    std::vector<ProxyHandle> found;
    const auto settled_bytes = [&] {
      for (int k = 0; k < kManyResolves; ++k) proxies.Resolve({});
      EXPECT_TRUE(proxies.Remove(add()));
      return proxies.native_bytes();
    };
    for (size_t k = 0; k < 2000; ++k) add();
    proxies.QueryBox({{1, 1, 0}, {5, 5, 1}}, {}, found);
    const size_t before = settled_bytes();
    const std::vector<ProxyHandle> living = found;
    std::vector<ProxyHandle> burst;
    for (size_t k = 0; k < kBurst; ++k) burst.push_back(add());
    proxies.QueryBox({{1, 1, 0}, {5, 5, 1}}, {}, found);
    EXPECT_GT(found.size(), living.size());
    EXPECT_TRUE(proxies.RemoveMany(burst));
    EXPECT_LE(10 * settled_bytes(), 11 * before);
    proxies.QueryBox({{1, 1, 0}, {5, 5, 1}}, {}, found);
    EXPECT_EQ(found, living);
  }
}

}  // namespace
}  // namespace sweepstake

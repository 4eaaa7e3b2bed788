// Tests that a restored set equals the saved set in everything that a game can observe.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/proxies/proxy_game.h"
#include "tests/support/allocation_counter.h"

namespace sweepstake {
namespace {

using test_support::ListedProxy;
using test_support::ProxyGame;

std::vector<std::byte> Saved(const ProxySet& proxies) {
  std::vector<std::byte> snapshot(proxies.snapshot_bytes());
  EXPECT_TRUE(proxies.Save(snapshot).ok());
  return snapshot;
}

// All results of a frame, in their order.
struct Frame {
  std::vector<OverlapPair> pairs;
  std::vector<ProxyPair> added;
  std::vector<ProxyPair> removed;
  std::vector<ProxyHandle> found;
  std::vector<RayHit> hits;
  std::vector<ProxyHandle> handles;
  std::vector<Aabb> boxes;

  friend bool operator==(const Frame&, const Frame&) = default;
};

Frame Play(ProxyGame& game) {
  game.Step();
  ProxySet& proxies = game.proxies;
  const auto backend = std::move(*MakeBroadPhase("BruteForce"));
  PairBuffer pairs;
  backend->Build(proxies.moving_boxes());
  backend->FindPairs(pairs);
  Frame frame;
  const auto resolved = proxies.Resolve(pairs.pairs());
  frame.pairs.assign(resolved.begin(), resolved.end());
  frame.added.assign(proxies.added().begin(), proxies.added().end());
  frame.removed.assign(proxies.removed().begin(), proxies.removed().end());
  proxies.QueryBox({{1, 1, 1}, {5, 5, 5}}, {}, frame.found);
  EXPECT_TRUE(proxies.CastRay({{0, 4, 4}, {1, 0.1F, 0.1F}}, {}, frame.hits).ok());
  for (const ListedProxy& proxy : game.listed) frame.handles.push_back(proxy.handle);
  for (const Aabb& box : proxies.moving_boxes()) {
    if (IsValid(box)) frame.boxes.push_back(box);  // a NaN would not equal itself
  }
  return frame;
}

// Runs a thousand frames after a snapshot, and again after it was restored into `other`.
void ExpectTheSameAgain(ProxyGame& game, ProxySet other) {
  for (int frame = 0; frame < 50; ++frame) Play(game);
  game.Step();  // the trees do not contain these changes yet
  const std::vector<std::byte> snapshot = Saved(game.proxies);
  const std::vector<ListedProxy> listed = game.listed;
  const SequentialRandom random = game.random();
  std::vector<Frame> frames;
  for (int frame = 0; frame < 1000; ++frame) frames.push_back(Play(game));
  ASSERT_TRUE(other.Restore(snapshot).ok());
  EXPECT_EQ(Saved(other), snapshot);
  game.proxies = std::move(other);
  game.listed = listed;
  game.random() = random;
  for (int frame = 0; frame < 1000; ++frame) {
    ASSERT_TRUE(Play(game) == frames[static_cast<size_t>(frame)]) << "frame " << frame;
  }
  ASSERT_FALSE(game.failed);
}

class Snapshots : public testing::TestWithParam<ProxySetOptions> {};

TEST_P(Snapshots, RestoreANewSetForAThousandFrames) {
  ProxyGame game(GetParam(), 41);
  game.AddSome(60, 40);
  ExpectTheSameAgain(game, ProxySet(GetParam()));
}

TEST_P(Snapshots, RestoreASetThatContinuedForAThousandFrames) {
  ProxyGame game(GetParam(), 42);
  ProxyGame another(GetParam(), 43);
  game.AddSome(60, 40);
  another.AddSome(400, 200);
  for (int frame = 0; frame < 20; ++frame) Play(another);
  ExpectTheSameAgain(game, std::move(another.proxies));
}

// Uses trees of several blocks, of which each frame refits some.
TEST_P(Snapshots, RestoreASetOfManyStaticProxiesForAThousandFrames) {
  ProxyGame game(GetParam(), 45, 20);
  game.AddSome(60, 1500);
  ExpectTheSameAgain(game, ProxySet(GetParam()));
}

INSTANTIATE_TEST_SUITE_P(, Snapshots,
                         testing::Values(ProxySetOptions{}, ProxySetOptions{.pair_events = true},
                                         ProxySetOptions{.pair_events = true,
                                                         .event_margin = 0.2F}),
                         [](const auto& test) {
                           return test.param.event_margin > 0 ? "WithMargin"
                                  : test.param.pair_events    ? "WithEvents"
                                                              : "WithoutEvents";
                         });

class ASnapshot : public testing::Test {
 protected:
  ASnapshot() {
    game_.AddSome(40, 20);
    for (int frame = 0; frame < 10; ++frame) Play(game_);
    snapshot_ = Saved(game_.proxies);
    game_.Step();
    before_ = Saved(game_.proxies);
  }

  void ExpectRefused(std::span<const std::byte> snapshot, StatusCode code,
                     std::string_view message) {
    const Status status = game_.proxies.Restore(snapshot);
    EXPECT_EQ(status.code(), code);
    EXPECT_NE(status.message().find(message), std::string::npos) << status.message();
    EXPECT_EQ(Saved(game_.proxies), before_);
  }

  ProxyGame game_{{.pair_events = true}, 44};
  std::vector<std::byte> snapshot_;
  std::vector<std::byte> before_;
};

TEST_F(ASnapshot, IsRefusedIfItIsTruncated) {
  const std::span whole(snapshot_);
  ExpectRefused(whole.first(whole.size() - 1), StatusCode::kDataLoss, " bytes");
  ExpectRefused(whole.first(31), StatusCode::kDataLoss, "shorter than its header");
  ExpectRefused({}, StatusCode::kDataLoss, "shorter than its header");
}

TEST_F(ASnapshot, IsRefusedIfAnyByteHasChanged) {
  for (size_t at = 0; at < snapshot_.size(); at += 1 + at / 64) {
    auto damaged = snapshot_;
    damaged[at] ^= std::byte{0x10};
    EXPECT_FALSE(game_.proxies.Restore(damaged).ok()) << "byte " << at;
  }
  EXPECT_EQ(Saved(game_.proxies), before_);
}

TEST_F(ASnapshot, IsRefusedWithAnotherVersionOrOtherOptions) {
  auto other = snapshot_;
  const uint32_t version = 77;
  std::memcpy(other.data() + 4, &version, sizeof version);
  ExpectRefused(other, StatusCode::kInvalidArgument, "has version 77");
  ExpectRefused(Saved(ProxySet({.sorted_pairs = true})), StatusCode::kInvalidArgument,
                "other options");
  ExpectRefused(Saved(ProxySet({.pair_events = true, .event_margin = 1})),
                StatusCode::kInvalidArgument, "other options");
}

TEST_F(ASnapshot, WritesExactlyItsSize) {
  std::vector<std::byte> room(before_.size() - 1, std::byte{7});
  EXPECT_EQ(game_.proxies.Save(room).code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(room, std::vector<std::byte>(room.size(), std::byte{7}));
  room.resize(before_.size() + 3, std::byte{7});
  ASSERT_TRUE(game_.proxies.Save(room).ok());
  EXPECT_TRUE(std::equal(before_.begin(), before_.end(), room.begin()));
  EXPECT_EQ(room.back(), std::byte{7});
}

TEST_F(ASnapshot, IsRestoredFromALargerBuffer) {
  std::vector<std::byte> room(before_.size() + 100, std::byte{7});
  ASSERT_TRUE(game_.proxies.Save(room).ok());
  game_.Step();
  ASSERT_NE(Saved(game_.proxies), before_);
  ASSERT_TRUE(game_.proxies.Restore(room).ok());
  EXPECT_EQ(Saved(game_.proxies), before_);
}

TEST_F(ASnapshot, AllocatesNothingIfTheSetHasEnoughMemory) {
  ASSERT_TRUE(game_.proxies.Restore(snapshot_).ok());
  const uint64_t allocations = test_support::ThreadAllocationCount();
  ASSERT_TRUE(game_.proxies.Save(snapshot_).ok());
  ASSERT_TRUE(game_.proxies.Restore(snapshot_).ok());
  EXPECT_EQ(test_support::ThreadAllocationCount(), allocations);
}

TEST(SnapshotsOfManyProxies, HaveAtMostTheDocumentedSize) {
  ProxySet proxies;
  const size_t empty = proxies.snapshot_bytes();
  std::vector<ProxyHandle> handles(10'000);
  const ProxyOptions options;
  proxies.AddMany(std::vector<Aabb>(10'000, Aabb{{0, 0, 0}, {1, 1, 1}}), std::span(&options, 1),
                  handles);
  proxies.Resolve({});
  EXPECT_LE(proxies.snapshot_bytes() - empty, 10'000U * 58);
  EXPECT_LE(empty, 2000U);
}

}  // namespace
}  // namespace sweepstake

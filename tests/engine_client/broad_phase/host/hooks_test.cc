#include "sweepstake/hooks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <mutex>
#include <new>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_sorter.h"
#include "sweepstake/proxy_set.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

// An allocator of a game, which records each block and can run out of memory.
class GameMemory {
 public:
  GameMemory() { EXPECT_TRUE(SetHooks(hooks()).ok()); }
  ~GameMemory() {
    EXPECT_TRUE(blocks_.empty());
    EXPECT_TRUE(SetHooks({}).ok());
  }

  Hooks hooks() {
    Hooks hooks;
    hooks.user = this;
    hooks.allocate = [](size_t bytes, size_t alignment, void* user) {
      return static_cast<GameMemory*>(user)->Allocate(bytes, alignment);
    };
    hooks.release = [](void* pointer, size_t bytes, size_t alignment, void* user) {
      static_cast<GameMemory*>(user)->Release(pointer, bytes, alignment);
    };
    return hooks;
  }

  size_t held_bytes() const {
    size_t bytes = 0;
    for (const auto& [pointer, block] : blocks_) bytes += block.bytes;
    return bytes;
  }

  static constexpr size_t kPlenty = std::numeric_limits<size_t>::max();
  size_t blocks_left = kPlenty;

 private:
  struct Block {
    size_t bytes;
    size_t alignment;
    bool operator==(const Block&) const = default;
  };

  void* Allocate(size_t bytes, size_t alignment) {
    const std::lock_guard lock(mutex_);
    if (blocks_left == 0) return nullptr;
    --blocks_left;
    void* const pointer = ::operator new (bytes, std::align_val_t{alignment});
    blocks_[pointer] = {bytes, alignment};
    return pointer;
  }

  void Release(void* pointer, size_t bytes, size_t alignment) {
    const std::lock_guard lock(mutex_);
    EXPECT_EQ(blocks_.at(pointer), (Block{bytes, alignment}));
    blocks_.erase(pointer);
    ::operator delete (pointer, std::align_val_t{alignment});
  }

  std::mutex mutex_;
  std::map<void*, Block> blocks_;
};

std::unique_ptr<Scene> SceneOf(std::string_view name, uint32_t object_count) {
  SceneOptions options;
  options.object_count = object_count;
  return std::move(*MakeScene(name, options));
}

TEST(HooksTest, ABackendAllocatesOnlyWithTheHooks) {
  const auto pool = MakeThreadPool(3);
  for (const std::string_view name : BroadPhaseNames()) {
    for (Executor* executor : {static_cast<Executor*>(nullptr), pool.get()}) {
      GameMemory memory;
      const auto scene = SceneOf("brownian", 5000);
      const auto backend = std::move(*MakeBroadPhase(name, {.executor = executor}));
      PairBuffer pairs;
      backend->Build(scene->aabbs());
      for (int frame = 0; frame < 20; ++frame) {
        backend->Update(scene->aabbs());
        pairs.Clear();
        backend->FindPairs(pairs);
        scene->Step();
      }
      EXPECT_EQ(memory.held_bytes(), backend->native_bytes() + pairs.capacity_bytes()) << name;
    }
  }
}

TEST(HooksTest, ProxiesAllocateOnlyWithTheHooks) {
  GameMemory memory;
  ProxySet proxies({.pair_events = true});
  const auto scene = SceneOf("brownian", 1000);
  for (const Aabb& box : scene->aabbs()) proxies.Add(box);
  const std::vector<OverlapPair> pairs = {{0, 1}};
  proxies.Resolve(pairs);
  EXPECT_GE(memory.held_bytes(), 1000 * sizeof(Aabb));
  // The sorter's table has a fixed size and does not use the game's allocator.
  EXPECT_EQ(memory.held_bytes(), proxies.native_bytes() - PairSorter().native_bytes());
}

TEST(HooksTest, ABackendWithoutMemoryThrowsAndCanContinueLater) {
  GameMemory memory;
  const auto scene = SceneOf("brownian", 1000);
  for (const std::string_view name : BroadPhaseNames()) {
    const auto backend = std::move(*MakeBroadPhase(name));
    PairBuffer pairs;
    memory.blocks_left = 0;
    EXPECT_THROW((backend->Build(scene->aabbs()), backend->FindPairs(pairs)), std::bad_alloc)
        << name;
    memory.blocks_left = GameMemory::kPlenty;
    backend->Build(scene->aabbs());
    backend->FindPairs(pairs);
    EXPECT_FALSE(pairs.empty()) << name;
  }
}

// The memory of a burst is freed with fewer and fewer failing allocations.
TEST(HooksTest, ProxiesWhoseMemoryCannotBeFreedStayUnchanged) {
  GameMemory memory;
  ProxySet proxies({.pair_events = true});
  const auto scene = SceneOf("brownian", 1000);
  for (const Aabb& box : scene->aabbs()) {
    proxies.Add(box, {.is_static = (proxies.moving_count() + proxies.static_count()) % 2 == 0});
  }
  std::vector<ProxyHandle> found;
  std::vector<ProxyHandle> found_after;
  proxies.QueryBox(scene->aabbs()[1], {}, found);
  const auto resolve_with = [&](size_t blocks) {
    memory.blocks_left = blocks;
    bool done = true;
    try {
      for (int k = 0; k < 512; ++k) proxies.Resolve({});
    } catch (const std::bad_alloc&) {
      done = false;
    }
    memory.blocks_left = GameMemory::kPlenty;
    return done;
  };
  ASSERT_TRUE(resolve_with(GameMemory::kPlenty));
  const size_t bytes = memory.held_bytes();
  std::vector<ProxyHandle> burst;
  for (size_t k = 0; k < 10'000; ++k) {
    burst.push_back(proxies.Add(scene->aabbs()[k % 1000], {.is_static = k % 3 == 0}));
  }
  proxies.Resolve({});
  ASSERT_TRUE(proxies.RemoveMany(burst));
  size_t blocks = 0;
  for (bool done = false; !done; ++blocks) {
    done = resolve_with(blocks);
    EXPECT_EQ(proxies.moving_count(), 500U);
    EXPECT_EQ(proxies.static_count(), 500U);
    proxies.QueryBox(scene->aabbs()[1], {}, found_after);
    EXPECT_EQ(found_after, found);
  }
  EXPECT_GT(blocks, 2U);
  ASSERT_TRUE(resolve_with(GameMemory::kPlenty));
  // Changes of both kinds free the rows, whose addresses a Resolve does not change, and the trees.
  ASSERT_TRUE(proxies.Remove(proxies.Add(scene->aabbs()[0])));
  ASSERT_TRUE(proxies.Remove(proxies.Add(scene->aabbs()[0], {.is_static = true})));
  ASSERT_TRUE(resolve_with(GameMemory::kPlenty));
  proxies.PrepareQueries();
  EXPECT_LE(memory.held_bytes(), bytes + bytes / 10);
}

// A set of static proxies. PrepareWith lets one allocation of their tree fail. Allocations after
// that call succeed again.
class StaticProxiesWithoutMemory {
 public:
  void Add(size_t count, float from) {
    for (size_t k = 0; k < count; ++k) {
      const float x = from + static_cast<float>(k % 100);
      const float y = static_cast<float>(k / 100);
      boxes_.push_back({{x, y, 0}, {x + 0.9F, y + 0.9F, 1}});
      handles_.push_back(proxies_.Add(boxes_.back(), {.is_static = true}));
    }
  }
  void MoveEvery(size_t step) {
    for (size_t k = 0; k < handles_.size(); k += step) {
      boxes_[k].max[0] += 0.05F;
      EXPECT_TRUE(proxies_.Move(handles_[k], boxes_[k]));
    }
  }
  void RemoveEvery(size_t step) {
    for (size_t k = handles_.size(); k-- > 0;) {
      if (k % step != 0) continue;
      EXPECT_TRUE(proxies_.Remove(handles_[k]));
      handles_.erase(handles_.begin() + static_cast<std::ptrdiff_t>(k));
      boxes_.erase(boxes_.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }
  // Prepares the queries with memory for `block_count` blocks. Returns whether that was enough.
  bool PrepareWith(size_t block_count) {
    memory_.blocks_left = block_count;
    bool done = true;
    try {
      proxies_.PrepareQueries();
    } catch (const std::bad_alloc&) {
      done = false;
    }
    memory_.blocks_left = GameMemory::kPlenty;
    return done;
  }
  void ExpectWhole() {
    std::vector<ProxyHandle> found;
    proxies_.QueryBox({{-1e6F, -1e6F, -1e6F}, {1e6F, 1e6F, 1e6F}}, {}, found);
    std::sort(handles_.begin(), handles_.end());
    ASSERT_EQ(found, handles_);
  }

 private:
  GameMemory memory_;
  ProxySet proxies_;
  std::vector<Aabb> boxes_;
  std::vector<ProxyHandle> handles_;
};

TEST(HooksTest, AFailedFirstStaticTreeIsCompletedAtTheNextUse) {
  bool has_all = false;
  for (size_t block_count = 0; !has_all; ++block_count) {
    StaticProxiesWithoutMemory game;
    game.Add(1000, 0);
    has_all = game.PrepareWith(block_count);
    game.RemoveEvery(30);
    game.ExpectWhole();
  }
}

TEST(HooksTest, AFailedUpdateOfAStaticTreeIsCompletedAtTheNextUse) {
  bool has_all = false;
  for (size_t block_count = 0; !has_all; ++block_count) {
    StaticProxiesWithoutMemory game;
    game.Add(70'000, 0);
    EXPECT_TRUE(game.PrepareWith(GameMemory::kPlenty));
    game.Add(3000, 200);
    EXPECT_TRUE(game.PrepareWith(GameMemory::kPlenty));
    game.MoveEvery(140);  // enough that the whole tree is refitted
    has_all = game.PrepareWith(block_count);
    game.RemoveEvery(2000);
    game.ExpectWhole();
  }
}

// Restores a snapshot of many proxies into a set of a few, with memory for some allocations only.
TEST(HooksTest, AFailedRestoreCanBeRepeated) {
  const auto add = [](ProxySet& proxies, size_t count) {
    for (size_t k = 0; k < count; ++k) {
      const auto x = static_cast<float>(k);
      proxies.Add({{x, 0, 0}, {x + 0.9F, 1, 1}}, {.is_static = k % 2 == 0});
    }
    proxies.PrepareQueries();
  };
  const auto all_of = [](ProxySet& proxies) {
    std::vector<ProxyHandle> found;
    proxies.QueryBox({{-1, -1, -1}, {1e6F, 2, 2}}, {}, found);
    return found;
  };
  GameMemory memory;
  ProxySet many({.pair_events = true});
  add(many, 3000);
  std::vector<std::byte> snapshot(many.snapshot_bytes());
  ASSERT_TRUE(many.Save(snapshot).ok());
  size_t block_count = 0;
  for (bool has_all = false; !has_all; ++block_count) {
    ProxySet few({.pair_events = true});
    add(few, 10);
    memory.blocks_left = block_count;
    try {
      ASSERT_TRUE(few.Restore(snapshot).ok());
      has_all = true;
    } catch (const std::bad_alloc&) {
    }
    memory.blocks_left = GameMemory::kPlenty;
    if (block_count % 2 == 0) continue;  // destroys the set as Restore left it
    ASSERT_TRUE(few.Restore(snapshot).ok());
    ASSERT_EQ(all_of(few), all_of(many));
    few.PrepareQueries();
    ASSERT_EQ(all_of(few), all_of(many));
  }
  EXPECT_GT(block_count, 10U);
}

TEST(HooksTest, AMoveThatCannotWakeProxiesMovesNone) {
  size_t block_count = 0;
  for (bool has_all = false; !has_all; ++block_count) {
    GameMemory memory;
    ProxySet proxies;
    std::vector<ProxyHandle> handles;
    for (size_t k = 0; k < 200; ++k) handles.push_back(proxies.Add({{0, 0, 0}, {1, 1, 1}}));
    for (size_t k = 100; k < 200; ++k) ASSERT_TRUE(proxies.SetSleeping(handles[k], true));
    proxies.PrepareQueries();
    const Aabb moved = {{5, 5, 5}, {6, 6, 6}};
    memory.blocks_left = block_count;
    try {
      has_all = proxies.Move(handles, std::vector<Aabb>(200, moved));
    } catch (const std::bad_alloc&) {
    }
    memory.blocks_left = GameMemory::kPlenty;
    const auto count = std::count_if(handles.begin(), handles.end(), [&](ProxyHandle handle) {
      return *proxies.box(handle) == moved;
    });
    EXPECT_EQ(count, has_all ? 200 : 0);
  }
  EXPECT_GT(block_count, 1U);
}

TEST(HooksTest, AFailedResolveDelaysItsEvents) {
  std::vector<OverlapPair> pairs;
  for (uint32_t k = 0; k < 100; ++k) pairs.push_back({2 * k, 2 * k + 1});
  size_t block_count = 0;
  for (bool has_all = false; !has_all; ++block_count) {
    GameMemory memory;
    ProxySet proxies({.pair_events = true});
    for (size_t k = 0; k < 200; ++k) proxies.Add({{0, 0, 0}, {1, 1, 1}});
    proxies.Resolve(std::span(pairs).first(1));
    memory.blocks_left = block_count;
    try {
      has_all = proxies.Resolve(pairs).size() == pairs.size();
    } catch (const std::bad_alloc&) {
      EXPECT_TRUE(proxies.added().empty() && proxies.removed().empty());
    }
    memory.blocks_left = GameMemory::kPlenty;
    if (!has_all) proxies.Resolve(pairs);
    EXPECT_EQ(proxies.added().size(), 99U);
    EXPECT_TRUE(proxies.removed().empty());
  }
  EXPECT_GT(block_count, 2U);
}

TEST(HooksTest, CannotChangeWhileAnObjectUsesTheirMemory) {
  GameMemory memory;
  {
    PairBuffer pairs;
    pairs.Append({1, 2});
    EXPECT_EQ(SetHooks({}).code(), StatusCode::kFailedPrecondition);
    EXPECT_EQ(memory.held_bytes(), pairs.capacity_bytes());
  }
  EXPECT_TRUE(SetHooks(memory.hooks()).ok());
}

TEST(HooksTest, AreRefusedIfOneOfAPairIsMissing) {
  Hooks no_release;
  no_release.allocate = [](size_t, size_t, void*) -> void* { return nullptr; };
  EXPECT_EQ(SetHooks(no_release).code(), StatusCode::kInvalidArgument);
  Hooks no_end;
  no_end.zone_begin = [](const char*, void*) {};
  EXPECT_EQ(SetHooks(no_end).code(), StatusCode::kInvalidArgument);
  EXPECT_NO_THROW(PairBuffer().Append({1, 2}));
}

TEST(HooksTest, ZonesBeginAndEndWithTheirNames) {
  std::vector<std::string> seen;
  Hooks hooks;
  hooks.user = &seen;
  hooks.zone_begin = [](const char* name, void* user) {
    static_cast<std::vector<std::string>*>(user)->push_back(std::string("begin ") + name);
  };
  hooks.zone_end = [](const char* name, void* user) {
    static_cast<std::vector<std::string>*>(user)->push_back(std::string("end ") + name);
  };
  { const Zone unseen("before the hooks"); }
  ASSERT_TRUE(SetHooks(hooks).ok());
  {
    const Zone frame("frame");
    const Zone search("search");
  }
  ASSERT_TRUE(SetHooks({}).ok());
  EXPECT_EQ(seen,
            (std::vector<std::string>{"begin frame", "begin search", "end search", "end frame"}));
}

TEST(HooksTest, EachThreadOfAPoolReportsItsNameOnce) {
  struct Started {
    std::mutex mutex;
    std::multiset<std::string> names;
    std::set<std::thread::id> threads;
  } started;
  Hooks hooks;
  hooks.user = &started;
  hooks.thread_started = [](const char* name, void* user) {
    auto& all = *static_cast<Started*>(user);
    const std::lock_guard lock(all.mutex);
    all.names.insert(name);
    all.threads.insert(std::this_thread::get_id());
  };
  ASSERT_TRUE(SetHooks(hooks).ok());
  MakeThreadPool(3).reset();
  ASSERT_TRUE(SetHooks({}).ok());
  EXPECT_EQ(started.names, (std::multiset<std::string>{"swp pool", "swp pool"}));
  EXPECT_EQ(started.threads.size(), 2U);
  EXPECT_FALSE(started.threads.contains(std::this_thread::get_id()));
}

}  // namespace
}  // namespace sweepstake

// A host loses its handles, for example when its domain is reloaded. It counts the live objects,
// shuts all down, and may still use an old handle. Run with the sanitizers.
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <string>
#include <thread>

#include "sweepstake/c_api.h"

namespace {

constexpr uint32_t kLong = 60000;  // deadline in ms that no test reaches

struct Objects {
  swp_world* world = nullptr;
  swp_session* session = nullptr;
  swp_link* link = nullptr;
  swp_proxies* proxies = nullptr;
  swp_scene* scene = nullptr;
};

template <typename Struct>
Struct Sized() {
  Struct made{};
  made.struct_size = sizeof made;
  return made;
}

// Creates objects with threads wherever an option allows it.
Objects MakeObjects() {
  Objects made;
  auto world = Sized<swp_world_options>();
  EXPECT_EQ(swp_world_options_init(&world), SWP_OK);
  world.thread_count = 2;
  EXPECT_EQ(swp_world_create("Grid", &world, &made.world), SWP_OK);
  auto session = Sized<swp_session_options>();
  EXPECT_EQ(swp_session_options_init(&session), SWP_OK);
  session.shadow = SWP_SHADOW_ON;
  session.thread_count = 2;
  EXPECT_EQ(swp_session_create(&session, &made.session), SWP_OK);
  EXPECT_EQ(swp_link_create(made.session, nullptr, &made.link), SWP_OK);
  EXPECT_EQ(swp_proxies_create(nullptr, &made.proxies), SWP_OK);
  EXPECT_EQ(swp_scene_create("brownian", nullptr, &made.scene), SWP_OK);
  return made;
}

void RunFrame(const Objects& objects) {
  const swp_aabb* boxes = nullptr;
  uint32_t count = 0;
  EXPECT_EQ(swp_scene_boxes(objects.scene, &boxes, &count), SWP_OK);
  EXPECT_EQ(swp_session_begin_frame(objects.session), SWP_OK);
  EXPECT_EQ(swp_session_find_pairs(objects.session, boxes, count), SWP_OK);
  EXPECT_EQ(swp_session_end_frame(objects.session, 5000000, 0), SWP_OK);
  EXPECT_EQ(swp_world_build(objects.world, boxes, count), SWP_OK);
  EXPECT_EQ(swp_world_find_pairs(objects.world), SWP_OK);
  EXPECT_EQ(swp_scene_step(objects.scene), SWP_OK);
}

void ExpectEnded(const Objects& objects) {
  const swp_pair* pairs = nullptr;
  uint64_t count = 0;
  uint32_t arm = 0;
  EXPECT_EQ(swp_session_begin_frame(objects.session), SWP_FAILED_PRECONDITION);
  EXPECT_NE(std::strstr(swp_last_error(), "swp_shutdown_all"), nullptr);
  EXPECT_EQ(swp_session_pairs(objects.session, &pairs, &count), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_session_active_arm(objects.session, &arm), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_session_attach_decider(objects.session, nullptr, 0), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_link_connected(objects.link, 1), SWP_FAILED_PRECONDITION);
  EXPECT_NE(std::strstr(swp_last_error(), "swp_shutdown_all"), nullptr);
  EXPECT_EQ(swp_world_find_pairs(objects.world), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_proxies_resolve(objects.proxies, nullptr, 0), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_scene_step(objects.scene), SWP_FAILED_PRECONDITION);
}

void Destroy(const Objects& objects) {
  swp_world_destroy(objects.world);
  swp_link_destroy(objects.link);
  swp_session_destroy(objects.session);
  swp_proxies_destroy(objects.proxies);
  swp_scene_destroy(objects.scene);
}

TEST(LostHandlesTest, CountsLiveObjectsByKind) {
  const uint32_t before = swp_live_count(SWP_KIND_ANY);
  const Objects objects = MakeObjects();
  EXPECT_EQ(swp_live_count(SWP_KIND_WORLD), 1U);
  EXPECT_EQ(swp_live_count(SWP_KIND_SESSION), 1U);
  EXPECT_EQ(swp_live_count(SWP_KIND_LINK), 1U);
  EXPECT_EQ(swp_live_count(SWP_KIND_PROXIES), 1U);
  EXPECT_EQ(swp_live_count(SWP_KIND_SCENE), 1U);
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), before + 5);
  EXPECT_EQ(swp_live_count(99), 0U);
  swp_world_destroy(objects.world);
  EXPECT_EQ(swp_live_count(SWP_KIND_WORLD), 0U);
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), before + 4);
  Destroy({nullptr, objects.session, objects.link, objects.proxies, objects.scene});
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), before);
}

TEST(LostHandlesTest, ShutdownEndsAllObjectsAndOldHandlesReturnErrors) {
  const Objects lost = MakeObjects();
  RunFrame(lost);
  EXPECT_EQ(swp_shutdown_all(kLong), SWP_OK);
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), 0U);
  ExpectEnded(lost);
  EXPECT_EQ(swp_shutdown_all(0), SWP_OK);
  const Objects next = MakeObjects();
  RunFrame(next);
  ExpectEnded(lost);
  Destroy(lost);
  Destroy(next);
}

TEST(LostHandlesTest, ShutdownWithoutADeadlineFreesIdleObjectsAtOnce) {
  const Objects first = MakeObjects();
  const Objects second = MakeObjects();
  EXPECT_EQ(swp_shutdown_all(0), SWP_OK);
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), 0U);
  Destroy(first);
  Destroy(second);
}

TEST(LostHandlesTest, AnotherThreadCanShutDown) {
  Objects lost;
  std::thread([&] {
    lost = MakeObjects();
    for (int frame = 0; frame < 10; ++frame) RunFrame(lost);
  }).join();
  EXPECT_EQ(swp_shutdown_all(kLong), SWP_OK);
  std::thread([&] { ExpectEnded(lost); }).join();
  Destroy(lost);
}

// The frame thread and the transport continue until their calls fail.
TEST(LostHandlesTest, ShutdownWaitsForRunningCallsAndRefusesNewOnes) {
  const Objects lost = MakeObjects();
  const swp_aabb boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}};
  std::atomic<int> frame_count = 0;
  std::atomic<bool> frames_ended = false;
  std::thread frame_thread([&] {
    while (swp_session_begin_frame(lost.session) == SWP_OK) {
      swp_session_find_pairs(lost.session, boxes, 2);
      swp_session_end_frame(lost.session, 5000000, 0);
      ++frame_count;
    }
    frames_ended = true;
  });
  std::thread transport([&] {
    swp_link_stats stats = Sized<swp_link_stats>();
    while (swp_link_status(lost.link, &stats) == SWP_OK) {
      uint64_t size = 0;
      swp_link_action action = 0;
      swp_link_next_message(lost.link, 1, nullptr, 0, &size, &action);
    }
  });
  while (frame_count < 3 && !frames_ended) std::this_thread::yield();
  EXPECT_GE(frame_count, 3);
  EXPECT_EQ(swp_shutdown_all(kLong), SWP_OK);
  frame_thread.join();
  transport.join();
  EXPECT_EQ(swp_session_end_frame(lost.session, 5000000, 0), SWP_FAILED_PRECONDITION);
  Destroy(lost);
}

// An executor that blocks in its first part until it is released.
struct Gate {
  std::atomic<bool> reached = false;
  std::atomic<bool> open = false;

  static void RunParts(void* user, uint64_t part_count, swp_run_part run_part, void* job) {
    auto& gate = *static_cast<Gate*>(user);
    gate.reached = true;
    while (!gate.open) std::this_thread::yield();
    for (uint64_t part = 0; part < part_count; ++part) run_part(job, part);
  }
};

TEST(LostHandlesTest, ACallThatDoesNotReturnKeepsOnlyItsObject) {
  Gate gate;
  auto executor = Sized<swp_executor>();
  ASSERT_EQ(swp_executor_init(&executor), SWP_OK);
  executor.thread_count = 2;
  executor.run_parts = Gate::RunParts;
  executor.user = &gate;
  auto options = Sized<swp_world_options>();
  ASSERT_EQ(swp_world_options_init(&options), SWP_OK);
  options.executor = &executor;
  swp_world* busy = nullptr;
  ASSERT_EQ(swp_world_create("Grid", &options, &busy), SWP_OK);
  const Objects others = MakeObjects();
  auto big = Sized<swp_scene_options>();
  ASSERT_EQ(swp_scene_options_init(&big), SWP_OK);
  big.object_count = 20000;
  swp_scene* scene = nullptr;
  ASSERT_EQ(swp_scene_create("suite-b", &big, &scene), SWP_OK);
  const swp_aabb* boxes = nullptr;
  uint32_t count = 0;
  ASSERT_EQ(swp_scene_boxes(scene, &boxes, &count), SWP_OK);
  const std::string copy(reinterpret_cast<const char*>(boxes), count * sizeof *boxes);
  std::thread caller([&] {
    const auto* const own = reinterpret_cast<const swp_aabb*>(copy.data());
    EXPECT_EQ(swp_world_build(busy, own, count), SWP_OK);
    swp_world_find_pairs(busy);  // may fail because of the shutdown
  });
  while (!gate.reached) std::this_thread::yield();
  EXPECT_EQ(swp_shutdown_all(0), SWP_UNAVAILABLE);
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), 1U);
  EXPECT_EQ(swp_live_count(SWP_KIND_WORLD), 1U);
  gate.open = true;
  caller.join();
  EXPECT_EQ(swp_shutdown_all(kLong), SWP_OK);
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), 0U);
  swp_world_destroy(busy);
  swp_scene_destroy(scene);
  Destroy(others);
}

TEST(LostHandlesTest, TheErrorOfAnEndedObjectSaysSo) {
  const Objects lost = MakeObjects();
  char text[256] = "";
  uint32_t arm = 0;
  EXPECT_EQ(swp_shutdown_all(kLong), SWP_OK);
  EXPECT_EQ(swp_world_find_pairs(lost.world), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_last_error_of(lost.world, text, sizeof text), SWP_OK);
  EXPECT_NE(std::strstr(text, "has ended this world"), nullptr);
  EXPECT_EQ(swp_session_active_arm(lost.session, &arm), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_last_error_of(lost.session, text, sizeof text), SWP_OK);
  EXPECT_NE(std::strstr(text, "has ended this session"), nullptr);
  Destroy(lost);
}

TEST(LostHandlesTest, TheLastErrorOfAnObjectIsReadableOnEveryThread) {
  const Objects objects = MakeObjects();
  char text[256] = "unchanged";
  EXPECT_EQ(swp_last_error_of(objects.session, text, sizeof text), SWP_OK);
  EXPECT_STREQ(text, "");
  std::thread([&] {
    EXPECT_EQ(swp_session_end_frame(objects.session, 1, 0), SWP_FAILED_PRECONDITION);
  }).join();
  EXPECT_EQ(swp_world_find_pairs(objects.world), SWP_FAILED_PRECONDITION);
  EXPECT_EQ(swp_last_error_of(objects.session, text, sizeof text), SWP_OK);
  EXPECT_STREQ(text, "call swp_session_begin_frame first");
  EXPECT_EQ(swp_last_error_of(objects.world, text, sizeof text), SWP_OK);
  EXPECT_STREQ(text, "call swp_world_build first");
  EXPECT_EQ(swp_last_error_of(objects.session, text, 5), SWP_OK);
  EXPECT_STREQ(text, "call");
  EXPECT_EQ(swp_last_error_of(text, text, sizeof text), SWP_NOT_FOUND);
  const void* const destroyed = objects.scene;
  Destroy(objects);
  EXPECT_EQ(swp_last_error_of(destroyed, text, sizeof text), SWP_NOT_FOUND);
}

}  // namespace

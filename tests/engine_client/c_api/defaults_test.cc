// The defaults of the C ABI are those of the C++ structs. C# reads the defaults of the C ABI.
#include <gtest/gtest.h>

#include <iterator>

#include "sweepstake/c_api.h"
#include "sweepstake/proxy_set.h"
#include "sweepstake/scene.h"
#include "sweepstake/session.h"

namespace sweepstake {
namespace {

template <typename Options>
Options Initialized(swp_result (*init)(Options*)) {
  Options options{};
  options.struct_size = sizeof options;
  EXPECT_EQ(init(&options), swp_result{SWP_OK});
  return options;
}

TEST(Defaults, OfASessionAreEqualInCAndCxx) {
  const swp_session_options c = Initialized(swp_session_options_init);
  const AdaptiveOptions cxx;
  EXPECT_EQ(c.mode, static_cast<swp_mode>(cxx.mode));
  EXPECT_EQ(c.arms == nullptr, cxx.arms.empty());
  EXPECT_EQ(c.initial_arm == nullptr, cxx.initial_arm.empty());
  EXPECT_EQ(c.bail_out_ns, cxx.bail_out_ns);
  EXPECT_EQ(c.settling_ns, cxx.settling_ns);
  EXPECT_EQ(c.executor == nullptr, cxx.executor == nullptr);
  EXPECT_EQ(c.thread_count, 0U);
  EXPECT_EQ(c.queue_frames, SessionOptions().queue_frames);
  EXPECT_EQ(c.shadow, static_cast<swp_shadow_mode>(cxx.shadow.enabled));
  EXPECT_EQ(c.shadow, swp_shadow_mode{SWP_SHADOW_AUTO});
  EXPECT_EQ(c.sorted_pairs != 0, cxx.sorted_pairs);
  EXPECT_EQ(c.shadow_duty_ratio, cxx.shadow.duty_ratio);
  EXPECT_EQ(c.shadow_memory_bytes, cxx.shadow.memory_cap_bytes);
  EXPECT_EQ(c.memory_budget_bytes, cxx.memory_budget_bytes);
  EXPECT_EQ(c.max_pairs, cxx.max_pairs);
}

TEST(Defaults, OfADeciderAreEqualInCAndCxx) {
  const swp_decider_options c = Initialized(swp_decider_options_init);
  const EmbeddedOptions cxx;
  EXPECT_EQ(c.policy, nullptr) << "NULL selects the C++ default, and so for each text";
  EXPECT_EQ(c.project, nullptr);
  EXPECT_EQ(c.scene, nullptr);
  EXPECT_EQ(c.machine_class == nullptr, cxx.machine_class.empty());
  EXPECT_EQ(c.build == nullptr, cxx.build.empty());
  EXPECT_EQ(c.source_id == nullptr, cxx.source_id.empty());
  EXPECT_EQ(c.priors_file == nullptr, cxx.priors_file.empty());
  EXPECT_EQ(c.priors_data == nullptr, cxx.priors_data.empty());
  EXPECT_EQ(c.priors_data_bytes, cxx.priors_data.size());
  EXPECT_EQ(c.seed, cxx.seed);
  EXPECT_EQ(c.time_scale, cxx.time_scale);
  EXPECT_EQ(c.decision_interval_ns, cxx.decision_interval_ns);
  EXPECT_EQ(c.cooldown_ns, cxx.cooldown_ns);
  EXPECT_EQ(c.fps_floor, cxx.fps_floor);
  EXPECT_EQ((RewardWeights{c.weights.fps, c.weights.detection, c.weights.memory, c.weights.checks}),
            cxx.weights);
}

TEST(Defaults, OfALinkAreEqualInCAndCxx) {
  const swp_link_options c = Initialized(swp_link_options_init);
  const SessionOptions cxx;
  EXPECT_EQ(c.allow_operator_orders != 0, cxx.allow_operator_orders);
  EXPECT_EQ(c.project, nullptr) << "NULL selects the C++ default, and so for each text";
  EXPECT_EQ(c.scene, nullptr);
  EXPECT_EQ(c.build == nullptr, cxx.build.empty());
  EXPECT_EQ(c.machine_class == nullptr, cxx.machine_class.empty());
  EXPECT_EQ(c.policy == nullptr, cxx.policy.empty());
  EXPECT_EQ(c.seed, cxx.seed);
  EXPECT_EQ(c.time_scale, cxx.time_scale);
  EXPECT_EQ(c.ignore_priors != 0, cxx.ignore_priors);
  EXPECT_EQ(c.batch_interval_ms, cxx.batch_interval_ms);
  EXPECT_EQ(c.batch_frames, cxx.batch_frames);
  EXPECT_EQ(c.batch_bytes, cxx.batch_bytes);
  EXPECT_EQ(c.unacknowledged_messages, cxx.unacknowledged_messages);
  EXPECT_EQ(c.backoff_min_ms, cxx.backoff_min_ms);
  EXPECT_EQ(c.backoff_max_ms, cxx.backoff_max_ms);
  EXPECT_EQ(cxx.rules, DecisionRules()) << "the daemon's rules";
  EXPECT_EQ(c.decision_interval_ns, SWP_DAEMON_VALUE);
  EXPECT_EQ(c.cooldown_ns, SWP_DAEMON_VALUE);
  EXPECT_EQ(c.settling_ns, SWP_DAEMON_VALUE);
  EXPECT_EQ(c.weights.fps + c.weights.detection + c.weights.memory + c.weights.checks, 0);
}

TEST(Defaults, OfAWorldAreEqualInCAndCxx) {
  const swp_world_options c = Initialized(swp_world_options_init);
  const BroadPhaseOptions cxx;
  EXPECT_EQ(c.executor == nullptr, cxx.executor == nullptr);
  EXPECT_EQ(c.max_pairs, cxx.max_pairs);
}

TEST(Defaults, OfAProxySetAreEqualInCAndCxx) {
  const swp_proxies_options c = Initialized(swp_proxies_options_init);
  const ProxySetOptions cxx;
  EXPECT_EQ(c.pair_events != 0, cxx.pair_events);
  EXPECT_EQ(c.sorted_pairs != 0, cxx.sorted_pairs);
  EXPECT_EQ(c.executor == nullptr, cxx.executor == nullptr);
  EXPECT_EQ(c.event_margin, cxx.event_margin);
  EXPECT_EQ(c.max_pairs, 0U);
}

TEST(Defaults, OfASceneAreEqualInCAndCxx) {
  const swp_scene_options c = Initialized(swp_scene_options_init);
  const SceneOptions cxx;
  EXPECT_EQ(c.object_count, cxx.object_count);
  EXPECT_EQ(c.spawn_seed, cxx.spawn_seed);
  EXPECT_EQ(c.motion_seed, cxx.motion_seed);
  EXPECT_EQ(c.world_half_extent, cxx.world_half_extent);
  EXPECT_EQ(c.fixed_step_s, cxx.fixed_step_s);
  EXPECT_EQ(c.half_extent_min, cxx.half_extent_min);
  EXPECT_EQ(c.half_extent_max, cxx.half_extent_max);
  EXPECT_EQ(c.speed, cxx.speed);
  EXPECT_EQ(c.gravity, cxx.gravity);
  EXPECT_EQ(c.direction_interval_s, cxx.direction_interval_s);
}

TEST(Defaults, OfAProxyAreEqualInCAndCxx) {
  swp_proxies* proxies = nullptr;
  ASSERT_EQ(swp_proxies_create(nullptr, &proxies), swp_result{SWP_OK});
  const swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  swp_proxy added = 0;
  ASSERT_EQ(swp_proxies_add_many(proxies, &box, nullptr, 1, &added), swp_result{SWP_OK});
  swp_proxy_options c;
  ASSERT_EQ(swp_proxies_get(proxies, added, nullptr, &c), swp_result{SWP_OK});
  const ProxyOptions cxx;
  EXPECT_EQ(c.filter.category, cxx.filter.category);
  EXPECT_EQ(c.filter.mask, cxx.filter.mask);
  EXPECT_EQ(c.flags, cxx.is_static ? uint32_t{SWP_PROXY_STATIC} : 0U);
  EXPECT_EQ(c.user, cxx.user);
  swp_proxies_destroy(proxies);
}

// A query without a filter finds every proxy that has a category and a mask, in both languages.
TEST(Defaults, OfAQueryAreEqualInCAndCxx) {
  constexpr CollisionFilter kFilters[] = {{}, {1, 4}, {4, 1}, {1U << 31, 1U << 30}};
  const swp_aabb box = {{0, 0, 0}, {1, 1, 1}};
  swp_proxies* proxies = nullptr;
  ASSERT_EQ(swp_proxies_create(nullptr, &proxies), swp_result{SWP_OK});
  for (const CollisionFilter& filter : kFilters) {
    EXPECT_TRUE(Passes({}, filter));
    const swp_proxy_options options = {{filter.category, filter.mask}, 0, 0, 0};
    swp_proxy added = 0;
    ASSERT_EQ(swp_proxies_add_many(proxies, &box, &options, 1, &added), swp_result{SWP_OK});
  }
  ASSERT_EQ(swp_proxies_prepare_queries(proxies), swp_result{SWP_OK});
  swp_proxy found[std::size(kFilters)];
  uint64_t end = 0;
  ASSERT_EQ(swp_proxies_query_boxes(proxies, &box, 1, nullptr, found, std::size(kFilters), &end),
            swp_result{SWP_OK});
  EXPECT_EQ(end, std::size(kFilters));
  swp_proxies_destroy(proxies);
}

}  // namespace
}  // namespace sweepstake

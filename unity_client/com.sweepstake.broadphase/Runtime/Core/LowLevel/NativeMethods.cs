// Written by unity_client/tools/make_bindings.py from the headers of the C ABI.
// The following condition alone decides which builds import the native library. The import of a missing shared library fails at run time. On
// iOS the library is an archive, and without it the imports would break the link of each build. Define SWEEPSTAKE_IOS if the archive is there.
#if !UNITY_5_3_OR_NEWER || UNITY_EDITOR || UNITY_STANDALONE || UNITY_EMBEDDED_LINUX || UNITY_ANDROID || (UNITY_IOS && SWEEPSTAKE_IOS)
#define HAS_LIBRARY
#endif
#nullable enable
using System;
using System.Runtime.InteropServices;

namespace Sweepstake.LowLevel
{
    /// <summary>
    /// The functions of the C ABI under their own names, for jobs and Burst; the C headers in Native~/include document them. They use
    /// pointers and scalars only, so nothing is marshalled and nothing allocates. All other code uses the classes of
    /// <see cref="Sweepstake"/>, which check results and own the native objects. In a build without the library, they throw
    /// <see cref="NotSupportedException"/>.
    /// </summary>
    public static unsafe class NativeMethods
    {
#if HAS_LIBRARY
        internal static bool HasLibrary => true;
#if UNITY_IOS && !UNITY_EDITOR
        private const string Library = "__Internal";
#else
        private const string Library = "sweepstake";
#endif

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* swp_last_error();

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_set_last_error(byte* text, ulong size);

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_last_error_of(void* @object, byte* text, uint capacity);

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_live_count(ObjectKind kind);

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_shutdown_all(uint deadlineMs);

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_abi_version();

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_abi_revision();

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_version(uint* major, uint* minor, uint* patch);

        /// <summary>See c_api.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_struct_size(uint which);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_decider_options_init(NativeDeciderOptions* options);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_attach_decider(IntPtr session, NativeDeciderOptions* options, ulong nowNs);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_detach_decider(IntPtr session);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_freeze(IntPtr session, NativeDeciderOptions* options);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_poll_decider(IntPtr session, ulong nowNs, SwitchCommand* command, uint* commanded);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_beliefs(IntPtr session, Belief* beliefs, uint capacity, uint* count);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_decision_count(IntPtr session, ulong* count);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_prior_source_count(IntPtr session, ulong* count);

        /// <summary>See c_deciders.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_export_priors(IntPtr session, byte* data, ulong capacity, ulong* bytes);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_options_init(NativeLinkOptions* options);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_create(IntPtr session, NativeLinkOptions* options, IntPtr* link);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_link_destroy(IntPtr link);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_connected(IntPtr link, ulong nowNs);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_next_message(IntPtr link, ulong nowNs, void* buffer, ulong capacity, ulong* size, LinkAction* action);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_on_message(IntPtr link, void* bytes, ulong size, ulong nowNs);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_disconnected(IntPtr link, uint grpcStatusCode, byte* message, void* details, ulong detailsSize, ulong nowNs, uint* delayMs);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_goodbye(IntPtr link, ulong deadlineNs);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_status(IntPtr link, LinkStats* stats);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_copy_text(IntPtr link, LinkText which, byte* text, ulong capacity, ulong* size);

        /// <summary>See c_link.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_beliefs(IntPtr link, Belief* beliefs, uint capacity, uint* count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_options_init(ProxySetOptions* options);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_create(ProxySetOptions* options, IntPtr* proxies);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_proxies_destroy(IntPtr proxies);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_add_many(IntPtr proxies, Aabb* boxes, ProxyOptions* options, uint count, ProxyHandle* added);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_remove_many(IntPtr proxies, ProxyHandle* removed, uint count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_boxes(IntPtr proxies, ProxyHandle* moved, Aabb* boxes, uint count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_filter(IntPtr proxies, ulong proxy, ProxyFilter* filter);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_user(IntPtr proxies, ulong proxy, ulong user);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_static(IntPtr proxies, ulong proxy, uint isStatic);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_sleeping(IntPtr proxies, ulong proxy, uint isSleeping);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_shift_origin(IntPtr proxies, float* offset);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_snapshot_bytes(IntPtr proxies, ulong* bytes);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_save(IntPtr proxies, void* snapshot, ulong capacity);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_restore(IntPtr proxies, void* snapshot, ulong bytes);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_get(IntPtr proxies, ulong proxy, Aabb* box, ProxyOptions* options);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_handle(IntPtr proxies, uint id, ProxyHandle* proxy);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_counts(IntPtr proxies, uint* movingCount, uint* staticCount, ulong* nativeBytes);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_moving_boxes(IntPtr proxies, Aabb** boxes, uint* count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_resolve(IntPtr proxies, OverlapPair* movingPairs, ulong movingPairCount);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_pairs(IntPtr proxies, OverlapPair** pairs, ulong* count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_added(IntPtr proxies, ProxyPair** added, ulong* count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_removed(IntPtr proxies, ProxyPair** removed, ulong* count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_prepare_queries(IntPtr proxies);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_query_boxes(IntPtr proxies, Aabb* boxes, uint boxCount, ProxyFilter* filter, ProxyHandle* found, ulong capacity, ulong* ends);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_query_spheres(IntPtr proxies, SphereQuery* spheres, uint sphereCount, ProxyFilter* filter, ProxyHandle* found, ulong capacity, ulong* ends);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_cast_rays(IntPtr proxies, RayQuery* rays, uint rayCount, ProxyFilter* filter, QueryHit* hits);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_sweep_boxes(IntPtr proxies, BoxSweepQuery* sweeps, uint sweepCount, ProxyFilter* filter, QueryHit* hits);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_cast_ray(IntPtr proxies, RayQuery* ray, ProxyFilter* filter, QueryHit* hits, ulong capacity, ulong* count);

        /// <summary>See c_proxies.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_round_outward(double* min, double* max, Aabb* box);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_scene_count();

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* swp_scene_name(uint index);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_options_init(SceneOptions* options);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_create(byte* scene, SceneOptions* options, IntPtr* @out);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_scene_destroy(IntPtr scene);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_step(IntPtr scene);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_boxes(IntPtr scene, Aabb** boxes, uint* count);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_world(IntPtr scene, Aabb* world);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_frame_index(IntPtr scene, ulong* frameIndex);

        /// <summary>See c_scenes.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_hash(IntPtr scene, ulong* hash);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_options_init(NativeSessionOptions* options);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_create(NativeSessionOptions* options, IntPtr* session);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_session_destroy(IntPtr session);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_begin_frame(IntPtr session);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_find_pairs(IntPtr session, Aabb* boxes, uint boxCount);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_pairs(IntPtr session, OverlapPair** pairs, ulong* count);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_end_frame(IntPtr session, ulong frameTimeNs, uint flags);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_trim(IntPtr session);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_select_arm(IntPtr session, byte* arm);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_set_mode(IntPtr session, SessionMode mode);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_mode(IntPtr session, SessionMode* mode);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_active_arm(IntPtr session, uint* arm);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_switch_epoch(IntPtr session, uint* switchEpoch);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_last_sample(IntPtr session, FrameSample* sample);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_arm_count(IntPtr session, uint* count);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_arm_name(IntPtr session, uint arm, byte** name);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_arm_version(IntPtr session, uint arm, uint* backendVersion);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_verdict(IntPtr session, Verdict* verdict);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_last_decision(IntPtr session, Decision* decision);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_last_outcome(IntPtr session, SwitchOutcome* outcome);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_dropped(IntPtr session, ulong* sampleCount, ulong* noteCount);

        /// <summary>See c_sessions.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_shadow_stats(IntPtr session, ShadowStats* stats);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_backend_count();

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* swp_backend_name(uint index);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_options_init(WorldOptions* options);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_create(byte* backend, WorldOptions* options, IntPtr* world);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_world_destroy(IntPtr world);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_build(IntPtr world, Aabb* boxes, uint count);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_update(IntPtr world, Aabb* boxes, uint count);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_find_pairs(IntPtr world);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_pairs(IntPtr world, OverlapPair** pairs, ulong* count);

        /// <summary>See c_worlds.h.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_counters(IntPtr world, WorldCounters* counters);
#else
        internal static bool HasLibrary => false;

        private static NotSupportedException Missing() => new NotSupportedException("Sweepstake has no native library for this platform.");

        public static byte* swp_last_error() => throw Missing();
        public static void swp_set_last_error(byte* text, ulong size) => throw Missing();
        public static ResultCode swp_last_error_of(void* @object, byte* text, uint capacity) => throw Missing();
        public static uint swp_live_count(ObjectKind kind) => throw Missing();
        public static ResultCode swp_shutdown_all(uint deadlineMs) => throw Missing();
        public static uint swp_abi_version() => throw Missing();
        public static uint swp_abi_revision() => throw Missing();
        public static ResultCode swp_version(uint* major, uint* minor, uint* patch) => throw Missing();
        public static uint swp_struct_size(uint which) => throw Missing();
        public static ResultCode swp_decider_options_init(NativeDeciderOptions* options) => throw Missing();
        public static ResultCode swp_session_attach_decider(IntPtr session, NativeDeciderOptions* options, ulong nowNs) => throw Missing();
        public static ResultCode swp_session_detach_decider(IntPtr session) => throw Missing();
        public static ResultCode swp_session_freeze(IntPtr session, NativeDeciderOptions* options) => throw Missing();
        public static ResultCode swp_session_poll_decider(IntPtr session, ulong nowNs, SwitchCommand* command, uint* commanded) => throw Missing();
        public static ResultCode swp_session_beliefs(IntPtr session, Belief* beliefs, uint capacity, uint* count) => throw Missing();
        public static ResultCode swp_session_decision_count(IntPtr session, ulong* count) => throw Missing();
        public static ResultCode swp_session_prior_source_count(IntPtr session, ulong* count) => throw Missing();
        public static ResultCode swp_session_export_priors(IntPtr session, byte* data, ulong capacity, ulong* bytes) => throw Missing();
        public static ResultCode swp_link_options_init(NativeLinkOptions* options) => throw Missing();
        public static ResultCode swp_link_create(IntPtr session, NativeLinkOptions* options, IntPtr* link) => throw Missing();
        public static void swp_link_destroy(IntPtr link) => throw Missing();
        public static ResultCode swp_link_connected(IntPtr link, ulong nowNs) => throw Missing();
        public static ResultCode swp_link_next_message(IntPtr link, ulong nowNs, void* buffer, ulong capacity, ulong* size, LinkAction* action) => throw Missing();
        public static ResultCode swp_link_on_message(IntPtr link, void* bytes, ulong size, ulong nowNs) => throw Missing();
        public static ResultCode swp_link_disconnected(IntPtr link, uint grpcStatusCode, byte* message, void* details, ulong detailsSize, ulong nowNs, uint* delayMs) => throw Missing();
        public static ResultCode swp_link_goodbye(IntPtr link, ulong deadlineNs) => throw Missing();
        public static ResultCode swp_link_status(IntPtr link, LinkStats* stats) => throw Missing();
        public static ResultCode swp_link_copy_text(IntPtr link, LinkText which, byte* text, ulong capacity, ulong* size) => throw Missing();
        public static ResultCode swp_link_beliefs(IntPtr link, Belief* beliefs, uint capacity, uint* count) => throw Missing();
        public static ResultCode swp_proxies_options_init(ProxySetOptions* options) => throw Missing();
        public static ResultCode swp_proxies_create(ProxySetOptions* options, IntPtr* proxies) => throw Missing();
        public static void swp_proxies_destroy(IntPtr proxies) => throw Missing();
        public static ResultCode swp_proxies_add_many(IntPtr proxies, Aabb* boxes, ProxyOptions* options, uint count, ProxyHandle* added) => throw Missing();
        public static ResultCode swp_proxies_remove_many(IntPtr proxies, ProxyHandle* removed, uint count) => throw Missing();
        public static ResultCode swp_proxies_set_boxes(IntPtr proxies, ProxyHandle* moved, Aabb* boxes, uint count) => throw Missing();
        public static ResultCode swp_proxies_set_filter(IntPtr proxies, ulong proxy, ProxyFilter* filter) => throw Missing();
        public static ResultCode swp_proxies_set_user(IntPtr proxies, ulong proxy, ulong user) => throw Missing();
        public static ResultCode swp_proxies_set_static(IntPtr proxies, ulong proxy, uint isStatic) => throw Missing();
        public static ResultCode swp_proxies_set_sleeping(IntPtr proxies, ulong proxy, uint isSleeping) => throw Missing();
        public static ResultCode swp_proxies_shift_origin(IntPtr proxies, float* offset) => throw Missing();
        public static ResultCode swp_proxies_snapshot_bytes(IntPtr proxies, ulong* bytes) => throw Missing();
        public static ResultCode swp_proxies_save(IntPtr proxies, void* snapshot, ulong capacity) => throw Missing();
        public static ResultCode swp_proxies_restore(IntPtr proxies, void* snapshot, ulong bytes) => throw Missing();
        public static ResultCode swp_proxies_get(IntPtr proxies, ulong proxy, Aabb* box, ProxyOptions* options) => throw Missing();
        public static ResultCode swp_proxies_handle(IntPtr proxies, uint id, ProxyHandle* proxy) => throw Missing();
        public static ResultCode swp_proxies_counts(IntPtr proxies, uint* movingCount, uint* staticCount, ulong* nativeBytes) => throw Missing();
        public static ResultCode swp_proxies_moving_boxes(IntPtr proxies, Aabb** boxes, uint* count) => throw Missing();
        public static ResultCode swp_proxies_resolve(IntPtr proxies, OverlapPair* movingPairs, ulong movingPairCount) => throw Missing();
        public static ResultCode swp_proxies_pairs(IntPtr proxies, OverlapPair** pairs, ulong* count) => throw Missing();
        public static ResultCode swp_proxies_added(IntPtr proxies, ProxyPair** added, ulong* count) => throw Missing();
        public static ResultCode swp_proxies_removed(IntPtr proxies, ProxyPair** removed, ulong* count) => throw Missing();
        public static ResultCode swp_proxies_prepare_queries(IntPtr proxies) => throw Missing();
        public static ResultCode swp_proxies_query_boxes(IntPtr proxies, Aabb* boxes, uint boxCount, ProxyFilter* filter, ProxyHandle* found, ulong capacity, ulong* ends) => throw Missing();
        public static ResultCode swp_proxies_query_spheres(IntPtr proxies, SphereQuery* spheres, uint sphereCount, ProxyFilter* filter, ProxyHandle* found, ulong capacity, ulong* ends) => throw Missing();
        public static ResultCode swp_proxies_cast_rays(IntPtr proxies, RayQuery* rays, uint rayCount, ProxyFilter* filter, QueryHit* hits) => throw Missing();
        public static ResultCode swp_proxies_sweep_boxes(IntPtr proxies, BoxSweepQuery* sweeps, uint sweepCount, ProxyFilter* filter, QueryHit* hits) => throw Missing();
        public static ResultCode swp_proxies_cast_ray(IntPtr proxies, RayQuery* ray, ProxyFilter* filter, QueryHit* hits, ulong capacity, ulong* count) => throw Missing();
        public static ResultCode swp_round_outward(double* min, double* max, Aabb* box) => throw Missing();
        public static uint swp_scene_count() => throw Missing();
        public static byte* swp_scene_name(uint index) => throw Missing();
        public static ResultCode swp_scene_options_init(SceneOptions* options) => throw Missing();
        public static ResultCode swp_scene_create(byte* scene, SceneOptions* options, IntPtr* @out) => throw Missing();
        public static void swp_scene_destroy(IntPtr scene) => throw Missing();
        public static ResultCode swp_scene_step(IntPtr scene) => throw Missing();
        public static ResultCode swp_scene_boxes(IntPtr scene, Aabb** boxes, uint* count) => throw Missing();
        public static ResultCode swp_scene_world(IntPtr scene, Aabb* world) => throw Missing();
        public static ResultCode swp_scene_frame_index(IntPtr scene, ulong* frameIndex) => throw Missing();
        public static ResultCode swp_scene_hash(IntPtr scene, ulong* hash) => throw Missing();
        public static ResultCode swp_session_options_init(NativeSessionOptions* options) => throw Missing();
        public static ResultCode swp_session_create(NativeSessionOptions* options, IntPtr* session) => throw Missing();
        public static void swp_session_destroy(IntPtr session) => throw Missing();
        public static ResultCode swp_session_begin_frame(IntPtr session) => throw Missing();
        public static ResultCode swp_session_find_pairs(IntPtr session, Aabb* boxes, uint boxCount) => throw Missing();
        public static ResultCode swp_session_pairs(IntPtr session, OverlapPair** pairs, ulong* count) => throw Missing();
        public static ResultCode swp_session_end_frame(IntPtr session, ulong frameTimeNs, uint flags) => throw Missing();
        public static ResultCode swp_session_trim(IntPtr session) => throw Missing();
        public static ResultCode swp_session_select_arm(IntPtr session, byte* arm) => throw Missing();
        public static ResultCode swp_session_set_mode(IntPtr session, SessionMode mode) => throw Missing();
        public static ResultCode swp_session_mode(IntPtr session, SessionMode* mode) => throw Missing();
        public static ResultCode swp_session_active_arm(IntPtr session, uint* arm) => throw Missing();
        public static ResultCode swp_session_switch_epoch(IntPtr session, uint* switchEpoch) => throw Missing();
        public static ResultCode swp_session_last_sample(IntPtr session, FrameSample* sample) => throw Missing();
        public static ResultCode swp_session_arm_count(IntPtr session, uint* count) => throw Missing();
        public static ResultCode swp_session_arm_name(IntPtr session, uint arm, byte** name) => throw Missing();
        public static ResultCode swp_session_arm_version(IntPtr session, uint arm, uint* backendVersion) => throw Missing();
        public static ResultCode swp_session_verdict(IntPtr session, Verdict* verdict) => throw Missing();
        public static ResultCode swp_session_last_decision(IntPtr session, Decision* decision) => throw Missing();
        public static ResultCode swp_session_last_outcome(IntPtr session, SwitchOutcome* outcome) => throw Missing();
        public static ResultCode swp_session_dropped(IntPtr session, ulong* sampleCount, ulong* noteCount) => throw Missing();
        public static ResultCode swp_session_shadow_stats(IntPtr session, ShadowStats* stats) => throw Missing();
        public static uint swp_backend_count() => throw Missing();
        public static byte* swp_backend_name(uint index) => throw Missing();
        public static ResultCode swp_world_options_init(WorldOptions* options) => throw Missing();
        public static ResultCode swp_world_create(byte* backend, WorldOptions* options, IntPtr* world) => throw Missing();
        public static void swp_world_destroy(IntPtr world) => throw Missing();
        public static ResultCode swp_world_build(IntPtr world, Aabb* boxes, uint count) => throw Missing();
        public static ResultCode swp_world_update(IntPtr world, Aabb* boxes, uint count) => throw Missing();
        public static ResultCode swp_world_find_pairs(IntPtr world) => throw Missing();
        public static ResultCode swp_world_pairs(IntPtr world, OverlapPair** pairs, ulong* count) => throw Missing();
        public static ResultCode swp_world_counters(IntPtr world, WorldCounters* counters) => throw Missing();
#endif
    }
}

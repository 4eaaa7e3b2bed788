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
    /// The functions of the C ABI under their own names, for jobs and Burst, with the comments of the C headers. c_api.h has the rules for
    /// threads, ownership, units and errors. The functions use pointers and scalars only, so nothing is marshalled and nothing allocates. All
    /// other code uses the classes of <see cref="Sweepstake"/>, which check results and own the native objects. In a build without the
    /// library, they throw <see cref="NotSupportedException"/>.
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

        /// <summary>
        /// One line about the latest failed call on this thread, "" if none has failed. Valid until the next failure on this thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* swp_last_error();

        /// <summary>
        /// Sets swp_last_error() of this thread to a text of `size` bytes, cut to 1,023. It is for libraries that add functions to the ABI,
        /// such as that of c_daemon.h.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_set_last_error(byte* text, ulong size);

        /// <summary>
        /// Writes one line about the latest failed call of one object, on whichever thread it ran: jobs migrate between threads. It is "" if
        /// no call has failed. It is cut to 255 bytes and to `capacity`, including its NUL. Any thread, any time; it takes a lock that no
        /// frame takes. SWP_NOT_FOUND if the object does not exist. If two calls of the object fail at the same moment, one of the two
        /// messages is returned.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_last_error_of(void* @object, byte* text, uint capacity);

        /// <summary>The number of living objects of this kind in the process, or 0 for an unknown kind. Any thread, at any time.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_live_count(ObjectKind kind);

        /// <summary>
        /// Ends every object of the process, with its threads and memory. It is for a host that has lost its handles because its domain was
        /// reloaded. Call it before new objects are made. From then on, calls on old objects fail with SWP_FAILED_PRECONDITION. The function
        /// waits at most deadline_ms for calls in progress; with 0 it does not wait. Freeing takes additional time, although a session's lane
        /// stops in the middle of a search. SWP_UNAVAILABLE: some calls had not returned at the deadline. Their objects stay alive and
        /// everything else is freed; call the function again to free the rest. Objects made during the call stay alive. Safe: any thread may
        /// call it, at any time and more than once, also while other threads are in calls that take an object as non-const. An old handle
        /// that is used afterwards gives SWP_FAILED_PRECONDITION in any function, on any thread. It may be passed to its _destroy once; until
        /// then it keeps a small block of memory. Not safe on another thread while this function runs: a _destroy, a call that takes its
        /// object as const (to read pairs or query proxies), reading memory that an object has returned, and using a destroyed handle. After
        /// SWP_OK the caller's executors are not called any more.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_shutdown_all(uint deadlineMs);

        /// <summary>
        /// SWP_ABI_VERSION of the loaded library. Compare it before anything else: a library with another version is incompatible.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_abi_version();

        /// <summary>
        /// SWP_ABI_REVISION of the loaded library. Check it before calling a function that an earlier revision lacks. Apart from that,
        /// callers and libraries of different revisions are compatible.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_abi_revision();

        /// <summary>The version of the library, for display. Programs compare the two numbers above instead.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_version(uint* major, uint* minor, uint* patch);

        /// <summary>The size in bytes of a struct in this library, for bindings of other languages; 0 for an unknown struct.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_struct_size(uint which);

        /// <summary>Sets the defaults of swp_decider_options, seed 1 and time scale 1.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_decider_options_init(NativeDeciderOptions* options);

        /// <summary>
        /// Attaches an embedded decider. `options` NULL uses the defaults. SWP_FAILED_PRECONDITION if a decider is already attached,
        /// SWP_NOT_FOUND if the file does not exist, SWP_DATA_LOSS if the priors are broken; the message names the first broken record.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_attach_decider(IntPtr session, NativeDeciderOptions* options, ulong nowNs);

        /// <summary>
        /// Ends the decider and discards what it has learnt. After that the session handles bail-outs itself, and the time scale does not
        /// divide its settling time any more.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_detach_decider(IntPtr session);

        /// <summary>
        /// Chooses the arm that the priors of `options` expect to cost least, from the next begin_frame on. With NULL the session keeps its
        /// arm. Sets SWP_MODE_MANUAL and disables everything that depends on time, so that runs repeat bit for bit (builds, replays,
        /// tournaments): the clock is not read, samples have no detection time, the lane gets no frames, and commands and orders are refused.
        /// swp_session_select_arm still works. swp_session_set_mode ends this state. SWP_NOT_FOUND if the priors have no evidence of the
        /// project with the session's arms; the session is unchanged then. Frame thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_freeze(IntPtr session, NativeDeciderOptions* options);

        /// <summary>
        /// Passes the frames since the last poll to the decider, makes a decision if one is due (decision_interval_ns), and posts its
        /// command, if any, to the frame thread. Sets `commanded` to 1 if a command was posted, and writes the command to `command`; both may
        /// be NULL. Poll every 250 ms or more often.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_poll_decider(IntPtr session, ulong nowNs, SwitchCommand* command, uint* commanded);

        /// <summary>
        /// Writes the posteriors in the order of arms; `count` is the number of arms. If `capacity` is too small, the result is
        /// SWP_RESOURCE_EXHAUSTED and only `count` is written.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_beliefs(IntPtr session, Belief* beliefs, uint capacity, uint* count);

        /// <summary>The number of decisions since the decider was attached.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_decision_count(IntPtr session, ulong* count);

        /// <summary>The number of sources in the decider's priors; 0: it started from Beta(1,1).</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_prior_source_count(IntPtr session, ulong* count);

        /// <summary>
        /// Writes the content of a priors file: all records that the decider started from, and what it has learnt since. Use it as the next
        /// run's priors_data, or with `sweepstake priors import`. Both count each piece of evidence only once, however often it is exported.
        /// `bytes` is the length without a NUL. If `capacity` is too small, the result is SWP_RESOURCE_EXHAUSTED and only `bytes` is written.
        /// Call it before the decider is detached, because detaching discards the evidence.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_export_priors(IntPtr session, byte* data, ulong capacity, ulong* bytes);

        /// <summary>Sets the defaults of swp_link_options.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_options_init(NativeLinkOptions* options);

        /// <summary>
        /// Attaches a link to the session. From now on the link sends the session's samples. `options` NULL uses the defaults.
        /// SWP_FAILED_PRECONDITION if a decider or another link is attached. After the session is destroyed or shut down, every function of
        /// the link except destroy returns SWP_FAILED_PRECONDITION.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_create(IntPtr session, NativeLinkOptions* options, IntPtr* link);

        /// <summary>
        /// Destroys the link. Call swp_link_goodbye before; without it the daemon keeps the session, which no other process may resume. No
        /// other thread may be in a call of the link.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_link_destroy(IntPtr link);

        /// <summary>
        /// Reports that a stream was opened, or is being opened. SWP_FAILED_PRECONDITION if the previous stream was not reported as
        /// disconnected, or the state is SWP_LINK_CLOSED.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_connected(IntPtr link, ulong nowNs);

        /// <summary>
        /// Reads the session's samples and returns the caller's next action. With SWP_LINK_SEND the next message is in `buffer` and counts as
        /// sent; with any other action `size` is 0. SWP_LINK_FINISH is returned once. Every few milliseconds, with and without a stream, call
        /// it until the action is not SWP_LINK_SEND. If `capacity` is too small for the message, the result is SWP_RESOURCE_EXHAUSTED, `size`
        /// is the size that it needs, and the message stays the next one. `action` is written too, and no last error is set. A caller with a
        /// write in progress therefore passes NULL and 0. A capacity of batch_bytes or 8 KiB, whichever is more, is enough for nearly all
        /// messages.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_next_message(IntPtr link, ulong nowNs, void* buffer, ulong capacity, ulong* size, LinkAction* action);

        /// <summary>
        /// Processes a message of the daemon; any bytes are safe. SWP_DATA_LOSS if they are not a valid message. The session then loses
        /// nothing: the next action is SWP_LINK_CANCEL, and everything unacknowledged is sent again on the next stream.
        /// SWP_FAILED_PRECONDITION without a stream.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_on_message(IntPtr link, void* bytes, ulong size, ulong nowNs);

        /// <summary>
        /// Reports that the stream has ended, after its last message was passed to swp_link_on_message. `message` and the code come from
        /// gRPC's status. `details` are the bytes of the trailer grpc-status-details-bin, decoded from base64. `message` and `details` may be
        /// NULL. If the details have the daemon's own code and message, those count: a proxy may reset the stream. The first 256 bytes of the
        /// message are kept, and shown as one line of UTF-8. `delay_ms` is the time to wait before the next stream, or SWP_LINK_NEVER.
        /// Without a previous swp_link_connected, the call reports that no stream could be opened.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_disconnected(IntPtr link, uint grpcStatusCode, byte* message, void* details, ulong detailsSize, ulong nowNs, uint* delayMs);

        /// <summary>
        /// Starts to end the session: the remaining evidence is sent, then a goodbye, and the state becomes SWP_LINK_CLOSED. At the deadline
        /// at the latest, SWP_LINK_CANCEL ends the stream. No further stream follows. If no stream is open, or it breaks before the end, the
        /// state becomes SWP_LINK_CLOSED at once and unsent evidence is dropped. To keep the evidence, an offline caller waits for its next
        /// stream before it calls this function. A later call can only bring the deadline forward.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_goodbye(IntPtr link, ulong deadlineNs);

        /// <summary>Writes the statistics. Set stats-&gt;struct_size before.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_status(IntPtr link, LinkStats* stats);

        /// <summary>
        /// Writes a text with its NUL; `size` is its length without it. If `capacity` is too small, the result is SWP_RESOURCE_EXHAUSTED and
        /// only `size` is written.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_copy_text(IntPtr link, LinkText which, byte* text, ulong capacity, ulong* size);

        /// <summary>
        /// Writes the daemon's latest posteriors in the order of arms. `count` is their number; it is 0 before the first posteriors arrive.
        /// If `capacity` is too small, the result is SWP_RESOURCE_EXHAUSTED and only `count` is written. For the verdict use
        /// swp_session_verdict.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_link_beliefs(IntPtr link, Belief* beliefs, uint capacity, uint* count);

        /// <summary>Sets the defaults: no events, unsorted pairs, and the calling thread alone.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_options_init(ProxySetOptions* options);

        /// <summary>Makes an empty set. `options` NULL uses the defaults. SWP_RESOURCE_EXHAUSTED if the system has no more threads.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_create(ProxySetOptions* options, IntPtr* proxies);

        /// <summary>Makes an empty set. `options` NULL uses the defaults. SWP_RESOURCE_EXHAUSTED if the system has no more threads.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_proxies_destroy(IntPtr proxies);

        /// <summary>
        /// Adds a proxy for each box and writes their handles to `added`. `options` has one element per box; NULL makes moving proxies with
        /// the default filter and user 0. Cost: O(1) per moving proxy; for static ones see ProxySet::Add. If memory runs out, no proxy is
        /// added, and the content of `added` is undefined.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_add_many(IntPtr proxies, Aabb* boxes, ProxyOptions* options, uint count, ProxyHandle* added);

        /// <summary>Removes these proxies. If one handle is SWP_NOT_FOUND, none is removed. A handle may be given twice.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_remove_many(IntPtr proxies, ProxyHandle* removed, uint count);

        /// <summary>
        /// Gives boxes[k] to moved[k]. If one handle is SWP_NOT_FOUND, no proxy is moved. Cost: O(1) each; almost nothing for an unchanged
        /// box. A resting proxy with a new box costs an add at the next use.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_boxes(IntPtr proxies, ProxyHandle* moved, Aabb* boxes, uint count);

        /// <summary>Sets the filter. It applies from the next resolve and the next query on.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_filter(IntPtr proxies, ulong proxy, ProxyFilter* filter);

        /// <summary>Sets the user value, which swp_proxies_get returns.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_user(IntPtr proxies, ulong proxy, ulong user);

        /// <summary>
        /// 1 makes a moving proxy static; 0 makes a static one moving and awake. Handle and id stay the same. Cost: as an add.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_static(IntPtr proxies, ulong proxy, uint isStatic);

        /// <summary>
        /// 1 marks a proxy that will not move. Its pairs with other resting (static or sleeping) proxies are kept, and no search starts from
        /// it. Setting a different box wakes it. Pairs, events and queries are the same as without the mark. Does nothing for a static proxy.
        /// Cost: as an add; the next resolve searches once among all resting proxies.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_set_sleeping(IntPtr proxies, ulong proxy, uint isSleeping);

        /// <summary>
        /// Subtracts offset[0..2] from all coordinates. No pair ends. Boxes whose gap is below the rounding of coordinates may begin to
        /// touch. A box that the shift takes beyond the largest float is invalid until it gets another box; an invalid box stays invalid.
        /// SWP_INVALID_ARGUMENT for an offset that is not finite, which changes nothing. Cost: O(proxies).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_shift_origin(IntPtr proxies, float* offset);

        /// <summary>The bytes that a snapshot of the current state takes.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_snapshot_bytes(IntPtr proxies, ulong* bytes);

        /// <summary>
        /// Writes the whole state to the caller's memory, without pointers, for a game that rolls back. SWP_INVALID_ARGUMENT if `capacity` is
        /// below swp_proxies_snapshot_bytes.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_save(IntPtr proxies, void* snapshot, ulong capacity);

        /// <summary>
        /// Restores the state: handles, pairs, events and queries are again as they were at the save. Handles made since the save are given
        /// out again. `bytes` may exceed the size of the snapshot. Invalidates pointers to pairs and boxes. The set is unchanged if the
        /// snapshot is refused. The result is SWP_DATA_LOSS if it is cut off or damaged, SWP_INVALID_ARGUMENT if it is of another version of
        /// the library or of a set with other options. Do not restore untrusted snapshots. If memory runs out, part of the state is lost:
        /// only another restore or swp_proxies_destroy may follow.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_restore(IntPtr proxies, void* snapshot, ulong bytes);

        /// <summary>Writes the current box and options. Either output may be NULL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_get(IntPtr proxies, ulong proxy, Aabb* box, ProxyOptions* options);

        /// <summary>Writes the handle of the proxy that has this id now.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_handle(IntPtr proxies, uint id, ProxyHandle* proxy);

        /// <summary>
        /// The numbers of living proxies, and the memory that the set holds, in bytes. Every 256th resolve frees memory that was not needed
        /// since then; the next add or removal frees that of the proxies. Each output may be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_counts(IntPtr proxies, uint* movingCount, uint* staticCount, ulong* nativeBytes);

        /// <summary>
        /// The boxes to give to a world or a session, valid until the next change of the set. Changes are adds, removals, new boxes, filters
        /// or flags, a shift and restore. Up to 1 in 32 boxes is invalid and belongs to no proxy. An index is not an id; swp_proxies_resolve
        /// converts it.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_moving_boxes(IntPtr proxies, Aabb** boxes, uint* count);

        /// <summary>
        /// Call it once per frame with all pairs found in the boxes of swp_proxies_moving_boxes; the set must be unchanged since they were
        /// read. Keeps the pairs whose filters pass, and adds the pairs of moving and static proxies. SWP_INVALID_ARGUMENT unless each pair
        /// has a &lt; b and both are indices of these boxes. After SWP_RESOURCE_EXHAUSTED (memory or max_pairs) there are no pairs and no
        /// events. The next successful resolve reports all events since the latest successful one. Skip it in a frame whose search exceeded
        /// max_pairs; no pair ends then.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_resolve(IntPtr proxies, OverlapPair* movingPairs, ulong movingPairCount);

        /// <summary>
        /// The pairs of the latest resolve, valid until the next one. They may share memory with moving_pairs, and are then valid only while
        /// that memory is. SWP_FAILED_PRECONDITION before the first resolve, and after restore or a resolve with SWP_RESOURCE_EXHAUSTED.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_pairs(IntPtr proxies, OverlapPair** pairs, ulong* count);

        /// <summary>
        /// The pairs that began (added) and ended (removed) between the latest two successful resolves, ascending; empty without pair_events.
        /// Pairs of a removed proxy have ended. Valid until the next resolve.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_added(IntPtr proxies, ProxyPair** added, ulong* count);

        /// <summary>
        /// The pairs that began (added) and ended (removed) between the latest two successful resolves, ascending; empty without pair_events.
        /// Pairs of a removed proxy have ended. Valid until the next resolve.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_removed(IntPtr proxies, ProxyPair** removed, ulong* count);

        /// <summary>
        /// Prepares the queries, as ProxySet::PrepareQueries. Cost: O(1) if nothing has changed, O(moving proxies) if a moving proxy has
        /// changed, otherwise O(changes).
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_prepare_queries(IntPtr proxies);

        /// <summary>
        /// Finds all proxies that overlap each box, by ascending id. The proxies of box k are in `found` from index ends[k - 1] (0 for the
        /// first box) up to, but not including, ends[k]. If the capacity of `found` is too small, the result is SWP_RESOURCE_EXHAUSTED.
        /// `ends` is correct even then: its last value is the needed capacity. The content of `found` is undefined then.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_query_boxes(IntPtr proxies, Aabb* boxes, uint boxCount, ProxyFilter* filter, ProxyHandle* found, ulong capacity, ulong* ends);

        /// <summary>Like swp_proxies_query_boxes, but finds the proxies that overlap spheres.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_query_spheres(IntPtr proxies, SphereQuery* spheres, uint sphereCount, ProxyFilter* filter, ProxyHandle* found, ulong capacity, ulong* ends);

        /// <summary>
        /// Finds the nearest hit of each ray; proxy and distance are 0 if there is none. SWP_INVALID_ARGUMENT for a ray that is not finite or
        /// has a negative max_distance.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_cast_rays(IntPtr proxies, RayQuery* rays, uint rayCount, ProxyFilter* filter, QueryHit* hits);

        /// <summary>Like swp_proxies_cast_rays, but for swept boxes.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_sweep_boxes(IntPtr proxies, BoxSweepQuery* sweeps, uint sweepCount, ProxyFilter* filter, QueryHit* hits);

        /// <summary>
        /// Finds all hits of one ray by ascending distance, then by id. If the capacity is too small, the result is SWP_RESOURCE_EXHAUSTED,
        /// `count` is the needed capacity, and the content of `hits` is undefined.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_proxies_cast_ray(IntPtr proxies, RayQuery* ray, ProxyFilter* filter, QueryHit* hits, ulong capacity, ulong* count);

        /// <summary>
        /// Writes the smallest box of floats that contains the box of doubles min[0..2] to max[0..2]: min is rounded down and max up. A
        /// coordinate beyond the range of float becomes infinite, which makes the box invalid. A box that violates min &lt;= max gives an
        /// invalid box too.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_round_outward(double* min, double* max, Aabb* box);

        /// <summary>
        /// The number of scenes, and the name of each. Names stay valid. The name is NULL if `index` is swp_scene_count() or more. Any
        /// thread, at any time.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_scene_count();

        /// <summary>
        /// The number of scenes, and the name of each. Names stay valid. The name is NULL if `index` is swp_scene_count() or more. Any
        /// thread, at any time.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* swp_scene_name(uint index);

        /// <summary>Sets the defaults, which scene.h documents.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_options_init(SceneOptions* options);

        /// <summary>
        /// Makes a scene. `scene` is one of swp_scene_name() or the path of a .aabbs file. `options` NULL uses the defaults. SWP_NOT_FOUND if
        /// there is no such scene; the message lists the names. SWP_DATA_LOSS if the file is broken; the message says where.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_create(byte* scene, SceneOptions* options, IntPtr* @out);

        /// <summary>
        /// Makes a scene. `scene` is one of swp_scene_name() or the path of a .aabbs file. `options` NULL uses the defaults. SWP_NOT_FOUND if
        /// there is no such scene; the message lists the names. SWP_DATA_LOSS if the file is broken; the message says where.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_scene_destroy(IntPtr scene);

        /// <summary>Advances the scene by one fixed step.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_step(IntPtr scene);

        /// <summary>The boxes of this frame, valid until the next step.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_boxes(IntPtr scene, Aabb** boxes, uint* count);

        /// <summary>The bounds of the motion; boxes may extend beyond them by their size.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_world(IntPtr scene, Aabb* world);

        /// <summary>The number of steps taken.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_frame_index(IntPtr scene, ulong* frameIndex);

        /// <summary>
        /// FNV-1a, 64 bits, over the bytes of this frame's boxes in little-endian order. The same seed and step give the same hash on every
        /// platform.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_scene_hash(IntPtr scene, ulong* hash);

        /// <summary>
        /// Sets the defaults: all arms, KDTree at first, SWP_MODE_AI, a bail-out limit of 5 s, 2 s of settling, 4,096 samples, the calling
        /// thread alone, and SWP_SHADOW_AUTO.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_options_init(NativeSessionOptions* options);

        /// <summary>
        /// Makes a session. `options` NULL uses the defaults. SWP_NOT_FOUND for an unknown arm; the message lists the backends.
        /// SWP_RESOURCE_EXHAUSTED if the system cannot create a thread.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_create(NativeSessionOptions* options, IntPtr* session);

        /// <summary>Destroys the session. No other call of the session may be in progress.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_session_destroy(IntPtr session);

        /// <summary>Executes a pending switch, if any.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_begin_frame(IntPtr session);

        /// <summary>
        /// Passes the boxes to the active backend and searches for pairs. The number of boxes may change as in swp_world_update. In a frame
        /// with substeps or several fixed updates, call it for each of them; together they are one sample. After SWP_RESOURCE_EXHAUSTED
        /// (memory, or more pairs than max_pairs) there are no pairs until the next search, which rebuilds; end the frame as usual.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_find_pairs(IntPtr session, Aabb* boxes, uint boxCount);

        /// <summary>
        /// The pairs of the latest search, in the library's memory, which any thread may read until the next find_pairs or begin_frame.
        /// SWP_FAILED_PRECONDITION if this frame has not searched, or its latest search failed.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_pairs(IntPtr session, OverlapPair** pairs, ulong* count);

        /// <summary>
        /// Ends the frame. `frame_time_ns` is the unscaled time since the previous end_frame. `flags` may contain SWP_FRAME_PAUSED and
        /// SWP_FRAME_LOADING.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_end_frame(IntPtr session, ulong frameTimeNs, uint flags);

        /// <summary>
        /// Frees the buffers that the next frame does not need: the buffers of inactive arms and of the pairs. The shadow lane frees its
        /// memory soon after, on its own thread. Call it at the end of a level, or when memory is low. SWP_FAILED_PRECONDITION between
        /// begin_frame and end_frame. The pairs of the latest search become invalid; the next frame and later switches allocate again. Cost:
        /// the time to free it.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_trim(IntPtr session);

        /// <summary>
        /// Chooses an arm manually, from the next begin_frame on; the mode does not change. The message of SWP_NOT_FOUND lists the arms.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_select_arm(IntPtr session, byte* arm);

        /// <summary>Sets the mode. In SWP_MODE_MANUAL posted commands are refused unless their reason is SWP_SWITCH_MANUAL.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_set_mode(IntPtr session, SessionMode mode);

        /// <summary>The session's current mode, active arm, and number of executed switches.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_mode(IntPtr session, SessionMode* mode);

        /// <summary>The session's current mode, active arm, and number of executed switches.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_active_arm(IntPtr session, uint* arm);

        /// <summary>The session's current mode, active arm, and number of executed switches.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_switch_epoch(IntPtr session, uint* switchEpoch);

        /// <summary>The sample of the latest end_frame; all 0 before the first.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_last_sample(IntPtr session, FrameSample* sample);

        /// <summary>The session's arms, which never change.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_arm_count(IntPtr session, uint* count);

        /// <summary>The name of an arm, valid until the session is destroyed.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_arm_name(IntPtr session, uint arm, byte** name);

        /// <summary>The name of an arm, valid until the session is destroyed.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_arm_version(IntPtr session, uint arm, uint* backendVersion);

        /// <summary>
        /// The latest verdict of the attached decider or of the link's daemon; SWP_VERDICT_UNKNOWN before the first. Reading it is one atomic
        /// load, so a game may call this function in each frame and react: swp_verdict verdict; if (swp_session_verdict(session,
        /// &amp;verdict) == SWP_OK &amp;&amp; verdict.kind == SWP_VERDICT_DEGRADED) { spawn_fewer_objects(); }
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_verdict(IntPtr session, Verdict* verdict);

        /// <summary>
        /// The latest decision of the attached decider, with its reasons, or the latest command of the daemon. The outcome is
        /// SWP_DECISION_NONE before the first. The value is kept when the decider is detached. Lock-free; the frame thread does not wait for
        /// it.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_last_decision(IntPtr session, Decision* decision);

        /// <summary>
        /// The latest outcome: of a switch that has settled or was refused, or of the end of a trial. All 0 before the first. Lock-free.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_last_outcome(IntPtr session, SwitchOutcome* outcome);

        /// <summary>
        /// The numbers of items that full queues have dropped since the session began: samples, and switch outcomes and descriptors together.
        /// Either pointer may be NULL.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_dropped(IntPtr session, ulong* sampleCount, ulong* noteCount);

        /// <summary>The shadow lane's counters, and its state, which gives the reason if the lane does not run.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_session_shadow_stats(IntPtr session, ShadowStats* stats);

        /// <summary>
        /// The number of backends, and the name of each. Names stay valid. The name is NULL if `index` is swp_backend_count() or more. Any
        /// thread, at any time.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern uint swp_backend_count();

        /// <summary>
        /// The number of backends, and the name of each. Names stay valid. The name is NULL if `index` is swp_backend_count() or more. Any
        /// thread, at any time.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern byte* swp_backend_name(uint index);

        /// <summary>Sets the defaults: only the calling thread, and pairs in the order of the backend.</summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_options_init(WorldOptions* options);

        /// <summary>
        /// Makes a world without boxes. `options` NULL uses the defaults. The message of SWP_NOT_FOUND lists the backends.
        /// SWP_RESOURCE_EXHAUSTED if the system has no more threads.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_create(byte* backend, WorldOptions* options, IntPtr* world);

        /// <summary>
        /// Makes a world without boxes. `options` NULL uses the defaults. The message of SWP_NOT_FOUND lists the backends.
        /// SWP_RESOURCE_EXHAUSTED if the system has no more threads.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern void swp_world_destroy(IntPtr world);

        /// <summary>
        /// Discards all state and sets these boxes, which are read during the call only. `boxes` may be NULL if count is 0.
        /// SWP_INVALID_ARGUMENT for more than 2^31 - 1 boxes. After SWP_RESOURCE_EXHAUSTED (memory) the world must be built again.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_build(IntPtr world, Aabb* boxes, uint count);

        /// <summary>
        /// Sets the boxes of the next frame. A larger count adds objects after the last one, a smaller one removes the last ones; the others
        /// keep their ids. SWP_FAILED_PRECONDITION before a build.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_update(IntPtr world, Aabb* boxes, uint count);

        /// <summary>
        /// Finds each overlapping pair. A second call without a build or update in between does nothing. SWP_FAILED_PRECONDITION before a
        /// build. After SWP_RESOURCE_EXHAUSTED (memory, or more pairs than max_pairs) there are no pairs, and the world must be built again.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_find_pairs(IntPtr world);

        /// <summary>
        /// Writes the pairs of the search, each once. They are in the library's memory, which any thread may read until the next build or
        /// update. SWP_FAILED_PRECONDITION before the search.
        /// </summary>
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl, ExactSpelling = true)]
        public static extern ResultCode swp_world_pairs(IntPtr world, OverlapPair** pairs, ulong* count);

        /// <summary>The counters of the latest build or update and search, and the memory that the world holds.</summary>
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

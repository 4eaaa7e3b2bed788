#nullable enable
using System.Collections.Generic;

namespace Sweepstake.Unity
{
    /// <summary>
    /// Provides the boxes of a game that a <see cref="SweepstakeManager"/> searches in each frame. All calls come from the main thread.
    /// </summary>
    public interface IBroadPhaseSource
    {
        /// <summary>
        /// Reads the boxes of this frame and searches them with the session, whose frame has begun. Call
        /// <see cref="BroadPhaseSession.FindPairs(System.ReadOnlySpan{Aabb})"/> or <see cref="ProxySet.FindPairs(BroadPhaseSession)"/>.
        /// </summary>
        void Search(BroadPhaseSession session);

        /// <summary>Called after the frame, to raise events. An exception is logged and does not stop the frames.</summary>
        void Report();

        /// <summary>Returns, for debug views, the boxes of a pair of the latest search; false if there is none or an object was removed.</summary>
        bool TryGetPair(int index, out Aabb a, out Aabb b);

        /// <summary>
        /// Replaces the content of the list with the boxes of the latest search, including static ones, for recordings. An object keeps its
        /// index as long as it is in the source; an unused index has an invalid box.
        /// </summary>
        void CopyBoxes(List<Aabb> boxes);
    }
}

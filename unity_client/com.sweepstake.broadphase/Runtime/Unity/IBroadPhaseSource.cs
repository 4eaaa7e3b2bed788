#nullable enable
using System.Collections.Generic;

namespace Sweepstake.Unity
{
    /// <summary>What a <see cref="SweepstakeManager"/> searches in each frame: the boxes of a game. All calls come from the main thread.</summary>
    public interface IBroadPhaseSource
    {
        /// <summary>
        /// Takes the boxes of this frame and searches them with the session, which is in the midst of its frame:
        /// <see cref="BroadPhaseSession.FindPairs(System.ReadOnlySpan{Aabb})"/> or <see cref="ProxySet.FindPairs(BroadPhaseSession)"/>.
        /// </summary>
        void Search(BroadPhaseSession session);

        /// <summary>After the frame: the place to raise events. What it throws is logged, and the frames go on.</summary>
        void Report();

        /// <summary>For debug views: the boxes of a pair of the latest search; false beyond the last one, and once objects of them are gone.</summary>
        bool TryGetPair(int index, out Aabb a, out Aabb b);

        /// <summary>
        /// For recordings: replaces the content of the list by the boxes of the latest search, static ones included. An object's index is the
        /// same as long as it is there; one that nobody has holds an invalid box.
        /// </summary>
        void CopyBoxes(List<Aabb> boxes);
    }
}

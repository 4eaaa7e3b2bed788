#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>Says from which frames nothing can be learnt. The frame after a pause or a load has their time in it, and counts to them.</summary>
    internal sealed class FrameFlagger
    {
        private bool isSkipping = true;
        private bool wasAway;

        internal bool IsPaused { get; set; }
        internal bool IsInBackground { get; set; }
        internal bool IsLoading { get; set; }

        /// <summary>The next frame is no ordinary one.</summary>
        internal void Skip() => isSkipping = true;

        /// <summary>The flags of the frame that ends now.</summary>
        internal FrameFlags Take(bool isTimeStopped)
        {
            FrameFlags flags = FrameFlags.None;
            bool isAway = IsPaused || IsInBackground || isTimeStopped;
            if (isAway || wasAway)
                flags |= FrameFlags.Paused;
            if (IsLoading || isSkipping)
                flags |= FrameFlags.Loading;
            wasAway = isAway;
            isSkipping = IsLoading;
            return flags;
        }
    }
}

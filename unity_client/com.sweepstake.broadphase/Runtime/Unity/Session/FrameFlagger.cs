#nullable enable

namespace Sweepstake.Unity
{
    /// <summary>
    /// Flags frames that are excluded from learning. The first frame after a pause or a load is flagged too, because its time includes the
    /// pause or load.
    /// </summary>
    internal sealed class FrameFlagger
    {
        private bool isSkipping = true;
        private bool wasAway;

        internal bool IsPaused { get; set; }
        internal bool IsInBackground { get; set; }
        internal bool IsLoading { get; set; }

        /// <summary>Flags the next frame as loading.</summary>
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

#nullable enable
using System;

namespace Sweepstake
{
    /// <summary>
    /// An axis-aligned box in world units. It is valid if all coordinates are finite and min is at most max on each axis. An invalid box
    /// overlaps nothing. Boxes that touch overlap.
    /// </summary>
    public struct Aabb
    {
        public float MinX;
        public float MinY;
        public float MinZ;
        public float MaxX;
        public float MaxY;
        public float MaxZ;

        public Aabb(float minX, float minY, float minZ, float maxX, float maxY, float maxZ) =>
            (MinX, MinY, MinZ, MaxX, MaxY, MaxZ) = (minX, minY, minZ, maxX, maxY, maxZ);

        /// <summary>The box with this center and these half sizes.</summary>
        public static Aabb Around(float x, float y, float z, float halfX, float halfY, float halfZ) =>
            new Aabb(x - halfX, y - halfY, z - halfZ, x + halfX, y + halfY, z + halfZ);

        /// <summary>
        /// The smallest box of floats that contains a box of doubles: min is rounded down and max up, so that no overlap is lost. A coordinate
        /// outside the range of float becomes infinite, which makes the box invalid.
        /// </summary>
        /// <param name="min">x, y and z.</param>
        /// <param name="max">x, y and z.</param>
        /// <exception cref="ArgumentException">The length of `min` or `max` is not 3.</exception>
        public static unsafe Aabb RoundOutward(ReadOnlySpan<double> min, ReadOnlySpan<double> max)
        {
            if (min.Length != 3 || max.Length != 3)
                throw new ArgumentException("Pass three coordinates for each corner.");
            Aabb box;
            fixed (double* minStart = min, maxStart = max)
                Native.Check(LowLevel.NativeMethods.swp_round_outward(minStart, maxStart, &box));
            return box;
        }

        /// <summary>Whether the two boxes overlap, by the same definition as in the broad phase. Testing many boxes this way is slow.</summary>
        public readonly bool Overlaps(in Aabb other) =>
            IsValid && other.IsValid &&
            MinX <= other.MaxX && other.MinX <= MaxX &&
            MinY <= other.MaxY && other.MinY <= MaxY &&
            MinZ <= other.MaxZ && other.MinZ <= MaxZ;

        /// <summary>Whether all coordinates are finite and min is at most max.</summary>
        public readonly bool IsValid => IsRange(MinX, MaxX) && IsRange(MinY, MaxY) && IsRange(MinZ, MaxZ);

        private static bool IsRange(float min, float max) => min >= float.MinValue && max <= float.MaxValue && min <= max;
    }

    /// <summary>Two objects whose boxes overlap, as indices into the array of boxes; A is smaller than B.</summary>
    public struct OverlapPair : IEquatable<OverlapPair>
    {
        public uint A;
        public uint B;

        public OverlapPair(uint a, uint b) => (A, B) = (a, b);

        public readonly bool Equals(OverlapPair other) => A == other.A && B == other.B;
        public override readonly bool Equals(object? other) => other is OverlapPair pair && Equals(pair);
        public override readonly int GetHashCode() => unchecked((int)(A * 0x9E3779B1u ^ B));
        public override readonly string ToString() => A + " " + B;
    }
}

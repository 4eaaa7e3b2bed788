#nullable enable
using System;
using System.Collections.Generic;

namespace Sweepstake.Tests
{
    /// <summary>Computes the expected pairs by brute force.</summary>
    internal static class Oracle
    {
        internal static List<OverlapPair> Pairs(ReadOnlySpan<Aabb> boxes)
        {
            var pairs = new List<OverlapPair>();
            for (int a = 0; a < boxes.Length; ++a)
            {
                for (int b = a + 1; b < boxes.Length; ++b)
                {
                    if (boxes[a].Overlaps(boxes[b]))
                        pairs.Add(new OverlapPair((uint)a, (uint)b));
                }
            }
            return pairs;
        }

        /// <summary>Sorts by A and then B.</summary>
        internal static List<OverlapPair> Sorted(ReadOnlySpan<OverlapPair> found)
        {
            var pairs = new List<OverlapPair>(found.ToArray());
            pairs.Sort((left, right) => left.A != right.A ? left.A.CompareTo(right.A) : left.B.CompareTo(right.B));
            return pairs;
        }

        /// <summary>Creates a moving scene with pairs. It has few enough objects for brute force.</summary>
        internal static MotionScene CrowdedScene(string name, uint objects = 300)
        {
            SceneOptions options = SceneOptions.Default;
            options.ObjectCount = objects;
            options.WorldHalfExtent = 12;
            return new MotionScene(name, options);
        }
    }
}

#nullable enable
using System;
using Unity.Collections;
using Unity.Jobs;
using UnityEngine;
#if SWEEPSTAKE_BURST
using Unity.Burst;
#endif

namespace Sweepstake.Unity
{
    /// <summary>
    /// Boxes in native arrays as input, for games whose jobs compute them. An array of Aabb is not copied. For calls that take a span, such as those
    /// of <see cref="ProxySet"/>, pass the array's AsReadOnlySpan().
    /// </summary>
    public static class NativeBoxes
    {
        private const int BatchSize = 256;

        /// <summary>Schedules the conversion of Unity's bounds. Negative extents give an invalid box, which overlaps nothing.</summary>
        /// <param name="boxes">Receives the boxes; as long as `bounds`.</param>
        /// <exception cref="ArgumentException">The lengths differ.</exception>
        public static JobHandle ScheduleToAabbs(this NativeArray<Bounds> bounds, NativeArray<Aabb> boxes, JobHandle dependsOn = default)
        {
            if (boxes.Length != bounds.Length)
                throw new ArgumentException("Pass as many boxes as bounds.");
            return new ToAabbsJob { Bounds = bounds, Boxes = boxes }.Schedule(bounds.Length, BatchSize, dependsOn);
        }

        /// <summary>Like <see cref="BroadPhaseSession.FindPairs(ReadOnlySpan{Aabb})"/>. Complete the jobs that write the boxes first.</summary>
        public static void FindPairs(this BroadPhaseSession session, NativeArray<Aabb> boxes) => session.FindPairs(boxes.AsReadOnlySpan());

        /// <summary>Converts the bounds and searches them. Complete the jobs that write the bounds first.</summary>
        /// <param name="boxes">Receives the boxes; as long as `bounds`.</param>
        /// <exception cref="ArgumentException">The lengths differ.</exception>
        public static void FindPairs(this BroadPhaseSession session, NativeArray<Bounds> bounds, NativeArray<Aabb> boxes)
        {
            bounds.ScheduleToAabbs(boxes).Complete();
            session.FindPairs(boxes);
        }

#if SWEEPSTAKE_BURST
        [BurstCompile]
#endif
        private struct ToAabbsJob : IJobParallelFor
        {
            [ReadOnly] internal NativeArray<Bounds> Bounds;
            [WriteOnly] internal NativeArray<Aabb> Boxes;

            public void Execute(int index)
            {
                Vector3 center = Bounds[index].center;
                Vector3 half = Bounds[index].extents;
                Boxes[index] = Aabb.Around(center.x, center.y, center.z, half.x, half.y, half.z);
            }
        }
    }
}

#nullable enable
using System;
using Sweepstake.LowLevel;
using Unity.Collections;
using Unity.Collections.LowLevel.Unsafe;
using Unity.Jobs;
#if SWEEPSTAKE_BURST
using Unity.Burst;
#endif

namespace Sweepstake.Samples
{
    /// <summary>
    /// Searches the boxes of a NativeArray on a worker. It uses only the C ABI with pointers and numbers, so that Burst can compile it. The caller
    /// keeps the world alive and does not use it until the job is complete.
    /// </summary>
#if SWEEPSTAKE_BURST
    [BurstCompile]
#endif
    internal unsafe struct FindNeighboursJob : IJob
    {
        /// <summary>Pointer of a <see cref="BroadPhaseWorld"/>.</summary>
        [NativeDisableUnsafePtrRestriction]
        internal IntPtr World;
        [ReadOnly]
        internal NativeArray<Aabb> Boxes;
        /// <summary>For each box, the number of boxes that overlap it.</summary>
        internal NativeArray<int> Neighbours;
        /// <summary>One element: the result code of the search.</summary>
        internal NativeArray<int> Result;

        public void Execute()
        {
            for (int index = 0; index < Neighbours.Length; ++index)
                Neighbours[index] = 0;
            var boxes = (Aabb*)Boxes.GetUnsafeReadOnlyPtr();
            ResultCode result = NativeMethods.swp_world_update(World, boxes, (uint)Boxes.Length);
            if (result == ResultCode.FailedPrecondition)
                result = NativeMethods.swp_world_build(World, boxes, (uint)Boxes.Length);
            if (result == ResultCode.Ok)
                result = NativeMethods.swp_world_find_pairs(World);
            if (result == ResultCode.Ok)
                result = Count();
            Result[0] = (int)result;
        }

        private ResultCode Count()
        {
            var neighbours = (int*)Neighbours.GetUnsafePtr();
            OverlapPair* pairs;
            ulong count;
            ResultCode result = NativeMethods.swp_world_pairs(World, &pairs, &count);
            for (ulong index = 0; result == ResultCode.Ok && index < count; ++index)
            {
                ++neighbours[pairs[index].A];
                ++neighbours[pairs[index].B];
            }
            return result;
        }
    }

    /// <summary>Moves boxes and reflects them at the walls.</summary>
#if SWEEPSTAKE_BURST
    [BurstCompile]
#endif
    internal struct DriftJob : IJobParallelFor
    {
        internal NativeArray<Aabb> Boxes;
        /// <summary>x, y and z of each box's velocity, in units per second.</summary>
        [NativeDisableParallelForRestriction]
        internal NativeArray<float> Velocities;
        internal float Seconds;
        internal float Reach;

        public void Execute(int index)
        {
            Aabb box = Boxes[index];
            Boxes[index] = new Aabb(
                box.MinX + Along(3 * index, box.MinX, box.MaxX), box.MinY + Along(3 * index + 1, box.MinY, box.MaxY),
                box.MinZ + Along(3 * index + 2, box.MinZ, box.MaxZ), box.MaxX + Along(3 * index, box.MinX, box.MaxX),
                box.MaxY + Along(3 * index + 1, box.MinY, box.MaxY), box.MaxZ + Along(3 * index + 2, box.MinZ, box.MaxZ));
        }

        private float Along(int axis, float min, float max)
        {
            float velocity = Velocities[axis];
            if ((min < -Reach && velocity < 0) || (max > Reach && velocity > 0))
                Velocities[axis] = velocity = -velocity;
            return velocity * Seconds;
        }
    }
}

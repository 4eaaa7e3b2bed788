#nullable enable
using Unity.Collections;
using UnityEngine.Jobs;
#if SWEEPSTAKE_BURST
using Unity.Burst;
#endif

namespace Sweepstake.Unity
{
    /// <summary>Computes the boxes of moving colliders from their shapes and transforms, on worker threads.</summary>
#if SWEEPSTAKE_BURST
    [BurstCompile]
#endif
    internal struct ColliderBoxesJob : IJobParallelForTransform
    {
        [ReadOnly]
        internal NativeArray<ColliderShape> Shapes;
        [WriteOnly]
        internal NativeArray<Aabb> Boxes;

        public void Execute(int index, TransformAccess transform) =>
            Boxes[index] = transform.isValid ? Shapes[index].BoxOf(transform.localToWorldMatrix) : ColliderShape.NoBox;
    }
}

#nullable enable
using Sweepstake;
using Unity.Collections;
using Unity.Jobs;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Thousands of drifting boxes without game objects. One job moves them, the next one finds each box's neighbours with a broad phase of the
    /// library. Both run on workers while the rest of the frame continues. Gizmos show the boxes that have neighbours.
    /// </summary>
    public sealed class JobBoids : MonoBehaviour
    {
        private const int MaxDrawn = 500;

        [SerializeField]
        [Range(1, 50_000)]
        [Tooltip("Number of boxes.")]
        private int count = 5000;
        [SerializeField]
        [Min(1)]
        [Tooltip("Largest distance from the centre on each axis, in units.")]
        private float reach = 30;
        [SerializeField]
        [Tooltip("Name of the broad phase.")]
        private string backend = "KDTree";

        private BroadPhaseWorld? world;
        private NativeArray<Aabb> boxes;
        private NativeArray<float> velocities;
        private NativeArray<int> neighbours;
        private NativeArray<int> result;
        private JobHandle job;

        /// <summary>Number of boxes with a neighbour in the latest job.</summary>
        public int TouchingCount { get; private set; }

        private void OnEnable()
        {
            world = new BroadPhaseWorld(backend);
            boxes = new NativeArray<Aabb>(count, Allocator.Persistent);
            velocities = new NativeArray<float>(3 * count, Allocator.Persistent);
            neighbours = new NativeArray<int>(count, Allocator.Persistent);
            result = new NativeArray<int>(1, Allocator.Persistent);
            var random = new System.Random(1);
            for (int index = 0; index < count; ++index)
                boxes[index] = Aabb.Around(Signed(random) * reach, Signed(random) * reach, Signed(random) * reach, 0.5f, 0.5f, 0.5f);
            for (int axis = 0; axis < velocities.Length; ++axis)
                velocities[axis] = 3 * Signed(random);
        }

        private void OnDisable()
        {
            job.Complete();
            boxes.Dispose();
            velocities.Dispose();
            neighbours.Dispose();
            result.Dispose();
            world?.Dispose();
            world = null;
        }

        private void Update()
        {
            JobHandle moved = new DriftJob { Boxes = boxes, Velocities = velocities, Seconds = Time.deltaTime, Reach = reach }.Schedule(count, 256);
            job = new FindNeighboursJob { World = world!.Pointer, Boxes = boxes, Neighbours = neighbours, Result = result }.Schedule(moved);
        }

        private void LateUpdate()
        {
            job.Complete();
            if (result[0] != (int)ResultCode.Ok)
            {
                Debug.LogError($"Sweepstake: the search failed with {(ResultCode)result[0]}.", this);
                enabled = false;
                return;
            }
            TouchingCount = 0;
            foreach (int others in neighbours)
                TouchingCount += others > 0 ? 1 : 0;
        }

        private void OnDrawGizmos()
        {
            if (world == null)
                return;
            Gizmos.color = new Color(0.95f, 0.5f, 0.15f);
            for (int index = 0, drawn = 0; index < boxes.Length && drawn < MaxDrawn; ++index)
            {
                if (neighbours[index] == 0)
                    continue;
                Aabb box = boxes[index];
                Gizmos.DrawWireCube(0.5f * new Vector3(box.MinX + box.MaxX, box.MinY + box.MaxY, box.MinZ + box.MaxZ), Vector3.one);
                ++drawn;
            }
        }

        private static float Signed(System.Random random) => (float)(2 * random.NextDouble() - 1);
    }
}

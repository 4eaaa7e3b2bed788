#nullable enable
using System.Collections.Generic;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>A level to record: cubes that move back and forth through each other.</summary>
    [RequireComponent(typeof(ColliderTracker))]
    public sealed class MovingCubes : MonoBehaviour
    {
        [SerializeField]
        [Range(1, 2000)]
        [Tooltip("Number of cubes.")]
        private int count = 200;
        [SerializeField]
        [Min(1)]
        [Tooltip("Largest distance from the centre on each axis, in units.")]
        private float reach = 15;

        private readonly List<(Transform Place, Vector3 Middle, Vector3 Way)> cubes = new List<(Transform, Vector3, Vector3)>();

        private void Start()
        {
            var tracker = GetComponent<ColliderTracker>();
            var random = new System.Random(1);
            for (int index = 0; index < count; ++index)
            {
                GameObject made = GameObject.CreatePrimitive(PrimitiveType.Cube);
                made.transform.SetParent(transform, false);
                // Naming the component type here keeps code stripping from removing the type.
                var collider = made.GetComponent<BoxCollider>();
                collider.isTrigger = true;
                cubes.Add((made.transform, reach * Direction(random), 0.3f * reach * Direction(random)));
                Move(cubes[index]);
                tracker.Register(collider);
            }
        }

        private void Update()
        {
            foreach ((Transform, Vector3, Vector3) cube in cubes)
                Move(cube);
        }

        private static void Move((Transform Place, Vector3 Middle, Vector3 Way) cube) =>
            cube.Place.position = cube.Middle + (float)System.Math.Sin(Time.realtimeSinceStartup) * cube.Way;

        private static Vector3 Direction(System.Random random) => new Vector3(Signed(random), Signed(random), Signed(random));

        private static float Signed(System.Random random) => (float)(2 * random.NextDouble() - 1);
    }
}

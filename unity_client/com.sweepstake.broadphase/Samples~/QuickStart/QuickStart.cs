#nullable enable
using System.Collections.Generic;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Balls that drift through each other, as triggers without Rigidbodies. A ball has the second colour while its box overlaps another
    /// one. Add this component to an object with a Sweepstake Collider Tracker and enter play mode.
    /// </summary>
    [RequireComponent(typeof(ColliderTracker))]
    public sealed class QuickStart : MonoBehaviour
    {
        private static readonly Color Alone = new Color(0.55f, 0.6f, 0.66f);
        private static readonly Color Touching = new Color(0.95f, 0.5f, 0.15f);

        [SerializeField]
        [Range(2, 2000)]
        [Tooltip("Number of balls.")]
        private int count = 300;
        [SerializeField]
        [Min(1)]
        [Tooltip("Largest distance from the centre, in units.")]
        private float reach = 12;
        [SerializeField]
        [Min(0)]
        [Tooltip("Speed in units per second.")]
        private float speed = 3;

        private readonly Dictionary<Collider, Ball> balls = new Dictionary<Collider, Ball>();
        private ColliderTracker? tracker;

        private void Start()
        {
            tracker = GetComponent<ColliderTracker>();
            tracker.PairBegan += OnPairBegan;
            tracker.PairEnded += OnPairEnded;
            var random = new System.Random(1);
            for (int index = 0; index < count; ++index)
            {
                var ball = new Ball(transform, random, reach, speed);
                balls.Add(ball.Collider, ball);
                tracker.Register(ball.Collider);
            }
        }

        private void OnDestroy()
        {
            if (tracker == null)
                return;
            tracker.PairBegan -= OnPairBegan;
            tracker.PairEnded -= OnPairEnded;
        }

        private void Update()
        {
            foreach (Ball ball in balls.Values)
                ball.Move(Time.deltaTime, reach);
        }

        private void OnPairBegan(ColliderPair pair) => Count(pair, 1);

        private void OnPairEnded(ColliderPair pair) => Count(pair, -1);

        private void Count(ColliderPair pair, int change)
        {
            if (balls.TryGetValue(pair.A, out Ball? a))
                a.Count(change);
            if (balls.TryGetValue(pair.B, out Ball? b))
                b.Count(change);
        }

        private sealed class Ball
        {
            private readonly Material material;
            private Vector3 velocity;
            private int touched;

            internal Ball(Transform parent, System.Random random, float reach, float speed)
            {
                GameObject made = GameObject.CreatePrimitive(PrimitiveType.Sphere);
                made.transform.SetParent(parent, false);
                made.transform.position = reach * Direction(random);
                velocity = speed * Direction(random);
                // Naming the component type here keeps code stripping from removing the type.
                Collider = made.GetComponent<SphereCollider>();
                Collider.isTrigger = true;
                material = made.GetComponent<MeshRenderer>().material;
                Show();
            }

            internal Collider Collider { get; }

            internal void Move(float seconds, float reach)
            {
                Transform place = Collider.transform;
                place.position += seconds * velocity;
                if (place.position.magnitude > reach)
                    velocity = -velocity.magnitude * place.position.normalized;
            }

            internal void Count(int change)
            {
                touched += change;
                if (touched == 0 || (touched == 1 && change > 0))
                    Show();
            }

            private void Show()
            {
                // The colour is named _Color in the Built-in pipeline, and _BaseColor in URP and HDRP.
                material.SetColor("_Color", touched > 0 ? Touching : Alone);
                material.SetColor("_BaseColor", touched > 0 ? Touching : Alone);
            }

            private static Vector3 Direction(System.Random random) => new Vector3(Signed(random), Signed(random), Signed(random));

            private static float Signed(System.Random random) => (float)(2 * random.NextDouble() - 1);
        }
    }
}

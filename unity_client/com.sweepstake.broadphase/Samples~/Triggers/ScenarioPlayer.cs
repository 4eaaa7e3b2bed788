#nullable enable
using System;
using System.Collections.Generic;
using Sweepstake.Unity;
using UnityEngine;

namespace Sweepstake.Samples
{
    /// <summary>
    /// Moves boxes and passes them to the manager on the same object: a scene of the library, or a recorded .aabbs file. One seed
    /// gives the same boxes in each step on every machine. Changing a setting while it plays restarts the scene. If a new scene cannot be
    /// played, the reason is logged and the former scene continues.
    /// </summary>
    [RequireComponent(typeof(SweepstakeManager))]
    [DisallowMultipleComponent]
    public sealed class ScenarioPlayer : MonoBehaviour, IBroadPhaseSource
    {
        /// <summary>Upper limit of <see cref="ObjectCount"/>.</summary>
        public const int MaxObjects = 100_000;

        [SerializeField]
        [Tooltip("Name of a scene of the library, such as brownian, or the path of an .aabbs file.")]
        private string scenario = "hurricane";
        [SerializeField]
        [Range(0, MaxObjects)]
        [Tooltip("Number of boxes.")]
        private int objectCount = 3000;
        [SerializeField]
        [Tooltip("The same seed gives the same boxes.")]
        private uint seed = 1;
        [SerializeField]
        [Min(1)]
        [Tooltip("Half the size of the world: it extends from minus this value to this value on each axis, in units.")]
        private float worldHalfExtent = 50;
        [SerializeField]
        [Min(0)]
        [Tooltip("Characteristic speed of the boxes, in units per second.")]
        private float speed = 10;
        [SerializeField]
        [Tooltip("Draws the boxes; boxes that touch another one have the second colour.")]
        private bool isDrawn = true;

        private MotionScene? scene;
        private InstancedBoxes? drawing;
        private bool isStale = true;
        private float dueSeconds;

        /// <summary>Name of a scene of the library, or the path of an .aabbs file.</summary>
        public string Scenario { get => scenario; set => Change(ref scenario, value); }
        /// <summary>Number of objects from 0 to <see cref="MaxObjects"/>; other values are clamped.</summary>
        public int ObjectCount { get => objectCount; set => Change(ref objectCount, Math.Min(Math.Max(value, 0), MaxObjects)); }
        /// <summary>The same seed gives the same boxes.</summary>
        public uint Seed { get => seed; set => Change(ref seed, value); }
        /// <summary>Half the size of the world on each axis, in units.</summary>
        public float WorldHalfExtent { get => worldHalfExtent; set => Change(ref worldHalfExtent, value); }
        /// <summary>Characteristic speed of the boxes, in units per second.</summary>
        public float Speed { get => speed; set => Change(ref speed, value); }

        /// <summary>Hash of the current boxes: the same on every platform for the same seed and step. 0 while no scene is playing.</summary>
        public ulong Hash => scene?.Hash ?? 0;
        /// <summary>Number of steps since the scene began.</summary>
        public ulong Step => scene?.FrameIndex ?? 0;

        /// <summary>Restarts the scene at the next frame.</summary>
        public void Restart() => isStale = true;

        void IBroadPhaseSource.Search(BroadPhaseSession session)
        {
            MotionScene? moved = Advanced();
            if (moved == null)
            {
                session.FindPairs(ReadOnlySpan<Aabb>.Empty);
                return;
            }
            session.FindPairs(moved.Boxes);
            if (isDrawn)
                (drawing ??= new InstancedBoxes()).Draw(moved.Boxes, session.Pairs);
        }

        void IBroadPhaseSource.Report()
        {
        }

        bool IBroadPhaseSource.TryGetPair(int index, out Aabb a, out Aabb b)
        {
            a = b = default;
            BroadPhaseSession? session = GetComponent<SweepstakeManager>().Session;
            if (scene == null || session == null || scene.FrameIndex == 0 || index >= session.Pairs.Length)
                return false;
            a = scene.Boxes[(int)session.Pairs[index].A];
            b = scene.Boxes[(int)session.Pairs[index].B];
            return true;
        }

        void IBroadPhaseSource.CopyBoxes(List<Aabb> boxes)
        {
            boxes.Clear();
            for (int index = 0; scene != null && index < scene.Boxes.Length; ++index)
                boxes.Add(scene.Boxes[index]);
        }

        private void OnEnable()
        {
            var manager = GetComponent<SweepstakeManager>();
            if (manager.Source != null)
                Debug.LogError("Sweepstake: no scenario is played, because the manager already has another source.", this);
            else
                manager.Source = this;
            isStale = true;
        }

        private void OnDisable()
        {
            var manager = GetComponent<SweepstakeManager>();
            if (manager != null && ReferenceEquals(manager.Source, this))
                manager.Source = null;
            scene?.Dispose();
            scene = null;
            drawing?.Dispose();
            drawing = null;
        }

        private void OnValidate() => isStale = true;

        /// <summary>
        /// Advances the scene by one step of fixed duration, and never by more. Otherwise a slow frame would make the next one slower.
        /// </summary>
        private MotionScene? Advanced()
        {
            // SweepstakeLibrary.Shutdown ends the scene too.
            if (isStale || scene?.IsDisposed == true)
                Begin();
            if (scene == null)
                return null;
            float step = scene.Options.FixedStepS;
            dueSeconds = Math.Min(dueSeconds + Time.deltaTime, 2 * step);
            if (scene.FrameIndex == 0 || dueSeconds >= step)
            {
                scene.Step();
                dueSeconds -= step;
            }
            return scene;
        }

        private void Begin()
        {
            isStale = false;
            try
            {
                MotionScene made = Made();
                scene?.Dispose();
                scene = made;
                dueSeconds = 0;
            }
            catch (SweepstakeException problem)
            {
                Debug.LogError("Sweepstake: the scenario cannot be played. " + problem.Message, this);
            }
        }

        private MotionScene Made()
        {
            SceneOptions options = SceneOptions.Default;
            options.ObjectCount = (uint)objectCount;
            options.SpawnSeed = options.MotionSeed = seed;
            options.WorldHalfExtent = worldHalfExtent;
            options.Speed = speed;
            return new MotionScene(scenario, options);
        }

        private void Change<T>(ref T field, T value)
        {
            field = value;
            isStale = true;
        }
    }
}

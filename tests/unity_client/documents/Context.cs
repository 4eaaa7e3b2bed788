using System;
using System.Collections.Generic;
using Sweepstake.Unity;
using Unity.Collections;
using UnityEngine;

namespace Sweepstake.Documents
{
    /// <summary>Declares the variables of a game that the code in the documents uses.</summary>
    internal abstract class Context
    {
        protected readonly BroadPhaseSession session = new BroadPhaseSession();
        protected readonly ProxyHandle[] handles = Array.Empty<ProxyHandle>();
        protected readonly List<Collider> found = new List<Collider>();
        protected readonly List<ColliderPair> pairs = new List<ColliderPair>();
        protected readonly Spawner spawner = new Spawner();
        protected readonly string tokenPath = "", authorityPath = "";
        protected SweepstakeManager manager;
        protected ColliderTracker tracker;
        protected Transform transform;
        protected Vector3 eye, forward;
        protected Aabb wallBox;
        protected Collider collider;
        protected NativeArray<Aabb> nativeBoxes;
        protected NativeArray<Bounds> nativeBounds;
        protected ulong frameTimeNs;

        protected ReadOnlySpan<Aabb> boxes => default;

        protected static void Touch(uint a, uint b)
        {
        }

        protected static void Enter(ProxyHandle a, ProxyHandle b)
        {
        }

        protected static void Meet(Collider a, Collider b)
        {
        }

        protected static void Part(Collider a, Collider b)
        {
        }

        protected static void Aim(Collider hit, float distance)
        {
        }

        protected sealed class Spawner
        {
            internal int Limit { get; set; }
        }
    }
}

#nullable enable
using System;
using Sweepstake.LowLevel;

namespace Sweepstake
{
    /// <summary>
    /// Moving boxes to test a broad phase: a scenario by name, or a recorded .aabbs file. The same seed gives the same boxes bit for bit on
    /// every platform, independent of the frame rate. A step costs O(objects) and allocates nothing.
    /// </summary>
    public sealed unsafe class MotionScene : NativeObject
    {
        /// <param name="scene">One of <see cref="SweepstakeLibrary.Scenes"/>, or the path of a .aabbs file.</param>
        /// <param name="options">Null for the defaults.</param>
        /// <exception cref="SweepstakeException">A value or the file is wrong, or the scene is unknown; the message lists the scenes.</exception>
        public MotionScene(string scene, SceneOptions? options = null)
            : base(Create(scene, options ?? SceneOptions.Default), NativeMethods.swp_scene_destroy)
        {
            Name = scene;
            Options = options ?? SceneOptions.Default;
        }

        public string Name { get; }
        public SceneOptions Options { get; }

        /// <summary>The boxes of the current frame, in the library's memory: valid until the next step.</summary>
        public ReadOnlySpan<Aabb> Boxes
        {
            get
            {
                Aabb* boxes;
                uint count;
                Check(NativeMethods.swp_scene_boxes(Pointer, &boxes, &count));
                return new ReadOnlySpan<Aabb>(boxes, checked((int)count));
            }
        }

        /// <summary>The bounds of the motion; boxes may extend beyond them by their own size.</summary>
        public Aabb World => Read<Aabb>((self, world) => NativeMethods.swp_scene_world(self, world));
        /// <summary>The number of steps taken.</summary>
        public ulong FrameIndex => Read<ulong>((self, index) => NativeMethods.swp_scene_frame_index(self, index));
        /// <summary>FNV-1a hash of the current boxes: the same on every platform for the same seed and step.</summary>
        public ulong Hash => Read<ulong>((self, hash) => NativeMethods.swp_scene_hash(self, hash));

        /// <summary>Advances the scene by one fixed step.</summary>
        public void Step() => Check(NativeMethods.swp_scene_step(Pointer));

        private static IntPtr Create(string scene, SceneOptions options)
        {
            SweepstakeLibrary.EnsureLoaded();
            using var memory = new CallMemory();
            IntPtr made;
            Native.Check(NativeMethods.swp_scene_create(memory.Text(scene ?? throw new ArgumentNullException(nameof(scene))), &options, &made));
            return made;
        }
    }
}

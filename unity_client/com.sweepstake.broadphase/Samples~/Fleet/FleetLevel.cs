#nullable enable
using System;
using System.Collections.Generic;
using Sweepstake.Unity;

namespace Sweepstake.Samples
{
    /// <summary>The boxes of a level, moved by one of the library's five scenarios. A frame makes one step.</summary>
    internal sealed class FleetLevel : IBroadPhaseSource, IDisposable
    {
        private const int ScenarioCount = 5;

        private readonly int index;
        private readonly int objectCount;
        private MotionScene? scene;

        /// <param name="index">Index of the level; each of five levels has another scenario.</param>
        internal FleetLevel(int index, int objectCount)
        {
            this.index = index;
            this.objectCount = objectCount;
        }

        public void Dispose() => scene?.Dispose();

        void IBroadPhaseSource.Search(BroadPhaseSession session)
        {
            // SweepstakeLibrary.Shutdown ends the scene too.
            if (scene == null || scene.IsDisposed)
                scene = Made();
            scene.Step();
            session.FindPairs(scene.Boxes);
        }

        void IBroadPhaseSource.Report()
        {
        }

        bool IBroadPhaseSource.TryGetPair(int pair, out Aabb a, out Aabb b)
        {
            a = b = default;
            return false;
        }

        void IBroadPhaseSource.CopyBoxes(List<Aabb> boxes)
        {
            boxes.Clear();
            for (int box = 0; scene != null && box < scene.Boxes.Length; ++box)
                boxes.Add(scene.Boxes[box]);
        }

        private MotionScene Made()
        {
            SceneOptions options = SceneOptions.Default;
            options.ObjectCount = (uint)objectCount;
            return new MotionScene(SweepstakeLibrary.Scenes[index % ScenarioCount], options);
        }
    }
}
